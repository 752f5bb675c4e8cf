"""Runs a program of each library in several worlds and compares what it derives: library_test.py MELDSIM FOLDER LIBRARY.

As for the example programs, digests and facts are the same bytes on 1 to 4 processes; the facts are checked against
what is computed here from the cells alone.
"""

import collections
import math
import pathlib
import sys
import tempfile

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent.parent / "programs"))

from lattice import components, hops, touching  # noqa: E402
from runner import Runner  # noqa: E402
from worlds import standing_worlds  # noqa: E402


class Case:
    """What came out in one world, with the catoms at its first and last cell."""

    def __init__(self, world, outcome):
        self.facts = outcome.facts
        self.summary = outcome.summary
        self.links = touching(world.lattice, outcome.cell_of)
        catom_at = {cell: catom for catom, cell in outcome.cell_of.items()}
        self.first, self.last = catom_at[min(world.cells)], catom_at[max(world.cells)]

    def rows(self, predicate):
        return sorted(self.facts.get(predicate, []))

    def map(self, predicate):
        """A predicate of two arguments as a dictionary; it has one fact a catom."""
        rows = self.rows(predicate)
        if len({row[0] for row in rows}) != len(rows):
            raise AssertionError(f"{predicate} has two facts at one catom")
        return dict(rows)

    def expect(self, predicate, wanted):
        found, wanted = self.rows(predicate), sorted(wanted)
        if len(found) == len(wanted) and all(map(alike, found, wanted)):
            return
        wrong = next((f"{a} where {b} was expected" for a, b in zip(found, wanted) if not alike(a, b)),
                     f"{len(found)} facts, not {len(wanted)}")
        raise AssertionError(f"{predicate}: {wrong}")

    def expect_one_nearer(self, predicate, found):
        """Each catom that is no source has one neighbour that is one hop nearer, and the fact names it."""
        chosen = self.map(predicate)
        if set(chosen) != {catom for catom, hop in found.items() if hop > 0}:
            raise AssertionError(f"{predicate} is not at the catoms that are reached")
        for catom, other in chosen.items():
            if other not in self.links[catom] or found[other] != found[catom] - 1:
                raise AssertionError(f"{predicate}: {other} is not one hop nearer than {catom}")
        return chosen


def alike(one, other):
    return len(one) == len(other) and all(a == b or (isinstance(a, float) and math.isclose(a, b, rel_tol=1e-12))
                                          for a, b in zip(one, other))


def gradient(case):
    found = hops(case.links, [case.first])
    case.expect("gradient-source", [(case.first,)])
    case.expect("gradient-dist", found.items())
    case.expect_one_nearer("gradient-next", found)


def tree(case):
    found = hops(case.links, [case.first])
    parent = case.expect_one_nearer("tree-parent", found)
    case.expect("tree-depth", found.items())
    case.expect("tree-child", [(above, catom) for catom, above in parent.items()])
    case.expect("tree-leaf", [(catom,) for catom in found if catom not in parent.values()])
    case.expect("tree-complete", [(catom,) for catom in found])


def convergecast(case):
    parent = case.expect_one_nearer("tree-parent", hops(case.links, [case.first]))
    below = collections.defaultdict(list)
    for catom in hops(case.links, [case.first]):
        at = catom
        while catom % 2 == 1 and at is not None:
            below[at].append(0.5 * catom)
            at = parent.get(at)
    case.expect("convergecast-count", [(a, len(v)) for a, v in below.items()])
    case.expect("convergecast-sum", [(a, math.fsum(v)) for a, v in below.items()])
    case.expect("convergecast-mean", [(a, math.fsum(v) / len(v)) for a, v in below.items()])
    case.expect("convergecast-least", [(a, min(v)) for a, v in below.items()])
    case.expect("convergecast-greatest", [(a, max(v)) for a, v in below.items()])
    root = case.first
    case.expect("convergecast-total", [(root, len(below[root]), math.fsum(below[root]))] if below[root] else [])


def broadcast(case):
    found = hops(case.links, [case.first])
    case.expect("broadcast-heard", [(catom, 100 + case.first) for catom in found])
    case.expect("broadcast-from", [(catom, case.first) for catom in found])


def leader(case):
    best = {}
    for part in components(case.links):
        standing = part - {case.first}
        if standing:
            best.update({catom: min(standing) for catom in part})
    case.expect("leader-of", best.items())
    case.expect("leader-elected", [(one,) for one in set(best.values())])
    case.expect("leader-known", best.items())


def timers(case):
    case.expect("timers-beat", [(case.first, 5), (case.first, 7)])
    case.expect("timers-due", [(case.first, 35)])


def greedy(case, decide):
    """What each catom but the marked one decides, in the order of numbers, from what its neighbours have decided."""
    decided = {}
    for catom in sorted(set(case.links) - {case.first}):
        decided[catom] = decide([decided[other] for other in case.links[catom] if other in decided])
    return decided


def mis(case):
    chosen = greedy(case, lambda around: not any(around))
    case.expect("mis-chosen", [(catom,) for catom, is_in in chosen.items() if is_in])
    case.expect("mis-passed", [(catom,) for catom, is_in in chosen.items() if not is_in])


