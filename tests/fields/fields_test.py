"""Disturbs the blocks of aggregate programming and compares what they have afterwards with what the final state alone gives:
fields_test.py MELDSIM BLOCK. For an example, in its own world, with the events that stand there: fields_test.py MELDSIM EXAMPLE.

A block stabilizes by itself if its values depend on its inputs and on the network as they are now, and on nothing that was before. So
sources come and go, catoms die and links are cut at random ticks, on random geometric graphs and on lattices, where messages take one tick
or several, get lost, and catoms act at their own pace. Digests and facts are the same bytes on 1 to 4 processes.
"""

import collections
import math
import pathlib
import random
import sys
import tempfile

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent.parent / "programs"))

import networkx  # noqa: E402
from oracles import EXAMPLES, ORACLES  # noqa: E402
from runner import CAMPAIGN, Runner, first_difference, literal, split  # noqa: E402

HERE = pathlib.Path(__file__).resolve().parent
PROGRAMS = HERE.parents[1] / "examples" / "meld"
# What the test has to know of the network as it is at the end.
TOLD = """
type where-link(node, node To).
type where-place(node, vec3 P).
where-link(A, B)  :- neighbor(A, B).
where-place(A, P) :- position(A, P).
"""
# Where devices are points that move: who is given this goes its way once, and loses some neighbours and finds others.
PUSHED = """
type where-pushed(node, float X, float Y).
moveBy(A, X, Y, 0.0) :- where-pushed(A, X, Y).
"""
CONDITIONS = {
    "at once": "",
    "late": '[network]\nkind = "latency"\nleast = 1\nmost = 7\n',
    "lossy": '[network]\nkind = "lossy"\nloss = 0.2\nretry = 3\ntries = 12\n',
    "by chance": '[clock]\nkind = "random"\nrate = 0.4\nmost = 6\n',
    "drifting": '[network]\nkind = "latency"\nleast = 2\nmost = 5\n[clock]\nkind = "drift"\nmost = 4\n',
}
NETWORKS = [
    'lattice = "graph"\ngraph = "geometric(90, 0.17)"\n',
    'lattice = "hex"\n[[body]]\nshape = "minus(box(11, 9, 1), box(4, 3, 1))"\n',
    'lattice = "graph"\ngraph = "geometric(70, 0.14)"\n',
    'lattice = "cubic"\n[[body]]\nshape = "minus(box(5, 5, 4), box(3, 2, 4))"\n',
    'lattice = "graph"\ngraph = "scatter(80, 12, 12)"\n[links]\nrange = 2.2\n',
    'lattice = "graph"\ngraph = "scatter(80, 12, 12)"\n[links]\nrange = 2.2\n[motion]\nkind = "points"\n',
]
CATOMS = 60  # At least as many in each of them.
SIZES = [[(1, 1), (2, 1), (3, 2)], [(1, 2), (4, 1)], [(1, 1), (2, 2)], [(1, 1), (3, 1)], [(2, 1), (1, 1)]]
# Blocks that go on for ever have corrected their distances by then.
ROUNDS = {"crf": 700, "bis": 1200, "flex": 1500}


def some(draw, count):
    return [f"id == {draw.randrange(CATOMS)}" for _ in range(count)]


def pushed(draw):
    way = [round(draw.uniform(-3, 3), 2) for _ in range(2)]
    return "give = { where-pushed = [" + ", ".join(f'{{ where = "{region}", args = {way} }}' for region in some(draw, 8)) + "] }\n"


def listed(regions):
    return "[" + ", ".join(f'"{region}"' for region in regions) + "]"


def disturbed(block, draw, moving):
    """Facts at the start, and what happens to them, to catoms and to links. Where catoms move, no link can be healed."""
    names = ["source"] + (["wall"] if block in ("field", "channel") else []) + (["goal"] if block == "channel" else [])
    text = "seed = %d\n" % draw.randrange(1000), "[facts]\n" + "".join(f"{name} = {listed(some(draw, 3))}\n" for name in names)
    events, tick = "", 0
    for _ in range(draw.randrange(3, 7)):
        tick += draw.randrange(1, 25)
        events += f"[[event]]\ntick = {tick}\n"
        name = draw.choice(names)
        events += draw.choice([
            f"give = {{ {name} = {listed(some(draw, 2))} }}\n",
            # Everything goes, and something comes, where it matters most.
            f'take = {{ source = "id >= 0" }}\ngive = {{ source = {listed(some(draw, 2))} }}\n',
            f"kill = {listed(some(draw, 4))}\n",
            f'cut = "id % 4 == {draw.randrange(4)}"\n',
            'heal = "all"\n' if not moving else pushed(draw),
        ])
        if moving:
            events += f"[[event]]\ntick = {tick + 1}\n{pushed(draw)}"
    return *text, events


