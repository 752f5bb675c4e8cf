"""The table of costs in docs/algorithms.md: each distributed algorithm is run once where a message takes a tick, and once where it takes up
to four, and its messages and its time stand beside what the paper allows.

    costs_test.py MELDSIM [--update]
"""

import json
import math
import pathlib
import re
import shutil
import subprocess
import sys
import tempfile
from concurrent.futures import ThreadPoolExecutor

import networkx

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1]))

from frame import environment_with  # noqa: E402

ROOT = pathlib.Path(__file__).resolve().parents[2]
PAGE = ROOT / "docs" / "algorithms.md"
BEGIN, END = "<!-- costs -->\n", "<!-- end of costs -->\n"
UNIT = 4
LATE = f'[network]\nkind = "latency"\nmost = {UNIT}\n'
GRAPH = "small_world(100, 6, 0.2)"
SECTIONS = {
    "diffusing": "termination-of-a-diffusing-computation", "alternating_bit": "alternating-bit", "articulation": "articulation-points",
    "luby": "maximal-independent-set", "fragments": "minimum-spanning-tree", "echo_election": "leader-election",
    "raymond": "mutual-exclusion-on-a-tree", "gossip": "gossip-and-reliable-broadcast",
    "reliable_broadcast": "gossip-and-reliable-broadcast", "byzantine": "byzantine-agreement",
    "stabilizing_tree": "self-stabilization", "token_ring": "self-stabilization",
    "vector_clocks": "vector-clocks", "dining_philosophers": "dining-philosophers", "synchronizer": "a-synchronizer",
    "link_reversal": "link-reversal", "k_core": "core-numbers", "chandra_toueg": "agreement-in-spite-of-crashes",
    "paxos": "agreement-in-spite-of-crashes"}
HEAD = """| program | messages | the bound | rounds | time units, late | the bound |
|---|---|---|---|---|---|
"""


class Run:
    """A run with its counts, and what the bounds speak of: n catoms, e links, the diameter d, the greatest distance from the root."""

    def __init__(self, summary, facts):
        self.summary, self.facts = summary, facts
        self.stats = {row["predicate"].split("/")[0]: row for row in summary["stats"]["predicates"]}
        graph = networkx.Graph([(a, b) for a, b in self.pairs("link-of")])
        self.graph, self.n, self.e = graph, graph.number_of_nodes(), graph.number_of_edges()
        self.d, self.far = networkx.diameter(graph), networkx.eccentricity(graph, 0)
        self.linear = summary["linear_messages"]

    def pairs(self, predicate):
        for line in self.facts:
            if line.startswith(predicate + "("):
                yield [int(word.strip().lstrip("@")) for word in line[len(predicate) + 1:-2].split(",")[:2]]

    def count(self, predicate):
        return sum(1 for _ in self.pairs(predicate))

    def greatest(self, predicate):
        return max(second for _, second in self.pairs(predicate))

    def messages(self, *predicates):
        return sum(self.stats[name]["messages"] for name in predicates)

    def last(self, predicate):
        return self.stats[predicate]["last_active_tick"]

    @property
    def ticks(self):
        """From the first tick to the last but one: in the last there was nothing left to do."""
        return self.summary["ticks"] - 2


class Row:
    """A program in its world, and from a run: its messages and their bound, its time in ticks and the bound on its time units. The bounds
    are texts with numbers from the run, and what they come to; None: the paper has none that could be compared."""

    def __init__(self, program, facts, messages, bound, time=lambda run: run.ticks, time_bound=None, graph=GRAPH, options=()):
        self.program, self.facts, self.graph, self.options = program, facts, graph, options
        self.messages, self.bound, self.time, self.time_bound = messages, bound, time, time_bound


def linear(run):
    return run.linear


def tree_diameter(run):
    return networkx.diameter(networkx.Graph(list(run.pairs("towards"))))


def reversals(run):
    """Each rise is told to all neighbours, and so is where each catom is at first."""
    down = networkx.DiGraph([(max(link), min(link)) for link in run.graph.edges])
    bad = run.n - 1 - len(networkx.ancestors(down, 99))
    return "the degree for each of B^2 rises, and 2 E", bad ** 2 * max(d for _, d in run.graph.degree()) + 2 * run.e


