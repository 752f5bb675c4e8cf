"""Breaks, watches and `until` of `meldsim debug`: they stop where queries asked after every tick say, on any number of processes.

    breaks_test.py --meldc PATH --meldsim PATH [unittest options]
"""
import json
import re
import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))

from debug_test import GRADIENT, OWN, DebugTest  # noqa: E402
from frame import main, square  # noqa: E402

# Programs, how many ticks of them, a rule, and its body: while catoms come, go and change processes, and of facts that go again.
RULES = ((OWN / "storm.meld", 16, "16", "neighbor(A, B), seen(B, C, D), D < 2"),
         (OWN / "storm.meld", 16, "give if K > 1", "neighbor(A, B), holds(A, K), K > 0, K > 1"),
         (GRADIENT, 60, "dist@10 if D > 50", "neighbor(A, B), dist(A, D), D > 50"))


def numbers(way):
    return tuple(int(n) for n in re.findall(r"-?\d+", way))


class Breaks(DebugTest):
    def new_ways(self, program, last, body):
        """By tick, as queries tell it."""
        asked = [c for t in range(last + 1) for c in (f"to {t}", f"query {body}")]
        answers = self.answers(asked, program, "--ticks", last)
        at = [{tuple(row) for row in found["rows"]} for found in answers[1::2]]
        self.assertTrue(answers[1]["columns"])
        return {t: at[t] - at[t - 1] for t in range(1, last + 1) if answers[2 * t]["tick"] == t and at[t] - at[t - 1]}

    def stops(self, answers):
        return [(a["tick"], {numbers(w) for stop in a["stops"] for w in stop["ways"]}) for a in answers if "stops" in a]

    def test_a_break_is_where_the_body_begins_to_hold(self):
        for program, last, rule, body in RULES:
            expected = sorted(self.new_ways(program, last, body).items())
            self.assertGreater(len(expected), 2, rule)
            runs = ["run"] * (len(expected) + 1)
            for processes in (1, 2, 3):
                with self.subTest(rule=rule, processes=processes):
                    answers = self.answers([f"break {rule}", *runs, "to 1", *runs], program, "--ticks", last, "-n", processes,
                                           "--history", "300kB")
                    moves = [a for a in answers if "from" in a]
                    self.assertEqual(self.stops(moves[:len(runs)]), expected)
                    self.assertNotIn("stops", moves[len(runs)])
                    self.assertEqual(self.stops(moves[len(runs) + 1:]), [e for e in expected if e[0] > 1])
                    self.assertEqual(moves[-1]["ended"], "quiet" if program == GRADIENT else "ticks")

    def test_a_way_back_stops_nowhere_and_a_step_does(self):
        answers = self.answers(["break 10 if D = 3", "step 9", "step 9", "back 5", "to 2", "to 9", "to 9"], GRADIENT)
        self.assertEqual([(a["tick"], "stops" in a) for a in answers[1:]],
                         [(4, True), (13, False), (8, False), (2, False), (4, True), (9, False)])

    def test_several_and_their_numbers(self):
        for processes in (1, 2):
            text = self.session(["breaks", "break dist", "watch dist(@42, D)", "watch dist(@43, _)", "delete 1", "run", "run", "run",
                                 "breaks", "delete all", "back 4", "break 9", "run"], GRADIENT, "-n", processes)[0]
            rules = ("   gradient.meld:9: dist(A, 0) :- source(A).\n"
                     "   gradient.meld:10: dist(B, D + 1) :- neighbor(A, B), dist(A, D).\n")
            two = "2: watch dist(@42, D)\n3: watch dist(@43, _)\n"
            self.assertEqual(text, "no breaks and no watches\n1: break dist\n" + rules + two + two +
                             "tick 7\n2: dist(@42, D): D = 6\ntick 8\n3: dist(@43, _)\ntick 59: nothing is left to do\n" + two +
                             "no breaks and no watches\ntick 55\n4: break 9\n" + rules.splitlines()[0] +
                             "\ntick 59: nothing is left to do\n")

    def test_until(self):
        for processes in (1, 2):
            answers = self.answers(["until dist(A, D), D > 30", "until dist(A, D), D > 30", "to 3", "break 10 if D = 9",
                                    "until dist(A, 12)", "until dist(A, 12)", "until dist(A, 99)"], GRADIENT, "-n", processes)
            moves = [a for a in answers if "from" in a]
            self.assertEqual([(m["tick"], m["ended"]) for m in moves],
                             [(32, None), (33, None), (3, None), (10, None), (13, None), (59, "quiet")])
            self.assertEqual([[s["number"] for s in m.get("stops", [])] for m in moves], [[None], [None], [], [1], [None], []])
            self.assertEqual(moves[0]["stops"][0]["what"], "dist(A, D), D > 30")
            self.assertEqual(len(moves[0]["stops"][0]["ways"]), 1)
        out, err = self.session(["until dist(A)"], GRADIENT, code=2)
        self.assertEqual(out, "")
        self.assertIn("the body:1:1", err)

    def test_mistakes(self):
        program = self.write("token.meld", "type linear token(node).\ntype seen(node).\ntype far(\n  node).\ntoken(@0).\n"
                             "token(A) -o seen(A).\nfar(A) :-\n  seen(A),\n  not tick(A, 0).\nfar(@7).\n")
        for command, says in (("break 99", "no rule is in line 99 of token.meld"),
                              ("break 2", "no rule is in line 2 of token.meld. The next one begins in line"),
                              ("break other.meld:1", "there are no rules in a file other.meld"),
                              ("break fat", "no rule has a head 'fat'. Did you mean 'far'?"),
                              ("break seen if N > 1", "the body:1:"), ("break 5", "has no body"),
                              ("break far fi seen(A)", "'fi' is too much. Write break RULE [if BODY]"),
                              ("break far if seen(B, C)", "the body:1:"),
                              ("break", "the rule is missing"), ("break far if", "the body behind if is missing"),
                              ("watch seen(A", "the body:1:"), ("watch", "the body is missing"),
                              ("delete 1", "there is no break or watch with the number 1"), ("delete", "the number is missing")):
            out, err = self.session([command], program, code=2)
            self.assertEqual(out, "")
            self.assertIn(says, err)
        self.assertEqual(self.session(["break 8", "run"], program)[0],
                         "1: break 8\n   token.meld:7: far(A) :- seen(A), not tick(A, 0).\ntick 1\n1: token.meld:7: A = @0\n")


