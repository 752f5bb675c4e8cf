"""Runs that go on while a test looks at them, sends them signals and kills their processes; whatever is left of them is found."""
import os
import pathlib
import signal
import subprocess
import time

import h5py

from frame import COUNT, FOREVER, TOOLS, Case, square

# The promise is two seconds; other tests may have the machine.
SECONDS = 5
# A tick takes minutes.
LONG_TICK = """type p(node, int).
fun spin(int N, int S) : int = if N = 0 then S else spin(N - 1, (S * 31 + N) % 1000003) end.
fun turn(int N, int S) : int = if N = 0 then S else turn(N - 1, spin(9000, S)) end.
p(A, turn(10, I)) :- id(A, I).
"""


def recorded_square(side):
    return square(side) + '[record]\nevery = 1\npredicates = ["p"]\n'


def stat(pid):
    """State, parent, group and session of a process."""
    try:
        fields = pathlib.Path(f"/proc/{pid}/stat").read_text().rsplit(") ", 1)[1].split()
        return fields[0], *map(int, fields[1:4])
    except (OSError, IndexError):
        return None


def children(pid):
    """The processes that a process has started, in order."""
    try:
        return [int(child) for child in pathlib.Path(f"/proc/{pid}/task/{pid}/children").read_text().split()]
    except OSError:
        return []


def processes_of(session):
    found = {int(p.name): stat(p.name) for p in pathlib.Path("/proc").iterdir() if p.name.isdigit()}
    return {pid for pid, status in found.items() if status and status[3] == session and status[0] != "Z"}


class Running(Case):
    FILES = {"w.toml": square(2), "p.meld": COUNT, "forever.meld": FOREVER, "long.meld": LONG_TICK,
             "small.toml": recorded_square(10), "large.toml": recorded_square(600)}

    def setUp(self):
        super().setUp()
        (self.folder / "shm").mkdir()

    def forget_outputs(self):
        for name in ("d", "f", "r", "r.xdmf"):
            (self.folder / name).unlink(missing_ok=True)

    def start(self, *arguments, environment=None, launcher=()):
        """A run, with --new: without what was compiled before."""
        # What parts share lies where nobody else's does. A session of its own, so that its processes can be told.
        environment = {"OMPI_MCA_btl_vader_backing_directory": self.folder / "shm", **(environment or {})}
        if "--new" in arguments:
            environment["CLAYMELD_CACHE"] = self.folder / "cache"
        words = [*launcher, TOOLS.meldsim, "run", *(word for word in arguments if word != "--new")]
        return self.begin(*words, environment=environment, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True,
                          start_new_session=True)

    def end(self, process):
        for pid in processes_of(process.pid):
            os.kill(pid, signal.SIGKILL)
        super().end(process)

    def ended(self, run, codes):
        """Waits for the end after a signal; returns what was said."""
        begin = time.monotonic()
        out, err = run.communicate(timeout=SECONDS)
        self.assertIn(run.returncode, codes, out + err)
        while processes_of(run.pid) and time.monotonic() < begin + SECONDS:
            time.sleep(0.05)
        self.assertEqual(processes_of(run.pid), set(), "processes are left")
        self.assertEqual(os.listdir(self.folder / "shm"), [], "shared memory is left")
        for wrong in ("crashed", "internal error", "terminate called"):
            self.assertNotIn(wrong, out + err)
        return out, err

    def ticks_are_made(self, run, name="d"):
        self.wait_for(lambda: (self.folder / name).exists() and (self.folder / name).stat().st_size > 0, run)

    def check_outputs(self):
        """What is there is whole, and nothing else is; returns the tick of the facts, or None."""
        digest = (self.folder / "d").read_text() if (self.folder / "d").exists() else ""
        self.assertTrue(digest == "" or digest.endswith("\n"))
        last = int(digest.splitlines()[-1].split()[1]) if digest else 0
        if (self.folder / "r").exists():
            with h5py.File(self.folder / "r") as recording:
                self.assertIn("VTKHDF", recording)
        facts = None
        if (self.folder / "f").exists():
            lines = (self.folder / "f").read_text().splitlines()
            self.assertEqual(lines, sorted((f"p(@{i}, {last})." for i in range(100)), key=lambda line: int(line[3:line.index(",")])))
            facts = last
        mine = {*self.FILES, "d", "f", "r", "r.xdmf", "shm", "bin"}
        self.assertLessEqual({p.name for p in self.folder.iterdir() if p.name != "cache"}, mine, "files are left")
        return facts


