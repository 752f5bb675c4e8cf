"""Runs that are disturbed at random until they end: disturb_test.py --meldc PATH --meldsim PATH [--seconds S] [--seed N] [--turn T]

Processes are killed, asked to end and stopped for a while, disks become full and have room again. However a run ends, it does so soon and
with the documented code; it goes on from its newest checkpoint, and arrives at the results of a run that nothing disturbed. No file, no
process and no shared memory is left. At the end it says how many disturbances there were. A turn is made again by --turn.
"""

import collections
import math
import os
import pathlib
import random
import shutil
import signal
import subprocess
import sys
import time

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1]))

import resume_test  # noqa: E402
from frame import TOOLS, files_of, main, no_file_above  # noqa: E402
from running import children, processes_of  # noqa: E402

# Short runs with tens of checkpoints.
RUNS = {"waiting": 300, "storm": 60, "doze": 60, "failing": 100}
BY_LINKS = ("failing",)
KEEP = ("--checkpoint", "kept", "--checkpoint-every", "7ticks")
MOST = 12  # Disturbances of a run.
HANGS_S = 900  # The machine may be busy with something else.
LIMIT = 4
ROOM = "48m"


def spawned(pid):
    """The processes that a process has started, and those that these have."""
    own = children(pid)
    return own + [each for child in own for each in spawned(child)]


class Kind:
    """A way to disturb a run: what is done to it once it has begun, the codes it may end with, and options it is started with."""

    def __init__(self, rng, supervised):
        self.rng, self.supervised = rng, supervised

    def options(self):
        return {}

    def do(self, run):
        """Returns what was done, or None if there was nothing to do it to."""

    def undo(self):
        pass


class Kill(Kind):
    def do(self, run):
        victims = [run.pid, *spawned(run.pid)]
        victim = self.rng.choice(victims)
        os.kill(victim, signal.SIGKILL)
        self.of_all = victim == run.pid
        return "kill"

    def codes(self):
        return {0, -signal.SIGKILL} if self.of_all else {0} if self.supervised else {0, 137}


class Ask(Kind):
    def do(self, run):
        self.sent = self.rng.choice((signal.SIGTERM, signal.SIGINT, signal.SIGHUP))
        for _ in range(self.rng.choice((1, 1, 2))):
            run.send_signal(self.sent)
            time.sleep(self.rng.uniform(0, 0.05))
        return self.sent.name

    def codes(self):
        return {0, 143 if self.sent == signal.SIGTERM else 130, -self.sent}


class Stop(Kind):
    def do(self, run):
        victim = self.rng.choice([run.pid, *spawned(run.pid)])
        os.kill(victim, signal.SIGSTOP)
        try:
            time.sleep(self.rng.uniform(0, 0.3))
        finally:
            os.kill(victim, signal.SIGCONT)
        return "stop"

    def codes(self):
        return {0}


class NoLargeFiles(Kind):
    """From its start no file may grow beyond a size."""

    def options(self):
        return {"preexec_fn": no_file_above(int(math.exp(self.rng.uniform(math.log(500), math.log(3_000_000)))))}

    def do(self, run):
        return "limit of file sizes"

    def codes(self):
        return {0, LIMIT}


class Full(Kind):
    """The disk becomes full in the middle, but for some bytes."""

    def __init__(self, rng, supervised, disk):
        super().__init__(rng, supervised)
        self.rest = disk / "rest"

    def do(self, run):
        space = os.statvfs(self.rest.parent)
        size = space.f_bavail * space.f_bsize - self.rng.choice((0, 0, 4096, 40_000, 400_000))
        with open(self.rest, "wb") as rest:
            try:
                while size > 0:
                    size -= os.write(rest.fileno(), bytes(min(size, 1 << 20)))
            except OSError:  # The run was faster.
                pass
        return "full disk"

    def undo(self):
        self.rest.unlink(missing_ok=True)

    def codes(self):
        return {0, LIMIT}


