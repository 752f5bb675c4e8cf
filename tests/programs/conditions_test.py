"""Runs a distributed algorithm among the examples where messages take time, get lost, and catoms act at their own pace, on graphs and on
lattices: conditions_test.py MELDSIM EXAMPLES PROGRAM.

Its outcome is judged by distributed.py as in the ideal network, with bounds on time that count in time units. The campaign, with
CLAYMELD_TEST_SIZES=all, takes all graphs under all conditions, with several seeds.
"""

import itertools
import pathlib
import random
import sys
import tempfile
from typing import NamedTuple

import networkx
from blobs import blob, ring
from distributed import Case, judge_all
from runner import CAMPAIGN


class GraphWorld(NamedTuple):
    name: str

    def text(self, facts=""):
        source = "links" if self.name.endswith(".txt") else "graph"
        return f'lattice = "graph"\n{source} = "{self.name}"\n[facts]\n{facts}\n'


class Condition(NamedTuple):
    """Sections of a world file; the longest that a message takes, and the longest that a catom pauses, in ticks."""
    text: str = ""
    delay: int = 1
    pause: int = 1

    @property
    def unit(self):
        return self.delay + self.pause - 1


IDEAL = Condition()
LATE = Condition('[network]\nkind = "latency"\nleast = 1\nmost = 7\n', 7)
# So many tries that no link ever goes down here.
LOSSY = Condition('[network]\nkind = "lossy"\nloss = 0.2\nretry = 3\ntries = 12\n', 34)
CHANCE = Condition('[clock]\nkind = "random"\nrate = 0.4\nmost = 6\n', 1, 6)
DRIFT = Condition('[network]\nkind = "latency"\nleast = 2\nmost = 5\n[clock]\nkind = "drift"\nmost = 4\n', 5, 4)
HARSH = Condition('[network]\nkind = "lossy"\nleast = 1\nmost = 4\nloss = 0.3\nretry = 5\ntries = 20\n'
                  '[[network.region]]\nwhere = "id % 5 == 0"\nleast = 9\nmost = 12\nloss = 0.5\nretry = 2\ntries = 30\n'
                  '[clock]\nkind = "random"\nrate = 0.3\nmost = 9\n', 99, 9)
CONDITIONS = (LATE, LOSSY, CHANCE, DRIFT, HARSH)

GRAPHS = [GraphWorld(name) for name in (
    "random(60, 0.08)", "scale_free(70, 2)", "club.txt", "small_world(60, 4, 0.2)", "complete(9)", "tree(40, 3)", "hypercube(5)",
    "star(20)", "regular(30, 3)", "line(15)", "ring(25)", "random(40, 0.1)", "geometric(60, 0.2)",
    "novel.txt")]
SIZES = [(1, 1), (2, 1)]


def told(program, draw):
    """What the world gives to the program: facts, options, what the check has to know."""
    root = f'root = ["id == {draw.randrange(9)}"]\n'
    if program == "alternating_bit":
        return 'say = [{ where = "id % 9 == 0", args = ["to be or"] }, { where = "id == 4", args = [""] }]', (), {"loss": 0}
    if program == "reliable_broadcast":
        return 'send = [{ where = "id % 20 == 0", args = [1, "one"] }, { where = "id == 0", args = [2, "two"] }]', (), {}
    if program in ("luby", "fragments", "echo_election", "flood_election", "leader", "pagerank", "pagerank_async"):
        return "", (), {}
    if program == "raymond":
        return root + 'wants = ["id % 3 == 1"]', (), {}
    return root, ("--stats",) if program == "diffusing" else (), {"patience": 6} if program == "gossip" else {}


def anywhere(program):
    """The graphs in the ideal network, then some of them, and lattices, under each of the conditions."""
    draw = random.Random(program)
    for graph in GRAPHS if CAMPAIGN else [GRAPHS[0], GRAPHS[-1]]:
        yield under(program, graph, IDEAL, draw)
    lattices = [blob("fcc", 40, seed=3), blob("hex", 30, 15, seed=4), blob("square", 40, seed=5), blob("cubic", 40, seed=6)]
    if CAMPAIGN:
        for world, condition, _ in itertools.product(GRAPHS + lattices, CONDITIONS, range(2)):
            yield under(program, world, condition, draw)
    else:
        for turn, condition in enumerate(CONDITIONS):
            yield under(program, draw.choice(lattices if turn % 2 else GRAPHS), condition, draw)


def under(program, world, condition, draw):
    facts, options, known = told(program, draw)
    events = condition.text
    if program == "stabilizing_tree" and draw.randrange(2):
        events += '\n[[event]]\ntick = 300\ngive = { tap = ["id % 2 == 0"] }\n'
    return Case(world, facts, (*options, "--seed", str(draw.randrange(1000))), events, SIZES, unit=condition.unit, **known)


# ---- programs that need more than that


