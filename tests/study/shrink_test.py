"""What `meldsim sweep --shrink` makes of rows that fail: shrink_test.py --meldc PATH --meldsim PATH [unittest options]

Faults are planted so that the smallest world is known. Each case is a row of a table: add one for each kind of thing that can be taken
away."""

import csv
import pathlib
import re
import shlex
import sys
import tomllib

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1]))

import frame  # noqa: E402
from frame import FOREVER, main  # noqa: E402

FINE, USAGE, FAILED = 0, 2, 3
GRADIENT = """
type source(node).
type dist(node, min int).
dist(A, 0)     :- source(A).
dist(B, D + 1) :- neighbor(A, B), dist(A, D).
"""
# Events poke catoms, and what was poked stays so.
POKED = """
type linear poke(node, int).
type poked(node, int).
poke(A, N) -o poked(A, N).
"""
# Who has had a neighbour remembers it.
REMEMBERS = """
type linear fresh(node).
type had(node, node).
type missing(node, node).
fresh(A).
fresh(A) -o { B | neighbor(A, B) | had(A, B) }.
missing(A, B) :- had(A, B), not neighbor(A, B).
"""
MARKED = """
type mark(node, int).
type pair(node, node).
pair(A, B) :- neighbor(A, B), mark(A, X), mark(B, Y), X < Y.
"""
SENDS = """
type linear start(node).
type first(node).
type sent(node, int).
sent(A, N) :- first(A), neighborCount(A, N).
type linear message(node).
type got(node).
start(A) -o { B | neighbor(A, B) | message(B) }.
message(A) -o got(A).
"""


def events(count, tick, item):
    return "".join(f"[[world.event]]\ntick = {tick(i)}\n{item(i)}\n" for i in range(count))


