"""Runs an algorithm of the textbooks under several networks, clocks and crashes: textbook_test.py MELDSIM EXAMPLES PROGRAM.

Its outcome is compared with networkx or a plain computation here, and what must never hold is watched in every tick. The same judge must
refuse a program that is broken in one place, or else it would see nothing.
"""

import itertools
import math
import pathlib
import random
import sys
import tempfile

import networkx
from conditions_test import CHANCE, DRIFT, HARSH, IDEAL, LATE, LOSSY, GraphWorld
from distributed import TELLING, Case, require
from runner import CAMPAIGN, Runner

SEEDS = range(8 if CAMPAIGN else 1)
ANY = (IDEAL, LATE, LOSSY, CHANCE, DRIFT, HARSH)
# All are connected.
GRAPHS = ("small_world(40, 4, 0.2)", "complete(9)", "tree(40, 3)", "hypercube(5)", "ring(15)", "scale_free(50, 3)")


def worlds(conditions, facts="", graphs=GRAPHS, options=(), **known):
    """All conditions, each in one graph, or, in the campaign, in all of them."""
    pairs = itertools.product(graphs, conditions) if CAMPAIGN else zip(itertools.cycle(graphs), conditions)
    for number, ((graph, condition), seed) in enumerate(itertools.product(pairs, SEEDS)):
        yield Case(GraphWorld(graph), facts, ("--seed", str(number), *options), condition.text, unit=condition.unit, pause=condition.pause,
                   **known)


# ---- vector clocks


def vector_clocks_cases():
    return worlds(ANY)


def vector_clocks(case):
    clock = {(a, n): c for a, n, c, _, _ in case.facts["event"]}
    causes = networkx.DiGraph([((a, n - 1), (a, n)) for a, n in clock if n > 1])
    causes.add_nodes_from(clock)
    causes.add_edges_from(((b, m), (a, n)) for a, n, _, b, m in case.facts["event"] if m)
    case.expect("events", set(causes), set(clock))
    later = {event: networkx.descendants(causes, event) for event in clock}
    for one, other in itertools.permutations(clock, 2):
        before = all(c <= d for c, d in zip(clock[one], clock[other])) and clock[one] != clock[other]
        require(before == (other in later[one]), f"{one} with {clock[one]} and {other} with {clock[other]}")
    case.expect("messages", case.messages, 6 * len(case.graph))


# ---- dining philosophers


def dining_philosophers_cases():
    return worlds(ANY, options=("--never", "eating(A, _), neighbor(A, B), eating(B, _)"))


def dining_philosophers(case):
    case.expect("meals", sorted(case.facts["ate"]), [(a, n) for a in sorted(case.graph) for n in (1, 2, 3)])
    case.expect("forks", sorted(tuple(sorted(row[:2])) for row in case.facts["fork"]), sorted(tuple(sorted(e)) for e in case.graph.edges))
    case.at_most("messages", case.messages, 2 * 3 * 2 * case.graph.number_of_edges())


# ---- the synchronizer

PULSES = 16


def synchronizer_cases():
    return worlds(ANY, 'root = "id == 3"')


def synchronizer(case):
    hops = networkx.single_source_shortest_path_length(case.graph, case.root)
    found = case.map("hop")
    case.expect("hops", {a: hop for a, (hop, _) in found.items()}, hops)
    for a, (hop, parent) in found.items():
        require(a == parent == case.root or parent in case.links[a] and hops[parent] == hop - 1, f"@{parent} is the parent of @{a}")
    # In each pulse all are safe; the search and its acknowledgements go once over each link in each direction.
    case.expect("messages", case.messages, (PULSES + 2) * 2 * case.graph.number_of_edges())
    step = case.unit + (case.unit > 1)
    case.at_most("ticks", case.summary["ticks"], (3 * PULSES + 2) * step)


# ---- link reversal


def link_reversal_cases():
    facts = 'destination = "id == 8"'
    # Lossy links that are down have no heights, and HARSH takes long.
    for partial in ("false", "true"):
        yield from worlds(ANY, facts, options=("--set", f"partial={partial}"), partial=partial == "true")
    for seed in SEEDS:
        cut = '[[event]]\ntick = 90\ncut = [[0, 1], [8, 9], [20, 21], [8, 7], [30, 31]]\n'
        yield Case(GraphWorld("small_world(40, 6, 0.3)"), facts, ("--seed", str(seed)), LATE.text + cut, drops=True, cut=True)