def worlds(block):
    if block in EXAMPLES:
        world = (PROGRAMS / f"{block}.toml").read_text()
        yield "its own", world, [(1, 1), (2, 1), (3, 2), (4, 1)]
        # A table of the whole world ends where the first event begins.
        head, _, events = world.partition("[[event]]")
        yield "late and drifting", head + CONDITIONS["drifting"] + "[[event]]" + events, [(1, 1), (3, 1)]
        return
    draw = random.Random(block)
    turns = (40 if CAMPAIGN else 12) // (2 if block in ROUNDS else 1)
    for turn in range(turns):
        condition = list(CONDITIONS)[turn % len(CONDITIONS)]
        if block in ROUNDS and condition == "lossy":
            condition = "late"
        network = NETWORKS[turn % len(NETWORKS)]
        seed, facts, events = disturbed(block, draw, "[motion]" in network)
        # What is of the whole world stands above its tables.
        head, table, body = network.partition("\n[")
        world = head + "\n" + seed + table[1:] + body + facts + CONDITIONS[condition] + events
        yield f"{turn}, {condition}", world, SIZES[turn % len(SIZES)]


class Final:
    """Inputs, network and outputs at the end."""

    def __init__(self, text):
        self.facts = collections.defaultdict(list)
        for line in text.splitlines():
            name, _, rest = line.partition("(")
            # Private facts have tuples, which nobody reads here.
            if ", (" in rest:
                continue
            self.facts[name].append(tuple(literal(word) for word in split(rest[:-2])))
        self.place = dict(self.facts["where-place"])
        self.links = {catom: [] for catom in self.place}
        for one, other in self.facts["where-link"]:
            self.links[one].append(other)

    def map(self, predicate):
        rows = self.facts[predicate]
        found = {row[0]: row[1] for row in rows}
        if len(found) != len(rows):
            raise AssertionError(f"{predicate} has two facts at one catom")
        return found

    def all(self, predicate):
        return {row[0] for row in self.facts[predicate]}

    def length(self, one, other):
        # As the runtime does, to the last bit.
        return math.sqrt(sum((a - b) ** 2 for a, b in zip(self.place[one], self.place[other])))

    def graph(self, without=()):
        graph = networkx.Graph()
        graph.add_nodes_from(set(self.links) - set(without))
        for one, others in self.links.items():
            graph.add_weighted_edges_from((one, other, self.length(one, other)) for other in others
                                          if one not in without and other not in without)
        return graph

    def same(self, predicate, wanted, tolerance=0.0):
        """A predicate of a catom and a value, exactly or up to rounding."""
        found = self.map(predicate)
        for catom in sorted(set(found) | set(wanted)):
            one, other = found.get(catom), wanted.get(catom)
            if one == other:
                continue
            if None in (one, other) or not tolerance or not math.isclose(one, other, rel_tol=tolerance, abs_tol=tolerance):
                raise AssertionError(f"{predicate}: @{catom} has {one}, not {other}")


def run(runner, world, sizes, options):
    text, digests, summary = runner.run(runner.telling, world, *sizes[0], options)
    for processes, threads in sizes[1:]:
        other, theirs, _ = runner.run(runner.telling, world, processes, threads, options)
        if (other, theirs) != (text, digests):
            raise AssertionError(f"{processes} processes of {threads} threads differ:\n{first_difference(text + digests, other + theirs)}")
    return text, summary


def main():
    meldsim, block = sys.argv[1:]
    with tempfile.TemporaryDirectory() as scratch:
        added = TOLD if block in EXAMPLES else TOLD + PUSHED
        runner = Runner(meldsim, (PROGRAMS if block in EXAMPLES else HERE) / f"{block}.meld", scratch, added)
        check = ORACLES.get(block) or EXAMPLES[block]
        path = runner.folder / "world.toml"
        for name, world, sizes in worlds(block):
            path.write_text(world)
            options = ["--ticks", str(ROUNDS[block])] if block in ROUNDS else []
            try:
                text, summary = run(runner, path, sizes, options)
                final = Final(text)
                check(final)
            except AssertionError as error:
                sys.exit(f"{block} in world {name}: {error}\n{world}")
            print(f"{name}: {len(final.place)} catoms at the end, {summary['ticks']} ticks")


if __name__ == "__main__":
    main()
