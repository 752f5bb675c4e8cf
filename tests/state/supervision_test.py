"""Runs that are killed, crash or hang and are started again: supervision_test.py --meldc PATH --meldsim PATH [unittest options]

Nobody touches the run; in the end its digests are those of an undisturbed one, byte for byte, and no process and no file is left.
"""

import json
import os
import pathlib
import pty
import random
import shutil
import signal
import subprocess
import sys
import threading
import time

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1]))

from frame import FOREVER, TOOLS, files_of, main  # noqa: E402
from running import LONG_TICK, Running, processes_of, recorded_square, stat  # noqa: E402

PROGRAMS = pathlib.Path(__file__).resolve().parent / "programs"
FAULTY = ("faulty.meld", "--link", "faults.c", "--ticks", "60", "--digest", "d")
KEEP = ("--checkpoint", "kept", "--checkpoint-every", "15ticks")
WAITING = ("waiting.meld", "--ticks", "700", "--quiet", "--digest", "d", "--facts-out", "f")


class Case(Running):
    FILES = Running.FILES | files_of(PROGRAMS)

    def begin_again(self, fault="", once=True):
        for name in ("d", "f", "once", "fault"):
            (self.folder / name).unlink(missing_ok=True)
        shutil.rmtree(self.folder / "kept", ignore_errors=True)
        if fault:
            self.write("fault", fault)
        if once:
            self.write("once", "")

    def whole(self, *arguments):
        """What an undisturbed run writes."""
        self.begin_again()
        run = self.start(*arguments)
        self.ended(run, [0])
        return self.outcome()

    def outcome(self):
        return [(self.folder / name).read_bytes() for name in "df" if (self.folder / name).exists()]

    def parts(self, run):
        """The processes that compute."""
        def computes(pid):
            try:
                return os.readlink(f"/proc/{pid}/exe") == os.path.realpath(TOOLS.meldsim)
            except OSError:
                return False
        return sorted(pid for pid in processes_of(run.pid) - {run.pid} if computes(pid))

    def checkpoints_are_made(self, run, count=1):
        self.wait_for(lambda: len(list((self.folder / "kept").glob("*.json"))) >= count, run)


