"""`meldsim query` and `meldsim facts`: what a body asks for is there, wherever the run comes from and on any number of processes.

    query_test.py --meldc PATH --meldsim PATH [unittest options]
"""
import csv
import io
import json
import os
import re
import sys
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT / "tests"))

from frame import Case, main, square  # noqa: E402

GRADIENT = ROOT / "examples/meld/gradient.meld"
PROGRAMS = Path(__file__).resolve().parent / "programs"
# A square of 16 catoms in which most of the language occurs.
PROGRAM = """
const step = 3.
const names = ["no", "one", "two"].
const doubled = twice(step).
fun twice(int X) : int = X * 2.
fun deep(int N) : int = if N < 1 then 0 else 1 + deep(N - 1) end.
fun summed(int S, int X) : int = S + X.
type row(node, int).
type pair(node, :(int, node)).
type path(node, list int).
type half(node, float).
type sign(node, string).
type marked(node, set int).
type used(node, int).
type route next(node, node).
type linear token(node, int).
type action setColor(node, int, int, int).
row(A, N) :- id(A, N).
pair(A, :(N, B)) :- row(A, N), neighbor(A, B, 0).
path(A, [N, N * 2, step]) :- row(A, N), N < 4.
half(A, float(N) / 2) :- row(A, N), N < 4.
sign(A, lnth(names, N)) :- row(A, N), N < 3.
marked(A, list2set([N % 3, 1])) :- row(A, N).
used(A, doubled + deep(2) + X) :- X = summed N : { row(A, N) }.
next(A, B) :- neighbor(A, B), row(A, N), row(B, M), M = N + 1.
token(@3, 7). token(@3, 8).
setColor(A, 1, 2, N) :- row(A, N), N > 13.
"""


class QueryTest(Case):
    FILES = {"p.meld": PROGRAM, "p.toml": square(4)}

    def query(self, target, body, *options, code=0):
        """The rows, as JSON has them."""
        out, _ = self.call("meldsim", "query", target, body, "--json", "--quiet", *options, code=code)
        answer = json.loads(out)
        self.assertEqual(answer["count"], len(answer["rows"]))
        return answer["rows"]