def colouring(case):
    colours = greedy(case, lambda around: min(set(range(len(around) + 1)) - set(around)))
    case.expect("colouring-colour", colours.items())


def late(case, decided):
    """Those that started later decided too, and nobody who was marked did."""
    if set(decided) != set(case.links) - {case.first}:
        raise AssertionError("not those decided that take part")


def mis_late(case):
    chosen, passed = {row[0] for row in case.rows("mis-chosen")}, {row[0] for row in case.rows("mis-passed")}
    late(case, chosen ^ passed)
    for catom in chosen:
        if chosen & set(case.links[catom]):
            raise AssertionError(f"{catom} is chosen, and so is a neighbour")
    for catom in passed:
        if not chosen & set(case.links[catom]):
            raise AssertionError(f"{catom} has passed, and no neighbour is chosen")


def colouring_late(case):
    colours = case.map("colouring-colour")
    late(case, colours)
    for catom, colour in colours.items():
        around = {colours[other] for other in case.links[catom] if other in colours}
        if colour in around or colour > len(around):
            raise AssertionError(f"{catom} has the colour {colour} among {around}")


def flood(case):
    found = hops(case.links, [case.first])
    case.expect("flood-visited", found.items())
    start = case.map("flood-from").pop(case.first)
    if start != case.first:
        raise AssertionError(f"the wave began at {case.first} and came from {start}")
    case.facts["flood-from"].remove((case.first, case.first))
    case.expect_one_nearer("flood-from", found)
    sent = sum(len(case.links[catom]) for catom in found)
    if case.summary["linear_messages"] != sent:
        raise AssertionError(f"{case.summary['linear_messages']} messages, not {sent}")


def terminated(case):
    """Everybody decided once the election and the wave were over, and the end is known again after more work."""
    found = hops(case.links, [case.first])
    case.expect("decided", [(catom, min(found), len(case.links[catom])) for catom in found])
    case.expect("terminated-now", [(case.first,)])
    case.expect("terminated-known", [(catom,) for catom in found])
    # A second phase, where the one that worked again is in the tree.
    case.expect("terminated-begun", [(case.first, 1 if case.last in found else 0)])


def khop(case):
    reach = 3
    near = [(catom, centre, hop) for centre in case.links if centre % 3 == 0
            for catom, hop in hops(case.links, [centre]).items() if hop <= reach]
    case.expect("khop-near", near)
    case.expect("khop-seen", collections.Counter(catom for catom, _, _ in near).items())


def fifo(case):
    """What was sent over each link has come in this order, and nothing was behind the end."""
    case.expect("whole", [(catom, other, list(range(9, 0, -1))) for catom in case.links for other in case.links[catom]])
    case.expect("fifo-packet", [])
    case.expect("fifo-got", [])


def one_fact(predicate):
    return lambda first, last: f'{predicate} = ["cell == {first}"]'


def brief(predicate):
    """The first cell for good and the last for a while."""
    return lambda first, last: f'{predicate} = ["cell == {first}"]\n' + (f'brief = ["cell == {last}"]' if first != last else "")


# The check, the facts of the world, and options of the run.
LIBRARIES = {
    "gradient": (gradient, brief("source"), ["--ticks", "150"]),
    "tree": (tree, one_fact("root"), []),
    "convergecast": (convergecast, one_fact("root"), []),
    "broadcast": (broadcast, brief("root"), ["--ticks", "150"]),
    "leader": (leader, one_fact("resigns"), ["--ticks", "400"]),
    "timers": (timers, one_fact("root"), ["--ticks", "35"]),
    "mis": (mis, one_fact("out"), []),
    "colouring": (colouring, one_fact("out"), []),
    "mis_late": (mis_late, one_fact("out"), ["--ticks", "120"]),
    "colouring_late": (colouring_late, one_fact("out"), ["--ticks", "120"]),
    "terminated": (terminated, lambda first, last: f'root = ["cell == {first}"]\nagain = ["cell == {last}"]', ["--ticks", "400"]),
    "flood": (flood, one_fact("go"), []),
    "fifo": (fifo, lambda first, last: '[network]\nkind = "latency"\nleast = 1\nmost = 4', []),
    "khop": (khop, lambda first, last: "", ["--set", "khop-reach=3"]),
}


def main():
    meldsim, folder, name = sys.argv[1], pathlib.Path(sys.argv[2]), sys.argv[3]
    check, facts, options = LIBRARIES[name]
    with tempfile.TemporaryDirectory() as scratch:
        runner = Runner(meldsim, folder / f"{name}.meld", scratch)
        for world in standing_worlds()[1:]:
            path = runner.folder / "world.toml"
            path.write_text(world.text(facts(tuple(min(world.cells)), tuple(max(world.cells)))))
            case = Case(world, runner.run_sizes(path, options))
            try:
                check(case)
            except AssertionError as error:
                sys.exit(f"{name} in {world.name}: {error}")
            print(f"{world.name}: {case.summary['catoms']} catoms, {case.summary['ticks']} ticks, "
                  f"{case.summary['exported_changes'] / case.summary['catoms']:.1f} exported changes a catom")


if __name__ == "__main__":
    main()
