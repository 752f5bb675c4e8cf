"""Runs an example program in several worlds and compares what it derives: program_test.py MELDSIM EXAMPLES PROGRAM.

In each world the digests of all ticks and the facts at the end must be the same bytes on 1 to 4 processes of 1 or 2 threads,
and the facts those that expected.py computes by other means.
"""

import collections
import math
import pathlib
import random
import sys
import tempfile

import expected
from lattice import position, touching
from runner import CAMPAIGN, Runner
from worlds import World, ball, box, standing_worlds


class Case:
    """A world, or the example's own (a path), on how many processes and threads it runs (None: as others), with what the check has to know
    about it."""

    def __init__(self, world, facts="", options=(), sources=(), sizes=None, **known):
        self.world = world
        self.sizes = sizes
        self.facts = facts
        self.options = options
        self.source_cells = sources
        self.__dict__.update(known)

    @property
    def name(self):
        return "its own world" if isinstance(self.world, str) else self.world.name

    def run(self, runner, examples):
        if isinstance(self.world, str):
            path = examples / self.world
        else:
            path = runner.folder / "world.toml"
            path.write_text(self.world.text(self.facts))
        self.outcome = runner.run_sizes(path, self.options, self.sizes)
        cell_of = self.outcome.cell_of
        self.lattice = self.lattice if isinstance(self.world, str) else self.world.lattice
        self.places = {catom: position(self.lattice, cell) for catom, cell in cell_of.items()}
        self.links = touching(self.lattice, cell_of)
        self.sources = [catom for catom, cell in cell_of.items() if cell in self.source_cells]

    def check_cells(self):
        if self.outcome.summary["ended"] != "quiet":
            raise AssertionError(f"the run ended with {self.outcome.summary['ended']}")
        if (not isinstance(self.world, str) and not hasattr(self, "goals")
                and sorted(self.outcome.cell_of.values()) != sorted(self.world.cells)):
            raise AssertionError("the catoms do not stand in the cells of the world")
        if len(self.sources) != len(self.source_cells):
            raise AssertionError(f"catoms at {len(self.sources)} of {len(self.source_cells)} sources")

    def expect_messages(self, count):
        if self.outcome.summary["linear_messages"] != count:
            raise AssertionError(f"{self.outcome.summary['linear_messages']} linear messages, expected {count}")


def at(cell):
    return f"cell == {tuple(cell)}"


def few_worlds():
    """Two that differ in everything, where a program's other worlds have shown what there is to be seen of worlds."""
    return [standing_worlds()[i] for i in (2, 3)]


def from_first(predicate, worlds=None):
    """Cases with one source, in the first cell of each world."""
    for world in worlds or standing_worlds():
        first = min(world.cells)
        yield Case(world, f'{predicate} = ["{at(first)}"]', sources=[first])


def gradient():
    yield Case("gradient.toml", lattice="cubic", sources=[(-10, -10, -10)])
    for world in standing_worlds():
        ends = [min(world.cells), max(world.cells)]
        yield Case(world, f'source = ["{at(ends[0])}", "{at(ends[1])}"]', sources=ends)


def spanning_tree():
    yield Case("spanning_tree.toml", lattice="cubic", sources=[(0, -8, -8)])
    yield from from_first("root")


def leader():
    yield Case("leader.toml", lattice="fcc")
    yield from (Case(world) for world in standing_worlds())


def census():
    yield Case("census.toml", lattice="fcc", sources=[(9, 0, 0)])
    yield from from_first("root")
    # Two roots share the catoms between them.
    bar = World("a bar with two roots", "cubic", box((-20, 0, 0), (20, 4, 4)))
    roots = [min(bar.cells), max(bar.cells)]
    yield Case(bar, f'root = ["{at(roots[0])}", "{at(roots[1])}"]', sources=roots)


def temperature():
    yield Case("temperature.toml", lattice="square", rounds=20, degrees=lambda cell: 100.0 if cell[0] < -10 else 20.0)
    given = 'temperature = [{ where = "x < 0", args = [0, 90.5] }, { where = "x >= 0", args = [0, -7.25] }]'
    for world in standing_worlds():
        yield Case(world, given, ("--set", "rounds=11"), rounds=11, degrees=lambda cell: 90.5 if cell[0] < 0 else -7.25)