class Bodies(QueryTest):
    def test_what_a_body_may_read(self):
        for body, rows in (
                ("row(A, N), N < 2", [[0, 0], [1, 1]]),
                ("row(@5, N)", [[5]]),
                ("row(A, 5)", [[5]]),
                ("pair(A, :(N, B)), N < 2, row(B, M)", None),
                ("path(@2, [X | L])", [[2, [4, 3]]]),
                ("path(A, L), X in L, X = 6", [[3, [3, 6, 3], 6]]),
                ("path(@1, [X, Y, Z])", [[1, 2, 3]]),
                ("half(A, F), F > 0.9", [[2, 1.0], [3, 1.5]]),
                ("sign(A, S), S <> \"no\", M = S ++ \"!\"", [[1, "one", "one!"], [2, "two", "two!"]]),
                ("marked(@4, S), E in S", [[[1], 1]]),
                ("marked(A, S), ssize(S) > 1, A = @2", [[2, [1, 2]]]),
                ("token(A, X), token(A, Y), X < Y", [[3, 7, 8]]),
                ("$token(A, 7)", [[3]]),
                ("X = step, Y = doubled, Z = twice(Y)", [[3, 6, 12]]),
                ("X = deep(4000)", [[4000]]),
                ("S = sum N : { row(_, N) }", [[120]]),
                ("L = min_k(2) N : { row(_, N), N > 3 }", [[[4, 5]]]),
                ("S = summed N : { row(_, N), N < 4 }", [[6]]),
                ("S = avg N : { row(_, N) }", [[7.5]]),
                ("C = count : { row(_, N), N > 99 }", [[0]]),
                ("forall row(A, N) [N < 16], X = 1", [[1]]),
                ("row(A, N), not next(A, _)", None),
                ("next(A, B), neighbor(B, C), row(A, N), row(C, N + 3)", None),
                ("tick(@0, T), neighborCount(@0, N)", None),
                ("cell(A, X, Y, 0), X = Y, id(A, N), position(A, P), x(P) > 0.0", None),
                ("row(A, N), M = N - 1, row(B, M), not neighbor(A, B)", None),
                ("row(A, X), row(B, Y), X + Y = 29, A < B", [[14, 14, 15, 15]]),
                ("row(A, @world - 1)", [[15]])):
            with self.subTest(body=body):
                found = [self.query("p.meld", body, "-n", n) for n in ((1, 2) if rows is None else (1,))]
                self.assertTrue(found[0])
                if rows is not None:
                    self.assertEqual(found[0], rows)
                self.assertEqual(found, found[:1] * len(found))

    def test_actions_are_those_that_are_asked_for(self):
        for n in (1, 2):
            self.assertEqual(self.query("p.meld", "setColor(A, _, _, B)", "--tick", 1, "-n", n), [[14, 14], [15, 15]])
            self.assertEqual(self.query("p.meld", "setColor(A, _, _, B)", "--tick", 2, "-n", n, code=1), [])

    def test_values_that_cannot_be_computed_are_left_out_and_counted(self):
        for body, rows, count in (("row(A, N), X = 12 / N, X > 5", [[1, 1, 12], [2, 2, 6]], 1), ("row(A, N), X = 12 / (N - 20)", None, 0),
                                  ("row(@0, N), not (row(B, M), 1 / M > 5)", [], 1), ("M = max X : { row(_, N), X = 1 / N }", [], 1)):
            with self.subTest(body=body):
                out, _ = self.call("meldsim", "query", "p.meld", body, "--json", "--quiet", code=0 if rows != [] else 1)
                answer = json.loads(out)
                if rows is not None:
                    self.assertEqual(answer["rows"], rows)
                self.assertEqual(answer.get("left_out", {}).get("count", 0), count)
        out, _ = self.call("meldsim", "query", "p.meld", "row(@0, N), X = 1 / N", "--quiet", code=1)
        self.assertEqual(out, "no rows\nleft out: 1 value that cannot be computed, the first for a division by zero\n")

    def test_mistakes_have_their_place_and_cure(self):
        for body, says in (("rwo(A, N)", ("the body:1:1", "did you mean `row`?")), ("row(A)", "`row` has 2 arguments, and here is 1"),
                           ("row(A, N), X > N", "`X` has no value in this condition"), ("row(A, N), N", "the body:1:12"),
                           ("row(A, N) -o row(A, N)", "is not one body"),
                           ('include "x.meld". row(A, N)', "is not one body"), ("row(A, N).", "found the end of the body"),
                           ("", "the body is missing"),
                           ("row(A, X), Y = randint(X)", "and a question is about what is there"),
                           ("delta(N; row(A, N)) > 1", "a question looks at one moment"),
                           ("pressure(A, P)", "the run has no facts of 'pressure/2', because no rule of the program reads it"),
                           ("row(A, N), N = @arg2", "the program takes no @arg2"),
                           ("stable(row(A, N), 5)", "no facts of 'stable(row/2, 5)'")):
            with self.subTest(body=body):
                self.refused("meldsim", "query", "p.meld", body, "--quiet", code=2, says=says, lines=None)
        self.refused("meldsim", "facts", "p.meld", "rwo", "--quiet", code=2, says="Did you mean 'row'?")
        self.refused("meldsim", "facts", "p.meld", "@99", "--quiet", code=2, says="there is no catom @99 in tick")
        self.refused("meldsim", "query", "p.meld", "row(A, N)", "--tick", 99, "--quiet", code=2, says="before tick 99")

    def test_functions_in_c_are_called_by_rules_only(self):
        self.write("c.meld", "extern int cubed(int).\ntype p(node, int).\np(A, cubed(N)) :- id(A, N).\n")
        self.write("c.c", "long cubed(long n) { return n * n * n; }\n")
        self.assertEqual(self.query("c.meld", "p(@2, N)", "--link", "c.c", "--world", "p.toml"), [[8]])
        self.refused("meldsim", "query", "c.meld", "p(A, N), M = cubed(N)", "--link", "c.c", "--quiet", code=2, says="this calls 'cubed'")

    def test_sources_come_from_the_module(self):
        """Includes, libraries and modules of a program whose files are gone."""
        self.write("sub/m.meld", "module counter.\nexport counted.\nuse \"colours\".\ntype counted(node, int).\n"
                                 "counted(A, N + shift) :- id(A, N).\n")
        self.write("libraries/colours.meld", "const shift = 100.\n")
        self.write("i.meld", 'include "sub/m".\nuse "gradient".\nimport counted as number from "sub/m.meld".\ngradient-source(@0).\n'
                             "type twice(node, int).\ntwice(A, 2 * N) :- number(A, N).\n"
                             "type far(node, int).\nfar(A, D) :- gradient-dist(A, D).\n")
        self.call("meldc", "compile", "i.meld", "-I", "libraries", "-o", "i.so", "--quiet")
        for path in ("sub/m.meld", "libraries/colours.meld", "i.meld"):
            (self.folder / path).unlink()
        body = "number(@3, N), counter-counted(@3, N), twice(@3, M), M = N * 2"
        self.assertEqual(self.query("i.so", body, "--world", "p.toml"), [[103, 206]])
        self.assertEqual(self.query("i.so", "D = max X : { gradient-dist(_, X) }", "--world", "p.toml"), [[6]])

    def test_includes_mean_what_they_meant_to_the_compiler(self):
        """A library and not the file that is named like it, the program itself even; and files by absolute paths."""
        for path in ("gradient.meld", "sub/gradient.meld"):
            self.write(path, 'use "gradient".\ngradient-source(@0).\ntype far(node, int).\nfar(A, D) :- gradient-dist(A, D).\n')
            self.assertEqual(self.query(path, "D = max X : { far(_, X) }", "--world", "p.toml"), [[6]])
        self.write("one/x.meld", "const n = 1.\n")
        self.write("two/x.meld", "const n = 2.\n")
        self.write("a.meld", f'include "{self.folder}/two/x.meld".\nimport n as m from "one/x".\ntype p(node, int).\np(@0, n * 10 + m).\n')
        self.assertEqual(self.query("a.meld", "p(@0, N), M = n", "--world", "p.toml"), [[21, 2]])

    def test_constants_of_the_run(self):
        self.write("k.meld", "const n = 4.\nconst pi = 3.5.\nconst more = n * 2.\ntype p(node, int, float).\n"
                             "p(A, n + @arg1, pi) :- id(A, 0).\n")
        options = ("--set", "n=7", "--set", "pi=2.25", "--arg", 5, "--world", "p.toml")
        self.assertEqual(self.query("k.meld", "p(A, N, F), X = n, Y = pi + 1, Z = @arg1, W = failed-create", *options),
                         [[0, 12, 2.25, 7, 3.25, 5, 1]])


