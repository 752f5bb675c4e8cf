"""`meldsim run --watch`, `--expect`, `--never` and `--junit`: what they say is what `meldsim query` finds after each tick, on any number of
processes, and the run is the one that it is without them.

    watch_test.py --meldc PATH --meldsim PATH [unittest options]
"""
import csv
import io
import re
import shutil
import sys
import xml.etree.ElementTree as ET
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT / "tests"))

from frame import FOREVER, Case, main, square  # noqa: E402

EXAMPLES = ROOT / "examples/meld"
GRADIENT = EXAMPLES / "gradient.meld"
PROGRAMS = Path(__file__).resolve().parent / "programs"
STORM = PROGRAMS / "storm.meld"
# Programs, ticks, and bodies: at a catom, over a link and over two, back over links, without any, with negation, aggregates, a literal,
# what was asked for in the tick, and catoms that rules make.
CASES = (
    (GRADIENT, 12, ("dist(A, D), D > 3", "dist(A, D), neighbor(A, B), dist(B, D)", "dist(A, 2), neighbor(A, C), neighbor(C, B), dist(B, 4)",
                    "source(A), dist(B, 5)",
                    "neighbor(A, B), dist(A, D), not dist(B, _)", "dist(A, D), N = count : {neighbor(A, _)}, N < D",
                    "not (dist(A, 3), neighbor(A, _)), source(_)", "dist(@4, D)", "tick(@3, T), T > 4, dist(@3, D)")),
    (PROGRAMS / "seen.meld", 3, ("seen(A, C), neighbor(A, B), seen(B, A)", "seen(A, @3)", "neighbor(A, B), not seen(A, B)",
                                 "seen(A, B), N = count : {neighbor(A, C), seen(C, B)}, N > 1")),
    (EXAMPLES / "walk.meld", 12, ("neighborCount(A, N), N < 3", "neighbor(A, B), not neighbor(B, @0)")),
    (PROGRAMS / "late_nodes.meld", 7, ("id(A, X)", "id(A, X), not made(A, _)", "id(A, X), not count(A, _)", "count(A, N)",
                                       "made(A, B), count(B, N)")),
    # Of facts that few catoms hold, wherever they are; then no two of a kind are left.
    (PROGRAMS / "tokens.meld", 16, ("token(A, N), token(B, M), A <> B", "token(A, N), stopped(B, M)", "stopped(A, N), stopped(B, M), N < M",
                                    "token(A, N), not (token(B, M), M > N)", "token(A, N), K = count : {token(B, _)}, K < 3",
                                    "token(A, N), neighbor(A, C), token(B, M), N <> M")),
    # Tables that are looked up by a value, an int beside a float, two of them, a constant, and a value that may overflow.
    (PROGRAMS / "routes.meld", 9, ("hop(A, X, Y), hop(A, Y, X), X < Y", "hop(A, X, Y), hop(A, Z, Y), X < Z",
                                   "hop(A, X, Y), not hop(A, Y, _), X > 20", "hop(A, X, Y), N = count : {hop(A, _, X)}, N > 1",
                                   "hop(A, X, Y), far(A, Z, X), Z > Y, X < 9",
                                   "neighbor(A, B), hop(B, X, Y), not hop(B, Y, X), X < 0", "hop(A, X, 8), hop(A, 7, X)",
                                   "hop(A, X, Y), hop(A, X + 9223372036854775800, Y)")),
)


class WatchTest(Case):
    def rows(self, program, body, tick, names):
        done = self.run_tool("meldsim", "query", program, body, "--tick", tick, "--csv", "--quiet")
        self.assertIn(done.returncode, (0, 1), done.stderr)
        return {tuple(row[n] for n in names) for row in csv.DictReader(io.StringIO(done.stdout))}

    def told(self, out):
        """Rows by tick and name, each a tuple of values; catoms as numbers."""
        lines = {}
        for line in out.splitlines():
            if found := re.match(r"tick (\d+): (\w+)(?:: (.*))?$", line):
                row = tuple(part.split(" = ", 1)[1].lstrip("@") for part in found[3].split(", ")) if found[3] else ()
                lines.setdefault((int(found[1]), found[2]), []).append(row)
        return lines

    def digests(self, *arguments, code=0):
        self.call("meldsim", "run", *arguments, "--quiet", "--digest", "d.txt", code=code)
        return self.read("d.txt")