def flood():
    yield Case("flood.toml", lattice="hex", sources=[(0, 0, 0), (0, 14, 0)])
    for world in standing_worlds():
        first = min(world.cells)
        yield Case(world, f'visit = [{{ where = "{at(first)}", args = [0] }}]', sources=[first])


def height_colour():
    yield Case("height_colour.toml", lattice="cubic", thickness=2)
    for world in standing_worlds():
        yield Case(world, options=("--set", "thickness=3"), thickness=3)


def thermometer():
    yield Case("thermometer.toml", lattice="cubic", limit=20.0, degrees=lambda place: 20.0 - 0.5 * place[0])
    for world in standing_worlds():
        plane = world._replace(more='[components]\nthermometer = "plane"')
        yield Case(plane, options=("--set", "limit=21.0"), limit=21.0, degrees=lambda place: 20.0 - 0.5 * place[0])
    drift = World("a ball that warms", "fcc", ball("fcc", 4), '[components]\nthermometer = "drift"')
    yield Case(drift, limit=20.0, degrees=lambda place: 30.0)


def walk():
    own = {(-11, -4, 0): (0, 1), (-11, 3, 0): (10, -3)}
    yield Case("walk.toml", lattice="cubic", goals=own, cells=box((-12, -6, -3), (12, 6, 0)) + box((-3, -6, 0), (3, 6, 4)) + list(own))

    def case(name, ground, goals):
        world = World(name, "cubic", ground + list(goals), '[motion]\nkind = "lattice"')
        sent = ", ".join(f'{{ where = "{at(start)}", args = [{x}, {y}] }}' for start, (x, y) in goals.items())
        return Case(world, f"sent = [{sent}]", goals=goals, cells=world.cells)

    flat = box((-12, -9, 0), (12, 9, 2))
    yield case("a floor", flat, {(-12, -9, 2): (11, 8)})
    yield case("a floor, backwards", flat, {(11, 8, 2): (-12, -9)})
    yield case("a walker that is there", flat, {(3, 3, 2): (3, 3)})
    # A stair up and down, a deep step, a goal on it and one behind it; lanes that touch.
    stair = flat + box((-6, -9, 2), (4, 9, 5)) + box((-3, -9, 5), (1, 9, 12))
    yield case("stairs", stair, {(-12, y, 2): (x, y) for y, x in ((-9, -6), (-8, -5), (-3, -3), (0, 0), (4, 3), (8, 11))})
    yield case("stairs along y", [(y, x, z) for x, y, z in stair], {(-9, -12, 2): (-9, 11), (0, 11, 2): (0, -12), (8, 11, 2): (8, 1)})
    pit = [cell for cell in flat if cell not in set(box((-2, -9, 1), (2, 9, 2)))]
    yield case("a pit", pit, {(-12, 0, 2): (9, -5)})
    # Two want one cell, one loses, and they climb over each other.
    yield case("walkers that meet", flat, {(-3, 0, 2): (7, 0), (1, 0, 2): (-8, 0)})
    yield case("walkers that cross", flat, {(-4, -4, 2): (1, 4), (0, 3, 2): (0, -8), (1, 8, 2): (1, -8)})
    places = random.Random(11).sample([(x, y) for x, y, _ in box((-6, -6, 0), (6, 6, 1))], 16)
    yield case("a crowd", box((-6, -6, 0), (6, 6, 2)), {(*start, 2): goal for start, goal in zip(places[::2], places[1::2])})


def life():
    own = {(-18, 8, 0), (-17, 7, 0), (-19, 6, 0), (-18, 6, 0), (-17, 6, 0), (10, 3, 0), (11, 3, 0), (12, 3, 0)}
    yield Case("life.toml", lattice="square", generations=24, first=own)
    odd = World("three plates", "square", box((-9, -7, 0), (9, 8, 1)) + box((12, 0, 0), (17, 1, 1)) + box((20, 3, 0), (21, 9, 1)))
    first = set(random.Random(5).sample(odd.cells, 90))
    yield Case(odd, "alive = [" + ", ".join(f'"{at(cell)}"' for cell in sorted(first)) + "]", ("--set", "generations=9"), generations=9,
               first=first)


def shortest_paths():
    yield Case("shortest_paths.toml", lattice="fcc", sources=[(7, 0, 0)])
    yield from from_first("source", few_worlds())


