"""`meldsim debug`: whatever way a tick is reached, what it shows is what a run to that tick writes, on any number of processes.

    debug_test.py --meldc PATH --meldsim PATH [--walks N] [unittest options]
"""
import functools
import json
import random
import re
import subprocess
import sys
from pathlib import Path

import h5py

ROOT = Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT / "tests"))

from frame import TOOLS, Case, main, square  # noqa: E402

EXAMPLES = ROOT / "examples/meld"
OWN = Path(__file__).resolve().parent / "programs"
GRADIENT = EXAMPLES / "gradient.meld"
# Programs, their worlds and how many ticks of them: views while catoms move, linear facts that wait, bodies, and a component with a state.
WALKS = ((EXAMPLES / "walk.meld", None, 30), (OWN / "storm.meld", None, 24), (OWN / "waiting.meld", None, 60),
         (ROOT / "tests/programs/bodies/crowd.meld", OWN / "heap.toml", 20), (OWN / "tumble.meld", None, 20),
         (EXAMPLES / "thermometer.meld", None, 30))
# Processes, and memory for snapshots: all that there is, so little that most are dropped, and none.
SETUPS = ((1, "300kB"), (2, "0"), (1, "1GiB"), (3, "300kB"), (1, "0"), (2, "1GiB"))


@functools.cache
def facts_at(program, world, tick):
    command = [TOOLS.meldsim, "run", program, "--ticks", str(tick), "--quiet", "--facts-out", "-"]
    done = subprocess.run(command + (["--world", world] if world else []), capture_output=True, text=True)
    return done.stdout


def typed(commands):
    """For subprocess.run()."""
    return {"stdin": None, "input": "".join(c + "\n" for c in commands).encode()}


