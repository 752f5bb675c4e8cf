"""Every catom asks for all that it can, in every tick: catoms come, go, migrate and fail by the hundred, and rows, lists and bricks grow.
Whatever the number of processes and threads, the facts and places after each tick are the same.

Usage: storm_test.py MELDSIM [FIRST_SEED [SEEDS [TICKS]]]
"""

import random
import sys

from seeds import Divided

# `seen` has rows that neighbours read and changes with every move; `memory` is a list that grows and follows its catom.
COMMON = """
type seen(node, node, min int).
type near(node, set_union set node).
type linear memory(node, list int).
type last(node, max int).
seen(A, A, 0) :- neighborCount(A, _).
seen(A, C, D + 1) :- neighbor(A, B), seen(B, C, D), D < REACH.
near(A, list2set([B])) :- neighbor(A, B).
last(A, K) :- holds(A, K).
memory(A, []).
failed(A, K), memory(A, L) -o memory(A, [K | L]).
"""

WISHES = {
    "moveAround(node, node, node)": [
        "moveAround(A, B, C) :- neighbor(A, B), neighbor(A, C), B <> C.",
        "moveAround(A, B, C) :- neighbor(A, B), neighbor(B, C), A <> C.",
    ],
    "create(node, int)": ["create(A, P) :- vacant(A, P)."],
    "destroy(node, node)": ["destroy(A, B) :- neighbor(A, B), last(A, N), N % 3 = 0.", "destroy(A, B) :- neighbor(A, B), last(A, 2)."],
    "give(node, node)": ["give(A, B) :- neighbor(A, B), holds(A, K), K > 0."],
    "moveTo(node, int, int, int)": [
        "moveTo(A, X + DX, Y, Z) :- cell(A, X, Y, Z), neighborCount(A, 1), last(A, 0).",
        "moveTo(A, X, Y - DX, Z) :- cell(A, X, Y, Z), neighborCount(A, 0).",
    ],
    "slide(node, int, int)": ["slide(A, P, Q) :- neighbor(A, _, P), vacant(A, Q)."],
    "turn(node, int, int)": ["turn(A, P, Q) :- neighbor(A, _, P), vacant(A, Q)."],
}

SETTINGS = [(1, 1), (2, 1), (3, 1), (4, 1), (2, 2)]  # Processes and threads of each


def case(seed):
    rng = random.Random(seed)
    lattice = rng.choice(["square", "hex", "cubic", "fcc"])
    flat = lattice in ("square", "hex")
    wishes = [head for head in WISHES if rng.random() < 0.6 or head.startswith("moveAround")]
    program = "".join(f"type action {head} while.\n" for head in wishes) + COMMON.replace("REACH", str(rng.randint(1, 3)))
    for head in wishes:
        kept = [rule for rule in WISHES[head] if rng.random() < 0.7] or WISHES[head][:1]
        program += "".join(rule.replace("DX", str(rng.randint(2, 20))) + "\n" for rule in kept)
    size = rng.randint(4, 14) if flat else rng.randint(2, 5)
    world = f'lattice = "{lattice}"\nseed = {seed}\nheld = {rng.randint(0, 2)}\n[[body]]\n'
    world += f'shape = "box({size}, {size}, {1 if flat else size})"\n'
    world += f'[motion]\nkind = "lattice"\ncapacity = {rng.randint(2, 5)}\nkeep_connected = {rng.choice(["true", "false"])}\n'
    return program, world


def main():
    meldsim, first, seeds, ticks = sys.argv[1], *(int(word) for word in (sys.argv[2:] + ["0", "4", "12"][len(sys.argv) - 2 :])[:3])
    divided = Divided(meldsim, "storm", SETTINGS, ["--ticks", str(ticks), "--digest", "-", "--digest-check", "1"])
    return divided.compare(((seed, *case(seed)) for seed in range(first, first + seeds)),
                           lambda digests: len(set(digests.splitlines())) > ticks // 2)


if __name__ == "__main__":
    sys.exit(main())
