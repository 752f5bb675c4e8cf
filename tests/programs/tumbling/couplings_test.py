"""Programs make joints and take them off, of single catoms and of pieces, near and far, some of which have joints of the world, connect,
break and die, in small random worlds. Whatever the number of processes and threads, also where a run is stopped in the middle and goes on
with others, the facts and places after each tick are the same.

Usage: couplings_test.py MELDSIM [FIRST_SEED [SEEDS [TICKS]]]
"""

import random
import sys

from arms_test import PROGRAM as OF_ARMS
from mechanisms_test import PROGRAM as OF_JOINTS
from mechanisms_test import chains_and_loose, joint, joints_between, motion_of
from tumble_test import held_and_thrown, main, other_shapes, range_and_kills

REFUSED = """
type linear failed(node, int).
type refused(node, int, int).
failed(A, C), tick(A, T) -o refused(A, C, T).
"""
# Those nearby; the catoms behind them; and one far away, or that is not there.
CHANGES = """
type action attach(node, node, int).
type action detach(node, node).
type second(node, node).
type has(node, node).
second(A, C) :- neighbor(A, B), neighbor(B, C).
has(A, B) :- joint(A, B, _, _).
attach(A, B, (I + T) % 4) :- neighbor(A, B), tick(A, T), T % 3 = 1, id(A, I), (I + T) % 4 = 0, not has(A, B).
attach(A, C, 0) :- second(A, C), tick(A, T), T % 4 = 2, id(A, I), (I + T) % 5 = 1.
attach(A, @FAR, 2) :- tick(A, T), T % 8 = 5, id(A, I), I % 6 = 2.
attach(A, @LAST, 2) :- tick(A, T), T % 8 = 1, id(A, I), I % 9 = 4.
detach(A, B) :- has(A, B), tick(A, T), T % 4 = 0, id(A, I), (I + T) % 6 = 2.
detach(A, B) :- neighbor(A, B), tick(A, T), T % 6 = 4, id(A, I), (I + T) % 8 = 3.
"""


def kind(rng, reach):
    """A kind of joints in the words of a world."""
    text = joint(rng, f"reach = {reach}").replace("[[motion.joint]]", "[[motion.joint_kind]]")
    if 'kind = "slider"' not in text and rng.random() < 0.4:
        text += f"anchor = [{rng.uniform(-0.5, 0.5):.2f}, {rng.uniform(-0.5, 0.5):.2f}, 0]\n"
    return text


def case(seed):
    rng = random.Random(seed)
    places, armed, known = chains_and_loose(rng, 3, 18, 2)
    world = motion_of(rng, seed, places)
    connects = rng.random() < 0.5
    if connects and rng.random() < 0.4:
        world += f"breaking_force = {rng.uniform(40, 400):.1f}\n"
    world += f"[motion.sense]\njoint = {rng.choice([0, 0.02])}\nload = {rng.choice([0, 0.02])}\n"
    world += other_shapes(rng) if rng.random() < 0.4 else ""
    world += held_and_thrown(rng, armed)
    size = rng.randint(2, 5)
    for first in range(0, armed if connects else 0, size):
        world += f'[[motion.catoms]]\nwhere = "id >= {first} && id < {min(first + size - rng.randint(0, 1), armed)}"\nconnected = true\n'
    if rng.random() < 0.6:
        world += joint(rng, f'where = "id < {rng.randint(4, armed)} && y >= {rng.randint(0, 6)}"')
    world += joints_between(rng, 2, known)
    for reach in (0.05, rng.choice([0, 0.3]), rng.choice([0.05, 90]), 0.02)[:rng.randint(2, 4)]:
        world += kind(rng, reach)
    world += range_and_kills(rng, 3.0, 2)
    far = str(rng.randrange(len(places))), str(len(places) - 1 + rng.randint(0, 1))
    program = OF_ARMS if connects else OF_JOINTS + REFUSED
    return program + CHANGES.replace("@FAR", "@" + far[0]).replace("@LAST", "@" + far[1]), world


if __name__ == "__main__":
    sys.exit(main("couplings", case))