# By name: the program, the study after its first line, and the sizes of the smallest world: catoms or nodes, links, targets of events,
# given facts. None: not looked at.
CASES = {
    "two of many events": (POKED, '[never]\nboth = "poked(@3, _), poked(@7, _)"\n[world]\nlattice = "graph"\ngraph = "ring(12)"\n' + events(
        12, lambda i: 3 * i + 1, lambda i: f'give = {{ poke = [{{ where = "id == {i}", args = [{i}] }}] }}'), (2, 0, 2, 0)),
    "one of the targets of an event": (POKED, '[never]\nboth = "poked(@3, _), poked(@7, _)"\n[world]\nlattice = "graph"\n'
                                       'graph = "complete(12)"\n[[world.event]]\ntick = 4\ngive = { poke = [{ args = [1] }] }\n',
                                       (2, 0, 2, 0)),
    "an event that happens again": (POKED, '[never]\ntwice = "N = count : { poked(@5, _) }, N > 1"\n[world]\nlattice = "graph"\n'
                                    'graph = "line(9)"\n[[world.event]]\ntick = 2\nevery = 3\ntimes = 8\n'
                                    'give = { poke = [{ where = "id == 5", args = [1] }] }\n[[world.event]]\ntick = 30\n'
                                    'give = { poke = [{ where = "id == 5", args = [2] }] }\n', (1, 0, 2, 0)),
    "a long way": (GRADIENT, '[expect]\nnear = "max D : { dist(A, D) } < 5"\n[world]\nlattice = "graph"\ngraph = "ring(20)"\n'
                   'facts.source = "id == 0"\n', (6, 5, 0, 1)),
    "a long way in a torus": (GRADIENT, '[expect]\nnear = "max D : { dist(A, D) } < 4"\n[world]\nlattice = "graph"\n'
                              'graph = "torus(9, 8)"\nfacts.source = "id == 30"\n', (5, 4, 0, 1)),
    "a long way over cells": (GRADIENT, '[expect]\nnear = "max D : { dist(A, D) } < 4"\n[world]\nlattice = "square"\n'
                              'facts.source = "id == 17"\n[[world.body]]\nshape = "box(8, 8, 1)"\n', (5, None, 0, 1)),
    "weights of links": (GRADIENT.replace("node, min int", "node, min int").replace("neighbor(A, B), dist(A, D)",
                                                                                   "neighbor(A, B), link(A, B, W), dist(A, D)")
                         .replace("D + 1", "D + W") + "type link(node, node, int).\n",
                         '[never]\nfar = "dist(A, D), D > 10"\n[world]\nlattice = "graph"\nlinks = "weights.csv"\n'
                         'facts.source = "id == 0"\n', (2, 1, 0, 1)),
    "neighbours on a lattice": (MARKED, '[never]\nbeside = "pair(A, B)"\n[world]\nlattice = "cubic"\n[world.facts]\n'
                                'mark = [{ where = "id == 9", args = [5] }, { where = "id == 41", args = [3] }, '
                                '{ where = "x == 0 && y == 0", args = [1] }, '
                                '{ where = "x == 1 && y == 0", args = [2] }, { where = "id > 60", args = [7] }]\n'
                                '[[world.body]]\nshape = "box(4, 4, 4)"\n', (2, None, 0, 2)),
    "a link that is cut": (REMEMBERS, '[never]\nlost = "missing(A, B)"\n[world]\nlattice = "square"\n[[world.body]]\n'
                           'shape = "box(6, 6, 1)"\n[[world.event]]\ntick = 5\ncut = { between = ["x < 0", "x >= 0"] }\n'
                           '[[world.event]]\ntick = 9\nheal = "all"\n[[world.event]]\ntick = 20\ngive = { fresh = "id == 3" }\n',
                           (2, None, 1, 0)),
    "a catom that is killed": (REMEMBERS, '[never]\nlost = "missing(A, B)"\n[world]\nlattice = "graph"\ngraph = "grid(5, 5)"\n'
                               '[[world.event]]\ntick = 5\nkill = [3, 8, "id > 20"]\nhang = "id == 1"\n', (2, 1, 1, 0)),
    "faults at random": (REMEMBERS, 'ticks = 60\n[never]\nlost = "missing(A, B)"\n[world]\nlattice = "square"\n[[world.body]]\n'
                         'shape = "box(6, 6, 1)"\n[world.faults]\nkill = 0.002\nhang = 0.01\ncut = 0.002\nrestart = 0.005\n',
                         (2, None, 1, 0)),
    "a program that ends with an error": ("type bad(node, int).\nbad(A, 10 / (N - 3)) :- neighborCount(A, N).\n",
                                          '[world]\nlattice = "graph"\ngraph = "small_world(30, 4, 0.2)"\n', (4, 3, 0, 0)),
    "no need of a network": (GRADIENT, '[expect]\nnear = "max D : { dist(A, D) } < 3"\n[world]\nlattice = "graph"\ngraph = "line(9)"\n'
                             'facts.source = "id == 0"\n[world.network]\nkind = "lossy"\nloss = 0.2\nmost = 4\ntries = 40\n'
                             '[world.clock]\nkind = "random"\nrate = 0.5\nmost = 4\n', (4, 3, 0, 1)),
    "a message that is lost": (SENDS, 'seeds = [1]\n[expect]\nall = "sent(@0, N), M = count : { got(_) }, N = M"\n[world]\n'
                               'lattice = "graph"\ngraph = "star(6)"\nfacts.start = "id == 0"\nfacts.first = "id == 0"\n'
                               '[world.network]\nkind = "raw"\nloss = 0.5\nmost = 3\n'
                               'duplicate = 0.2\nreorder = true\n', (2, 1, 0, 2)),
    "bodies that overlap": ("type p(node).\np(A).\n", '[world]\n[[world.body]]\nshape = "box(3, 3, 1)"\n[[world.body]]\n'
                            'positions = [[8, 0, 0], [8.2, 0, 0], [20, 0, 0]]\n[world.motion]\nkind = "bodies"\n', (2, None, 0, 0)),
    "a run without end": (FOREVER, 'timeout = 0.4\n[world]\nlattice = "graph"\ngraph = "ring(6)"\n', (1, 0, 0, 0)),
    "a graph that the program lists": ("type route edge(node, node).\ntype far(node, min int).\nedge(@0, @1). edge(@1, @2).\n"
                                       "far(@0, 0).\nfar(B, N + 1) :- edge(A, B), far(A, N).\n",
                                       '[never]\ntwo = "far(A, 2)"\n', (3, 2, 0, 0)),
    "events of another file": (POKED, 'events = ["events.toml"]\n[never]\nboth = "poked(@3, _), poked(@7, _)"\n[world]\n'
                               'lattice = "graph"\ngraph = "ring(9)"\n[[world.event]]\ntick = 1\n'
                               'give = { poke = [{ where = "id == 3", args = [1] }] }\n', (2, 0, 2, 0)),
}
FILES = {
    "weights.csv": "from,to,km\n0,1,3\n1,2,4\n2,3,2\n0,4,1\n4,5,12\n3,6,1\n5,6,1\n0,6,11\n",
    "events.toml": '[[event]]\ntick = 3\ngive = { poke = [{ where = "id == 7", args = [1] }, { where = "id == 2", args = [1] }] }\n',
}