def relaxation():
    yield Case("relaxation.toml", lattice="fcc", sources=[(7, 0, 0)])
    for world in few_worlds():
        first = min(world.cells)
        yield Case(world, f'offer = [{{ where = "{at(first)}", args = [0, "@0"] }}]', sources=[first])


def pagerank():
    yield Case("pagerank.toml", lattice="hex", rounds=30)
    yield from (Case(world, options=("--set", "rounds=12"), rounds=12) for world in few_worlds())


def pagerank_async():
    yield Case("pagerank_async.toml", lattice="hex", enough=0.0001)
    yield from (Case(world, options=("--set", "enough=0.003"), enough=0.003) for world in few_worlds())


def bipartite():
    yield Case("bipartite.toml", lattice="hex", sources=[(9, 0, 0)])
    yield from from_first("root", few_worlds())


def colouring():
    yield Case("colouring.toml", lattice="fcc")
    yield from (Case(world) for world in few_worlds())


def minimum_spanning_tree():
    yield Case("minimum_spanning_tree.toml", lattice="square")
    yield Case(World("a small ball", "fcc", ball("fcc", 2)))
    yield Case(World("two blocks", "cubic", box((0, 0, 0), (3, 3, 3)) + box((5, 0, 0), (7, 2, 3))))


def consensus():
    yield Case("consensus.toml", lattice="cubic", sources=[(-10, -10, -3)], wants=lambda cell: cell[0] < -2 or cell[1] > 4)
    for world in few_worlds():
        first = min(world.cells)
        yield Case(world, f'root = ["{at(first)}"]\nyes = ["x < -1"]', sources=[first], wants=lambda cell: cell[0] < -1)


def queens():
    yield Case("queens.toml", lattice="square", columns=8)
    for side in (1, 3, 4, 6):
        board = World(f"{side} rows", "square", box((0, 0, 0), (side, 1, 1)))
        yield Case(board, 'placed = [{ where = "cell == (0, 0, 0)", args = [[]] }]', ("--set", f"columns={side}"), columns=side)


def quicksort():
    own = {(-2, 0, 0): [5, 3, 9, 1, 3, 8, 0, -4, 7, 7, 2], (-1, 0, 0): [], (0, 0, 0): list(range(1, 11)), (1, 0, 0): [12]}
    yield Case("quicksort.toml", lattice="square", lists=own)
    draw = random.Random(3)
    row = box((0, 0, 0), (24, 1, 1))
    lists = {cell: [draw.randint(-50, 50) for _ in range(draw.randint(0, 60))] for cell in row}
    given = ", ".join(f'{{ where = "{at(cell)}", args = [{numbers}, 0] }}' for cell, numbers in lists.items())
    yield Case(World("a row of lists", "square", row), f"sort = [{given}]", lists=lists)


def belief_propagation():
    wrong = {(-10, 3, 0): 2, (0, 0, 0): 2, (-13, -4, 0): 1, (9, 2, 0): 1, (-9, -8, 0): 1, (2, 7, 0): 0, (12, -6, 0): 0}
    yield Case("belief_propagation.toml", lattice="square", rounds=12,
               colour=lambda c: wrong.get(c, 0 if c[0] < -5 else 1 if c[0] < 5 else 2))
    disc = [cell for cell in ball("hex", 6, 1)]
    given = ('seen = [{ where = "x < 0", args = [0] }, { where = "x >= 0 && y < 2", args = [1] }, '
             '{ where = "x >= 0 && y >= 2", args = [2] }]')
    yield Case(World("a disc", "hex", disc), given, ("--set", "rounds=5"), rounds=5,
               colour=lambda c: 0 if c[0] < 0 else 1 if c[1] < 2 else 2)


def mutual_exclusion():
    yield Case("mutual_exclusion.toml", lattice="cubic", sources=[(-2, -2, -1)], wants=lambda c: c[0] < 0 or c[2] > 0)
    knot = World("a small ball and an island", "fcc", ball("fcc", 2) + [(9, 9, 0)])
    first = (0, 0, 0)
    yield Case(knot, f'root = ["{at(first)}"]\nwants = ["y < 1"]', sources=[first], wants=lambda c: c[1] < 1)