class Crashes(Case):
    def test_once(self):
        wanted = self.whole(*FAULTY, "--quiet")
        for n, fault, says in ((1, "abort", "signal 6: Aborted"), (1, "kill", "killed (signal 9)"),
                               (2, "segv", "signal 11: Segmentation fault")):
            with self.subTest(n=n, fault=fault):
                self.begin_again(fault)
                run = self.start(*FAULTY, *KEEP, "-n", n, "--json")
                out, err = run.communicate(timeout=60)
                self.assertEqual(run.returncode, 0, err)
                self.assertIn(says, err)
                self.assertIn("in tick 40", err)
                self.assertIn("restart 1 of 3, from the checkpoint of tick 30", err)
                self.assertEqual(self.outcome(), wanted)
                restarts = json.loads(out)["restarts"]
                self.assertEqual([(r["in_tick"], r["from_tick"]) for r in restarts], [(40, 30)])
                self.assertIn(says, restarts[0]["reason"])
                self.assertEqual(os.listdir(self.folder / "shm"), [])
                self.assertEqual(processes_of(run.pid), set())

    def test_before_the_first_checkpoint(self):
        wanted = self.whole(*FAULTY, "--quiet")
        self.begin_again("abort")
        run = self.start(*FAULTY, "--checkpoint", "kept")
        out, err = self.run_out(run, 0)
        self.assertIn("restart 1 of 3, from the start", err)
        self.assertRegex(out, r"restarted +from the start, after the run crashed .* in tick 40")
        self.assertEqual(self.outcome(), wanted)

    def run_out(self, run, code):
        out, err = run.communicate(timeout=60)
        self.assertEqual(run.returncode, code, out + err)
        return out, err

    def test_the_same_again(self):
        self.begin_again("abort", once=False)
        run = self.start(*FAULTY, *KEEP, "--quiet")
        _, err = self.run_out(run, 134)
        self.assertEqual(err.count("restart "), 1, err)
        self.assertRegex(err, "crashed .* in tick 40.*; that is the second time, and it would come again. "
                         "The last checkpoint is of tick 30: `meldsim resume kept`")
        # Somebody has removed the cause.
        (self.folder / "fault").unlink()
        self.call("meldsim", "resume", "kept", "--quiet")
        self.assertEqual(self.outcome(), self.whole(*FAULTY, "--quiet"))

    def test_restarts_are_used_up(self):
        self.begin_again("kill", once=False)
        run = self.start(*FAULTY, *KEEP, "--retries", 2, "--quiet")
        _, err = self.run_out(run, 137)
        self.assertEqual(err.count("killed (signal 9) in tick 40, in the evaluation of the program; restart "), 2, err)
        self.assertIn("2 restarts are used up", err)

    def test_resume_has_restarts_of_its_own(self):
        wanted = self.whole(*FAULTY, "--quiet")
        self.begin_again("kill", once=False)
        self.run_out(self.start(*FAULTY, *KEEP, "--retries", 1, "--quiet"), 137)
        for retries, code in ((0, -signal.SIGKILL), (2, 137)):
            done = self.run_tool("meldsim", "resume", "kept", "--retries", retries, "--quiet")
            self.assertEqual((done.returncode, done.stderr.count("; restart ")), (code, retries), done.stderr)
        # The command of the run counts where nothing else is said.
        done = self.run_tool("meldsim", "resume", "kept", "--quiet")
        self.assertEqual((done.returncode, done.stderr.count("; restart 1 of 1")), (137, 1), done.stderr)
        self.write("fault", "sleep")
        done = self.run_tool("meldsim", "resume", "kept", "--heartbeat", "700ms", "--quiet")
        self.assertEqual((done.returncode, done.stderr.count("hung, without a sign of life for 700 ms")), (4, 2), done.stderr)
        (self.folder / "fault").unlink()
        self.call("meldsim", "resume", "kept", "--quiet")
        self.assertEqual(self.outcome(), wanted)

    def test_what_is_no_accident(self):
        """Errors of the program, of the world and of limits are told once."""
        self.write("wrong.meld", "type clock(node, int).\ntype p(node, int).\nclock(A, T) :- tick(A, T).\n"
                   "p(A, 9000000000000000000 + T * 10000000000000000) :- clock(A, T).\n")
        for n, program, options, code in ((1, "wrong.meld", ("--strict",), 1), (2, "wrong.meld", ("--strict",), 1),
                                          (1, "faulty.meld", ("--link", "faults.c", "--timeout", "0.3"), 4),
                                          (1, "waiting.meld", ("--world", "nowhere.toml"), 2)):
            with self.subTest(n=n, program=program):
                self.begin_again("sleep" if code == 4 else "")
                run = self.start(program, "--ticks", 5000000, "--quiet", *options, *KEEP, "-n", n)
                _, err = self.run_out(run, code)
                self.assertNotIn("restart", err)

    def test_without_retries_nobody_looks_after_the_run(self):
        self.begin_again("abort")
        run = self.start(*FAULTY, *KEEP, "--retries", 0, "--quiet")
        _, err = self.run_out(run, -signal.SIGABRT)
        self.assertEqual(err, "")


