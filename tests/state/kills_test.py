"""Runs that are killed until they end: kills_test.py --meldc PATH --meldsim PATH [--kills N] [--seconds S] [--seed N] [--turn T]

SIGKILL hits a run while it is set up, while it goes on from a checkpoint, in the middle of a tick, and while it writes a checkpoint. It
goes on from the newest checkpoint on any number of processes, and in the end its digests and facts are those of a run that nobody
disturbed, byte for byte, and its recording has the same data. No process, no shared memory and no file is left. At the end the test says
how many kills there were, and what the runs were doing. A turn is made again by --turn.

Programs are compiled once, and the disk is in memory, so that a kill takes a tenth of a second. Where a process is it tells in a table, as
to a supervisor (runtime/base/process/liveness.h).
"""

import collections
import mmap
import os
import pathlib
import random
import shutil
import signal
import struct
import subprocess
import sys
import tempfile
import time

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1]))

import resume_test  # noqa: E402
from frame import TOOLS, files_of, main  # noqa: E402
from running import children, processes_of  # noqa: E402

# Short runs with tens of checkpoints.
RUNS = {"waiting": 300, "storm": 60, "doze": 60, "tumble": 60, "chains": 40, "pieces": 40}
KEEP = ("--checkpoint", "kept", "--checkpoint-every", "7ticks")
MOST = 30  # Kills of a run.
HANGS_S = 300  # Without a sign of life. The machine may be busy with something else, and three processes may then take minutes.
SIGNS = "CLAYMELD_LIVENESS"
PHASES = ("set-up", "modules", "evaluation", "exchange", "recording", "checkpoint")
SET_UP, CHECKPOINT = 0, 5


class Signs:
    """The table in which the processes of a run tell where they are; it outlives them."""
    PLACE = struct.Struct("<QqIi4xiiB")  # Beats, tick, phase, process, writes, here, left.
    BYTES = 64

    def __init__(self, path):
        with open(path, "rb") as file:
            self.table = mmap.mmap(file.fileno(), 0, prot=mmap.PROT_READ)

    def beats(self):
        return sum(self.PLACE.unpack_from(self.table, at)[0] for at in range(0, len(self.table), self.BYTES))

    def of(self, pid):
        """Its phase, and whether it has come to its own end; nothing before it has begun."""
        for at in range(0, len(self.table), self.BYTES):
            _, _, phase, process, _, _, left = self.PLACE.unpack_from(self.table, at)
            if process == pid:
                return phase, left != 0
        return None

    @classmethod
    def told_to(cls, pid):
        """The table of a process that somebody supervises; nothing if it has ended or is not told of one."""
        try:
            variables = pathlib.Path(f"/proc/{pid}/environ").read_bytes().split(b"\0")
            return next((cls(os.fsdecode(v.split(b"=", 1)[1])) for v in variables if v.startswith(SIGNS.encode() + b"=")), None)
        except (OSError, ValueError):
            return None


