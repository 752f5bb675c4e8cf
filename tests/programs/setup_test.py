"""Sets up ensembles of some ten thousand catoms, so that all threads take part in it: bricks that are full, cut by the surface, and empty;
facts by regions, with lists. Facts, ids and the digest after each tick are the same bytes for all numbers of processes and threads.

Usage: setup_test.py MELDSIM
"""

import pathlib
import sys
import tempfile

from runner import Runner

PROGRAM = """
type mark(node).
type weight(node, int).
type name(node, string).
type path(node, list int).
type dist(node, min int).
type heavier(node, node).
type long(node, int).
dist(A, 0) :- mark(A).
dist(B, D + 1) :- neighbor(A, B), dist(A, D), D < 4.
heavier(A, B) :- neighbor(A, B), weight(A, V), weight(B, W), W > V + 900.
long(A, llength(L)) :- path(A, L), name(A, "inner").
"""
FACTS = """
[facts]
mark = ["id % 1000 == 7", "x == 0 && y == 0"]
weight = [{ args = [1] }, { where = "id % 3 == 0", args = [1000] }, { where = "x > 5", args = [7] }]
name = [{ where = "x > -15 && x < 15 && y < 9", args = ["inner"] }, { where = "z > 0", args = ["upper"] }]
path = [{ where = "id % 2 == 0", args = [[1, 2, 3]] }, { where = "y > 3", args = [[4]] }]

[[event]]
tick = 3
take = { mark = ["id % 2000 == 7"], name = [{ where = "z > 4", args = ["upper"] }] }
give = { weight = [{ where = "y < 0", args = [2000] }] }
"""
SIZES = [(1, 1), (1, 2), (1, 3), (2, 1), (3, 2)]


def main():
    with tempfile.TemporaryDirectory() as folder:
        folder = pathlib.Path(folder)
        program = folder / "written/setup.meld"
        program.parent.mkdir()
        program.write_text(PROGRAM)
        for lattice, shape in (("cubic", "minus(box(56, 44, 41), sphere(16))"), ("hex", "minus(sphere(120), box(150, 99, 1))")):
            world = folder / f"{lattice}.toml"
            world.write_text(f'lattice = "{lattice}"\n\n[[body]]\nshape = "{shape}"\n{FACTS}')
            outcome = Runner(sys.argv[1], program, folder).run_sizes(world, sizes=SIZES)
            catoms = outcome.summary["catoms"]
            if catoms < 33_000 or sorted(outcome.cell_of) != list(range(catoms)):
                sys.exit(f"{lattice}: {catoms} catoms, {len(outcome.cell_of)} with a cell")
            for one in ("dist", "heavier", "long", "weight", "name", "path"):
                if not outcome.facts[one]:
                    sys.exit(f"{lattice}: no facts of {one}")


main()