class DebugTest(Case):
    def session(self, commands, *arguments, code=0, **options):
        """What it answers, and what it says besides."""
        return self.call("meldsim", "debug", *arguments, code=code, **typed(commands), **options)

    def answers(self, commands, *arguments, **options):
        return [json.loads(line) for line in self.session(commands, *arguments, "--json", **options)[0].splitlines()]

    def refuses(self, commands, *arguments, says, code=2):
        """It ends before the first answer."""
        return self.refused("meldsim", "debug", *arguments, code=code, says=says, **typed(commands))


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
        text = self.session(["to 5", "facts", "facts dist", "facts @1", "facts dist @1"], GRADIENT)[0]
        everything = facts_at(GRADIENT, None, 5)
        dist = "".join(re.findall(r"^dist.*\n", everything, re.M))
        one = "".join(re.findall(r"^\w+\(@1[,)].*\n", everything, re.M))
        place = "// @1 in cell (-9, -10, -10), touches @168 at port 0, @0 at port 1, @3 at port 2 and @5 at port 4\n"
        self.assertEqual(text, "tick 5\n" + everything + dist + place + one + "".join(re.findall(r"^dist.*\n", one, re.M)))
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
        self.assertEqual(self.session(["step", "step", "diff"], GRADIENT)[0], "tick 1\ntick 2\nfrom tick 1 to tick 2:\ndist: +3 -0\n")

    def test_what_the_program_has(self):
        self.write("library.meld", "type far(node).\nfar(A) :- dist(A, D),\n    D > 9.\n")
        program = self.write("own.meld", "type dist(node, int).\ndist(@0, 10).\ninclude \"library.meld\".\n")
        for processes in (1, 2):
            text = self.session(["rules", "rules far"], program, "-n", processes)[0]
            self.assertEqual(text, "own.meld:2: dist(@0, 10).\n" + 2 * "library.meld:2: far(A) :- dist(A, D), D > 9.\n")
        rules, known = self.answers(["rules", "predicates"], program)
        self.assertEqual([(r["name"], r["file"], r["library"], r["line"], r["last_line"]) for r in rules["rules"]],
                         [("dist@2", "own.meld", False, 2, 2), ("far@2", "library.meld", False, 2, 3)])
        self.assertEqual([(p["name"], p["declaration"]) for p in known["predicates"] if p["own"]],
                         [("dist", "type dist(node, int)"), ("far", "type far(node)")])
        self.assertIn("type sensed neighbor", self.session(["predicates"], program)[0])
        self.refuses(["rules fra"], program, says="Did you mean 'far'?")

    def test_why_without_a_second_run(self):
        program = self.write("token.meld", "type linear token(node, int).\ntoken(@0, 3).\ntoken(A, N), N > 0 -o token(A, N - 1).\n")
        short, long = (self.session(["to 2", f"why {option} token(@0, _)"], program)[0] for option in ("--no-replay", ""))
        self.assertNotIn("made in tick", short)
        self.assertIn("made in tick", long)
        self.assertTrue(long.startswith(short))

    def test_where(self):
        self.call("meldsim", "run", GRADIENT, "--quiet", "--digest", "run.digest")
        lines = self.read("run.digest").decode().splitlines()
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
                self.assertIn(message, self.session(commands, GRADIENT, "-n", processes, code=code)[1])
        script = self.write("walk.txt", "step 2\nwher\nstep\n")
        self.assertEqual(self.call("meldsim", "debug", GRADIENT, "--commands", script, code=2),
                         ("tick 2\n", f"meldsim: {script}:2: there is no command 'wher'. Did you mean 'where'?\n"))
        error = self.answers(["stp"], GRADIENT, code=2)[0]
        self.assertEqual((error["error"], error["code"]), ("there is no command 'stp'", 2))
        self.refuses([], GRADIENT, "--history", "lots", says="--history")
        self.refuses([], GRADIENT, "--commands", "nowhere.txt", says="nowhere.txt")

    def test_the_end_of_the_input_ends_it(self):
        script = self.write("walk.txt", "step 2\r\n\n  step  # twice\nquit\nstp")
        for processes in (1, 2):
            self.assertEqual(self.session([], GRADIENT, "--commands", script, "-n", processes), ("tick 2\ntick 3\n", ""))
        self.assertEqual(self.session([], GRADIENT)[0], "")
        self.assertEqual(self.call("meldsim", "debug", GRADIENT, stdin=None, input=b"step")[0], "tick 1\n")

    def test_a_program_that_fails(self):
        program = OWN / "fails.meld"
        out, err = self.session(["to 5", "run"], program, code=1)
        self.assertEqual(out, "tick 5\n")
        self.assertRegex(err, "^meldsim: standard input:2: 60 is divided by zero in rule count@")

    def test_nothing_is_printed_or_written(self):
        program = self.write("talks.meld", 'type linear n(node, int).\nn(@0, 3).\nn(A, N), N > 0 -o n(A, N - 1)@+1, print(A, "here").\n')
        self.assertIn("here", self.call("meldsim", "run", program, "--ticks", 6)[0])
        before = self.files()
        self.assertEqual(self.session(["to 3", "to 1", "to 3"], program, "--ticks", 6)[0], "tick 3\ntick 1\ntick 3\n")
        self.assertEqual(self.files(), before)

    def test_a_run_that_is_not_the_same_again(self):
        """An extern function that counts its calls: no digest comes twice."""
        code = self.write("count.c", "#include <meld/extern.h>\nint64_t count(int64_t n) { static int64_t calls; return n + ++calls; }\n")
        program = self.write("counts.meld", "extern int count(int).\ntype n(node, int).\nn(A, count(T)) :- tick(A, T).\n")
        for processes in (1, 2):
            _, err = self.session(["step", "step", "back"], program, "--link", code, "--ticks", 9, "-n", processes,
                                  "--history", 0, code=70)
            self.assertRegex(err, r"^meldsim: standard input:3: tick 1 is not what it was: its digest is \w+ now, and was \w+\. ")


    def test_a_comment_does_not_begin_in_a_string(self):
        self.write("s.meld", 'type s(node, string).\ns(@0, "a#b"). s(@0, "a\\"#"). s(@0, "x").\n')
        self.write("s.toml", square(2))
        commands = ["step # one", 'query s(A, "a#b") # not "this"', 'query s(A, "a\\"#")# "', 'query s(A, X), X = "a#b"']
        rows = [a["rows"] for a in self.answers(commands, "s.meld", "--world", "s.toml")[1:]]
        self.assertEqual(rows, [[[0]], [[0]], [[0, "a#b"]]])