VOTES = "vote = [" + ", ".join(f'{{ where = "id == {a}", args = [{a % 2}] }}' for a in range(7)) + "]"
ROWS = [
    Row("echo", 'root = "id == 0"', linear, lambda r: ("2 E", 2 * r.e), time_bound=lambda r: ("D + N", r.d + r.n)),
    Row("diffusing", 'root = "id == 0"', linear, lambda r: ("2 for each offer", 2 * r.messages("offer")),
        time_bound=lambda r: ("2 N", 2 * r.n)),
    Row("articulation", 'root = "id == 0"', linear, lambda r: ("2 E", 2 * r.e), time_bound=lambda r: ("2 E", 2 * r.e)),
    Row("snapshot", 'root = "id == 0"', lambda r: r.messages("marker"), lambda r: ("2 E", 2 * r.e),
        lambda r: r.last("under-way") - 11, lambda r: ("R + 1", r.far + 1)),
    Row("alternating_bit", 'say = { where = "id == 0", args = ["to be or not"] }', linear,
        lambda r: ("2 for each letter and link, without loss", 2 * 12 * r.graph.degree(0)), lambda r: r.last("ack") - 1,
        lambda r: ("2 for each letter", 24)),
    Row("luby", "", linear, lambda r: ("6 E for each of its rounds", 6 * r.e * max(r.greatest("chosen"), r.greatest("passed"))),
        time_bound=lambda r: ("3 for each of its O(log N) rounds", 3 * max(r.greatest("chosen"), r.greatest("passed")))),
    Row("fragments", "", linear, lambda r: ("5 N log2 N + 2 E", 5 * r.n * math.log2(r.n) + 2 * r.e),
        time_bound=lambda r: ("5 N log2 N", 5 * r.n * math.log2(r.n))),
    Row("echo_election", "", lambda r: r.linear + r.messages("leader"), lambda r: ("2 N E + 2 E", 2 * r.n * r.e + 2 * r.e),
        time_bound=lambda r: ("2 D + N", 2 * r.d + r.n)),
    Row("raymond", 'root = "id == 0"\nwants = "id % 10 == 3"', lambda r: r.messages("request", "privilege"),
        lambda r: ("2 D' for each entry", r.count("entered") * 2 * tree_diameter(r)),
        time_bound=lambda r: ("2 D' and 3 ticks for each entry", r.far + 1 + r.count("entered") * (2 * tree_diameter(r) + 3))),
    Row("gossip", 'root = "id == 0"', linear, lambda r: ("2 (N - 1 + patience N)", 2 * (r.n - 1 + 6 * r.n))),
    Row("reliable_broadcast", 'send = { where = "id == 0", args = [1, "hello"] }', linear,
        lambda r: ("2 E - (N - 1)", 2 * r.e - (r.n - 1)), time_bound=lambda r: ("R + 1", r.far + 1)),
    Row("stabilizing_tree", 'root = "id == 0"', lambda r: r.messages("chosen"), None, time_bound=lambda r: ("N + D", r.n + r.d)),
    Row("token_ring", "", lambda r: r.messages("value"), None, graph="ring(25)", options=("--ticks", "1000")),
    Row("byzantine", 'vote = [{ where = "id < 3", args = [0] }, { where = "id >= 3", args = [1] }]\n'
        '[[program]]\nwhere = "id == 1 || id == 5"\nfile = "byzantine_liar.meld"\n', linear,
        lambda r: ("3 (f + 1) N (N - 1)", 3 * 3 * 7 * 6), time_bound=lambda r: ("6 (f + 1)", 6 * 3),
        graph="complete(7)", options=("--set", "slowest={unit}")),
    Row("vector_clocks", "", linear, lambda r: ("none of its own: those of the system", 6 * r.n)),
    Row("dining_philosophers", "", linear, lambda r: ("2 for each meal at the two ends of a link", 2 * 2 * 3 * r.e)),
    Row("synchronizer", 'root = "id == 0"', linear, lambda r: ("2 E for each pulse, and 4 E", 16 * 2 * r.e + 4 * r.e),
        time_bound=lambda r: ("3 for each pulse", 3 * 16 + 2)),
    Row("link_reversal", 'destination = "id == 99"', lambda r: r.messages("height"), reversals),
    Row("k_core", "", lambda r: r.messages("core"), lambda r: ("the squares of the degrees", sum(d * d for _, d in r.graph.degree())),
        time_bound=lambda r: ("N", r.n), graph="scale_free(100, 3)"),
    Row("chandra_toueg", VOTES, lambda r: r.messages("told", "propose", "reply", "decide"),
        lambda r: ("3 (N - 1) for each round, and N (N - 1)", 3 * (r.n - 1) * (1 + r.greatest("told")) + r.n * (r.n - 1)),
        lambda r: r.last("decided") - 1, graph="complete(7)"),
    Row("paxos", VOTES.replace("vote", "proposes"), lambda r: r.messages("prepare", "promise", "accept", "vote", "decide"),
        lambda r: ("5 (N - 1)", 5 * (r.n - 1)), lambda r: r.last("decided") - 1, lambda r: ("5 of a leader alone", 5), graph="complete(7)"),
    Row("triangles", 'root = "id == 0"', lambda r: r.summary["stats"]["algorithm"]["messages"], None),
]


