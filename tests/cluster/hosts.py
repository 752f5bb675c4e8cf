"""Two hosts on one machine: each has a network of its own with its own loopback, a name, a /tmp and a /dev/shm; a cable joins them.

They are namespaces of Linux, made by `unshare` and ended with the processes that hold them. mpirun starts its daemon on the other host
by an agent in the place of ssh.
"""
import os
import pathlib
import subprocess

NETWORK = "10.77.7.0/24"
ADDRESSES = ("10.77.7.1", "10.77.7.2")
NAMES = ("meld-one", "meld-two")
KINDS = ("--net", "--mount", "--uts", "--ipc")
# What a host does when it is made; then it stays until its holder ends.
MADE = ("mount --make-rprivate / && mount -t tmpfs tmpfs /tmp && mount -t tmpfs tmpfs /dev/shm && hostname {name} && ip link set lo up "
        "&& echo made && exec sleep 1000000")


class Hosts:
    """`folder` is one that both see, and is not in /tmp."""

    def __init__(self, folder):
        self.folder = pathlib.Path(folder)
        self.holders = []
        try:
            for name in NAMES:
                self.holders.append(subprocess.Popen(["unshare", *KINDS, "sh", "-c", MADE.format(name=name)], stdout=subprocess.PIPE,
                                                     stderr=subprocess.STDOUT, text=True))
                said = self.holders[-1].stdout.readline()
                if said != "made\n":
                    raise OSError(said.strip() or "a host cannot be made")
            self._join()
        except (OSError, subprocess.CalledProcessError):
            self.end()
            raise
        self.agent = self.folder / "agent"
        cases = "".join(f"{address}) holder={holder.pid} ;;\n" for address, holder in zip(ADDRESSES, self.holders))
        self.agent.write_text(f'#!/bin/bash\nhost=$1\nshift\ncase $host in\n{cases}*) echo "there is no host $host" >&2; exit 1 ;;\nesac\n'
                              f'exec nsenter -t "$holder" {" ".join(KINDS)} --wd="{self.folder}" /bin/bash -c "$*"\n')
        self.agent.chmod(0o755)
        (self.folder / "hosts").write_text("".join(f"{address} slots=2\n" for address in ADDRESSES))

    def _join(self):
        ends = [f"meld{holder.pid}" for holder in self.holders]

        def ip(*words, at=None):
            inside = [] if at is None else ["nsenter", "-t", str(self.holders[at].pid), "--net"]
            subprocess.run([*inside, "ip", *words], check=True, capture_output=True, text=True)

        ip("link", "add", ends[0], "netns", str(self.holders[0].pid), "type", "veth", "peer", "name", ends[1], "netns",
           str(self.holders[1].pid))
        for at, (end, address) in enumerate(zip(ends, ADDRESSES)):
            ip("address", "add", f"{address}/24", "dev", end, at=at)
            ip("link", "set", end, "up", at=at)

    def cut(self):
        """The cable: what is sent is lost, and nobody is told."""
        subprocess.run(["nsenter", "-t", str(self.holders[1].pid), "--net", "ip", "link", "set", f"meld{self.holders[1].pid}", "down"],
                       check=True)

    def on(self, host, *words):
        """A command as it runs on one of them."""
        return ["nsenter", "-t", str(self.holders[host].pid), *KINDS, f"--wd={self.folder}", *map(str, words)]

    def mpirun(self, *words, processes=4):
        """From the first host, over both in turn."""
        options = ["--hostfile", "hosts", "-n", str(processes), "--map-by", "node", "--bind-to", "none"]
        chosen = {"plm_rsh_agent": str(self.agent), "oob_tcp_if_include": NETWORK, "btl_tcp_if_include": NETWORK,
                  # How soon a cable that is cut is noticed: after 2 s of silence, three questions a second apart.
                  "oob_tcp_keepalive_time": "2", "oob_tcp_keepalive_intvl": "1", "oob_tcp_keepalive_probes": "3"}
        for name, value in chosen.items():
            options += ["--mca", name, value]
        return self.on(0, "mpirun", *options, *words)

    def end(self):
        for holder in self.holders:
            holder.kill()
            holder.wait()
            holder.stdout.close()


def can_be_made(folder):
    """Nothing, or why hosts cannot be made here."""
    if os.geteuid() != 0:
        return "only root may make hosts"
    try:
        Hosts(folder).end()
    except (OSError, subprocess.CalledProcessError) as problem:
        return f"no hosts can be made here: {getattr(problem, 'stderr', '') or problem}"
    return ""
