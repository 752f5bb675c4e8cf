"""`meldsim debug`: whatever way a tick is reached, what it shows is what a run to that tick writes, on any number of processes.

    debug_test.py --meldc PATH --meldsim PATH [--walks N] [unittest options]
"""
import fcntl
import functools
import json
import os
import pty
import random
import re
import select
import signal
import struct
import subprocess
import sys
import termios
import time
from pathlib import Path

import h5py

ROOT = Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT / "tests"))

from frame import TOOLS, Case, main  # noqa: E402

EXAMPLES = ROOT / "examples/meld"
OWN = Path(__file__).resolve().parent / "programs"
GRADIENT = EXAMPLES / "gradient.meld"
# Programs, their worlds and how many ticks of them: views while catoms move, linear facts that wait, bodies, and a component with a state.
WALKS = ((EXAMPLES / "walk.meld", None, 30), (OWN / "storm.meld", None, 24), (OWN / "waiting.meld", None, 60),
         (ROOT / "tests/programs/bodies/crowd.meld", OWN / "heap.toml", 20), (EXAMPLES / "thermometer.meld", None, 30))
# Processes, and memory for snapshots: all that there is, so little that most are dropped, and none.
SETUPS = ((1, "300kB"), (2, "0"), (1, "1GiB"), (3, "300kB"), (1, "0"), (2, "1GiB"))


@functools.cache
def facts_at(program, world, tick):
    command = [TOOLS.meldsim, "run", program, "--ticks", str(tick), "--quiet", "--facts-out", "-"]
    done = subprocess.run(command + (["--world", world] if world else []), capture_output=True, text=True)
    return done.stdout


class DebugTest(Case):
    def path(self, name, text=None):
        return self.folder / name if text is None else self.write(name, text)

    def meldsim(self, *arguments, stdin="", code=0, **options):
        """It ends with this code; returns the process."""
        done = self.run_tool("meldsim", *arguments, stdin=None, input=stdin.encode(), **options)
        self.assertEqual(done.returncode, code, done.stderr)
        return done

    def session(self, commands, *arguments, code=0):
        return self.meldsim("debug", *arguments, stdin="".join(c + "\n" for c in commands), code=code)

    def answers(self, commands, *arguments, code=0):
        return [json.loads(line) for line in self.session(commands, *arguments, "--json", code=code).stdout.splitlines()]


class Walks(DebugTest):
    def walk(self, program, world, last, processes, history, seed):
        """Commands, and the ticks to which they lead."""
        rng = random.Random(f"{program} {processes} {history} {seed}")
        stops = sorted(rng.sample(range(last + 1), 4)) + [last]
        commands, ticks, now = [], [], 0
        for _ in range(9):
            there = rng.choice(stops)
            steps = there - now
            commands.append(f"to {there}" if steps == 0 or rng.random() < 0.4 else f"step {steps}" if steps > 0 else f"back {-steps}")
            ticks.append(there)
            now = there
        both = [c for command in commands for c in (command, "facts")]
        answers = self.answers(both, program, "-n", processes, "--history", history, "--ticks", last,
                               *(["--world", world] if world else []))
        self.assertEqual(len(answers), len(both))
        for tick, moved, found in zip(ticks, answers[::2], answers[1::2]):
            self.assertEqual((moved["tick"], found["tick"]), (tick, tick))
            self.assertEqual("".join(f + "\n" for f in found["facts"]), facts_at(program, world, tick), f"tick {tick} of {commands}")
            self.assertEqual(found["count"], len(found["facts"]))

    def test_facts_are_those_of_a_run(self):
        for i, (program, world, last) in enumerate(WALKS):
            for processes, history in SETUPS if TOOLS.walks > 1 else (SETUPS[2 * i % 6], SETUPS[(2 * i + 1) % 6]):
                with self.subTest(program=program.name, world=world, processes=processes, history=history):
                    for seed in range(TOOLS.walks):
                        self.walk(program, world, last, processes, history, seed)

    def test_answers_do_not_depend_on_processes(self):
        commands = ["where", "step", "diff", "facts @0", "step 12", "diff", "facts last", "back 5", "diff", "diff 2", "facts @30 seen",
                    "run", "diff", "where", "step", "to 0", "facts"]
        results = []
        for processes in (1, 2, 3):
            answers = self.answers(commands, OWN / "storm.meld", "--ticks", 25, "-n", processes)
            for answer in answers:
                for key in ("history_bytes", "snapshots", "oldest_snapshot"):
                    answer.pop(key, None)
            results.append(answers)
        self.assertEqual(len(results[0]), len(commands))
        self.assertEqual(results[1:], results[:1] * 2)
        run = results[0][11]
        self.assertEqual((run["from"], run["tick"], run["ended"]), (8, 25, "ticks"))

    def test_history_is_bounded(self):
        sizes = {}
        for history in ("0", "1", "300kB", "1GiB"):
            *_, at = self.answers(["to 24", "where"], OWN / "storm.meld", "--history", history)
            sizes[history] = at["history_bytes"], at["snapshots"]
            self.assertEqual(at["oldest_snapshot"] is None, history == "0")
        self.assertEqual(sizes["0"], (0, 0))
        self.assertEqual(sizes["1"][1], 1)
        self.assertLessEqual(sizes["300kB"][0], 300_000)
        self.assertGreater(sizes["1GiB"][1], sizes["300kB"][1])
        self.assertGreater(sizes["300kB"][1], 1)


