"""Examples whose catoms die while they work, and some of whose messages are late: failures_test.py MELDSIM EXAMPLES NAME.

walking_token: no two catoms are ever inside together, and those that are left enter with a new token. shape_change: those that are left
fill the target as far as they go. All of it is the same on several numbers of processes.
"""

import collections
import pathlib
import re
import sys
import tempfile

import networkx
from distributed import TELLING, require
from runner import CAMPAIGN, WHERE, Runner
from shape_test import BAR, WORLD, distances

SIZES = [(1, 1), (2, 1)]


# ---- a token in a graph that breaks

# A walk takes at most 2 E steps, of a message and a stay; so many hundreds of ticks are more than enough.
PATIENCE, TICKS = 25, 8000
CONDITIONS = ("", '[network]\nkind = "latency"\nleast = 1\nmost = 5\n', '[network]\nkind = "lossy"\nloss = 0.2\nretry = 3\ntries = 12\n',
              '[clock]\nkind = "drift"\nmost = 3\n')
TOGETHER = "inside(A, _, _), inside(B, _, _), A < B"


def kills(*events):
    return "".join(f'[[event]]\ntick = {tick}\nkill = "{where}"\n' for tick, where in events)


def walking_token(meldsim, examples, folder):
    runner = Runner(meldsim, examples / "walking_token.meld", folder, TELLING)
    world = folder / "world.toml"
    for seed in range(24 if CAMPAIGN else 4):
        text = (f'lattice = "graph"\ngraph = "small_world(50, 4, 0.3)"\nseed = {seed}\n[facts]\nkeeper = "id == 0"\n'
                f'wants = "id % 4 == 1"\n{CONDITIONS[seed % 4]}')
        early = kills((200, f"id % 25 == {seed} && id != 0"), (320, f"id % 20 == {(seed * 7 + 3) % 20} && id != 0"))
        # Somebody is inside: he is killed.
        tick, holders = 400, []
        while not holders:
            world.write_text(text + early)
            facts, _, _ = runner.run(runner.program, world, 1, 1, ("--ticks", str(tick)))
            holders = re.findall(r"^inside\(@(\d+)", facts, re.M)
            tick += 1
        world.write_text(text + early + kills((tick, f"id == {holders[0]}")))
        options = ("--ticks", str(TICKS), "--set", f"patience={PATIENCE}", "--never", TOGETHER)
        outcome = runner.run_sizes(world, options, SIZES if seed < 2 else [(1, 1)])
        facts = outcome.facts
        graph = networkx.Graph()
        graph.add_nodes_from(a for a, in facts["graph-node"])
        graph.add_edges_from(facts["graph-link"])
        numbers = collections.Counter((generation, number) for _, generation, number in facts["entered"])
        require(max(numbers.values()) == 1, f"seed {seed}: two catoms entered with the same number")
        last = max(generation for generation, _ in numbers)
        require(last > 1, f"seed {seed}: the token died with @{holders[0]}, and no other one was made")
        # In what is left of the run, everybody who can be reached has been inside with the last token.
        entered = {a for a, generation, _ in facts["entered"] if generation == last}
        wanted = {a for a, in facts["wants"]} & networkx.node_connected_component(graph, 0)
        require(wanted <= entered, f"seed {seed}: {sorted(wanted - entered)} wait for ever")
        print(f"token, seed {seed}: {outcome.summary['killed']} killed, {last} tokens, {len(facts['entered'])} entries")


# ---- a change of shape

DEATHS = "".join(f'[[event]]\ntick = {tick}\nkill = "id % 100 == {{{number}}} && cell != (0, 0, 0)"\n'
                 for number, tick in enumerate((20, 30, 40, 60, 80, 100, 120, 150)))
# Links of a catom in ten are slow, which is a fifth of all links.
LATE = '[network]\nkind = "latency"\n[[network.region]]\nwhere = "id % 10 == {late}"\nleast = 2\nmost = 6\n'


def shape_change(meldsim, examples, folder):
    runner = Runner(meldsim, examples / "shape_change.meld", folder, WHERE)
    world = folder / "world.toml"
    for seed in range(12 if CAMPAIGN else 3):
        dying = [(seed * 31 + 17 * number) % 100 for number in range(8)]
        world.write_text(f"seed = {seed}\n" + WORLD + LATE.format(late=seed % 10) + DEATHS.format(*dying))
        outcome = runner.run_sizes(world, (), SIZES if seed == 0 else [(1, 1)])
        killed, cells = outcome.summary["killed"], set(outcome.cell_of.values())
        require(outcome.summary["ended"] == "quiet", f"seed {seed}: it ended with {outcome.summary['ended']}")
        require(13 <= killed <= 40, f"seed {seed}: {killed} were killed")
        # A catom that dies takes the unit with it that it holds.
        require(512 - 2 * killed <= len(cells) <= 512 - killed, f"seed {seed}: {len(cells)} of 512 are left after {killed} were killed")
        # Deaths can cut catoms off from the seed. All others are in the target, and have passed on what they held.
        near = distances(cells, (0, 0, 0))
        require(len(cells) - len(near) <= 4, f"seed {seed}: {len(cells) - len(near)} are cut off")
        require(set(near) <= BAR, f"seed {seed}: {sorted(set(near) - BAR)[:5]} are outside the target")
        loaded = {outcome.cell_of[catom] for catom, in outcome.facts["loaded"]}
        require(not loaded & set(near), f"seed {seed}: {loaded & set(near)} have units left")
        joined = {outcome.cell_of[catom] for catom, in outcome.facts["joined"]}
        require(joined == set(near), f"seed {seed}: not those have joined that the seed reaches")
        print(f"shape, seed {seed}: {killed} killed, {len(cells) - len(near)} cut off, {len(near)} of {len(BAR)} cells filled in "
              f"{outcome.summary['ticks']} ticks")


def main():
    meldsim, examples, name = sys.argv[1], pathlib.Path(sys.argv[2]), sys.argv[3]
    with tempfile.TemporaryDirectory() as folder:
        try:
            globals()[name](meldsim, examples, pathlib.Path(folder))
        except AssertionError as error:
            sys.exit(f"{name}: {error}")


if __name__ == "__main__":
    main()
