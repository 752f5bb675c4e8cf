"""Small worlds for the programs: each a lattice and a list of cells, so that nothing has to be believed about shapes."""

import itertools
import math
from typing import NamedTuple

from lattice import position


class World(NamedTuple):
    name: str
    lattice: str
    cells: list
    more: str = ""  # Further sections of the world file.

    def text(self, facts=""):
        cells = ", ".join(str(list(cell)) for cell in self.cells)
        return f'lattice = "{self.lattice}"\n[[body]]\ncells = [{cells}]\n[facts]\n{facts}\n{self.more}\n'


def box(low, high):
    return list(itertools.product(*(range(a, b) for a, b in zip(low, high))))


def ball(lattice, radius, height=None):
    reach = range(-2 * radius, 2 * radius + 1)
    layers = reach if height is None else range(height)
    return [cell for cell in itertools.product(reach, reach, layers) if math.hypot(*position(lattice, cell)) <= radius]


def without(cells, hole):
    gone = set(hole)
    return [cell for cell in cells if cell not in gone]


def standing_worlds():
    disc = [cell for cell in ball("hex", 13, 1) if math.dist(position("hex", cell), (5, 3, 0)) > 3]
    return [
        World("a block with a cavity", "cubic", without(box((-5, -4, -3), (6, 6, 6)), box((-2, -2, -1), (3, 2, 3)))),
        World("a ball of spheres", "fcc", ball("fcc", 5)),
        World("a disc with a hole", "hex", disc),
        World("an angle, an island and a single catom", "square",
              box((-20, -9, 0), (14, -1, 1)) + box((-20, -1, 0), (-11, 15, 1)) + box((0, 4, 0), (9, 11, 1)) + [(30, 0, 0)]),
        World("three catoms, for more processes", "cubic", [(1, 1, 1), (2, 1, 1), (2, 2, 1)]),
    ]