def run(meldsim, row, late, folder):
    name = f"{row.program}{len(late)}"
    world, program, facts = (folder / f"{name}.{kind}" for kind in ("toml", "meld", "facts"))
    world.write_text(f'lattice = "graph"\ngraph = "{row.graph}"\nseed = 1\n[facts]\n{row.facts}\n{late}')
    for other in re.findall(r'^file = "(.*)"', row.facts, re.M):
        shutil.copy(ROOT / "examples" / "meld" / other, folder)
    text = (ROOT / "examples" / "meld" / f"{row.program}.meld").read_text()
    program.write_text(text + "\ntype link-of(node, node).\nlink-of(A, B) :- neighbor(A, B).\n")
    command = [meldsim, "run", program, "--world", world, "--stats", "--json", "--facts-out", facts, "-I", ROOT / "examples" / "meld",
               *(word.format(unit=UNIT if late else 1) for word in row.options)]
    done = subprocess.run(command, env=environment_with({"CLAYMELD_CACHE": folder / "cache"}), capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    return Run(json.loads(done.stdout), facts.read_text().splitlines())


def within(what, number, bound, of):
    """The bound as it stands in the table: its formula, and what it comes to."""
    if bound is None:
        return "–"
    text, value = bound(of)
    assert number <= value, f"{what}: {number}, more than {text} = {value}"
    return f"{text} = {value:,.0f}"


def line(row, ideal, late):
    units = [row.time(ideal), row.time(late) / UNIT]
    bounds = {within(f"{row.program}: messages", row.messages(each), row.bound, each) for each in (ideal, late)}
    shown = within(f"{row.program}: messages", row.messages(late), row.bound, late)
    time_bound = within(f"{row.program}: time units", units[1], row.time_bound, late)
    within(f"{row.program}: rounds", units[0], row.time_bound, ideal)
    count = f"{row.messages(ideal):,}" if len(bounds) == 1 and row.messages(ideal) == row.messages(late) else \
        f"{row.messages(ideal):,}; late {row.messages(late):,}"
    times = ["does not end"] * 2 if "--ticks" in row.options else [f"{units[0]:,}", f"{units[1]:,.1f}"]
    section = SECTIONS.get(row.program, row.program)
    return f"| [{row.program}](#{section}) | {count} | {shown} | {times[0]} | {times[1]} | {time_bound} |\n"


def main():
    meldsim = sys.argv[1]
    with tempfile.TemporaryDirectory() as name, ThreadPoolExecutor(2) as pool:
        folder = pathlib.Path(name)
        runs = list(pool.map(lambda job: run(meldsim, *job, folder), [(row, late) for row in ROWS for late in ("", LATE)]))
        table = HEAD + "".join(line(row, ideal, late) for row, ideal, late in zip(ROWS, runs[::2], runs[1::2]))
    page = PAGE.read_text()
    before, rest = page.split(BEGIN)
    shown, after = rest.split(END)
    if "--update" in sys.argv:
        PAGE.write_text(before + BEGIN + table + END + after)
    elif shown != table:
        sys.exit(f"{PAGE}: the table of costs is another one now; review it, and write it with --update:\n{table}")
    print(table)


if __name__ == "__main__":
    main()
