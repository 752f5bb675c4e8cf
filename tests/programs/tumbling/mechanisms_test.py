"""Mechanisms of joints fall, turn by motors, break and lose parts in small random worlds. Whatever the number of processes and threads,
also where a run is stopped in the middle and goes on with others, the facts and places after each tick are the same.

Usage: mechanisms_test.py MELDSIM [FIRST_SEED [SEEDS [TICKS]]]
"""

import random
import sys

from tumble_test import held_and_thrown, main, other_shapes, range_and_kills

PROGRAM = """
type action force(node, float, float, float) while.
type action motor(node, node, float).
type action servo(node, node, float).
type action brake(node, node).
type action coast(node, node).
type turned(node, node, float, float).
type carries(node, node, float, float, float).
type linear lost(node, node).
type parted(node, node, int).
type degree(node, count int).
type source(node).
type dist(node, min int).
type lies(node, int).
type fast(node, vec3).
degree(A, 1) :- neighbor(A, _).
dist(A, 0) :- source(A).
dist(B, D + 1) :- dist(A, D), neighbor(A, B).
turned(A, B, P, S) :- joint(A, B, P, S).
carries(A, B, T, S, M) :- load(A, B, T, S, M).
broke(A, B), tick(A, T) -o parted(A, B, T).
lies(A, O) :- contact(A, O).
fast(A, V) :- velocity(A, V), id(A, I), I % 3 = 0.
motor(A, B, 2.0) :- joint(A, B, _, _), tick(A, T), T % 7 = 2, id(A, I), I % 4 = 1.
servo(A, B, 0.4) :- joint(A, B, _, _), tick(A, T), T % 9 = 4, id(A, I), I % 3 = 0.
brake(A, B) :- joint(A, B, P, _), P > 0.8, id(A, I), I % 2 = 0.
coast(A, B) :- parted(A, _, T), tick(A, N), N < T + 3, neighbor(A, B).
force(A, 0 - X, 0, 4) :- position(A, X, _, _), id(A, I), I % 11 = 5.
"""


def joint(rng, where):
    """A joint in the words of a world."""
    kind = rng.choice(["hinge", "hinge", "slider", "ball"])
    text = f'[[motion.joint]]\n{where}\nkind = "{kind}"\n'
    if kind != "ball":
        text += f"axis = [{rng.randint(0, 1)}, 1, {rng.randint(-1, 1)}]\n"
        way = rng.random()
        if way < 0.3:
            text += f"{'torque' if kind == 'hinge' else 'force'} = {rng.uniform(1, 30):.2f}\n"
            text += rng.choice([f"motor = {rng.uniform(-4, 4):.2f}\n", f"servo = {rng.uniform(-1, 1):.2f}\n", "brake = true\n", ""])
        elif way < 0.5:
            text += f"stiffness = {rng.uniform(5, 60):.2f}\ndamping = {rng.uniform(0, 3):.2f}\n"
        if rng.random() < 0.4:
            text += "limits = [-40, 60]\n" if kind == "hinge" else "limits = [-0.3, 0.4]\n"
    if rng.random() < 0.4:
        text += f"breaking_force = {rng.uniform(20, 200):.1f}\n"
    if rng.random() < 0.2:
        text += f"breaking_torque = {rng.uniform(5, 80):.1f}\n"
    return text


def chains_and_loose(rng, shortest, longest, height):
    """Rows of catoms that touch, one or two diameters apart; some far away; and some that fall on them. Returns the places, how many are
    in rows, and how many of these and of those far away there are."""
    places = []
    for chain in range(rng.randint(2, 4)):
        along = rng.randrange(2)
        for i in range(rng.randint(shortest, longest)):
            low = height + 0.6 * chain
            places.append([i - 9, 2.5 * chain, low] if along else [3 * chain - 12, i - 5, low + 3])
    chained = len(places)
    for i in range(rng.randint(0, 4)):
        places.append([rng.randint(-45, 45), -20 - 3 * i, rng.randint(2, 12)])
    known = len(places)
    for _ in range(rng.randint(0, 60)):
        places.append([rng.randint(-9, 9) + 0.1 * rng.randint(0, 3), rng.randint(-6, 12), 12 + 1.2 * len(places) % 6])
    unique = []
    for i, place in enumerate(places):
        if i < chained or all(abs(place[0] - x) + abs(place[1] - y) + abs(place[2] - z) > 2 for x, y, z in unique):
            unique.append(place)
    return unique, chained, min(known, len(unique))


def motion_of(rng, seed, places):
    """The beginning of a world of bodies at these places; keys of [motion] may follow."""
    world = (f"seed = {seed}\n[[body]]\npositions = {places}\n"
             f'[motion]\nkind = "bodies"\nground = 0\nsteps = {rng.choice([3, 6])}\n'
             f"friction = {rng.choice([0.2, 0.6])}\nrestitution = {rng.choice([0, 0, 0.4])}\nsleep_ticks = {rng.choice([0, 4, 12])}\n"
             f"deepest_overlap = 0.9\n")
    return world + rng.choice(['solver = "pgs20"\n', "", "", ""]) + rng.choice(['lowest = 0.2\nlost = "remove"\n', "", "", ""])


def joints_between(rng, most, catoms):
    """At most so many joints, each between two of the first catoms, wherever they are."""
    return "".join(joint(rng, f"between = {rng.sample(range(catoms), 2)}") for _ in range(rng.randint(0, most)))


def case(seed):
    rng = random.Random(seed)
    places, chained, known = chains_and_loose(rng, 3, 26, 3)
    world = motion_of(rng, seed, places)
    world += f"[motion.sense]\njoint = {rng.choice([0, 0.02])}\nload = {rng.choice([0, 0.02])}\n"
    world += other_shapes(rng) if rng.random() < 0.4 else ""
    world += held_and_thrown(rng, chained)
    world += joint(rng, f'where = "id < {chained} && y {rng.choice(["<", ">="])} {rng.randint(0, 6)}"')
    world += joint(rng, f'where = "id < {rng.randint(4, chained)}"')
    world += joints_between(rng, 3, known)
    world += range_and_kills(rng, 3.0, 2)
    return PROGRAM, world


if __name__ == "__main__":
    sys.exit(main("mechanisms", case))