def localization():
    # Without noise; the example's L; and three parts, one of them a catom alone, which do not hear of each other, with late messages.
    yield Case(World("a cube", "fcc", box((0, 0, 0), (6, 6, 6))), within=0.00005)
    yield Case("localization.toml", lattice="fcc", within=0.038)
    parts = box((0, 0, 0), (3, 3, 3)) + [(9, 0, 0), (10, 0, 0), (0, 9, 0)]
    yield Case(World("three parts", "fcc", parts, '[network]\nkind = "latency"\nmost = 4\n'), within=0.0001)
    if CAMPAIGN:
        thousand = World("1000 catoms", "fcc", box((0, 0, 0), (10, 10, 10)))
        yield Case(thousand, options=("--set", "noise=0.05"), within=0.0245)
        yield Case(thousand, options=("--set", "noise=0.1"), within=0.06, sizes=[(1, 2)])
        yield Case(World("10000 catoms", "fcc", box((0, 0, 0), (20, 20, 25))), options=("--set", "noise=0.05"), within=0.04,
                   sizes=[(1, 1), (2, 2)])


def kmeans():
    yield Case("kmeans.toml", lattice="hex", sources=[(0, -4, 0)])
    for world in standing_worlds():
        first = min(world.cells)
        yield Case(world, f'root = ["{at(first)}"]', sources=[first])
    # A cluster that no catom joins; one alone.
    first = (0, 0, 0)
    for starts in ("[vec3(0, 0, 0), vec3(900, 0, 0)]", "[vec3(1, 0, 0)]"):
        yield Case(World("a ball", "fcc", ball("fcc", 2)), f'root = ["{at(first)}"]', ("--set", f"starts={starts}"), sources=[first])


def heat():
    yield Case("heat.toml", lattice="cubic", step=0.05, held=lambda c: 100.0 if c[0] < -14 else 0.0 if c[0] >= 14 else None)
    for world in few_worlds():
        yield Case(world, 'hot = ["x < -9"]\ncold = ["x >= 9"]', ("--set", "step=0.5"), step=0.5,
                   held=lambda c: 100.0 if c[0] < -9 else 0.0 if c[0] >= 9 else None)


PROGRAMS = {make.__name__: make for make in (gradient, spanning_tree, leader, census, temperature, flood, height_colour, thermometer, walk,
                                             life, shortest_paths, relaxation, pagerank, pagerank_async, bipartite, colouring,
                                             minimum_spanning_tree, consensus, queens, quicksort, belief_propagation,
                                             mutual_exclusion, localization, kmeans, heat)}


def equal(found, wanted):
    """Facts are the same, numbers up to rounding: the order of a sum is the program's own."""
    if isinstance(found, (list, tuple)):
        return isinstance(wanted, (list, tuple)) and len(found) == len(wanted) and all(equal(a, b) for a, b in zip(found, wanted))
    return math.isclose(found, wanted, rel_tol=1e-9, abs_tol=1e-9) if isinstance(found, float) else found == wanted


def hashable(facts):
    return [tuple(tuple(v) if isinstance(v, list) else v for v in fact) for fact in facts]


def check(case, compute):
    case.check_cells()
    wanted = compute(case)
    for name in sorted(set(wanted) | set(case.outcome.facts)):
        here, there = sorted(case.outcome.facts[name]), sorted(wanted.get(name, []))
        if equal(here, there):
            continue
        extra = collections.Counter(hashable(here)) - collections.Counter(hashable(there))
        missing = collections.Counter(hashable(there)) - collections.Counter(hashable(here))
        raise AssertionError(f"{name} is not as expected; not expected: {list(extra)[:5]}; missing: {list(missing)[:5]}")


def main():
    meldsim, examples, program = sys.argv[1], pathlib.Path(sys.argv[2]), sys.argv[3]
    with tempfile.TemporaryDirectory() as folder:
        runner = Runner(meldsim, examples / f"{program}.meld", folder)
        for case in PROGRAMS[program]():
            case.run(runner, examples)
            try:
                check(case, getattr(expected, program))
            except AssertionError as error:
                sys.exit(f"{program} in {case.name}: {error}")
            told = case.outcome.summary
            print(f"{case.name}: {told['catoms']} catoms, {told['ticks']} ticks, "
                  f"{told['exported_changes'] / told['catoms']:.1f} exported changes "
                  f"and {told['linear_messages'] / told['catoms']:.1f} linear messages a catom")


if __name__ == "__main__":
    main()
