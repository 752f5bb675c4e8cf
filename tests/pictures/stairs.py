"""Catoms that look different from all sides, each with a number of its own."""
import numpy as np

from judge import viridis

CELLS = ([(x, 0, 0) for x in range(6)] + [(0, y, 0) for y in range(1, 4)] + [(0, 0, z) for z in range(1, 5)] + [(5, 1, 0), (5, 1, 1)]
         + [(2, 0, 1), (3, 3, 0), (3, 3, 2)])
PLACES = np.array(CELLS, dtype=float)
VALUES = PLACES @ (3, 5, 11)
COLOURS = viridis((VALUES - VALUES.min()) / np.ptp(VALUES))
FILES = {
    "stairs.meld": "type value(node, int).\nvalue(A, 3 * X + 5 * Y + 11 * Z) :- cell(A, X, Y, Z).\n",
    "stairs.toml": f'lattice = "cubic"\n[[body]]\ncells = {[list(cell) for cell in CELLS]}\n',
}