class Questions(DebugTest):
    def test_facts_of_a_catom_and_of_a_predicate(self):
        text = self.session(["to 5", "facts", "facts dist", "facts @1", "facts dist @1"], GRADIENT).stdout
        everything = facts_at(GRADIENT, None, 5)
        dist = "".join(re.findall(r"^dist.*\n", everything, re.M))
        one = "".join(re.findall(r"^\w+\(@1[,)].*\n", everything, re.M))
        self.assertEqual(text, "tick 5\n" + everything + dist + one + "".join(re.findall(r"^dist.*\n", one, re.M)))
        self.assertTrue(one)

    def test_what_has_changed(self):
        answers = self.answers(["diff", "to 3", "diff", "back", "diff", "diff 3", "diff 0"], GRADIENT)
        at = {t: set(facts_at(GRADIENT, None, t).splitlines()) for t in (0, 2, 3)}
        for answer, (since, now) in zip((answers[2], answers[4], answers[5], answers[6]), ((0, 3), (3, 2), (3, 2), (0, 2))):
            self.assertEqual((answer["since"], answer["tick"]), (since, now))
            self.assertEqual(sum(p["come"] for p in answer["predicates"].values()), len(at[now] - at[since]))
            self.assertEqual(sum(p["gone"] for p in answer["predicates"].values()), len(at[since] - at[now]))
        self.assertEqual(answers[0]["predicates"], {})
        self.assertGreater(answers[2]["predicates"]["dist"]["come"], 1)
        self.assertEqual(self.session(["step", "step", "diff"], GRADIENT).stdout, "tick 1\ntick 2\nfrom tick 1 to tick 2:\ndist: +3 -0\n")

    def test_where(self):
        digests = self.path("run.digest")
        self.meldsim("run", GRADIENT, "--quiet", "--digest", digests)
        lines = digests.read_text().splitlines()
        *_, at = self.answers(["run", "back 9", "where"], GRADIENT, "-n", 2)
        self.assertEqual((at["catoms"], at["tick"], at["ended"]), (8000, 50, None))
        self.assertIn(at["digest"], lines[49])
        *_, at = self.answers(["run", "catoms"], GRADIENT)
        self.assertEqual((at["tick"], at["ended"]), (59, "quiet"))

    def test_mistakes_in_a_script_have_their_place(self):
        for commands, code, message in ((["stp"], 2, "standard input:1: there is no command 'stp'. Did you mean 'step'?"),
                                        (["step", "", "# a remark", "xyzzy"], 2, "input:4: there is no command 'xyzzy'. There are step, "),
                                        (["back"], 2, "back 1: this is tick 0, and the first is 0. `to 0` goes there"),
                                        (["facts dst"], 2, "the program has no facts named 'dst'. Did you mean 'dist'?"),
                                        (["facts @8000"], 2, "there is no catom @8000 in tick 0"),
                                        (["diff 5000"], 2, "the run ends before tick 5000, with tick 59")):
            for processes in (1, 2) if commands[0] in ("stp", "facts @8000") else (1,):
                done = self.session(commands, GRADIENT, "-n", processes, code=code)
                self.assertIn(message, done.stderr)
        script = self.path("walk.txt", "step 2\nwher\nstep\n")
        done = self.meldsim("debug", GRADIENT, "--commands", script, code=2)
        self.assertEqual((done.stdout, done.stderr),
                         ("tick 2\n", f"meldsim: {script}:2: there is no command 'wher'. Did you mean 'where'?\n"))
        error = self.answers(["stp"], GRADIENT, code=2)[0]
        self.assertEqual((error["error"], error["code"]), ("there is no command 'stp'", 2))
        self.assertIn("--history", self.session([], GRADIENT, "--history", "lots", code=2).stderr)
        self.meldsim("debug", GRADIENT, "--commands", "nowhere.txt", code=2)

    def test_the_end_of_the_input_ends_it(self):
        script = self.path("walk.txt", "step 2\r\n\n  step  # twice\nquit\nstp")
        for processes in (1, 2):
            done = self.meldsim("debug", GRADIENT, "--commands", script, "-n", processes)
            self.assertEqual((done.stdout, done.stderr), ("tick 2\ntick 3\n", ""))
        self.assertEqual(self.session([], GRADIENT).stdout, "")
        self.assertEqual(self.meldsim("debug", GRADIENT, stdin="step").stdout, "tick 1\n")

    def test_a_program_that_fails(self):
        program = OWN / "fails.meld"
        done = self.session(["to 5", "run"], program, code=1)
        self.assertEqual(done.stdout, "tick 5\n")
        self.assertRegex(done.stderr, "^meldsim: standard input:2: 60 is divided by zero in rule count@")

    def test_nothing_is_printed_or_written(self):
        program = self.path("talks.meld", 'type linear n(node, int).\nn(@0, 3).\nn(A, N), N > 0 -o n(A, N - 1)@+1, print(A, "here").\n')
        self.assertIn("here", self.meldsim("run", program, "--ticks", 6).stdout)
        before = sorted(os.listdir(self.folder))
        self.assertEqual(self.session(["to 3", "to 1", "to 3"], program, "--ticks", 6).stdout, "tick 3\ntick 1\ntick 3\n")
        self.assertEqual(sorted(os.listdir(self.folder)), before)

    def test_a_run_that_is_not_the_same_again(self):
        """An extern function that counts its calls: no digest comes twice."""
        code = self.path("count.c", "#include <meld/extern.h>\nint64_t count(int64_t n) { static int64_t calls; return n + ++calls; }\n")
        program = self.path("counts.meld", "extern int count(int).\ntype n(node, int).\nn(A, count(T)) :- tick(A, T).\n")
        for processes in (1, 2):
            done = self.session(["step", "step", "back"], program, "--link", code, "--ticks", 9, "-n", processes,
                                "--history", 0, code=70)
            self.assertRegex(done.stderr, r"^meldsim: standard input:3: tick 1 is not what it was: its digest is \w+ now, and was \w+\. ")