def link_reversal(case):
    heights = {a: (x, y, a) for a, _, x, y in case.facts["height"]}
    rises = {a: n for a, n, _, _ in case.facts["height"]}
    case.expect("lower", set(case.facts["lower"]), {(a, b) for a, others in case.links.items() for b in others if heights[b] < heights[a]})
    case.expect("catoms without a way down", {a for a in case.graph if all(heights[b] > heights[a] for b in case.links[a])}, {8})
    if case.known.get("cut"):
        return
    wanted, count, bad = reversals(case)
    case.expect("rises", rises, count)
    if not case.known["partial"]:
        case.expect("heights", heights, wanted)
    case.at_most("rises in all", sum(rises.values()), bad ** 2)


def reversals(case):
    """One catom after the other rises, always the first that can: heights, how often each has risen, and how many had no way down."""
    height, count = {a: (0, 0, a) for a in case.graph}, dict.fromkeys(case.graph, 0)
    down = networkx.DiGraph([(max(link), min(link)) for link in case.graph.edges])
    bad = len(case.graph) - 1 - len(networkx.ancestors(down, 8))
    while sinks := [a for a in case.graph if a != 8 and all(height[b] > height[a] for b in case.links[a])]:
        a = sinks[0]
        near, y = [height[b] for b in case.links[a]], height[a][1]
        if case.known["partial"]:
            x = min(near)[0] + 1
            height[a] = (x, min([w for v, w, _ in near if v == x], default=y + 1) - 1, a)
        else:
            height[a] = (max(near)[0] + 1, y, a)
        count[a] += 1
    return height, count, bad


# ---- core numbers


def k_core_cases():
    return worlds(ANY, graphs=("scale_free(70, 3)", "random(60, 0.08)", "club.txt", "geometric(60, 0.2)", "novel.txt", "tree(40, 3)"))


def k_core(case):
    case.expect("core", case.map("core"), networkx.core_number(case.graph))


# ---- failure detector and agreement with it


def failure_detector_cases():
    slow = '[[network.region]]\nwhere = "id % 7 == 0"\nleast = 1\nmost = 40\n'
    for seed in SEEDS:
        hung = random.Random(seed).sample(range(40), 4)
        for network, most in ((LATE.text + slow, 40), ("", 1), (LOSSY.text, 34)):
            yield Case(GraphWorld("small_world(40, 4, 0.2)"), "", ("--seed", str(seed), "--ticks", "1500"),
                       f"{network}[[event]]\ntick = 100\nhang = {hung}\n", ended="ticks", hung=set(hung), most=most)


def failure_detector(case):
    rows = [row for row in case.facts["watched"] if row[0] not in case.known["hung"]]
    case.expect("watched", {row[:2] for row in rows},
                {(a, b) for a, others in case.links.items() if a not in case.known["hung"] for b in others})
    case.expect("suspects", {row[:2] for row in rows if row[4]}, {row[:2] for row in rows if row[1] in case.known["hung"]})
    # A heartbeat comes every four ticks; between two of them at most the longest delay more.
    case.at_most("limit", max(row[3] for row in rows), math.ceil(case.known["most"] / 4) + 2)


