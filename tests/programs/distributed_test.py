"""Runs a distributed algorithm among the examples on lattices: distributed_test.py MELDSIM EXAMPLES PROGRAM.

Its outcome is judged by distributed.py; digests and facts are the same bytes on 1 to 4 processes.
"""

import itertools
import pathlib
import random
import sys
import tempfile

from blobs import blob, blobs, ring
from distributed import Case, judge_all
from worlds import World


def rooted(program, seed, more="", **known):
    """The example's own world and random ones with a root anywhere."""
    yield Case(f"{program}.toml", **known)
    draw = random.Random(seed)
    for world in blobs(seed):
        yield Case(world, f'root = ["id == {draw.randrange(len(world.cells))}"]\n{more}', **known)


def alternating_bit_cases():
    yield Case("alternating_bit.toml", loss=0)
    for seed, loss in ((1, 0), (2, 20), (3, 50)):
        world = blob("hex", 12, seed=seed)
        says = 'say = [{ where = "id % 3 == 0", args = ["to be or not"] }, { where = "id == 4", args = [""] }]'
        yield Case(world, says, ("--set", f"loss={loss}"), loss=loss)


def token_ring_cases(folder):
    # Every tick is recorded, so that long runs are left to one process.
    for seed, (width, height, sizes) in enumerate(((3, 3, [(1, 1), (2, 1), (3, 1)]), (7, 5, [(1, 1)]), (3, 5, [(1, 1)]))):
        world = ring(width, height)
        # A move takes three ticks, and a catom and what its neighbour sees of it are two machines.
        settle, lap = 16 * len(world.cells), 4 * len(world.cells)
        taps = f'\n[[event]]\ntick = {settle + lap}\ngive = {{ tap = ["id % 3 == 1"] }}\n'
        yield Case(world, "", ("--ticks", str(2 * settle + 2 * lap), "--seed", str(seed), "--record", folder / "ring.vtkhdf"), taps,
                   sizes=sizes, ended="ticks", settle=settle, lap=lap, recording=folder / "ring.vtkhdf")


def stabilizing_tree_cases():
    for case in rooted("stabilizing_tree", 30):
        yield case
        case.events = '\n[[event]]\ntick = 300\ngive = { tap = ["id % 2 == 0"] }\n'


def gossip_cases():
    for options in ((), ("--set", "patience=2")):
        for case in rooted("gossip", 40 + len(options), patience=2 if options else 6):
            case.options = options
            yield case


def reliable_broadcast_cases():
    yield Case("reliable_broadcast.toml")
    for world in blobs(50):
        yield Case(world, 'send = [{ where = "id % 20 == 0", args = [1, "one"] }, { where = "id == 0", args = [2, "two"] }]')


# What liars run, from the examples.
LIAR = "byzantine_liar.meld"
# Four balls that all touch each other, and three of them.
FOUR = [(0, 0, 0), (1, 0, 0), (0, 0, 1), (0, -1, 1)]


def groups(size, count, seed):
    """A world of groups, with one liar in most; votes at random, but in every third group all alike."""
    draw = random.Random(seed)
    places = [[(x + 4 * i, y, z) for x, y, z in FOUR[:size]] for i in range(count)]
    liars = [draw.choice(place) for i, place in enumerate(places) if i % 5]
    ones = [cell for i, place in enumerate(places) for cell in place if (i // 3 % 2 if i % 3 == 0 else draw.randrange(2))]
    zeros = [cell for place in places for cell in place if cell not in ones]
    facts = "vote = ["
    facts += ", ".join(f'{{ where = "cell == {cell}", args = [{v}] }}' for v, cells in enumerate((zeros, ones)) for cell in cells) + "]"
    facts += "".join(f'\n[[program]]\nwhere = "cell == {cell}"\nfile = "{LIAR}"' for cell in liars)
    return World(f"{count} groups of {size}", "fcc", sorted(itertools.chain(*places))), facts


def byzantine_cases():
    yield Case("byzantine.toml", fails=False)
    for seed in range(3):
        yield Case(*groups(4, 30, seed), ("--seed", str(seed)), fails=False)
    # A third of liars is too many: somewhere honest catoms differ, or leave what they all wanted.
    yield Case(*groups(3, 60, 7), fails=True)


def cases(program, folder):
    own = {"alternating_bit": alternating_bit_cases, "stabilizing_tree": stabilizing_tree_cases, "gossip": gossip_cases,
           "reliable_broadcast": reliable_broadcast_cases, "byzantine": byzantine_cases}
    if program in own:
        return own[program]()
    if program == "token_ring":
        return token_ring_cases(folder)
    if program in ("luby", "fragments", "echo_election"):
        more = [Case(blob("fcc", 40, 30, seed=seed), sizes=[(1, 1)]) for seed in range(8)]
        return [Case(f"{program}.toml"), *map(Case, blobs(60)), *more]
    if program == "diffusing":
        return rooted(program, 10, options=("--stats",))
    return rooted(program, 20, 'wants = ["id % 3 == 1"]' if program == "raymond" else "")


def main():
    meldsim, examples, program = sys.argv[1], pathlib.Path(sys.argv[2]), sys.argv[3]
    with tempfile.TemporaryDirectory() as folder:
        judge_all(meldsim, examples, program, folder, cases(program, pathlib.Path(folder)))


if __name__ == "__main__":
    main()