class Kills(resume_test.Case):
    FILES = files_of(pathlib.Path(__file__).resolve().parent / "programs")

    def setUp(self):
        before, memory = tempfile.tempdir, pathlib.Path("/dev/shm")
        tempfile.tempdir = str(memory) if memory.is_dir() else None
        super().setUp()
        tempfile.tempdir = before
        self.shm = self.folder / "shm"
        self.shm.mkdir()
        self.environment = {"OMPI_MCA_btl_vader_backing_directory": self.shm}
        self.done = collections.Counter()
        for program in RUNS:
            self.call("meldc", "compile", f"{program}.meld", "-o", f"{program}.so", "--quiet")
        self.own = self.files()

    def words(self, program):
        return ["run", f"{program}.so", "--world", f"{program}.toml", "--ticks", RUNS[program], "--quiet", "--digest", "d", "--facts-out",
                "f", "--record", "r"]

    def forget(self):
        super().forget()
        (self.folder / "signs").unlink(missing_ok=True)

    def begin_again(self):
        shutil.rmtree(self.folder / "kept", ignore_errors=True)
        self.forget()

    def computing(self, run, n, supervised):
        """The processes that compute: the one that was started, or what it or its mpirun has started."""
        if n > 1:
            return [p for launcher in children(run.pid) for p in children(launcher)]
        return children(run.pid) if supervised else [run.pid]

    def aim(self, rng, run, n, supervised, takes_s):
        """Waits for a moment; returns a process and where it tells what it does, or nothing if the run was faster."""
        wanted = rng.choice(("any", "any", "start", "checkpoint", "checkpoint"))
        end = time.monotonic() + (rng.uniform(0, takes_s) if wanted == "any" else HANGS_S)
        late = rng.uniform(0, 0.06 if wanted == "start" else 0.002)
        skip = rng.randrange(3)
        victim = signs = None
        last, seen = None, 0
        while run.poll() is None and time.monotonic() < end:
            if victim is None:
                found = self.computing(run, n, supervised)
                if not found:
                    time.sleep(0.001)
                    continue
                victim = rng.choice(found)
            if signs is None and n == 1 and not supervised:
                signs = Signs(self.folder / "signs")
            elif signs is None:
                signs = Signs.told_to(victim)
            if wanted == "start":
                break
            now = signs.of(victim) if signs else None
            # So many checkpoints are let through.
            seen += now is not None and now[0] == CHECKPOINT != last
            last = now[0] if now else None
            if wanted == "checkpoint" and seen > skip:
                break
            time.sleep(0.0001)
        time.sleep(late)
        return victim, signs

    def wait_for_end(self, run, n, supervised, signs):
        """As long as it gives signs of life."""
        beats, since = None, time.monotonic()
        while run.poll() is None:
            time.sleep(0.002)
            if signs is None:
                signs = next(filter(None, map(Signs.told_to, self.computing(run, n, supervised))), None)
            if signs and signs.beats() != beats:
                beats, since = signs.beats(), time.monotonic()
            if time.monotonic() < since + HANGS_S:
                continue
            left = subprocess.run(["ps", "-o", "pid,ppid,stat,wchan:20,args", "--sid", str(run.pid)], capture_output=True, text=True)
            # Those of the next turns write to the same files.
            for pid in processes_of(run.pid):
                os.kill(pid, signal.SIGKILL)
            run.wait()
            self.fail(f"it hangs: {run.args}\n{left.stdout}")

    def killed(self, rng, command, n, supervised, takes_s):
        """One process that is killed: whether the run has come to its end."""
        signs = self.folder / "signs"
        environment = dict(self.environment)
        if n == 1 and not supervised:
            signs.write_bytes(bytes(Signs.BYTES))
            environment[SIGNS] = signs
        run = self.begin("meldsim", *command, environment=environment, stdout=subprocess.PIPE, stderr=subprocess.PIPE,
                         start_new_session=True)
        goes_on = command[0] == "resume"
        kills, table = 0, None
        # One that is supervised goes on by itself.
        for _ in range(rng.randrange(1, 8) if supervised else 1):
            victim, table = self.aim(rng, run, n, supervised, takes_s)
            if victim is None or run.poll() is not None:
                break
            try:
                os.kill(victim, signal.SIGKILL)
            except ProcessLookupError:
                continue
            kills += 1
            if supervised:
                end = time.monotonic() + HANGS_S
                while run.poll() is None and victim in self.computing(run, n, supervised) and time.monotonic() < end:
                    time.sleep(0.001)
            else:
                self.wait_for_end(run, n, supervised, table)
            self.count(table.of(victim) if table else None, goes_on or (supervised and kills > 1), n)
        self.wait_for_end(run, n, supervised, table)
        out, err = run.communicate(timeout=HANGS_S)
        said = (out + err).decode(errors="replace")
        codes = {0, 137, -signal.SIGKILL} if kills and not supervised else {0}
        self.assertIn(run.returncode, codes, f"{command}\n{said}")
        for wrong in ("internal error", "terminate called", "a bug in", "does not give back"):
            self.assertNotIn(wrong, said, command)
        end = time.monotonic() + HANGS_S
        while (n > 1 or supervised) and processes_of(run.pid) and time.monotonic() < end:
            time.sleep(0.01)
        self.assertEqual(processes_of(run.pid) if n > 1 or supervised else set(), set(), f"left of {command}\n{said}")
        return run.returncode == 0

    def count(self, at, goes_on, n):
        """A kill, by what the process was doing."""
        if at is None or (at[0] == SET_UP and not at[1]):
            state = "while resuming" if goes_on else "in the set-up"
        elif at[1]:
            state = "at its end"
        elif at[0] == CHECKPOINT:
            state = "while writing a checkpoint"
        else:
            state = f"in or between ticks ({PHASES[at[0]]})"
        self.done[state] += 1
        self.done["on several processes"] += n > 1

    def count_of_kills(self):
        return self.done.total() - self.done["on several processes"]

    def turn(self, number, wanted, takes_s):
        rng = random.Random(f"{TOOLS.seed} {number}")
        program = rng.choice(list(RUNS))
        several = rng.randrange(12) == 0
        supervised = not several and rng.randrange(5) == 0

        def processes():
            return rng.choice((1, 2, 3)) if several else 1
        self.begin_again()
        n = processes()
        # Every second turn keeps changes.
        keep = (*KEEP, *("--checkpoint-changes",) * (number % 2))
        command = first = [*self.words(program), *keep, "--retries", 100 if supervised else 0]
        parts = set()
        for _ in range(MOST):
            if self.killed(rng, [*command, "-n", n], n, supervised, takes_s[program] * (4 if n > 1 else 1)):
                break
            n = processes()
            if self.manifests():
                command = ["resume", "kept", "--quiet"]
            else:
                # Or what there is stays until the new run is whole.
                shutil.rmtree(self.folder / "kept", ignore_errors=True)
                if rng.randrange(2):
                    self.forget()
                # What a killed run has begun to write stays under another name: nobody goes on with it.
                parts = {name for name in self.files() if ".part-" in name}
                command = first
        else:
            self.call("meldsim", *command, "-n", n, environment=self.environment, seconds=HANGS_S)
        self.assertEqual(self.outcome(), wanted[program])
        self.assertEqual([path.name.split(".")[0] for path in self.manifests()][-1:], [str(RUNS[program])])
        # A lock that a killed run has left goes with its file.
        kept = [*self.shares(), *self.manifests()]
        self.assertLessEqual(self.files() - self.own - {"d", "f", "r", "r.xdmf", "r.lines.xdmf", "kept", "signs"} - parts,
                             {f"kept/{path.name}" for path in kept} | {f"kept/.{path.name}.claymeld-lock" for path in kept})
        # What a killed launcher has left in shared memory goes with the next run of several processes.
        if list(self.shm.iterdir()):
            self.call("meldsim", *self.words(program)[:4], "--ticks", 1, "--quiet", "-n", 2, environment=self.environment, seconds=HANGS_S)
        self.assertEqual(list(self.shm.iterdir()), [])

    def test_kills(self):
        wanted, takes_s = {}, {}
        for program in RUNS:
            self.begin_again()
            begun = time.monotonic()
            self.call("meldsim", *self.words(program), *KEEP, seconds=HANGS_S)
            takes_s[program] = time.monotonic() - begun
            wanted[program] = self.outcome()
        begun = time.monotonic()
        number = TOOLS.turn or 0
        while True:
            with self.subTest(seed=TOOLS.seed, turn=number):
                try:
                    self.turn(number, wanted, takes_s)
                except AssertionError as wrong:
                    # A campaign is long: at once.
                    print(f"seed {TOOLS.seed}, turn {number}: {wrong}", file=sys.stderr, flush=True)
                    raise
            number += 1
            if TOOLS.turn is not None or self.count_of_kills() >= TOOLS.kills or time.monotonic() > begun + TOOLS.seconds:
                break
        counts = ", ".join(f"{count} {what}" for what, count in sorted(self.done.items()))
        print(f"{self.count_of_kills()} kills in {number} runs, in {time.monotonic() - begun:.0f} s: {counts}", file=sys.stderr)
        self.assertGreater(self.count_of_kills(), 0)


if __name__ == "__main__":
    main("meldc", "meldsim", kills={"type": int, "default": 60, "help": "begin no other run after so many"},
         seconds={"type": float, "default": 3600, "help": "begin no other run after so long"},
         seed={"type": int, "default": 1}, turn={"type": int, "help": "only this one"})