class OfRuns(DebugTest):
    def test_recordings(self):
        """From what they carry, up to their last tick."""
        world = self.path("storm.toml", (OWN / "storm.toml").read_text())
        recording = self.path("run.vtkhdf")
        self.meldsim("run", OWN / "storm.meld", "--world", world, "--ticks", 22, "--seed", 8, "--quiet", "--record", recording)
        facts = {ticks: self.meldsim("run", OWN / "storm.meld", "--world", world, "--ticks", ticks, "--seed", 8, "--quiet",
                                     "--facts-out", "-").stdout for ticks in (7, 22)}
        world.unlink()
        for processes in (1, 2):
            answers = self.answers(["run", "facts", "back 15", "facts"], recording, "-n", processes)
            self.assertEqual([a["tick"] for a in answers], [22, 22, 7, 7])
            self.assertEqual([a["ended"] for a in answers[::2]], ["ticks", None])
            for found in answers[1::2]:
                self.assertEqual("".join(f + "\n" for f in found["facts"]), facts[found["tick"]])
        self.assertEqual(self.answers(["run"], recording, "--ticks", 7)[0]["tick"], 7)
        self.assertIn("--seed has no place here", self.session([], recording, "--seed", 3, code=2).stderr)

    def test_a_recording_of_another_run(self):
        code = self.path("count.c", "#include <meld/extern.h>\nint64_t count(int64_t n) { return n; }\n")
        program = self.path("counts.meld", "extern int count(int).\ntype n(node, int).\nn(A, count(T)) :- tick(A, T).\n")
        recording = self.path("run.vtkhdf")
        self.meldsim("run", program, "--link", code, "--ticks", 4, "--quiet", "--record", recording)
        code.write_text("int count(int n) { return n; }\n")
        self.assertIn("its hash", self.session(["step"], recording, code=2).stderr)

    def test_a_step_that_is_not_as_recorded(self):
        recording = self.path("run.vtkhdf")
        self.meldsim("run", OWN / "storm.meld", "--ticks", 22, "--quiet", "--record", recording)
        with h5py.File(recording, "r+") as file:
            file["VTKHDF/Steps/StateDigestLow"][3] += 1
        for processes in (1, 2):
            done = self.session(["to 11", "to 3", "to 12"], recording, "-n", processes, code=3)
            self.assertEqual(done.stdout, "tick 11\ntick 3\n")
            self.assertRegex(done.stderr, r"^meldsim: standard input:3: tick 12 is not as it was recorded")

    def test_checkpoints(self):
        """From their tick on, in the folder of the run, with modules that have written then and do not now."""
        checkpoints, recording, digests = self.path("kept"), self.path("run.vtkhdf"), self.path("run.digest")
        self.meldsim("run", OWN / "storm.meld", "--ticks", 12, "--quiet", "--checkpoint", checkpoints, "--record", recording,
                  "--digest", digests, "--facts-out", "run.facts")
        written = {name: self.path(name).read_bytes() for name in ("run.vtkhdf", "run.digest", "run.facts")}
        self.path("script", "to 19\nfacts\nto 12\nfacts\nwhere\n")
        folder = self.path("elsewhere")
        folder.mkdir()
        for processes in (1, 2, 3):
            done = self.meldsim("debug", "../kept", "--ticks", 20, "-n", processes, "--commands", "../script", "--json", cwd=folder)
            answers = [json.loads(line) for line in done.stdout.splitlines()]
            self.assertEqual([a["tick"] for a in answers], [19, 19, 12, 12, 12])
            for found in answers[1:4:2]:
                self.assertEqual("".join(f + "\n" for f in found["facts"]), facts_at(OWN / "storm.meld", None, found["tick"]))
            self.assertEqual(answers[4]["first_tick"], 12)
        self.assertIn("to 11: the first tick here is 12", self.session(["to 11"], checkpoints, code=2).stderr)
        self.assertEqual({name: self.path(name).read_bytes() for name in written}, written)
        self.assertEqual(self.session([], folder, code=6).stdout, "")
        self.assertIn("--world has no place here", self.session([], checkpoints, "--world", "x.toml", code=2).stderr)

    def test_a_damaged_checkpoint(self):
        """The one before serves instead."""
        kept = self.path("kept")
        self.meldsim("run", OWN / "storm.meld", "--ticks", 12, "--quiet", "--checkpoint", kept, "--checkpoint-every", "5ticks")
        share = kept / "12.0-of-1.share"
        share.write_bytes(share.read_bytes()[:-1])
        for processes in (1, 2):
            done = self.session(["where"], kept, "-n", processes)
            self.assertIn("tick 10", done.stdout)
            self.assertRegex(done.stderr, "^warning: .*a newer checkpoint is not whole, and the session begins with that of tick 10")


