"""Runs on two hosts, each with a loopback, a name and a /tmp of its own, over a hostfile and an agent in the place of ssh: the same facts,
a checkpoint on a folder that both see, files and messages from the right host, and an end where the cable between them is cut.

    two_hosts_test.py --meldc PATH --meldsim PATH [unittest options]
"""
import os
import pathlib
import shutil
import subprocess
import sys
import tempfile
import time
import unittest

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1]))

from frame import FOREVER, OPEN_MPI, TOOLS, main  # noqa: E402
from hosts import Hosts, can_be_made  # noqa: E402

EXAMPLES = pathlib.Path(__file__).resolve().parents[2] / "examples" / "meld"
BOX = 'lattice = "cubic"\n[[body]]\nshape = "box(24, 8, 8)"\n'
# Wrong at the last catom, which the last process has, on the second host.
WRONG = "type p(node, int).\np(A, 1 / (1535 - I)) :- id(A, I), I = 1535.\n"
# How soon an end must come after the cable is cut: Open MPI needs some six seconds with the settings of hosts.py.
SECONDS = 40


class TwoHosts(unittest.TestCase):
    def setUp(self):
        # Not in /tmp, which each host has for itself.
        self.folder = pathlib.Path(tempfile.mkdtemp(prefix="hosts-", dir=pathlib.Path(TOOLS.meldsim).parents[1]))
        self.addCleanup(shutil.rmtree, self.folder)
        if why := can_be_made(self.folder):
            self.skipTest(why)
        self.hosts = Hosts(self.folder)
        self.addCleanup(self.hosts.end)
        self.environment = {**os.environ, **OPEN_MPI, "PATH": f"{pathlib.Path(TOOLS.meldsim).parent}:{os.environ['PATH']}"}
        for name in ("shape_change.meld", "shape_change.toml"):
            shutil.copy(EXAMPLES / name, self.folder)
        for name, text in (("forever.meld", FOREVER), ("forever.toml", BOX), ("wrong.meld", WRONG), ("wrong.toml", BOX)):
            (self.folder / name).write_text(text)
        for name in ("shape_change", "forever", "wrong"):
            self.call([TOOLS.meldc, "compile", f"{name}.meld", "-o", f"{name}.so"])

    def call(self, words, code=0, seconds=90):
        done = subprocess.run(words, cwd=self.folder, env=self.environment, capture_output=True, text=True, timeout=seconds)
        self.assertEqual(done.returncode, code, f"{words}\n{done.stdout}{done.stderr}")
        return done.stdout + done.stderr

    def alone(self, *words):
        return self.call([TOOLS.meldsim, *words])

    def on_both(self, *words, **how):
        return self.call(self.hosts.mpirun(TOOLS.meldsim, *words), **how)

    def text(self, name):
        return (self.folder / name).read_text()

    def test_the_hosts_are_two(self):
        said = self.call(self.hosts.mpirun("sh", "-c", "echo $(hostname) $(ls -d /tmp/ompi*); touch /tmp/of-$(hostname)"))
        for name in ("meld-one", "meld-two"):
            self.assertEqual(said.count(f"{name} /tmp/ompi.{name}.0"), 2, said)
        for host, name in enumerate(("meld-one", "meld-two")):
            self.assertEqual(self.call(self.hosts.on(host, "sh", "-c", "ls /tmp | grep of-")), f"of-{name}\n")

    def test_facts_digests_and_recordings_are_those_of_one_process(self):
        run = ("run", "shape_change.so", "--world", "shape_change.toml", "--quiet")
        self.alone(*run, "--digest", "one.digest", "--facts-out", "one.facts", "--record", "one.vtkhdf")
        self.on_both(*run, "--digest", "both.digest", "--facts-out", "both.facts", "--record", "both.vtkhdf")
        self.assertGreater(self.text("one.digest").count("\n"), 50)
        for kind in ("digest", "facts"):
            self.assertEqual(self.text(f"one.{kind}"), self.text(f"both.{kind}"))
        self.alone("diff", "one.vtkhdf", "both.vtkhdf")

    def test_a_checkpoint_on_a_folder_that_both_see_goes_on_anywhere(self):
        run = ("run", "shape_change.so", "--world", "shape_change.toml", "--quiet")
        self.alone(*run, "--facts-out", "one.facts")
        self.on_both(*run, "--ticks", "40", "--checkpoint", "there")
        shutil.copytree(self.folder / "there", self.folder / "again")
        self.on_both("resume", "there", "--ticks", "50", "--quiet")
        self.alone("resume", "again", "--ticks", "50", "--quiet", "-n", "2")
        self.alone("diff", "there", "again")
        for folder in ("there", "again"):
            self.assertTrue((self.folder / folder / "50.checkpoint.json").exists())

    def test_files_and_messages_come_from_the_first_host(self):
        self.on_both("run", "shape_change.so", "--world", "shape_change.toml", "--quiet", "--ticks", "3", "--facts-out", "/tmp/out.facts")
        self.assertIn("/tmp/out.facts", self.call(self.hosts.on(0, "ls", "/tmp/out.facts")))
        self.call(self.hosts.on(1, "ls", "/tmp/out.facts"), code=2)
        said = self.on_both("run", "wrong.so", "--world", "wrong.toml", "--quiet", code=1)
        self.assertEqual(said.count("in rule p@2 at catom @1535 in tick"), 1, said)

    def left_over(self):
        """Processes of runs that have not ended."""
        found = []
        for path in pathlib.Path("/proc").glob("[0-9]*/cmdline"):
            try:
                command = path.read_bytes().split(b"\0")
            except OSError:
                continue
            if command[0] == TOOLS.meldsim.encode() and path.parent.joinpath("cwd").resolve() == self.folder:
                found.append(command)
        return found

    def test_a_cable_that_is_cut_ends_the_run_which_goes_on_from_its_checkpoint(self):
        run = self.hosts.mpirun(TOOLS.meldsim, "run", "forever.so", "--world", "forever.toml", "--checkpoint", "there",
                                "--checkpoint-every", "200ticks")
        child = subprocess.Popen(run, cwd=self.folder, env=self.environment, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True)
        self.addCleanup(child.kill)
        end = time.monotonic() + SECONDS
        while not list(self.folder.glob("there/*.checkpoint.json")):
            self.assertLess(time.monotonic(), end)
            self.assertIsNone(child.poll())
            time.sleep(0.1)
        self.hosts.cut()
        said, _ = child.communicate(timeout=SECONDS)
        self.assertNotEqual(child.returncode, 0)
        self.assertIn("lost communication with a remote daemon", said)
        end = time.monotonic() + SECONDS
        while self.left_over():
            self.assertLess(time.monotonic(), end, self.left_over())
            time.sleep(0.1)
        last = max(int(path.name.split(".")[0]) for path in self.folder.glob("there/*.checkpoint.json"))
        self.alone("resume", "there", "--ticks", str(last + 10), "--quiet", "-n", "2")
        self.alone("run", "forever.so", "--world", "forever.toml", "--ticks", str(last + 10), "--quiet", "--checkpoint", "whole")
        self.alone("diff", "there", "whole")
        self.assertTrue((self.folder / "whole" / f"{last + 10}.checkpoint.json").exists())


if __name__ == "__main__":
    main("meldc", "meldsim")