class Case(frame.Case):
    FILES = FILES

    def sweep(self, *options, code=FINE, study="study.toml"):
        return self.call("meldsim", "sweep", study, *options, code=code)

    def plant(self, name):
        program, study, smallest = CASES[name]
        self.write("program.meld", program)
        self.write("study.toml", 'program = "program.meld"\n' + study)
        self.sweep("--quiet", code=FAILED)
        with open(self.folder / "study.results" / "rows.csv", newline="") as file:
            return next(csv.DictReader(file)), smallest

    def shrink(self, *options, row=1, code=FINE):
        """What is printed, and the world that is written."""
        out, err = self.sweep("--shrink", row, *options, code=code)
        path = self.folder / "study.results" / "shrunk" / f"row-{row}.toml"
        return out, err, path

    def listed(self, path, of):
        """Lines of a list that the world has in a file of its own."""
        return (path.parent / of).read_text().splitlines()[1:]

    def sizes(self, path):
        world = tomllib.loads(path.read_text())
        links = None
        if world.get("lattice") == "graph":
            catoms, links = (len(self.listed(path, world[key]) if isinstance(world[key], str) else world[key])
                             for key in ("nodes", "links"))
        else:
            catoms = sum(len(body.get("cells", body.get("positions", []))) for body in world.get("body", []))
        targets = 0
        for event in world.get("event", []):
            for key, value in event.items():
                if key in ("give", "take"):
                    targets += sum(len(facts) for facts in value.values())
                elif key not in ("tick", "every", "times"):
                    targets += len(value)
        self.assertNotIn("faults", world)
        facts = sum(len(value) if isinstance(value, list) else 1 for value in world.get("facts", {}).values())
        return catoms, links, targets, facts

    def masked(self, reason):
        """Without the numbers of catoms and ticks, and the names of files."""
        return re.sub(r"\S*\.toml\S*", "", re.sub(r"-?\d+", "#", reason)).split(":")[0]


class Smallest(Case):
    """The smallest world is found, and the command that is printed fails as the row does."""

    def check(self, name):
        row, smallest = self.plant(name)
        self.assertEqual(row["status"], "failed", name)
        out, _, path = self.shrink()
        lines = out.splitlines()
        self.assertIn(row["reason"].split("\n")[0][:30], lines[0])
        if smallest is not None:
            found = self.sizes(path)
            wanted = tuple(None if want is None else is_now for want, is_now in zip(smallest, found))
            self.assertEqual(wanted, smallest, path.read_text())
        command = shlex.split(lines[-1])
        self.assertEqual(command[:2], ["meldsim", "run"])
        done = self.run_tool("meldsim", *command[1:], "--junit", "how.xml")
        self.assertNotEqual(done.returncode, 0, out)
        if row["reason"].startswith(("expect", "never")):
            self.assertEqual(done.returncode, FAILED, done.stderr)
            demand = row["reason"].split(":")[0].split(" ", 1)[1]
            self.assertRegex(self.read("how.xml").decode(), rf'(?s)name="[^"]*{demand}"[^>]*>\s*<failure')
        else:
            self.assertIn(self.masked(row["reason"]).split(" of ")[0].strip(), self.masked(done.stderr.replace("meldsim: ", "")))
        return path


for case_name in CASES:
    setattr(Smallest, "test_" + re.sub(r"\W+", "_", case_name), lambda self, name=case_name: self.check(name))