class AtATerminal(DebugTest):
    def start(self, *arguments):
        pid, self.terminal = pty.fork()
        if pid == 0:
            os.execv(TOOLS.meldsim, ["meldsim", "debug", *map(str, arguments)])
        fcntl.ioctl(self.terminal, termios.TIOCSWINSZ, struct.pack("HHHH", 50, 200, 0, 0))
        self.pid, self.shown = pid, ""

    def expect(self, text, seconds=20):
        """What was shown up to this text."""
        end = time.monotonic() + seconds
        while text not in self.shown:
            ready, _, _ = select.select([self.terminal], [], [], max(0, end - time.monotonic()))
            try:
                more = os.read(self.terminal, 4096).decode() if ready else ""
            except OSError:
                more = ""
            self.assertTrue(more, f"'{text}' is missing in {self.shown!r}")
            self.shown += more
        before, _, self.shown = self.shown.partition(text)
        return before

    def say(self, text):
        os.write(self.terminal, text.encode())

    def interrupt_a_run(self):
        self.say("run\n")
        self.expect("run")
        time.sleep(0.4)
        self.say("\x03")
        self.expect(": interrupted")
        self.expect("> ")

    def ends(self, code):
        _, status = os.waitpid(self.pid, 0)
        os.close(self.terminal)
        self.assertEqual(os.waitstatus_to_exitcode(status), code)

    def test_a_session(self):
        self.start(GRADIENT)
        self.expect("tick 0> ")
        self.say("step 9\n")
        self.expect("tick 9> ")
        self.say("\n")
        self.expect("tick 10> ")
        self.say("bakc\n")
        self.expect("Did you mean 'back'?")
        self.expect("tick 10> ")
        self.say("facts\n")
        shown = self.expect("more")
        self.assertEqual(shown.count("dist(@"), 40)
        self.expect("tick 10> ")
        # Ctrl-C drops what was typed, and Ctrl-D ends.
        self.say("run\x03")
        self.expect("tick 10> ")
        self.say("where\n")
        self.expect("catoms   8000")
        self.expect("tick 10> ")
        self.say("\x04")
        self.ends(0)

    def test_a_session_on_several_processes(self):
        """The terminal is that of the process which has started them."""
        self.start(OWN / "waiting.meld", "--ticks", 10**9, "-n", 2)
        self.expect("tick 0> ")
        self.say("step 2\n\nbakc\n")
        self.expect("tick 3> ")
        self.expect("Did you mean 'back'?")
        self.say("facts\n")
        self.expect("more")
        self.expect("tick 3> ")
        self.interrupt_a_run()
        self.say("to 5\n")
        self.expect("tick 5\r\n")
        self.expect("tick 5> ")
        self.say("\x04")
        self.ends(0)

    def test_ctrl_c_stops_between_two_ticks(self):
        self.start(OWN / "waiting.meld", "--ticks", 10**9)
        self.expect("> ")
        for _ in range(2):
            self.interrupt_a_run()
        self.say("to 5\n")
        self.expect("tick 5\r\n")
        self.say("facts longest\n")
        self.expect("> ")
        os.kill(self.pid, signal.SIGTERM)
        self.ends(143)

    def test_a_pipe_is_interrupted(self):
        for processes in (1, 2):
            self.interrupt(processes)

    def interrupt(self, processes):
        run = subprocess.Popen([TOOLS.meldsim, "debug", OWN / "waiting.meld", "--ticks", str(10**9), "--quiet", "-n", str(processes)],
                               stdin=subprocess.PIPE, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
        run.stdin.write("step 3\nrun\nwhere\n")
        run.stdin.flush()
        self.assertEqual(run.stdout.readline(), "tick 3\n")
        time.sleep(0.3)
        run.send_signal(signal.SIGINT)
        out, err = run.communicate(timeout=20)
        self.assertEqual(run.returncode, 130)
        self.assertRegex(out, r"^tick \d+: interrupted\n$")
        self.assertRegex(err, r"^meldsim: interrupted after tick \d+\n$")


if __name__ == "__main__":
    main("meldc", "meldsim", walks={"type": int, "default": 1, "help": "random walks for each program and setup"})