class Watches(WatchTest):
    """What begins to hold is what a query finds and did not find before."""

    def test_watches_are_queries_after_every_tick(self):
        for program, ticks, bodies in CASES:
            rules = "".join(f'tell("w{i}") :- {body}.\n' for i, body in enumerate(bodies))
            self.write("w.meld", rules)
            outs = [self.call("meldsim", "run", program, "--ticks", ticks, "--quiet", "--watch", "w.meld", "-n", n)[0] for n in (1, 2, 3)]
            self.assertEqual(outs[0], outs[1])
            self.assertEqual(outs[0], outs[2])
            told = self.told(outs[0])
            self.assertTrue(told)
            for i, body in enumerate(bodies):
                first = self.run_tool("meldsim", "query", program, body, "--tick", 1, "--csv").stdout.splitlines()
                names = first[0].split(",") if first and first[0] else []
                before = set()
                for tick in range(1, ticks + 1) if names else ():
                    now = self.rows(program, body, tick, names)
                    self.assertEqual(set(told.get((tick, f"w{i}"), [])), now - before, f"{body} in tick {tick}")
                    before = now

    def test_the_run_is_the_same(self):
        for program, ticks, bodies in (*CASES, (STORM, 10, ("neighbor(A, B), neighbor(B, C), A <> C",))):
            plain = self.digests(program, "--ticks", ticks)
            self.write("w.meld", "".join(f"tell() :- {body}.\n" for body in bodies))
            for n in (1, 4):
                self.assertEqual(self.digests(program, "--ticks", ticks, "--watch", "w.meld", "-n", n), plain)


    def test_a_join_without_links(self):
        """Facts of other processes come before any index of them is made."""
        self.write("lit.meld", "type dist(node, min int D).\ntype c(node, int).\ntype lit(node, int).\n"
                               "dist(@5, 0). dist(@20, 0). dist(@70, 0). dist(@90, 0).\n"
                               "dist(B, D + 1) :- neighbor(A, B), dist(A, D), D < 3.\n"
                               "c(@3, 1). c(@22, 100). c(@68, 4). c(@92, 100).\nlit(A, X) :- c(A, X), dist(A, 2).\n")
        self.write("lit.toml", 'lattice = "square"\n[[body]]\nshape = "box(121, 1, 1)"\n')
        for n in (1, 2, 3):
            out, _ = self.call("meldsim", "run", "lit.meld", "--world", "lit.toml", "--quiet", "-n", n, "--never",
                               "lit(A, X), lit(B, X), A <> B", code=3)
            self.assertIn("A = @22, X = 100, B = @92", out)

    def test_bodies_that_fall(self):
        """They move while nothing is evaluated."""
        self.write("x.meld", "type x(node).\nx(@0).\n")
        self.write("x.toml", 'lattice = "cubic"\n[[body]]\ncells = [[0, 0, 5], [3, 0, 9]]\n[motion]\nkind = "bodies"\nspacing = 1\n'
                             'steps = 4\nground = -0.5\n')
        body = "position(A, X, Y, Z), Z < 4.0"
        run = ("--world", "x.toml", "--ticks", 30, "--quiet")
        for n in (1, 2):
            out, _ = self.call("meldsim", "run", "x.meld", *run, "-n", n, "--watch", f"tell: {body}", code=3)
            tick = int(re.match(r"tick (\d+): tell: A = @0", out)[1])
            for t, code in ((tick - 1, 1), (tick, 0)):
                self.call("meldsim", "query", "x.meld", body, "--world", "x.toml", "--tick", t, "--quiet", code=code)
            self.assertGreater(tick, 2)

    def test_a_warning_does_not_depend_on_processes(self):
        """A search that lacked a fact, and went another way for that, says nothing."""
        self.write("p.meld", "type one(node, int).\none(A, 5).\n")
        self.write("p.toml", square(3))
        run = ("p.meld", "--world", "p.toml", "--quiet", "--never")
        for body in ("one(@0, X), N = count : {one(@8, _)}, X / N < 1", "one(@8, X), N = count : {one(@0, _)}, X / N < 1"):
            said = [self.call("meldsim", "run", *run, body, "-n", n)[1] for n in (1, 2, 3)]
            self.assertEqual(said, [""] * 3)

    def test_a_name_is_the_body_on_one_line(self):
        self.write("w.meld", 'tell(A) :- source(A), // Where it begins.\n    dist(A, 0), /* As /* it */ is. */ "a  b" = "a  b".\n')
        out, _ = self.call("meldsim", "run", GRADIENT, "--quiet", "--ticks", 1, "--watch", "w.meld")
        self.assertEqual(out, 'tick 1: source(A), dist(A, 0), "a  b" = "a  b": A = @0\n')