class Ways(Case):
    def test_the_same_by_any_number_of_jobs(self):
        for name in ("two of many events", "a long way over cells", "faults at random"):
            with self.subTest(name):
                self.plant(name)
                texts = []
                for jobs in (1, 3):
                    out, _, path = self.shrink("--jobs", jobs)
                    texts.append((out, path.read_text()))
                self.assertEqual(*texts)

    def test_it_stays_as_simple_as_it_can(self):
        """Of a network that must lose something, only that is left."""
        self.plant("a message that is lost")
        _, _, path = self.shrink()
        network = tomllib.loads(path.read_text())["network"]
        self.assertEqual((network["kind"], network["loss"]), ("raw", 0.5))
        self.assertLess(set(network), {"kind", "loss", "most", "duplicate", "reorder"})
        self.plant("no need of a network")
        out, _, path = self.shrink()
        self.assertIn("  network, clock: ideal\n", out)
        self.assertFalse({"network", "clock"} & set(tomllib.loads(path.read_text())))

    def test_ticks(self):
        """Of what may never hold, no tick after that counts; what is expected at the end needs all of them."""
        self.plant("two of many events")
        out, _, _ = self.shrink()
        # The later of the two events is in tick 22, and its fact is taken in the same.
        self.assertRegex(out, r"  ticks: \d+ to 22\n")
        self.assertIn(" --ticks 22 ", out)
        self.plant("a long way")
        self.assertNotIn("--ticks", self.shrink()[0])

    def test_what_must_still_hold(self):
        """What is expected fails in many ways; a body says in which."""
        self.write("program.meld", "type leader(node).\nleader(A) :- neighborCount(A, N), N > 1.\n")
        self.write("study.toml", 'program = "program.meld"\n[expect]\none = "count : { leader(A) } = 1"\n[world]\nlattice = "graph"\n'
                                 'graph = "ring(9)"\n')
        self.sweep("--quiet", code=FAILED)
        self.assertEqual(self.sizes(self.shrink()[2])[0], 1)
        self.assertEqual(self.sizes(self.shrink("--still", "leader(A), leader(B), A <> B")[2])[:2], (3, 3))
        for body, said in (("leader(@99)", "does not hold at the end of row 1 itself"), ("laeder(A)", "there is no predicate `laeder`")):
            self.assertIn(said, self.sweep("--shrink", 1, "--still", body, code=USAGE)[1])

    def test_tries_have_a_bound(self):
        self.plant("a long way over cells")
        out, err, path = self.shrink("--tries", 5)
        self.assertIn("  5 tries\n", out)
        self.assertIn("so many tries were not enough: give more with --tries", err)
        self.call("meldsim", *shlex.split(out.splitlines()[-1])[1:], code=FAILED)

    def test_progress(self):
        self.plant("a run without end")
        self.assertEqual(self.shrink("--quiet")[1], "")

    def test_rows_that_do_not_fail(self):
        study = ('program = "program.meld"\n[expect]\nnear = "max D : { dist(A, D) } < 5"\n[world]\nlattice = "graph"\n'
                 'graph = "ring({n})"\nfacts.source = "id == 0"\n[set]\nn = [6, 20, 8]\n')
        self.write("program.meld", GRADIENT)
        self.write("study.toml", study)
        # Nothing has been made yet.
        self.assertIn("row 1 has not failed, so there is nothing to shrink. No row that has been made has failed",
                      self.sweep("--shrink", 1, code=USAGE)[1])
        self.assertEqual(self.sizes(self.shrink(row=2)[2])[0], 6)
        self.sweep("--quiet", code=FAILED)
        self.assertIn("row 3 has not failed, so there is nothing to shrink. Those that have failed are 2",
                      self.sweep("--shrink", 3, code=USAGE)[1])
        self.assertIn("Its rows are 1 to 3", self.sweep("--shrink", 4, code=USAGE)[1])
        self.write("study.toml", study.replace("[set]", '[measure]\nd = "dist(A, D)"\n[set]'))
        self.sweep("--quiet", code=FAILED)
        self.assertIn("row 1 has failed by a measure, and its run is fine", self.sweep("--shrink", 1, code=USAGE)[1])
        for options in (["--tries", 3], ["--still", "p(A)"], ["--shrink", 1, "--show", 1]):
            self.sweep(*options, code=USAGE)


if __name__ == "__main__":
    main("meldc", "meldsim")