def crashes(count, draw):
    """Fewer than half hang, each at a time when the others are at work: the events, and who."""
    hung = draw.sample(range(count // 2 + 1), draw.randrange(1, (count + 1) // 2))
    return "".join(f"[[event]]\ntick = {draw.randrange(2, 40)}\nhang = [{a}]\n" for a in hung), set(hung)


def chandra_toueg_cases():
    for seed, condition in itertools.product(range(20 if CAMPAIGN else 2), (IDEAL, LATE, LOSSY, CHANCE, DRIFT)):
        draw = random.Random(f"{seed} {condition}")
        events, hung = crashes(9, draw)
        facts = "vote = [" + ", ".join(f'{{ where = "id == {a}", args = [{draw.randrange(4)}] }}' for a in range(9)) + "]"
        yield Case(GraphWorld("complete(9)"), facts, ("--seed", str(seed), "--set", "patience=0",
                    "--never", "decided(A, V), decided(B, W), V < W"),
                   condition.text + events, hung=hung)


def chandra_toueg(case):
    agreement(case, "vote")


def paxos_cases():
    # Two catoms never hear of the leader, and the others no more from one of the ticks on in which a leader alone is done.
    facts = 'proposes = [{ where = "id == 0", args = [1] }, { where = "id > 0", args = [2] }]'
    for seed, tick, far in itertools.product(SEEDS, range(2, 9), ("id < 3", "id > 2")):
        crash = (f'[network]\nkind = "raw"\n[[event]]\ntick = 1\njam = {{ between = ["id == 0", "{far}"], ticks = 30 }}\n'
                 f'[[event]]\ntick = {tick}\nhang = [0]\njam = {{ where = "id == 0", ticks = 5 }}\n')
        yield paxos_case(5, facts, crash, seed, {0}, sizes=[(1, 1)])
    # What the leader asks for comes late, when others try.
    for seed, ticks in itertools.product(SEEDS, range(8, 16)):
        late = f'[network]\nkind = "latency"\nmost = 1\n[[event]]\ntick = 3\njam = {{ where = "id == 0", ticks = {ticks} }}\n'
        yield paxos_case(5, facts, late, seed, set(), "--set", "patience=10", sizes=[(1, 1)])
    raw = '[network]\nkind = "raw"\nmost = 6\nloss = 0.2\nduplicate = 0.2\nreorder = true\n'
    jammed = '[network]\nkind = "raw"\nmost = 30\nloss = 0.5\nreorder = true\n'
    slow = '[network]\nkind = "raw"\nmost = 200\nreorder = true\n'     # Who tries next does not wait for the one before.
    for seed, text in itertools.product(range(20 if CAMPAIGN else 2), (IDEAL.text, LATE.text, raw, jammed, slow, CHANCE.text)):
        draw = random.Random(f"{seed} {text}")
        count = draw.choice((3, 5, 8))
        events, hung = crashes(count, draw)
        facts = "proposes = [" + ", ".join(f'{{ where = "id == {a}", args = [{draw.randrange(4)}] }}' for a in range(count)) + "]"
        yield paxos_case(count, facts, text + events, seed, hung)


def paxos_case(count, facts, text, seed, hung, *options, sizes=None):
    options = ("--seed", str(seed), "--never", "decided(A, V), decided(B, W), V < W", *options)
    return Case(GraphWorld(f"complete({count})"), facts, options, text, sizes=sizes, hung=hung, drops=True)


def paxos(case):
    agreement(case, "proposes")


def agreement(case, proposed):
    decided = case.facts["decided"]
    require(case.known["hung"] < set(case.graph), "the test is to leave some")
    case.expect("decided once", len({a for a, _ in decided}), len(decided))
    require({a for a, _ in decided} >= set(case.graph) - case.known["hung"], f"not all that are alive have decided: {decided}")
    values = {value for _, value in decided}
    require(len(values) == 1 and values <= {v for _, v in case.facts[proposed]}, f"{values} are decided")


# ---- routing

# Links break, and some of them come back; in the second graph the loss divides it.
BROKEN = '[[event]]\ntick = 150\ncut = { between = ["id % 5 == 0", "id % 3 == 1"] }\n[[event]]\ntick = 400\nheal = "id < 10"\n'
DIVIDED = '[[event]]\ntick = 150\ncut = { between = ["id < 20", "id >= 20"] }\n'


def routing_cases():
    for seed, (graph, events) in itertools.product(SEEDS, (("geometric(40, 0.25)", BROKEN), ("small_world(40, 4, 0.1)", DIVIDED))):
        for condition in (LATE, DRIFT) if seed % 2 == 0 else (IDEAL, LOSSY):
            yield Case(GraphWorld(graph), "", ("--seed", str(seed)), condition.text + events, drops=True)


distance_vector_cases = link_state_cases = routing_cases


def distance_vector(case):
    shortest(case, [row for row in case.facts["route"] if row[2] < 100])
    require(all(row[2] <= 100 for row in case.facts["route"]), "a distance beyond infinity")


def link_state(case):
    shortest(case, case.facts["route"])


def shortest(case, routes):
    def length(a, b, _=None):
        return 1 + (a * b + a + b) % 9

    distance = dict(networkx.all_pairs_dijkstra_path_length(case.graph, weight=length))
    case.expect("routes", {row[:2]: row[2] for row in routes}, {(a, b): d for a, near in distance.items() for b, d in near.items()})
    for a, to, d, via in routes:
        require(a == to or via in case.links[a] and d == length(a, via) + distance[via][to], f"@{a} sends to @{to} through @{via}")


# ---- one place of each program, and what breaks it; in some, several

BREAKS = {
    "vector_clocks": ("counted(later(C, D), ", "counted(C, "),
    "dining_philosophers": ("hungry(A, N), missing(A, 0) -o missing(A, 0)", "hungry(A, N), missing(A, M), M < 2 -o missing(A, M)"),
    # Without acknowledgements it would still be right: links keep the order of messages.
    "synchronizer": ("waiting(A, P, 0) -o", "waiting(A, P, _) -o"),
    "link_reversal": ("known(A, N), not lower", "N > 0, known(A, _), not lower"),
    "k_core": ("neighborCount(A, llength(L))", "llength(L) > 0"),
    "failure_detector": ("watched(A, B, 0, L + 1, false)", "watched(A, B, 0, L, false)"),
    "chandra_toueg": ("adopters(A, R, N), 2 * N > @world", "adopters(A, R, N), N > 0"),
    "paxos": (("if K < 0 then V else W end", "if K < 0 then V else V end"),
              ("votes(A, N, V, C), 2 * C > @world", "votes(A, N, V, C), C > 0"),
              ("promises(A, N, C), 2 * C > @world", "promises(A, N, C), C > 0"),
              ("acceptor(A, M, _, _), N >= M", "acceptor(A, M, _, _), N >= 0 || N > M")),
    "distance_vector": ("max int Number", "min int Number"),
    "link_state": ("max int Time", "min int Time"),
}


def judge(program, runner, examples, cases):
    for case in cases:
        case.options = (*case.options, "-I", str(examples))
        try:
            case.run(runner, examples)
            globals()[program](case)
        except AssertionError as error:
            raise AssertionError(f"{program} in {case.name} with {case.options}:\n{case.events}{error}") from error
        print(f"{case.name}: {case.summary['catoms']} catoms, {case.graph.number_of_edges()} links, {case.summary['ticks']} ticks, "
              f"{case.messages} linear messages, {case.summary['exported_changes']} exported changes")


def breaks(program):
    found = BREAKS[program]
    return [found] if isinstance(found[0], str) else found


def refuses(program, right, wrong, folder, meldsim, examples, cases):
    """Whether the judge refuses the broken program in one of the worlds."""
    text = (examples / f"{program}.meld").read_text()
    require(right in text, f"{program}.meld has no '{right}' that could be broken")
    broken = folder / "broken" / f"{program}.meld"
    broken.parent.mkdir(exist_ok=True)
    broken.write_text(text.replace(right, wrong))
    runner = Runner(meldsim, broken, folder, TELLING)
    for case in cases:
        case.sizes = [(1, 1)]
        if "--ticks" not in case.options:
            # Where it goes round in circles, that is wrong as well.
            case.options = (*case.options, "--limit", "ticks=5000")
        try:
            judge(program, runner, examples, [case])
        except (AssertionError, SystemExit) as error:
            print(f"broken, it is refused: {str(error)[-300:]}")
            return True
    return False


def main():
    meldsim, examples, program = sys.argv[1], pathlib.Path(sys.argv[2]), sys.argv[3]
    with tempfile.TemporaryDirectory() as name:
        folder = pathlib.Path(name)
        for graph, text in (("club", networkx.karate_club_graph()), ("novel", networkx.les_miserables_graph())):
            networkx.write_edgelist(text, folder / f"{graph}.txt", data=False)
        cases = globals()[f"{program}_cases"]
        try:
            judge(program, Runner(meldsim, examples / f"{program}.meld", folder, TELLING), examples, cases())
            for right, wrong in breaks(program):
                require(refuses(program, right, wrong, folder, meldsim, examples, cases()), f"with '{wrong}', and nobody notices")
        except AssertionError as error:
            sys.exit(str(error))


if __name__ == "__main__":
    main()