class Disturbances(resume_test.Case):
    FILES = files_of(pathlib.Path(__file__).resolve().parent / "programs")

    def setUp(self):
        super().setUp()
        self.disk = None
        self.done = collections.Counter()
        whole = self.folder
        if shutil.which("mount") and os.geteuid() == 0:
            try:
                self.disk = self.small_disk(ROOM)
            except Exception as skipped:  # The other disturbances need no disk of their own.
                print(skipped, file=sys.stderr)
        self.folder = self.disk or whole
        if self.disk:
            for name in self.FILES:
                shutil.copy(whole / name, self.disk)
        self.shm = whole / "shm"
        self.shm.mkdir()
        self.environment = {"OMPI_MCA_btl_vader_backing_directory": self.shm}
        # Compiled once: what is disturbed is the run.
        for program in RUNS:
            links = ["--links"] if program in BY_LINKS else []
            self.call("meldc", "compile", f"{program}.meld", "-o", f"{program}.so", "--quiet", *links)
        self.own = self.files()

    def words(self, program):
        return ["run", f"{program}.so", "--world", f"{program}.toml", "--ticks", RUNS[program], "--quiet", "--digest", "d", "--facts-out",
                "f", "--record", "r"]

    def begin_again(self):
        shutil.rmtree(self.folder / "kept", ignore_errors=True)
        self.forget()

    def kind(self, rng, supervised, n):
        # On several processes Open MPI is the first that cannot write its files.
        kinds = [Kill, Kill, Kill, Ask, Stop, NoLargeFiles] if n == 1 else [Kill, Kill, Kill, Ask, Stop]
        if self.disk and rng.randrange(6) == 0:
            return Full(rng, supervised, self.disk)
        return rng.choice(kinds)(rng, supervised)

    def disturbed(self, command, kind, seconds):
        """One process that is disturbed; its exit code and what it said, and what was done to it."""
        run = self.begin("meldsim", *command, environment=self.environment, stdout=subprocess.PIPE, stderr=subprocess.PIPE,
                         start_new_session=True, **kind.options())
        what = None
        try:
            try:
                out, err = run.communicate(timeout=seconds)
            except subprocess.TimeoutExpired:
                try:
                    what = kind.do(run)
                except ProcessLookupError:
                    pass
                out, err = run.communicate(timeout=HANGS_S)
        except subprocess.TimeoutExpired:
            left = subprocess.run(["ps", "-o", "pid,ppid,stat,wchan:20,args", "--sid", str(run.pid)], capture_output=True, text=True)
            for pid in processes_of(run.pid):
                os.kill(pid, signal.SIGKILL)
            self.fail(f"it hangs after {what}: {command}\n{left.stdout}")
        finally:
            kind.undo()
            # An error of the test leaves nobody behind who writes.
            if run.poll() is None:
                run.kill()
        if isinstance(kind, NoLargeFiles):
            what = kind.do(run)
        allowed = {0} if what is None else kind.codes()
        said = (out + err).decode(errors="replace")
        # Where a supervisor was killed, its processes end in order, and meanwhile nobody else may write.
        end = time.monotonic() + HANGS_S
        while processes_of(run.pid) and time.monotonic() < end:
            time.sleep(0.01)
        self.assertEqual(processes_of(run.pid), set(), f"left after {what}: {command}\n{said}")
        self.assertIn(run.returncode, allowed, f"after {what}: {command}\n{said}")
        for wrong in ("crashed", "internal error", "terminate called", "a bug in"):
            if not (wrong == "crashed" and "was killed or crashed" in said):
                self.assertNotIn(wrong, said, f"after {what}: {command}")
        if run.returncode == LIMIT:
            self.assertRegex(said, "cannot write|No space|too large", command)
        if what:
            self.done[what] += 1
        return run.returncode

    def turn(self, number, wanted, takes_s):
        rng = random.Random(f"{TOOLS.seed} {number}")
        program = rng.choice(list(RUNS))
        supervised = rng.randrange(3) == 0
        self.begin_again()
        # Every second turn keeps changes.
        first = [*self.words(program), *KEEP, *("--checkpoint-changes",) * (number % 2), "--retries", 3 if supervised else 0]
        command = [*first, "-n", rng.choice((1, 1, 1, 2, 3))]
        for _ in range(MOST):
            code = self.disturbed(command, self.kind(rng, supervised, command[-1]), rng.uniform(0, takes_s[program, command[-1]]))
            if code == 0:
                break
            n = rng.choice((1, 1, 1, 2, 3))
            if self.manifests():
                command = ["resume", "kept", "--quiet", "-n", n]
            else:
                # What a killed run has begun to record stays under another name: nobody goes on with it.
                self.begin_again()
                command = [*first, "-n", n]
        else:
            self.call("meldsim", *command, environment=self.environment, seconds=HANGS_S)
        self.assertEqual(self.outcome(), wanted[program])
        self.assertLessEqual(self.files() - self.own - {"d", "f", "r", "r.xdmf", "r.lines.xdmf", "kept"},
                             {f"kept/{path.name}" for path in [*self.shares(), *self.manifests()]})
        # What a killed supervisor has left goes with the next run of several processes.
        if list(self.shm.iterdir()):
            self.call("meldsim", *self.words(program)[:4], "--ticks", 1, "--quiet", "-n", 2, environment=self.environment, seconds=HANGS_S)
        self.assertEqual(list(self.shm.iterdir()), [])

    def test_at_random(self):
        wanted, takes_s = {}, {}
        for program in RUNS:
            for n in (1, 2, 3):
                self.begin_again()
                begun = time.monotonic()
                self.call("meldsim", *self.words(program), *KEEP, "-n", n, environment=self.environment, seconds=HANGS_S)
                takes_s[program, n] = time.monotonic() - begun
            wanted[program] = self.outcome()
        end = time.monotonic() + TOOLS.seconds
        number = TOOLS.turn or 0
        while True:
            with self.subTest(seed=TOOLS.seed, turn=number):
                self.turn(number, wanted, takes_s)
            number += 1
            if TOOLS.turn is not None or time.monotonic() > end:
                break
        counts = ", ".join(f"{count} {what}" for what, count in sorted(self.done.items()))
        print(f"{number} runs, {self.done.total()} disturbances: {counts}", file=sys.stderr)


if __name__ == "__main__":
    main("meldc", "meldsim", seconds={"type": float, "default": 60, "help": "begin no other run after so long"},
         seed={"type": int, "default": 1}, turn={"type": int, "help": "only this one"})