class Targets(QueryTest):
    BODIES = ("last(A, N), neighbor(A, B), not holds(B, N)", "N = count : { seen(_, _, _) }", "memory(A, [K | L]), K <> 3",
              "seen(A, B, 2), seen(B, C, 2), A < C, last(A, K), last(C, K)", "create(A, P), give(A, B)")

    def test_a_run_a_recording_and_a_checkpoint_answer_alike(self):
        storm = PROGRAMS / "storm.meld"
        self.call("meldsim", "run", storm, "--ticks", 12, "--quiet", "--record", "r.vtkhdf", "--checkpoint", "kept")
        for i, body in enumerate(self.BODIES):
            with self.subTest(body=body):
                expected = None
                for target, options in ((storm, ("--tick", 12)), (storm, ("--tick", 12, "-n", 3)), ("r.vtkhdf", ("-n", 1 + i % 2)),
                                        ("kept", ("-n", 1 + (i + 1) % 2))):
                    rows = self.query(target, body, *options, code=None if expected is None else 0)
                    expected = rows if expected is None else expected
                    self.assertEqual(rows, expected, f"{target} {options}")
                self.assertTrue(expected)
        self.assertEqual(self.query("r.vtkhdf", self.BODIES[1], "--tick", 7), self.query(storm, self.BODIES[1], "--tick", 7))
        self.assertEqual(self.query("kept", self.BODIES[1], "--tick", 15, "-n", 2), self.query(storm, self.BODIES[1], "--tick", 15))
        self.refused("meldsim", "query", "kept", self.BODIES[1], "--tick", 3, "--quiet", code=2, says="the first tick here is 12")
        self.refused("meldsim", "query", "r.vtkhdf", self.BODIES[1], "--tick", 13, "--quiet", code=2, says="before tick 13")

    def call(self, tool, *arguments, code=0, **options):
        if code is not None:
            return super().call(tool, *arguments, code=code, **options)
        done = self.run_tool(tool, *arguments, **options)
        self.assertIn(done.returncode, (0, 1), done.stderr)
        return done.stdout, done.stderr

    def test_forms_of_the_answer(self):
        body = "sign(A, S), row(A, N)"
        out, _ = self.call("meldsim", "query", "p.meld", body, "--quiet")
        self.assertEqual(out, 'A   S      N\n@0  "no"   0\n@1  "one"  1\n@2  "two"  2\n3 rows\n')
        out, _ = self.call("meldsim", "query", "p.meld", body, "--quiet", "--limit", 1)
        self.assertEqual(out, 'A   S     N\n@0  "no"  0\n... and 2 more\n3 rows\n')
        out, _ = self.call("meldsim", "query", "p.meld", body, "--quiet", "--csv")
        self.assertEqual(list(csv.reader(io.StringIO(out))), [["A", "S", "N"], ["0", "no", "0"], ["1", "one", "1"], ["2", "two", "2"]])
        out, _ = self.call("meldsim", "query", "p.meld", "path(A, L), A = @2", "--quiet", "--csv")
        self.assertEqual(list(csv.reader(io.StringIO(out))), [["A", "L"], ["2", "[2, 4, 3]"]])
        out, _ = self.call("meldsim", "query", "p.meld", body, "--quiet", "--json", "--limit", 1)
        self.assertEqual(json.loads(out), {"tick": json.loads(out)["tick"], "query": body, "count": 3, "rows": [[0, "no", 0]], "columns":
                                           [{"name": "A", "type": "node"}, {"name": "S", "type": "string"}, {"name": "N", "type": "int"}]})
        for yes, code in (("row(@3, 3)", 0), ("row(@3, 4)", 1)):
            out, _ = self.call("meldsim", "query", "p.meld", yes, "--quiet", code=code)
            self.assertEqual(out, "no\n" if code else "yes\n")

    def test_facts_of_a_catom(self):
        waiting = PROGRAMS / "waiting.meld"
        for n in (1, 2):
            out, _ = self.call("meldsim", "facts", waiting, "@17", "--tick", 6, "--quiet", "-n", n)
            place, *coming = [line for line in out.splitlines() if line.startswith("//")]
            self.assertRegex(place, r"^// @17 in cell \(\S+, \S+, \S+\), touches @\d+ at port \d")
            self.assertTrue(coming)
            for line in coming:
                self.assertRegex(line, r"^// \w+\(@17, .*\) comes in tick (7|8|9)$")
            json_out, _ = self.call("meldsim", "facts", waiting, "@17", "--tick", 6, "--quiet", "--json", "-n", n)
            catom = json.loads(json_out)["catom"]
            self.assertEqual(len(catom["coming"]), len(coming))
            # What comes is there in its tick, at the end of which its rules have seen it.
            for at in catom["coming"]:
                bell = re.match(r"bell\(@17, (\d+), (.*)\)", at["fact"])
                if bell:
                    self.assertEqual(self.query(waiting, f"rung(@17, {bell[1]}, {bell[2]})", "--tick", at["tick"]), [[]])
        [catom, pivot], *_ = self.query(PROGRAMS / "storm.meld", "destroy(A, B)", "--tick", 3)
        out, _ = self.call("meldsim", "facts", PROGRAMS / "storm.meld", f"@{catom}", "--tick", 3, "--quiet")
        self.assertIn(f"// asks for destroy(@{catom}, @{pivot})\n", out)

    def test_in_the_debugger(self):
        commands = "to 4\nquery dist(A, D), D > 3\nto 5\nquery N = count : { dist(_, _) }\n"
        for n in (1, 3):
            done = self.run_tool("meldsim", "debug", GRADIENT, "--json", "-n", n, stdin=None, input=commands.encode())
            answers = [json.loads(line) for line in done.stdout.splitlines()]
            self.assertEqual([(a["tick"], a.get("count"), a.get("rows")) for a in answers],
                             [(4, None, None), (4, 0, []), (5, None, None), (5, 1, [[35]])])
        done = self.run_tool("meldsim", "debug", GRADIENT, stdin=None, input=b"query\n")
        self.assertIn("query: the body is missing. Write query BODY", done.stderr)


if __name__ == "__main__":
    os.environ.update({"OMPI_ALLOW_RUN_AS_ROOT": "1", "OMPI_ALLOW_RUN_AS_ROOT_CONFIRM": "1", "OMPI_MCA_rmaps_base_oversubscribe": "1"})
    main("meldc", "meldsim")
