"""`meldsim bisect`: the tick that it finds is the first one, on any number of processes, in a program, a recording and a
checkpoint.

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


class BisectCase(Case):
    def bisect(self, *arguments, code=0):
        return json.loads(self.call("meldsim", "bisect", *arguments, "--json", "--quiet", code=code)[0])

    def facts(self, program, ticks, name):
        facts, _ = self.call("meldsim", "run", program, "--ticks", ticks, "--quiet", "--facts-out", "-")
        return re.findall(rf"^{name}\(@(\d+)(?:, (.*))?\)\.$", facts, re.M)


class Answers(BisectCase):
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

    def test_a_body_of_no_catom(self):
        body = "N = count : { dist(_, _) }, N > 100"
        answers = [self.bisect(EXAMPLES / "gradient.meld", "--until", body, "-n", n) for n in (1, 2)]
        self.assertEqual(answers[0], answers[1])
        self.assertEqual((answers[0]["tick"], answers[0]["catoms"], answers[0]["witness"]), (8, 0, {"N": "120"}))
        self.assertNotIn("catom", answers[0])
        self.assertEqual(self.bisect(EXAMPLES / "gradient.meld", "--while", "N = count : { dist(_, _) }, N < 100")["tick"], 8)

    def test_mistakes_have_their_place(self):
        program = EXAMPLES / "gradient.meld"
        for body, message in (("dst(A, D), D > 3", "the body:1:1"),
                              ("dist(A, D), D > E", "the body:1:17"),
                              ("dist(A, D), D +", "the body:1:15"),
                              ("dist(A, D", "found the end of the body"),
                              ("dist(A, D). dist(A, D)", "is not one body"),
                              ("", "there is nothing to look for")):
            for processes in (1, 2):
                self.refused("meldsim", "bisect", program, "--until", body, "-n", processes, "--quiet", code=2, says=message, lines=None)
        self.refused("meldsim", "bisect", program, code=2, says="--until 'body' or --while 'body'")
        self.refused("meldsim", "bisect", program, "--until", "source(A)", "--while", "source(A)", code=2, says="--while")

    def test_a_module(self):
        module = self.folder / "gradient.so"
        self.call("meldc", "compile", EXAMPLES / "gradient.meld", "-o", module)
        answers = [self.bisect(what, "--world", EXAMPLES / "gradient.toml", "--until", "dist(A, D), D > 20")
                   for what in (EXAMPLES / "gradient.meld", module)]
        self.assertEqual(answers[0], answers[1])

    def test_a_program_that_fails_is_no_answer(self):
        program = self.write("fails.meld", "type linear n(node, int).\nn(A, 5).\nn(A, N) -o n(A, 10 / N - 2).\n")
        self.refused("meldsim", "bisect", program, "--until", "id(A, -1)", code=1, says="divided by zero")



class Targets(BisectCase):
    """A recording and a checkpoint give the answer of one pass over the program, which is what each tick says by itself."""
    BODIES = {"storm": ("last(A, N), neighbor(A, B), last(B, M), M > N", "memory(A, [K | _]), K <> 3",
                        "last(A, N), not neighborCount(A, 3), seen(A, B, 1)", "create(A, _), destroy(A, _)"),
              "waiting": ("rung(A, N, S), N > 3", "lit(A)", "rung(A, N, _), neighbor(A, B), rung(B, M, _), M > N + 1"),
              "doze": ("degree(A, N), N > 5", "high(A, Z), Z < 1.0, neighbor(A, B), high(B, Y), Y < Z")}
    LAST, AT = 24, (7, 14)

    def ticks(self, program, body):
        """The catoms at which the body holds in each tick, as one query for each says."""
        commands = "".join(f"to {t}\nquery {body}\n" for t in range(1, self.LAST + 1))
        done = self.run_tool("meldsim", "debug", program, "--json", "--history", 0, "--ticks", self.LAST, stdin=None,
                             input=commands.encode())
        answers = [json.loads(line) for line in done.stdout.splitlines()]
        self.assertEqual(done.returncode, 0, done.stderr)
        held = [set()]
        for answer in answers:
            if "rows" in answer:
                at = [column["name"] for column in answer["columns"]].index("A")
                held.append({row[at] for row in answer["rows"]})
        # A run that has ended stays as it is.
        return held

    def expected(self, held, asked, start):
        """The tick that is sought after `start`, and where; nothing if there is none."""
        for tick in range(start + 1, len(held)):
            found = held[tick] if asked == "--until" else held[tick - 1] - held[tick]
            if found:
                return tick, min(found), len(found)
        return None

    def answer(self, target, asked, body, *options):
        done = self.run_tool("meldsim", "bisect", target, asked, body, "--ticks", self.LAST, "--json", "--quiet", "--depth", 0, *options)
        self.assertIn(done.returncode, (0, 3), done.stderr)
        found = json.loads(done.stdout)
        self.assertEqual((done.returncode == 0), found["found"])
        return found

    def test_alike(self):
        turn = after = already = 0
        for name, bodies in self.BODIES.items():
            program = OWN / f"{name}.meld"
            self.call("meldsim", "run", program, "--ticks", self.LAST, "--quiet", "--record", f"{name}.vtkhdf")
            # Its last two checkpoints are of the ticks AT.
            self.call("meldsim", "run", program, "--ticks", self.AT[1], "--quiet", "--checkpoint", name, "--checkpoint-every",
                      f"{self.AT[0]}ticks", "-n", 2)
            for body in bodies:
                held = self.ticks(program, body)
                for asked in ("--until", "--while"):
                    turn += 1
                    wanted = self.expected(held, asked, 0)
                    for target, n in ((program, 1 + turn % 3), (f"{name}.vtkhdf", 1 + turn // 3 % 2)):
                        found = self.answer(target, asked, body, "-n", n)
                        self.assertEqual((found["from"], found["found"]), (0, wanted is not None), (target, asked, body))
                        if wanted:
                            self.assertEqual((found["tick"], found["catom"], found["catoms"]), wanted, (target, asked, body))
                    found = self.answer(name, asked, body, "-n", 1 + (turn + 1) % 3)
                    # The newest in which it does not hold yet, or else the oldest.
                    start = self.AT[1] if asked == "--while" or not held[self.AT[1]] else self.AT[0]
                    self.assertEqual(found["from"], start, (name, asked, body))
                    if asked == "--until" and held[start]:
                        self.assertEqual((found["already"], found["found"], found["tick"], found["catom"], found["catoms"]),
                                         (True, False, start, min(held[start]), len(held[start])))
                        already += 1
                        continue
                    wanted = self.expected(held, asked, start)
                    self.assertEqual(found["found"], wanted is not None, (name, asked, body))
                    if wanted:
                        self.assertEqual((found["tick"], found["catom"], found["catoms"]), wanted, (name, asked, body))
                        after += 1
        self.assertGreater(min(after, already), 2)

    def keep(self):
        """Checkpoints of the ticks 10 and 12, in which the run ended."""
        self.call("meldsim", "run", EXAMPLES / "gradient.meld", "--ticks", 12, "--quiet", "--checkpoint", "kept", "--checkpoint-every",
                  "5ticks")

    def test_its_derivation(self):
        """From a checkpoint as from the start, as far down as the checkpoint knows it."""
        self.keep()
        for body in ("dist(A, D), D > 20", "dist(A, D), D > 10"):
            answers = [self.bisect(target, "--until", body, "--ticks", 40, "-n", n)
                       for target, n in ((EXAMPLES / "gradient.meld", 1), ("kept", 1), ("kept", 2))]
            self.assertEqual([answer.pop("from") for answer in answers], [0] + [12 if "20" in body else 10] * 2)
            self.assertEqual(answers[1:], answers[:1] * 2)
            self.assertTrue(answers[0]["why"]["nodes"])

    def test_what_it_says(self):
        self.keep()

        def says(*arguments, code):
            return self.call("meldsim", "bisect", "kept", *arguments, "--quiet", "--depth", 0, code=code)[0]
        self.assertIn("tick 10, where the checkpoint is: 'dist(A, D), D > 3' already holds at catom @",
                      says("--until", "dist(A, D), D > 3", code=3))
        far = ("--until", "dist(A, D), D > 20")
        self.assertIn("holds nowhere from tick 12, where the checkpoint is, to tick 20, after", says(*far, "--ticks", 20, code=3))
        self.assertIn("holds nowhere in tick 12, where the checkpoint is, after", says(*far, code=3))
        self.refused("meldsim", "bisect", "kept", "--until", "lit(A)", "--world", "w.toml", code=2, says="--world has no place here")
        self.refused("meldsim", "bisect", "nowhere", "--until", "lit(A)", code=2, says="nowhere")


if __name__ == "__main__":
    main("meldc", "meldsim")
