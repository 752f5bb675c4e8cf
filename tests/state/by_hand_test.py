"""What is done by hand in `meldsim debug`: a run of a world with the same events has the same digests, whatever way was gone.

    by_hand_test.py --meldc PATH --meldsim PATH [unittest options]
"""
import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))

from debug_test import GRADIENT, OWN, DebugTest  # noqa: E402
from frame import main, square  # noqa: E402

# Facts of every kind that can be given; the token goes round, and leaves what it has read.
NOTES = """type linear token(node, int).
type note(node, string, list float, set int, (int, bool), vec3).
type wall(node).
type seen(node, int, min int).
type heard(node, string).
type tapped(node).
token(A, N), N > 0 -o seen(A, N, 0), {B | neighbor(A, B), not wall(B) | token(B, N - 1)}.
heard(A, S) :- note(A, S, [_, X], _, _, _), X > 0.0.
tap(A) -o tapped(A).
heard(B, S) :- neighbor(A, B), heard(A, S), not wall(B).
"""
DEEDS = ("give token(@5, 3).", r'give note(@0, "a \"b\" \\ c\n5", [1.0, 2.5], list2set([3, 1]), (7, true), vec3(0.0, -1.5, 1e9))',
         r'give note(@2, "5", [0.0, 1.0], list2set([7]), (-7, false), vec3(0.0, 0.0, 0.0))', "take wall(@1)", "give wall(@6)",
         "take token(@3, 0)", "give token(@9, 2 + 2)", "give tap(@3)")


class ByHand(DebugTest):
    def setUp(self):
        super().setUp()
        self.write("notes.meld", NOTES)
        self.write("notes.toml", square(4) + '[facts]\nwall = "id == 1"\n[[event]]\ntick = 5\ntake = { wall = "id == 1" }\n')

    def digests(self, ticks, events, program="notes.meld", world="notes.toml"):
        both = self.write("both.toml", self.read(world).decode() + self.read(events).decode())
        lines = self.call("meldsim", "run", program, "--world", both, "--ticks", ticks, "--quiet", "--digest", "-")[0].splitlines()
        return {int(t): d for _, t, d in (line.split() for line in lines if line.startswith("tick "))}

    def test_a_world_with_the_events_makes_the_same_run(self):
        commands, deeds = [], list(DEEDS)
        while deeds:
            commands += ["step", deeds.pop(0), "where"]
        # Going back and forth changes nothing, and something else in the past drops what came after it.
        commands += ["to 9", "where", "to 4", "where", "to 12", "where", "to 3", "events", "to 7", "give token(@3, 9)", "save-events {}",
                     "to 12", "where", "to 4", "where", "to 14", "where"]
        for processes, history in ((1, "1GiB"), (2, "0"), (3, "20kB")):
            with self.subTest(processes=processes):
                answers = self.answers([c.format(f"by hand {processes}.toml") for c in commands], "notes.meld", "-n", processes,
                                       "--history", history, "--ticks", 16)
                (back,) = [i for i, c in enumerate(commands) if c.startswith("save")]
                events = answers[commands.index("events")]["events"]
                self.assertEqual([(e["tick"], e["kind"]) for e in events], [(t + 2, d.split()[0]) for t, d in enumerate(DEEDS)])
                self.assertEqual(events[6]["fact"], "token(@9, 4)")
                self.assertEqual(answers[back - 1]["dropped"], 1)
                self.assertEqual(answers[back], {"written": str(self.folder / f"by hand {processes}.toml"), "events": 8})
                made = self.digests(16, f"by hand {processes}.toml")
                for answer in answers[back + 1:]:
                    if "digest" in answer:
                        self.assertEqual(answer["digest"], made[answer["tick"]], f"tick {answer['tick']}")
                # Until tick 8 it is the run from before; then another.
                for answer in answers[:back]:
                    if "digest" in answer and answer["tick"] <= 7:
                        self.assertEqual(answer["digest"], made[answer["tick"]], f"tick {answer['tick']}")
                first, = (a["digest"] for a, c in zip(answers[:back], commands) if c == "where" and a["tick"] == 12)
                self.assertNotEqual(first, made[12])

    def test_a_quiet_run_goes_on(self):
        for processes in (1, 2):
            answers = self.answers(["run", "take source(@0)", "give source(@42)", "run", "back", "to 59", "run", "facts source", "events",
                                    "to 59", "give source(@7)", "save-events e.toml", "run", "where"], GRADIENT, "-n", processes)
            self.assertEqual([a["tick"] for a in answers if "from" in a], [59, 112, 111, 59, 112, 59, 112])
            self.assertEqual(answers[7]["facts"], ["source(@42)."])
            self.assertEqual([e["fact"] for e in answers[8]["events"]], ["source(@0)", "source(@42)"])
            self.assertEqual(answers[-4]["dropped"], 0)
            world = GRADIENT.with_suffix(".toml").read_text()
            self.write("gradient.toml", world)
            self.assertEqual(self.digests(200, "e.toml", GRADIENT, "gradient.toml")[112], answers[-1]["digest"])

    def test_a_checkpoint(self):
        """It can be changed too; files are where the commands are typed, not where the run was."""
        run = self.folder / "run"
        run.mkdir()
        self.call("meldsim", "run", "../notes.meld", "--ticks", 5, "--quiet", "--checkpoint", "kept", cwd=run)
        for processes in (1, 2):
            answers = self.answers(["step", "give token(@0, 2)", "step 2", "facts seen", "save-events e.toml"], "run/kept", "--ticks", 9,
                                   "-n", processes)
            self.assertEqual(len(answers[3]["facts"]), 3)
            self.assertIn(b"tick = 7", self.read("e.toml"))

    def test_what_the_run_is_made_from_stays(self):
        for command in ("save-events notes.meld", "save-events notes.toml", "save-events ./notes.toml"):
            before = self.files(), self.read("notes.meld"), self.read("notes.toml")
            err = self.session(["give wall(@2)", command], "notes.meld", "-n", 2, code=2)[1]
            self.assertIn("and save-events are the same file", err)
            self.assertEqual((self.files(), self.read("notes.meld"), self.read("notes.toml")), before)

    def test_what_cannot_be_done(self):
        for command, says in (("give heard(@1, \"a\")", "facts of heard are derived by rules"),
                              ("give wall(@99)", "there is no catom @99 in tick 0"),
                              ("give wall(A)", "wall(_) leaves something open"),
                              ("take token(@1)", "the body:1:1"),
                              ("take wall(@2)", "wall(@2) does not hold after tick 0"),
                              ("take heard(@1, \"a\")", "heard(@1, \"a\") is not given from outside: rules derive it"),
                              ("give wall(@1), wall(@2)", "this is not one fact"),
                              ("give", "the fact is missing"), ("save-events", "the file is missing"),
                              ("save-events no/where", "no/where")):
            out, err = self.session([command], "notes.meld", code=2)
            self.assertEqual(out, "")
            self.assertIn(says, err)
        self.assertEqual(self.session(["events"], "notes.meld")[0], "nothing has been done by hand\n")
        self.assertIn("there is no predicate `wall`", self.session(["give wall(@1)"], OWN / "storm.meld", code=2)[1])
        self.assertIn("the run ends with tick 3", self.session(["to 3", "give wall(@2)"], "notes.meld", "--ticks", 3, code=2)[1])
        self.call("meldsim", "run", "notes.meld", "--ticks", 5, "--quiet", "--record", "run.vtkhdf")
        self.refuses(["give wall(@2)"], "run.vtkhdf", says="a recording says itself what happens")


