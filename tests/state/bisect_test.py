"""`meldsim bisect`: the tick that it finds is the first one, on any number of processes, and asking changes nothing.

    bisect_test.py --meldc PATH --meldsim PATH [unittest options]
"""
import json
import pathlib
import re
import sys

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1]))

from frame import Case, main  # noqa: E402

ROOT = pathlib.Path(__file__).resolve().parents[2]
EXAMPLES = ROOT / "examples/meld"
OWN = pathlib.Path(__file__).resolve().parent / "programs"


class Bisect(Case):
    def bisect(self, *arguments, code=0):
        return json.loads(self.call("meldsim", "bisect", *arguments, "--json", "--quiet", code=code)[0])

    def facts(self, program, ticks, name):
        facts, _ = self.call("meldsim", "run", program, "--ticks", ticks, "--quiet", "--facts-out", "-")
        return re.findall(rf"^{name}\(@(\d+)(?:, (.*))?\)\.$", facts, re.M)

    def test_a_planted_fault_is_found(self):
        """A rule that counts wrong from 12 on: neighbours differ by more than one."""
        text = (EXAMPLES / "gradient.meld").read_text()
        faulty = text.replace("dist(B, D + 1)", "dist(B, D + 1 + D / 12)")
        self.assertNotEqual(text, faulty)
        program = self.write("faulty.meld", faulty)
        self.write("faulty.toml", (EXAMPLES / "gradient.toml").read_text())
        body = "neighbor(A, B), dist(A, X), dist(B, Y), X > Y + 1"
        answers = [self.bisect(program, "--until", body, "-n", n) for n in (1, 2, 3)]
        self.assertEqual(answers[0]["tick"], 14)
        # Twelve steps from the source in the corner, and the thirteenth is too long.
        self.assertEqual((answers[0]["catom"], answers[0]["witness"]), (63, {"B": "@55", "X": "14", "Y": "12"}))
        self.assertEqual(answers[1:], answers[:1] * 2)
        self.assertFalse(self.bisect(EXAMPLES / "gradient.meld", "--until", body, code=3)["found"])
        # Its derivation names both facts, and the rule that is wrong.
        nodes = answers[0]["why"]["nodes"]
        root, = answers[0]["why"]["roots"]
        way, = nodes[root]["ways"]
        told = [nodes[part["node"]] for part in way["parts"] if "node" in part]
        self.assertEqual([node["fact"] for node in told], ["neighbor(@63, @55)", "dist(@63, 14)", "dist(@55, 12)"])
        self.assertIn("D / 12", told[1]["ways"][0]["text"])
        out, _ = self.call("meldsim", "bisect", program, "--until", body, "--quiet")
        self.assertIn("dist(B, D + 1 + D / 12)", out)
        self.assertEqual(self.call("meldsim", "bisect", program, "--until", body, "--quiet", "--depth", 0)[0], out.splitlines()[0] + "\n")

    def test_it_is_the_first_tick(self):
        program = OWN / "waiting.meld"
        for body, name, holds in (("rung(A, N, S), N > 3", "rung", lambda v: int(v.split(",")[0]) > 3), ("lit(A)", "lit", lambda v: True)):
            found = self.bisect(program, "--until", body)
            now = [int(a) for a, v in self.facts(program, found["tick"], name) if holds(v)]
            before = [int(a) for a, v in self.facts(program, found["tick"] - 1, name) if holds(v)]
            self.assertEqual((min(now), len(now), before), (found["catom"], found["catoms"], []), body)

    def test_it_ceases_to_hold(self):
        """While catoms come, go and move between processes."""
        program = OWN / "storm.meld"
        for body, name, holds in (("last(A, N), N > 1", "last", lambda v: int(v) > 1), ("last(A, _)", "last", lambda v: True)):
            answers = [self.bisect(program, "--ticks", 30, "--while", body, "-n", n) for n in (1, 2, 3)]
            self.assertEqual(answers[1:], answers[:1] * 2)
            found = answers[0]
            held = [{int(a) for a, v in self.facts(program, t, name) if holds(v)} for t in range(found["tick"] + 1)]
            lost = [sorted(before - now) for before, now in zip(held, held[1:])]
            self.assertEqual(([t + 1 for t, ids in enumerate(lost) if ids], lost[-1][0], len(lost[-1])),
                             ([found["tick"]], found["catom"], found["catoms"]), body)

    def test_asking_changes_nothing(self):
        for program, body in ((EXAMPLES / "gradient.meld", "neighbor(A, B), dist(A, X), dist(B, Y), X > Y"),
                              (EXAMPLES / "walk.meld", "neighbor(A, B), neighbor(B, C), position(C, X, _, _), X > 1.0"),
                              (OWN / "waiting.meld", "N = count : { neighbor(A, B), dist(B, _) }, dist(A, D), D > N"),
                              (OWN / "storm.meld", "last(A, N), not neighborCount(A, 3), seen(A, B, 1)")):
            module = self.folder / "asked.so"
            self.call("meldc", "compile", program, "--ask", body, "-o", module)
            results = []
            for what in (program, module):
                self.call("meldsim", "run", what, "--world", program.with_suffix(".toml"), "--ticks", 40, "--quiet",
                          "--digest", "run.digest", "--facts-out", "run.facts")
                results.append([self.read("run.digest"), self.read("run.facts")])
            self.assertEqual(results[0], results[1], program.name)
            self.assertNotIn(b"question", results[1][1])

    def test_mistakes_have_their_place(self):
        program = EXAMPLES / "gradient.meld"
        for body, code, message in (("dst(A, D), D > 3", 1, "the body:1:1"),
                                    ("dist(A, D), D > E", 1, "the body:1:17"),
                                    ("dist(A, D), D +", 1, "the body:1:15"),
                                    ("dist(A, D", 1, "found the end of the body"),
                                    ("dist(A, D). dist(A, D)", 2, "is not one body"),
                                    ("3 > 2", 2, "has no fact of a catom"),
                                    ("", 2, "there is nothing to look for")):
            for processes in (1, 2):
                self.refused("meldsim", "bisect", program, "--until", body, "-n", processes, code=code, says=message,
                             lines=None if code == 1 else 1)
        self.refused("meldsim", "bisect", OWN / "waiting.meld", "--until", "token(A, N, _)", code=2,
                     says="asks about a linear fact, token")
        self.refused("meldsim", "bisect", program, code=2, says="--until 'body' or --while 'body'")
        self.refused("meldsim", "bisect", program, "--until", "source(A)", "--while", "source(A)", code=2, says="--while")
        module = self.folder / "gradient.so"
        self.call("meldc", "compile", program, "-o", module)
        self.refused("meldsim", "bisect", module, "--until", "source(A)", code=2, says="a module has no room for a body")

    def test_a_program_that_fails_is_no_answer(self):
        program = self.write("fails.meld", "type linear n(node, int).\nn(A, 5).\nn(A, N) -o n(A, 10 / N - 2).\n")
        self.refused("meldsim", "bisect", program, "--until", "id(A, -1)", code=1, says="divided by zero")


if __name__ == "__main__":
    main("meldc", "meldsim")