class OfRuns(DebugTest):
    def test_recordings(self):
        """From what they carry, up to their last tick."""
        world = self.write("storm.toml", (OWN / "storm.toml").read_text())
        run = ("run", OWN / "storm.meld", "--world", world, "--seed", 8, "--quiet")
        self.call("meldsim", *run, "--ticks", 22, "--record", "run.vtkhdf")
        facts = {ticks: self.call("meldsim", *run, "--ticks", ticks, "--facts-out", "-")[0] for ticks in (7, 22)}
        world.unlink()
        for processes in (1, 2):
            answers = self.answers(["run", "facts", "back 15", "facts"], "run.vtkhdf", "-n", processes)
            self.assertEqual([a["tick"] for a in answers], [22, 22, 7, 7])
            self.assertEqual([a["ended"] for a in answers[::2]], ["ticks", None])
            for found in answers[1::2]:
                self.assertEqual("".join(f + "\n" for f in found["facts"]), facts[found["tick"]])
        self.assertEqual(self.answers(["run"], "run.vtkhdf", "--ticks", 7)[0]["tick"], 7)
        self.refuses([], "run.vtkhdf", "--seed", 3, says="--seed has no place here")

    def test_a_recording_of_another_run(self):
        code = self.write("count.c", "#include <meld/extern.h>\nint64_t count(int64_t n) { return n; }\n")
        program = self.write("counts.meld", "extern int count(int).\ntype n(node, int).\nn(A, count(T)) :- tick(A, T).\n")
        self.call("meldsim", "run", program, "--link", code, "--ticks", 4, "--quiet", "--record", "run.vtkhdf")
        code.write_text("int count(int n) { return n; }\n")
        self.refuses(["step"], "run.vtkhdf", says="its hash")

    def test_a_step_that_is_not_as_recorded(self):
        self.call("meldsim", "run", OWN / "storm.meld", "--ticks", 22, "--quiet", "--record", "run.vtkhdf")
        with h5py.File(self.folder / "run.vtkhdf", "r+") as file:
            file["VTKHDF/Steps/StateDigestLow"][3] += 1
        for processes in (1, 2):
            out, err = self.session(["to 11", "to 3", "to 12"], "run.vtkhdf", "-n", processes, code=3)
            self.assertEqual(out, "tick 11\ntick 3\n")
            self.assertRegex(err, r"^meldsim: standard input:3: tick 12 is not as it was recorded")

    def test_checkpoints(self):
        """From their tick on, in the folder of the run, with modules that have written then and do not now."""
        self.call("meldsim", "run", OWN / "storm.meld", "--ticks", 12, "--quiet", "--checkpoint", "kept", "--record", "run.vtkhdf",
                  "--digest", "run.digest", "--facts-out", "run.facts")
        written = {name: self.read(name) for name in ("run.vtkhdf", "run.digest", "run.facts")}
        self.write("script", "to 19\nfacts\nto 12\nfacts\nwhere\n")
        folder = self.folder / "elsewhere"
        folder.mkdir()
        for processes in (1, 2, 3):
            answers = self.answers([], "../kept", "--ticks", 20, "-n", processes, "--commands", "../script", cwd=folder)
            self.assertEqual([a["tick"] for a in answers], [19, 19, 12, 12, 12])
            for found in answers[1:4:2]:
                self.assertEqual("".join(f + "\n" for f in found["facts"]), facts_at(OWN / "storm.meld", None, found["tick"]))
            self.assertEqual(answers[4]["first_tick"], 12)
        self.refuses(["to 11"], "kept", says="to 11: the first tick here is 12")
        self.assertEqual({name: self.read(name) for name in written}, written)
        self.refuses([], folder, code=6, says="there is no checkpoint in")
        self.refuses([], "kept", "--world", "x.toml", says="--world has no place here")

    def test_a_checkpoint_of_a_run_with_results_and_a_time_limit(self):
        """They are not those of the session."""
        self.call("meldsim", "run", OWN / "storm.meld", "--ticks", 2, "--quiet", "--digest", "-", "--checkpoint", "kept",
                  "--timeout", 3)
        out, _ = self.call("sh", "-c", '(echo step; sleep 3.2; echo back) | "$0" debug kept --ticks 9 --json', TOOLS.meldsim)
        self.assertEqual([json.loads(line)["tick"] for line in out.splitlines()], [3, 2])

    def test_a_checkpoint_of_a_run_that_was_watched(self):
        """What it was watched for is no part of the session: the file need not be there any more."""
        self.write("w.meld", "tell(A) :- neighborCount(A, 3).\n")
        self.call("meldsim", "run", OWN / "storm.meld", "--ticks", 2, "--quiet", "--watch", "w.meld", "--expect", "neighborCount(_, _)",
                  "--never", "neighborCount(_, 9)", "--junit", "out.xml", "--profile", "run.profile", "--checkpoint", "kept")
        (self.folder / "w.meld").unlink()
        written = self.read("out.xml"), self.read("run.profile")
        for processes in (1, 2):
            self.assertEqual(self.answers(["step"], "kept", "--ticks", 9, "-n", processes)[0]["tick"], 3)
        self.assertEqual((self.read("out.xml"), self.read("run.profile")), written)

    def test_a_damaged_checkpoint(self):
        """The one before serves instead."""
        self.call("meldsim", "run", OWN / "storm.meld", "--ticks", 12, "--quiet", "--checkpoint", "kept", "--checkpoint-every", "5ticks")
        share = self.folder / "kept/12.0-of-1.share"
        share.write_bytes(share.read_bytes()[:-1])
        for processes in (1, 2):
            out, err = self.session(["where"], "kept", "-n", processes)
            self.assertIn("tick 10", out)
            self.assertRegex(err, "^warning: .*a newer checkpoint is not whole, and the session begins with that of tick 10")


if __name__ == "__main__":
    main("meldc", "meldsim", walks={"type": int, "default": 1, "help": "random walks for each program and setup"})