# One token is counted down within a tick by one of two rules that both could take it, and the rest is passed on to all neighbours.
TOKENS = """type linear token(node, int).
type linear spare(node, string).
type even(node, int).
type odd(node, int).
token(A, 2 * node2int(A) + 1).
spare(A, "left, \\"over\\"").
token(A, N), N > 0, N % 2 = 0 -o even(A, N), token(A, N - 1).
token(A, N), N > 0 -o odd(A, N), token(A, N - 1).
token(A, N), neighbor(A, B), spare(A, S) -o token(B, 3).
"""


class LinearBreaks(DebugTest):
    FILES = {"tokens.meld": TOKENS, "tokens.toml": square(3)}

    def stops(self, *breaks, processes=1, more=()):
        """By tick: of each break where it fired and how."""
        answers = self.answers([*(f"break {b}" for b in breaks), *["run"] * 9], "tokens.meld", "-n", processes, *more)
        return {a["tick"]: [(s["number"], s["what"], list(zip(s["at"], s["ways"]))) for s in a["stops"]] for a in answers if "stops" in a}

    def test_each_firing_is_told_with_its_catom_and_values(self):
        alone = self.stops(7, 8, 9)
        first = {number: ways for number, _, ways in alone[1]}
        # By rule, catom and order: of two rules the first one takes what both could.
        self.assertEqual([way for at, way in first[1] if at == 2], ["A = @2, N = 4", "A = @2, N = 2"])
        self.assertEqual([way for at, way in first[2] if at == 2], ["A = @2, N = 5", "A = @2, N = 3", "A = @2, N = 1"])
        self.assertEqual([at for at, _ in first[3]], list(range(9)))
        self.assertIn('S = "left, \\"over\\""', first[3][0][1])
        stats = json.loads(self.call("meldsim", "run", "tokens.meld", "--stats", "--json", "--quiet")[0])["stats"]
        fired = {rule["line"]: rule["firings"] for rule in stats["rules"]}
        for number, line in ((1, 7), (2, 8), (3, 9)):
            told = sum(len(ways) for stops in alone.values() for of, _, ways in stops if of == number)
            self.assertEqual((told, told > 0), (fired[line], True))
        for processes in (2, 4):
            self.assertEqual(self.stops(7, 8, 9, processes=processes, more=("--threads", 2)), alone)

    def test_a_condition_of_a_linear_rule(self):
        for processes in (1, 3):
            [(tick, [(_, what, ways)])] = self.stops("odd if N > 15, neighbor(A, B), odd(B, 7)", processes=processes).items()
            # Catom 8 begins with 17; catom 3, which it does not touch, and catom 5, which it does, count down by way of 7.
            self.assertEqual((tick, what, ways), (1, "tokens.meld:8", [(8, "A = @8, N = 17")]))

    def test_on_every_way(self):
        answers = self.answers(["to 2", "break 9", "to 1", "to 0", "run", "back", "run", "to 3", "reverse", "delete 1", "run"],
                               "tokens.meld")
        moves = [a for a in answers if "from" in a]
        self.assertEqual([(m["tick"], "stops" in m) for m in moves[1:4]], [(1, False), (0, False), (1, True)])
        self.assertEqual(moves[3], {**moves[5], "from": 0})
        self.assertEqual(moves[7]["stops"], moves[3]["stops"])
        self.assertNotIn("stops", moves[8])


class Reverse(DebugTest):
    def test_to_the_last_stop_before(self):
        for processes in (1, 2):
            answers = self.answers(["break 10 if D = 3", "watch dist(@42, D)", "run", "run", "run", *["reverse"] * 4], GRADIENT,
                                   "-n", processes, "--history", "300kB")
            there = [(a["tick"], a.get("stops")) for a in answers if "from" in a]
            self.assertEqual([tick for tick, _ in there], [4, 7, 59, 7, 4, 0, 0])
            self.assertEqual([there[3], there[4]], [there[1], there[0]])
            self.assertEqual([stops for _, stops in there[5:]], [None, None])

    def test_without_breaks_to_the_first_tick(self):
        self.assertEqual(self.session(["to 9", "reverse", "diff"], GRADIENT)[0], "tick 9\ntick 0\nfrom tick 9 to tick 0:\ndist: +0 -165\n")

    def test_a_break_far_behind(self):
        program = self.write("long.meld", "type linear t(node, int).\nt(@0, 0).\nt(A, N), N < 700 -o t(A, N + 1)@+1.\n")
        self.write("long.toml", square(1))
        answers = self.answers(["break 3 if N = 9", "to 600", "to 600", "reverse", "reverse"], program)
        self.assertEqual([(a["tick"], "stops" in a) for a in answers if "from" in a], [(10, True), (600, False), (10, True), (0, False)])


if __name__ == "__main__":
    main("meldc", "meldsim")