class Hangs(Case):
    def test_once(self):
        wanted = self.whole(*FAULTY, "--quiet")
        for n, fault in ((1, "sleep"), (2, "loop")):
            with self.subTest(n=n):
                self.begin_again(fault)
                run = self.start(*FAULTY, *KEEP, "-n", n, "--heartbeat", "1s", "--quiet")
                _, err = run.communicate(timeout=60)
                self.assertEqual(run.returncode, 0, err)
                self.assertRegex(err, r"(the run|process \d) hung, without a sign of life for 1\S* s, in tick 40, in the evaluation of "
                                 "the program; restart 1 of 3, from the checkpoint of tick 30")
                self.assertEqual(self.outcome(), wanted)
                self.assertEqual(os.listdir(self.folder / "shm"), [])
                self.assertEqual(processes_of(run.pid), set())

    def test_the_same_again(self):
        self.begin_again("sleep", once=False)
        run = self.start(*FAULTY, *KEEP, "--heartbeat", "700ms", "--quiet")
        _, err = run.communicate(timeout=60)
        self.assertEqual(run.returncode, 4, err)
        self.assertEqual(err.count("restart "), 1, err)
        self.assertIn("that is the second time", err)
        self.assertIn("raise --heartbeat", err)

    def test_a_stopped_process(self):
        wanted = self.whole(*WAITING)
        for n in (1, 2):
            with self.subTest(n=n):
                self.begin_again()
                run = self.start(*WAITING, *KEEP, "-n", n, "--heartbeat", "1s")
                self.checkpoints_are_made(run)
                stopped = self.parts(run)[-1]
                os.kill(stopped, signal.SIGSTOP)
                _, err = run.communicate(timeout=60)
                self.assertEqual(run.returncode, 0, err)
                self.assertIn("was stopped by a signal or a debugger, without a sign of life for 1", err)
                self.assertIsNone(stat(stopped))
                self.assertEqual(self.outcome(), wanted)

    def test_a_long_tick_is_none(self):
        self.write("long.meld", LONG_TICK.replace("turn(10, I)", "turn(7, I)"))
        self.write("middle.toml", recorded_square(128))
        run = self.start("long.meld", "--world", "middle.toml", "-n", 2, *KEEP, "--heartbeat", "1s", "--json")
        out, err = run.communicate(timeout=60)
        self.assertEqual((run.returncode, err), (0, ""))
        self.assertGreater(json.loads(out)["stage_seconds"]["evaluation"], 1.2, "the tick is too short for this test")

    def test_a_reader_that_pauses_is_none(self):
        """Neither one that has not come yet nor one that leaves the pipe full, as a pager does."""
        self.write("talks.meld", FOREVER + "print(A, int2str(N)) :- tick(A, N).\n")
        self.begin_again()
        os.mkfifo(self.folder / "fifo")
        run = self.start("talks.meld", "--world", "small.toml", "--ticks", 300, "--facts-out", "fifo", *KEEP, "--heartbeat", "500ms",
                         "--quiet")
        time.sleep(1.5)
        facts = []
        reader = threading.Thread(target=lambda: facts.append((self.folder / "fifo").read_text()), daemon=True)
        reader.start()
        time.sleep(1.5)
        out, err = run.communicate(timeout=60)
        self.assertEqual((run.returncode, err), (0, ""))
        self.assertEqual((out.count("\n"), out.split()[-1]), (30000, "300"))
        reader.join(60)
        self.assertEqual(facts[0].count("\n"), 100)

    def test_a_supervisor_that_was_stopped(self):
        """Time in which it could not look does not count."""
        self.begin_again()
        run = self.start("forever.meld", "--world", "small.toml", "--digest", "d", *KEEP, "--heartbeat", "1500ms", "--quiet")
        self.ticks_are_made(run)
        child, = self.parts(run)
        for pid in (child, run.pid):
            os.kill(pid, signal.SIGSTOP)
        time.sleep(2)
        for pid in (run.pid, child):
            os.kill(pid, signal.SIGCONT)
        time.sleep(0.3)
        self.assertEqual(self.parts(run), [child])
        run.send_signal(signal.SIGINT)
        self.ended(run, [130])

    def test_times(self):
        for wrong in ("soon", "0", "-1s"):
            run = self.start(*FAULTY, f"--heartbeat={wrong}")
            _, err = run.communicate(timeout=60)
            self.assertEqual(run.returncode, 2, err)
            self.assertIn("60s or 10min, or off", err)