def raw_links():
    """Over links on which frames get lost and come twice, the alternating bit protocol repeats what is missing and takes nothing twice. If
    frames overtake each other as well, an old one may have the bit that is next: too little for this protocol."""
    for seed in range(6 if CAMPAIGN else 1):
        for world in (GraphWorld("random(12, 0.3)"), blob("hex", 12, seed=seed)):
            yield raw(world, seed, 'least = 1\nmost = 4\nloss = 0.2\nduplicate = 0.2\n')
    yield raw(GraphWorld("complete(12)"), 5, 'least = 1\nmost = 40\nloss = 0.2\nduplicate = 0.3\nreorder = true\n', garbled=True)


def raw(world, seed, terms, **known):
    facts, options, _ = told("alternating_bit", random.Random(seed))
    events = f'[network]\nkind = "raw"\n{terms}'
    return Case(world, facts, (*options, "--seed", str(seed)), events, SIZES, loss=20, drops=True, **known)


def worst_links():
    """What is lost, comes twice and overtakes does no harm to an election in which all that is told only grows."""
    for seed, world in itertools.product(range(6 if CAMPAIGN else 1), (*GRAPHS[:3], blob("cubic", 40, seed=6))):
        events = '[network]\nkind = "raw"\nleast = 1\nmost = 9\nloss = 0.4\nduplicate = 0.3\nreorder = true\n'
        events += '[clock]\nkind = "drift"\nmost = 3\n' if seed % 2 else ""
        yield Case(world, "", ("--seed", str(seed)), events, SIZES, drops=True)


def senders_that_die():
    """A sender is killed while its messages are under way, so some of them never arrive anywhere, and others everywhere."""
    for seed, condition in itertools.product(range(8 if CAMPAIGN else 3), (LATE, DRIFT)):
        facts = 'send = [{ where = "id % 7 == 0", args = [1, "last words"] }]'
        kill = f'[[event]]\ntick = {2 + seed}\nkill = ["id % 7 == 0"]\n'
        yield Case(GraphWorld("random(40, 0.2)"), facts, ("--seed", str(seed)), condition.text + kill, SIZES, unit=condition.unit,
                   drops=True, killed=True, sent=6)


def rings(folder):
    """A message that is late is a machine more in the ring, and a value more: so more values than there are values under way."""
    for seed, condition in enumerate(CONDITIONS[:4] * (3 if CAMPAIGN else 1)):
        world = GraphWorld("ring(9)") if seed % 2 else ring(3, 4)
        count = 9 if seed % 2 else 10
        # A move: two ticks inside, a message, and each of these waits for the clock.
        move = condition.unit + 2 + 2 * condition.pause
        settle, lap = 6 * count * move, count * move
        events = condition.text + f'\n[[event]]\ntick = {settle + lap}\ngive = {{ tap = ["id % 3 == 1"] }}\n'
        events += "" if not seed % 2 else '[record]\nevery = 1\npredicates = ["privileged"]\n'
        options = ("--ticks", str(2 * settle + 2 * lap), "--seed", str(seed), "--record", folder / "ring.vtkhdf", "--set",
                   f"pending={condition.unit // 3 + 2}")
        yield Case(world, "", options, events, [(1, 1), (2, 1)] if seed == 0 else [(1, 1)], unit=condition.unit, ended="ticks",
                   settle=settle, lap=lap, recording=folder / "ring.vtkhdf")


def assemblies():
    """Agreement needs all to be in step: no clocks, and rounds as long as the slowest message."""
    for seed in range(6 if CAMPAIGN else 2):
        for (count, liars), condition in zip(((4, 1), (7, 2), (10, 3), (13, 4)), (IDEAL, LATE, LOSSY, LATE)):
            draw = random.Random(seed)
            votes = [draw.randrange(2) if seed % 2 else 1 for _ in range(count)]
            where = " || ".join(f"id == {a}" for a in draw.sample(range(count), liars))
            facts = "vote = [" + ", ".join(f'{{ where = "id == {a}", args = [{vote}] }}' for a, vote in enumerate(votes))
            facts += f']\n[[program]]\nwhere = "{where}"\nfile = "byzantine_liar.meld"\n'
            yield Case(GraphWorld(f"complete({count})"), facts, ("--seed", str(seed), "--set", f"slowest={condition.delay}"),
                       condition.text, SIZES, unit=condition.unit, fails=False)


def cases(program, folder):
    if program == "token_ring":
        return rings(folder)
    if program == "byzantine":
        return assemblies()
    more = {"alternating_bit": raw_links, "flood_election": worst_links, "reliable_broadcast": senders_that_die}.get(program, list)
    return itertools.chain(anywhere(program), more())


def main():
    meldsim, examples, program = sys.argv[1], pathlib.Path(sys.argv[2]), sys.argv[3]
    with tempfile.TemporaryDirectory() as folder:
        # Numbers, of which some are missing, and words.
        club = networkx.relabel_nodes(networkx.karate_club_graph(), lambda a: a + 20 * (a > 8))
        for name, graph in (("club", club), ("novel", networkx.les_miserables_graph())):
            networkx.write_edgelist(graph, pathlib.Path(folder) / f"{name}.txt", data=False)
        judge_all(meldsim, examples, program, folder, cases(program, pathlib.Path(folder)))


if __name__ == "__main__":
    main()
