"""Random worlds for algorithms that must be right on any graph: connected blobs of cells, also several that do not touch."""

import itertools
import math
import random

from lattice import position
from worlds import World


def around(lattice, cell):
    """The cells that touch this one."""
    heights = (0,) if lattice in ("square", "hex") else (-1, 0, 1)
    near = (tuple(c + s for c, s in zip(cell, step)) for step in itertools.product((-1, 0, 1), (-1, 0, 1), heights))
    return [other for other in near if abs(math.dist(position(lattice, cell), position(lattice, other)) - 1) < 1e-6]


def grown(lattice, count, draw, start):
    """A connected set of cells: each next one touches one that is there, so there are holes and arms."""
    cells = [start]
    while len(cells) < count:
        other = draw.choice(around(lattice, draw.choice(cells)))
        if other not in cells:
            cells.append(other)
    return cells


def blob(lattice, *counts, seed, more=""):
    """A world of a blob of so many cells for each of the counts, far from each other."""
    draw = random.Random(seed)
    cells = [cell for i, count in enumerate(counts) for cell in grown(lattice, count, draw, (200 * i, 0, 0))]
    return World(f"{lattice} blobs of {counts} cells, seed {seed}", lattice, sorted(cells), more)


def blobs(seed):
    """One of each lattice, one that is not connected, and the least that there are."""
    return [blob("fcc", 70, seed=seed), blob("square", 60, seed=seed + 1), blob("hex", 50, 20, 1, seed=seed + 2),
            blob("cubic", 90, seed=seed + 3), blob("hex", 2, seed=seed + 4), blob("square", 1, seed=seed + 5)]


def ring(width, height):
    """The outline of a rectangle: each cell touches two others."""
    cells = [cell for cell in itertools.product(range(width), range(height), (0,))
             if cell[0] in (0, width - 1) or cell[1] in (0, height - 1)]
    return World(f"a ring of {len(cells)}", "square", cells, '[record]\nevery = 1\npredicates = ["privileged"]')