class Alone(Case):
    """A run of one process that is supervised behaves as one that is not."""
    RUN = ("forever.meld", "--world", "small.toml", "--digest", "d", "--facts-out", "f", "--checkpoint", "kept",
           "--checkpoint-every", "10000ticks")

    def test_signals(self):
        for sent, code in ((signal.SIGINT, 130), (signal.SIGTERM, 143), (signal.SIGHUP, 130)):
            for to in (os.kill, os.killpg):
                with self.subTest(sent=sent, to=to.__name__):
                    self.begin_again()
                    run = self.start(*self.RUN, "--quiet")
                    self.ticks_are_made(run)
                    to(run.pid, sent)
                    out, err = self.ended(run, [code])
                    self.assertEqual(out + err, "")
                    self.assertIsNotNone(self.check_whole())

    def check_whole(self):
        """Digest, facts and checkpoint are of one tick."""
        last = int((self.folder / "d").read_text().splitlines()[-1].split()[1])
        self.assertEqual((self.folder / "f").read_text().splitlines()[0], f"p(@0, {last}).")
        self.assertEqual(max(int(p.name.split(".")[0]) for p in (self.folder / "kept").glob("*.json")), last)
        return last

    def test_to_the_process_itself(self):
        for sent, code in ((signal.SIGTERM, 143), (signal.SIGINT, 130)):
            with self.subTest(sent=sent):
                self.begin_again()
                run = self.start(*self.RUN, "--quiet")
                self.ticks_are_made(run)
                os.kill(self.parts(run)[0], sent)
                out, err = self.ended(run, [code])
                self.assertEqual(out + err, "")
                self.check_whole()

    def test_a_program_that_has_been_removed(self):
        """While it compiled."""
        (self.folder / "bin").mkdir()
        mine = shutil.copy(TOOLS.meldsim, self.folder / "bin")
        (self.folder / "bin/meldc").symlink_to(TOOLS.meldc)
        run = subprocess.Popen([mine, "run", *self.RUN, "--quiet"], cwd=self.folder, stdout=subprocess.PIPE, stderr=subprocess.PIPE,
                               text=True, env=dict(os.environ, CLAYMELD_CACHE=str(self.folder / "cache")))
        os.unlink(mine)
        out, err = run.communicate(timeout=60)
        self.assertEqual((run.returncode, out), (127, ""))
        self.assertRegex(err, "^meldsim: the process that computes cannot be started. .* removed or replaced")

    def test_twice(self):
        self.begin_again()
        run = self.start("long.meld", "--world", "large.toml", *KEEP)
        self.wait_for(lambda: self.parts(run), run)
        time.sleep(1)
        for _ in range(2):
            run.send_signal(signal.SIGTERM)
            time.sleep(0.2)
        self.ended(run, [143])

    def test_as_soon_as_it_starts(self):
        for delay in (0, 0.01, 0.03, 0.06):
            self.begin_again()
            run = self.start(*self.RUN, "--quiet")
            time.sleep(delay)
            run.send_signal(signal.SIGTERM)
            self.ended(run, [143, -signal.SIGTERM])

    def test_the_supervisor_is_killed(self):
        self.begin_again()
        run = self.start(*self.RUN, "--quiet")
        self.ticks_are_made(run)
        run.kill()
        self.ended(run, [-signal.SIGKILL])

    def test_it_costs_little_memory(self):
        self.begin_again()
        run = self.start(*self.RUN, "--quiet")
        self.ticks_are_made(run)
        status = pathlib.Path(f"/proc/{run.pid}/status").read_text()
        own = sum(int(line.split()[1]) for line in status.splitlines() if line.startswith("RssAnon:"))
        self.assertLess(own, 8192)
        run.send_signal(signal.SIGINT)
        self.ended(run, [130])

    def test_on_a_terminal(self):
        """Ctrl-C and Ctrl-Z are the terminal's, and the progress line is shown."""
        self.begin_again()
        pid, terminal = pty.fork()
        if pid == 0:
            os.chdir(self.folder)
            os.execv(TOOLS.meldsim, [TOOLS.meldsim, "run", *self.RUN])
        shown = b""
        end = time.monotonic() + 60
        while b"tick 1" not in shown and time.monotonic() < end:
            shown += os.read(terminal, 4096)
        self.assertIn(b"tick 1", shown)
        os.write(terminal, b"\x03")
        try:
            while os.read(terminal, 4096):
                pass
        except OSError:
            pass
        self.assertEqual(os.waitstatus_to_exitcode(os.waitpid(pid, 0)[1]), 130)
        os.close(terminal)
        self.check_whole()


class Killed(Case):
    """Any process of the run, and mpirun, at random moments."""

    def victims(self, run):
        # While it compiles, nothing is lost yet that a restart would save.
        return [pid for pid in sorted(processes_of(run.pid) - {run.pid}) if self.name(pid) in ("meldsim", "mpirun")]

    def name(self, pid):
        try:
            return pathlib.Path(f"/proc/{pid}/comm").read_text().strip()
        except OSError:
            return ""

    def test_at_random(self):
        generator = random.Random(TOOLS.seed)
        wanted = self.whole(*WAITING)
        takes_s = {n: self.takes(n) for n in (1, 2)}
        kills = turns = 0
        while turns < TOOLS.runs or (kills == 0 and turns < 50):
            turns += 1
            n = generator.choice((1, 2, 2))
            with self.subTest(turn=turns, n=n):
                self.begin_again()
                run = self.start(*WAITING, *KEEP, "-n", n, "--retries", 10)
                for _ in range(TOOLS.kills):
                    time.sleep(generator.uniform(0, takes_s[n]))
                    # The processes that compute, and mpirun.
                    self.wait_for(lambda run=run: self.victims(run), run)
                    victims = self.victims(run)
                    if run.poll() is not None or not victims:
                        break
                    try:
                        os.kill(generator.choice(victims), signal.SIGKILL)
                        kills += 1
                    except ProcessLookupError:
                        pass
                _, err = run.communicate(timeout=120)
                self.assertEqual(run.returncode, 0, err)
                self.assertEqual(self.outcome(), wanted, err)
                self.assertEqual(os.listdir(self.folder / "shm"), [], "shared memory is left")
                self.assertEqual(processes_of(run.pid), set())
        print(f"{kills} kills in {turns} runs", file=sys.stderr)
        self.assertGreater(kills, 0)

    def takes(self, n):
        """Seconds of a run with checkpoints that nobody disturbs."""
        self.begin_again()
        start = time.monotonic()
        self.ended(self.start(*WAITING, *KEEP, "-n", n), [0])
        return time.monotonic() - start

    def test_the_supervisor_of_several(self):
        """Its processes go with it, and the next run removes what is left in shared memory."""
        self.begin_again()
        run = self.start("forever.meld", "--world", "small.toml", "--digest", "d", *KEEP, "-n", 2, "--quiet")
        self.checkpoints_are_made(run)
        run.kill()
        run.communicate(timeout=60)
        self.wait_for(lambda: not processes_of(run.pid), self.start("waiting.meld", "--ticks", 1, "--quiet"))
        end = time.monotonic() + 10
        while processes_of(run.pid) and time.monotonic() < end:
            time.sleep(0.05)
        self.assertEqual(processes_of(run.pid), set())
        self.ended(self.start("waiting.meld", "--ticks", 1, "--quiet", "-n", 2), [0])