class Endings(WatchTest):
    FILES = {"forever.meld": FOREVER, "forever.toml": square(3)}

    def test_a_stop_ends_the_run_after_its_tick(self):
        for n in (1, 2):
            out, _ = self.call("meldsim", "run", GRADIENT, "-n", n, "--watch", "far: dist(A, D), D > 5", "--facts-out", "end.facts",
                               "--record", "end.vtkhdf", "--quiet", code=3)
            tick = int(re.match(r"tick (\d+): far: A = @", out)[1])
            self.assertEqual(tick, 7)
            self.call("meldsim", "run", GRADIENT, "--ticks", tick, "--facts-out", "plain.facts", "--quiet")
            self.assertEqual(self.read("end.facts"), self.read("plain.facts"))
            out, _ = self.call("meldsim", "replay", "end.vtkhdf")
            self.assertIn(f"replayed {tick} ticks", out)

    def test_expect_and_never(self):
        run = ("run", GRADIENT, "--quiet")
        self.call("meldsim", *run, "--expect", "dist(A, 9)", "--never", "dist(A, D), D < 0")
        out, _ = self.call("meldsim", *run, "--expect", "dist(A, 999)", code=3)
        self.assertIn("expected, and it does not hold: dist(A, 999)", out)
        out, _ = self.call("meldsim", *run, "--never", "dist(A, D), D > 2", "--facts-out", "end.facts", code=3)
        self.assertEqual(out.count("tick 4: dist(A, D), D > 2: A = @"), 1)
        self.call("meldsim", *run, "--facts-out", "plain.facts")
        self.assertEqual(self.read("end.facts"), self.read("plain.facts"))

    def test_junit(self):
        self.call("meldsim", "run", GRADIENT, "--quiet", "--junit", "out.xml", "--never", 'dist(A, D), D < 0 || "<&" = "x"', "--expect",
                  "far and wide: dist(A, 999)", "--watch", "dist(A, D), D > 4", code=3)
        suite = ET.fromstring(self.read("out.xml")).find("testsuite")
        self.assertEqual((suite.get("tests"), suite.get("failures"), suite.get("errors")), ("4", "2", "0"))
        cases = {case.get("name"): case for case in suite.findall("testcase")}
        self.assertIsNone(cases["the run"].find("failure"))
        failure = cases["stop: dist(A, D), D > 4"].find("failure")
        self.assertRegex(failure.get("message"), r"^tick 6: A = @\d+, D = 5$")
        self.assertRegex(failure.text, r"^\ndist\(@\d+, 5\), 5 > 4\n    dist\(@\d+, 5\)  rank 5\n      gradient.meld:10: ")
        self.assertIsNone(cases['never: dist(A, D), D < 0 || "<&" = "x"'].find("failure"))

    def test_why_the_first_of_them_found_what_it_did(self):
        """In the state of that tick, which the run itself does not notice; the same on any number of processes."""
        outputs = ("--record", "r.vtkhdf", "--profile", "run.profile", "--checkpoint", "kept", "--quiet")
        for program, ticks, body, rule in ((GRADIENT, 8, "dist(A, D), neighbor(A, B), dist(B, E), E > 3, D < E", "dist(B, D + 1) :-"),
                                           (STORM, 10, "neighbor(A, B), neighbor(B, C), A <> C", "neighbor(@"),
                                           (EXAMPLES / "walk.meld", 12, "tick(A, T), T > 8, neighborCount(A, N)", "sensed")):
            plain = self.digests(program, "--ticks", ticks)
            outs = []
            for n in (1, 2, 3):
                out, err = self.call("meldsim", "run", program, "--ticks", ticks, *outputs, "--digest", "d", "-n", n, "--never",
                                     f"{body}, 1 > 2", "--never", f"first: {body}", "--never", f"second: {body}", code=3)
                self.assertEqual(err, "")
                self.assertEqual(self.read("d"), plain)
                outs.append(out)
                shutil.rmtree(self.folder / "kept")
            self.assertEqual(outs, outs[:1] * 3)
            lines = outs[0].splitlines()
            said = [i for i, line in enumerate(lines) if line.startswith("tick ")]
            self.assertEqual([lines[i].split(": ")[1] for i in said], ["first", "second"])
            # Both are told first, then why the first holds.
            self.assertEqual(said, [0, 1])
            self.assertIn(rule, outs[0])
            # That is what a question about the tick says, where nothing has changed since.
            tick = lines[0].split()[1].strip(":")
            fact = lines[3].strip().split("  ")[0]
            self.call("meldsim", "why", program, fact, "--tick", tick, "--quiet")

    def test_who_holds_what_is_linear_is_said_without_its_maker(self):
        self.write("p.meld", "type linear token(node, int).\ntoken(@0, 0).\ntoken(A, N), N < 9 -o token(A, N + 1).\n")
        self.write("p.toml", square(2))
        out, _ = self.call("meldsim", "run", "p.meld", "--world", "p.toml", "--quiet", "--watch", "token(A, N), N > 4", code=3)
        self.assertEqual(out.splitlines()[:3],
                         ["tick 1: token(A, N), N > 4: A = @0, N = 9", "token(@0, 9), 9 > 4", "    token(@0, 9)  made"])

    def test_names_are_shown_as_text(self):
        self.write("w.meld", 'never("\x1b[2Jcleared") :- dist(@2, D), D > 0.\nexpect("\x1b[2Jcleared", A) :- dist(A, 999).\n')
        out, _ = self.call("meldsim", "run", GRADIENT, "--quiet", "--watch", "w.meld", code=3)
        self.assertEqual((out.count("\x1b"), out.count("\\x1b[2Jcleared")), (0, 2))

    def test_one_result_that_cannot_be_written_takes_no_other_along(self):
        run = ("run", GRADIENT, "--quiet", "--ticks", 3)
        self.call("meldsim", *run, "--facts-out", "plain.facts")
        for n in (1, 2):
            _, err = self.call("meldsim", *run, "--junit", "/dev/full", "--facts-out", "end.facts", "--profile", "run.profile", "-n", n,
                               code=4)
            self.assertEqual(err.count("/dev/full"), 1, err)
            self.assertEqual(self.read("end.facts"), self.read("plain.facts"))
            self.call("meldsim", "profile", "run.profile")
            _, err = self.call("meldsim", *run, "--facts-out", "/dev/full", "--profile", "/dev/full", "--junit", "out.xml", "--expect",
                               "dist(A, 999)", "-n", n, code=4)
            self.assertEqual(err.count("/dev/full"), 2, err)
            self.assertEqual(ET.fromstring(self.read("out.xml")).get("failures"), "1")
            for name in ("end.facts", "run.profile", "out.xml"):
                (self.folder / name).unlink()

    def test_its_files_are_apart_from_others(self):
        self.write("w.meld", "tell(A) :- dist(A, 3).\n")
        self.refused("meldsim", "run", GRADIENT, "--watch", "w.meld", "--junit", "w.meld", code=2, says="--watch and --junit are the same")
        self.refused("meldsim", "run", GRADIENT, "--junit", "out/junit.csv", "--facts-out", "out/", code=2,
                     says="--junit and --facts-out both write into the folder out/")

    def test_a_run_that_goes_on_tells_no_line_twice(self):
        self.write("w.meld", 'tell("t", A, T) :- tick(A, T).\nstop("s") :- tick(@2, T), T > 5.\n')
        whole, _ = self.call("meldsim", "run", "forever.meld", "--ticks", 12, "--quiet", "--watch", "w.meld", code=3)
        self.assertEqual(whole.count(": t: "), 6 * 9)
        for n in (1, 3):
            first, _ = self.call("meldsim", "run", "forever.meld", "--ticks", 4, "--quiet", "--watch", "w.meld", "-n", n,
                                 "--checkpoint", f"c{n}")
            second, _ = self.call("meldsim", "resume", f"c{n}", "--ticks", 12, "--quiet", "-n", 4 - n, code=3)
            self.assertEqual(first + second, whole)

    def test_what_held_at_the_checkpoint_is_not_told_again(self):
        self.write("w.meld", 'tell("far", A, D) :- dist(A, D), D > 2.\n')
        whole, _ = self.call("meldsim", "run", GRADIENT, "--ticks", 12, "--quiet", "--watch", "w.meld")
        first, _ = self.call("meldsim", "run", GRADIENT, "--ticks", 6, "--quiet", "--watch", "w.meld", "--checkpoint", "c")
        second, _ = self.call("meldsim", "resume", "c", "--ticks", 12, "--quiet", "-n", 2)
        self.assertEqual(first + second, whole)

    def test_watches_of_one_body_are_told_apart(self):
        """Also those that say the same: they are in their order."""
        self.write("w.meld", "".join(f"tell({shown}) :- dist(A, D), D > 2.\n" for shown in ("D", "A", "A", "D")))
        whole, _ = self.call("meldsim", "run", GRADIENT, "--ticks", 12, "--quiet", "--watch", "w.meld")
        first, _ = self.call("meldsim", "run", GRADIENT, "--ticks", 6, "--quiet", "--watch", "w.meld", "--checkpoint", "c")
        second, _ = self.call("meldsim", "resume", "c", "--ticks", 12, "--quiet", "-n", 2)
        self.assertEqual(first + second, whole)

    def test_a_run_that_branches_off_has_watches_of_its_own(self):
        self.write("w.meld", 'tell("far", A, D) :- dist(A, D), D > 8.\n')
        self.call("meldsim", "run", GRADIENT, "--ticks", 6, "--quiet", "--never", "dist(A, D), D > 7", "--checkpoint", "c")
        whole, _ = self.call("meldsim", "run", GRADIENT, "--ticks", 12, "--quiet", "--watch", "w.meld")
        out, _ = self.call("meldsim", "fork", "c", "--ticks", 12, "--quiet", "--watch", "w.meld", "--expect", "dist(A, 11)", "-n", 2)
        self.assertTrue(out)
        self.assertEqual(out, whole)
        self.call("meldsim", "fork", "c", "--ticks", 12, "--quiet", "--never", "dist(A, D), D > 8", "--junit", "f.xml", code=3)
        self.assertIn("tick 10: A = @", self.read("f.xml").decode())

    def test_mistakes_come_before_the_run(self):
        self.write("w.meld", "stop(A) :- dist(A, D), D > 3.\ntell(A) :- dits(A, D).\n")
        self.refused("meldsim", "run", GRADIENT, "--watch", "w.meld", code=2, says=("w.meld:2:12", "no predicate `dits`"), lines=None)
        self.write("w.meld", "halt(A) :- dist(A, D).\n")
        self.refused("meldsim", "run", GRADIENT, "--watch", "w.meld", code=2, says=("w.meld:1:1", "stop(...)"), lines=None)
        self.write("w.meld", "stop(B) :- dist(A, D).\n")
        self.refused("meldsim", "run", GRADIENT, "--watch", "w.meld", code=2, says="the body gives 'B' no value", lines=None)
        self.write("w.meld", 'include "more.meld".\ntell(A) :- dist(A, D).\n')
        self.refused("meldsim", "run", GRADIENT, "--watch", "w.meld", code=2, says=("w.meld:1:9", "and nothing else"), lines=None)
        self.refused("meldsim", "run", GRADIENT, "--never", "dist(A, D), E > 1", "--digest", "d.txt", code=2, says="`E`", lines=None)
        self.assertFalse((self.folder / "d.txt").exists())


if __name__ == "__main__":
    main("meldc", "meldsim")
