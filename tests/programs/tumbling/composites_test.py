"""Rigid pieces of connected catoms fall, merge, split, carry loads, break and lose parts in small random worlds. Whatever the number of
processes and threads, also where a run is stopped in the middle and goes on with others, the facts and places after each tick are the same.

Usage: composites_test.py MELDSIM [FIRST_SEED [SEEDS [TICKS]]]
"""

import random
import sys

from tumble_test import held_and_thrown, main, other_shapes, range_and_kills, turning_friction, what_the_world_moves

PROGRAM = """
type action force(node, float, float, float) while.
type action torque(node, float, float, float) while.
type action connect(node, node).
type action release(node, node).
type linear failed(node, int).
type refused(node, int, int).
type holds(node, node).
type carries(node, node, float, float, float).
type parted(node, node, int).
type degree(node, count int).
type source(node).
type dist(node, min int).
type lies(node, int).
type fast(node, vec3).
type pressed(node, float).
type turned(node, float, float, float, float).
degree(A, 1) :- neighbor(A, _).
dist(A, 0) :- source(A).
dist(B, D + 1) :- dist(A, D), neighbor(A, B).
holds(A, B) :- connected(A, B).
broke(A, B), tick(A, T) -o parted(A, B, T).
failed(A, C), tick(A, T) -o refused(A, C, T).
lies(A, O) :- contact(A, O).
fast(A, V) :- velocity(A, V), id(A, I), I % 3 = 0.
pressed(A, P) :- pressure(A, P), id(A, I), I % 4 = 1.
turned(A, W, X, Y, Z) :- orientation(A, W, X, Y, Z), id(A, I), I % 5 = 2.
connect(A, B) :- neighbor(A, B), tick(A, T), T % 4 = 2, id(A, I), (I + T) % 3 = 0, not parted(A, B, _).
connect(A, B) :- dist(A, 0), neighbor(A, B).
release(A, B) :- connected(A, B), tick(A, T), T % 5 = 3, id(A, I), (I + T) % 7 = 1.
release(A, B) :- neighbor(A, B), tick(A, 9), id(A, I), I % 4 = 0.
force(A, 0 - X, 0, 4) :- position(A, X, _, _), id(A, I), I % 11 = 5.
torque(A, 1, 0, 2) :- degree(A, 3), id(A, I), I % 2 = 0.
"""
LOADS = "carries(A, B, T, S, M) :- load(A, B, T, S, M).\n"


def case(seed):
    rng = random.Random(seed)
    places = []
    for row in range(rng.randint(2, 4)):
        along = rng.randrange(2)
        for i in range(rng.randint(2, 24)):
            places.append([i - 9, 2.5 * row, 0.6 + 1.2 * row] if along else [3 * row - 12, i - 5, 1.3 + 1.1 * row])
    side, high = rng.randint(1, 6), rng.randint(1, 9)
    places += [[14 + i % side, i // side - 4, high] for i in range(side * rng.randint(1, 6))]
    rows = len(places)
    for i in range(rng.randint(0, 3)):
        places.append([rng.randint(-45, 45), -20 - 3 * i, rng.randint(2, 12)])
    for _ in range(rng.randint(0, 60)):
        places.append([rng.randint(-9, 9) + 0.1 * rng.randint(0, 3), rng.randint(-6, 12), 6 + 1.2 * len(places) % 6])
    unique = []
    for i, place in enumerate(places):
        far = all(abs(place[0] - x) + abs(place[1] - y) + abs(place[2] - z) >= (1 if i < rows else 2) for x, y, z in unique)
        if far:
            unique.append(place)
    world = (f"seed = {seed}\n[[body]]\npositions = {unique}\n"
             f'[motion]\nkind = "bodies"\nground = 0\nsteps = {rng.choice([3, 6, 12])}\n'
             f"friction = {rng.choice([0.2, 0.6])}\nrestitution = {rng.choice([0, 0, 0.4, 0.8])}\nsleep_ticks = {rng.choice([0, 4, 12])}\n"
             f"deepest_overlap = 0.9\n" + turning_friction(seed))
    world += rng.choice(['solver = "pgs20"\n', "", "", ""]) + rng.choice(['lowest = 0.2\nlost = "remove"\n', "", "", ""])
    if rng.random() < 0.4:
        world += f"breaking_force = {rng.uniform(20, 300):.1f}\n"
    if rng.random() < 0.3:
        world += f"breaking_torque = {rng.uniform(10, 200):.1f}\n"
    world += f"[motion.sense]\nload = {rng.choice([0, 0.02])}\n"
    world += other_shapes(rng) if rng.random() < 0.4 else ""
    world += held_and_thrown(rng, rows)
    for _ in range(rng.randint(1, 3)):
        world += f'[[motion.catoms]]\nwhere = "id < {rng.randint(2, rows)} && y {rng.choice(["<", ">="])} {rng.randint(0, 6)}"\n'
        world += "connected = true\n"
    if rng.random() < 0.3:
        world += f'[[motion.catoms]]\nwhere = "id % 5 == {rng.randint(0, 4)}"\nbreaking_force = {rng.uniform(10, 100):.1f}\n'
    world += range_and_kills(rng, 2.0, 1)
    return PROGRAM + (LOADS if rng.random() < 0.6 else ""), world + what_the_world_moves(seed, about_z=True)


if __name__ == "__main__":
    sys.exit(main("composites", case))