class ShapeChange(Case):
    """A cube of 10,648 metamodules becomes a trumpet on two processes, of which one is killed ten times; --side 46: of 97,336."""
    WORLD = """
lattice = "cubic"

[[body]]
shape = "box({side}, {side}, {side})"

[target]
shape = "{target}"
fit = "mass"

[facts]
given-seed = ["cell == {seed}"]

[motion]
kind = "lattice"
capacity = 1
"""
    SIDES = {22: ("move(trumpet(length=60, bell=30, wall=3), -42, 0, 0)", "(-3, -6, -2)"),
             46: ("move(scale(trumpet(length=60, bell=30, wall=3), 2.0909), -87.8, 0, 0)", "(-5, -9, -9)")}
    RUN = ("shape_change.meld", "--world", "cube.toml", "--checkpoint-every", "500ms", "--facts-out", "f", "--json")

    def setUp(self):
        super().setUp()
        shutil.copy(PROGRAMS.parents[2] / "examples/meld/shape_change.meld", self.folder)
        target, seed = self.SIDES[TOOLS.side]
        self.write("cube.toml", self.WORLD.format(side=TOOLS.side, target=target, seed=seed))

    def run_whole(self, *options):
        run = self.start(*self.RUN, *options)
        out, err = run.communicate(timeout=3600)
        self.assertEqual(run.returncode, 0, err)
        return json.loads(out), (self.folder / "f").read_bytes()

    def test_killed_ten_times(self):
        generator = random.Random(TOOLS.seed)
        begun = time.monotonic()
        summary, wanted = self.run_whole("-n", 2, "--checkpoint", "whole")
        seconds = time.monotonic() - begun
        run = self.start(*self.RUN, "-n", 2, "--checkpoint", "kept", "--retries", 20)
        kills = 0
        while kills < 10:
            time.sleep(generator.uniform(0, seconds / 5))
            self.wait_for(lambda: self.parts(run), run)
            self.assertIsNone(run.poll(), "it has ended before the kills")
            try:
                os.kill(generator.choice(self.parts(run)), signal.SIGKILL)
                kills += 1
            except (ProcessLookupError, IndexError):
                pass
        out, err = run.communicate(timeout=3600)
        self.assertEqual(run.returncode, 0, err)
        disturbed = json.loads(out)
        self.assertEqual(disturbed["ticks"], summary["ticks"])
        self.assertGreaterEqual(len(disturbed["restarts"]), 5, err)
        self.assertEqual((self.folder / "f").read_bytes(), wanted)
        self.assertEqual(self.call("meldsim", "diff", "whole", "kept", seconds=3600)[0], "")
        ticks = [restart["in_tick"] for restart in disturbed["restarts"]]
        print(f"{summary['catoms']} catoms, {summary['ticks']} ticks, {kills} kills; restarted in ticks {ticks}", file=sys.stderr)

    def test_stopped_on_two_goes_on_with_three_and_with_one(self):
        summary, wanted = self.run_whole("-n", 2)
        run = self.start(*self.RUN, "-n", 2, "--checkpoint", "kept")
        self.checkpoints_are_made(run)
        run.send_signal(signal.SIGINT)
        run.communicate(timeout=60)
        self.assertEqual(run.returncode, 130)
        for n, ticks, code in ((3, summary["ticks"] // 2, 0), (1, None, 0)):
            options = ["--ticks", str(ticks)] if ticks else ["--ticks", str(summary["ticks"])]
            self.call("meldsim", "resume", "kept", "-n", n, "--quiet", *options, code=code, seconds=3600)
        self.assertEqual((self.folder / "f").read_bytes(), wanted)


if __name__ == "__main__":
    main("meldc", "meldsim", runs={"type": int, "default": 1}, kills={"type": int, "default": 3, "help": "in each run"},
         seed={"type": int, "default": 1},
         side={"type": int, "default": 22, "choices": ShapeChange.SIDES, "help": "of the cube that changes its shape"})
