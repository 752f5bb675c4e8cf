"""Pieces of connected catoms hang together by joints, which motors drive: they fall, merge, split, carry loads, break and lose parts in
small random worlds. Whatever the number of processes and threads, also where a run is stopped in the middle and goes on with others, the
facts and places after each tick are the same.

Usage: arms_test.py MELDSIM [FIRST_SEED [SEEDS [TICKS]]]
"""

import random
import sys

from mechanisms_test import PROGRAM as OF_JOINTS
from mechanisms_test import chains_and_loose, joint, joints_between, motion_of
from tumble_test import held_and_thrown, main, other_shapes, range_and_kills

PROGRAM = OF_JOINTS + """
type action torque(node, float, float, float) while.
type action connect(node, node).
type action release(node, node).
type linear failed(node, int).
type refused(node, int, int).
type holds(node, node).
type pressed(node, float).
holds(A, B) :- connected(A, B).
failed(A, C), tick(A, T) -o refused(A, C, T).
pressed(A, P) :- pressure(A, P), id(A, I), I % 4 = 1.
connect(A, B) :- neighbor(A, B), tick(A, T), T % 4 = 2, id(A, I), (I + T) % 3 = 0, not parted(A, B, _).
release(A, B) :- connected(A, B), tick(A, T), T % 5 = 3, id(A, I), (I + T) % 7 = 1.
torque(A, 1, 0, 2) :- degree(A, 3), id(A, I), I % 2 = 0.
"""


def case(seed):
    rng = random.Random(seed)
    places, armed, known = chains_and_loose(rng, 4, 22, 2)
    world = motion_of(rng, seed, places)
    if rng.random() < 0.4:
        world += f"breaking_force = {rng.uniform(40, 400):.1f}\n"
    if rng.random() < 0.3:
        world += f"breaking_torque = {rng.uniform(20, 300):.1f}\n"
    world += f"[motion.sense]\njoint = {rng.choice([0, 0.02])}\nload = {rng.choice([0, 0.02])}\n"
    world += other_shapes(rng) if rng.random() < 0.4 else ""
    world += held_and_thrown(rng, armed)
    # Pieces, and joints between those that touch; of some, both.
    size = rng.randint(2, 5)
    for first in range(0, armed, size):
        world += f'[[motion.catoms]]\nwhere = "id >= {first} && id < {min(first + size - rng.randint(0, 1), armed)}"\nconnected = true\n'
    for first in range(size, armed, size):
        if rng.random() < 0.8:
            world += joint(rng, f'where = "id >= {first - 1} && id <= {first}"')
    if rng.random() < 0.4:
        world += joint(rng, f'where = "id < {rng.randint(4, armed)} && y >= {rng.randint(0, 6)}"')
    world += joints_between(rng, 3, known)
    world += range_and_kills(rng, 3.0, 2)
    return PROGRAM, world


if __name__ == "__main__":
    sys.exit(main("arms", case))