class Branches(DebugTest):
    def test_each_branch_is_its_own_run(self):
        """Whichever way they are reached, and as a run of their own events is."""
        commands = ["to 10", "fork away", "take source(@0)", "to 40", "fork there", "give source(@42)", "run", "fork same", "branches"]
        for processes in (1, 3):
            answers = self.answers([*commands, "switch main", "facts", "switch away", "events", "save-events away.toml", "facts",
                                    "switch there", "save-events there.toml", "facts", "switch there", "run", "switch main", "run", "facts",
                                    "branches", "switch same", "where"], GRADIENT, "-n", processes)
            moves = [a for a in answers if "branch" in a]
            end = answers[6]["tick"]
            self.assertEqual([(m["branch"], m["tick"]) for m in moves],
                             [("main", 10), ("away", 40), ("there", end), ("there", end), ("main", 10), ("same", end)])
            self.assertEqual([(b["name"], b["tick"], b["events"], b["present"]) for b in answers[8]["branches"]],
                             [("main", 10, 0, False), ("away", 40, 1, False), ("there", end, 2, False), ("same", end, 2, True)])
            facts = [a["facts"] for a in answers if "facts" in a]
            for found, ticks, events in zip(facts, (10, 40, end, 59), ((), ("--events", "away.toml"), ("--events", "there.toml"), ())):
                out = self.call("meldsim", "run", GRADIENT, "--quiet", "--ticks", ticks, *events, "--facts-out", "-")[0]
                self.assertEqual("".join(f + "\n" for f in found), out)
            self.assertEqual(answers[-1]["tick"], end)
            self.assertEqual([b["tick"] for b in answers[-3]["branches"]], [59, 40, end, end])

    def test_what_cannot_be_done_with_branches(self):
        for command, says in (("fork main", "there is a branch main already"), ("fork", "the name of the branch is missing"),
                              ("switch b", "there is no branch b. There are main"), ("fork a b", "'b' is too much")):
            self.refuses([command], GRADIENT, says=says)


if __name__ == "__main__":
    main("meldc", "meldsim")
