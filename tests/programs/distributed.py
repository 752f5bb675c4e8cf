"""Distributed algorithms among the examples: a run of one in a world, and for each what must hold of it.

What it computes is compared with networkx or with what must hold of it, its messages with the bound in its paper.
"""

import collections
import math
import re
import sys

import networkx
from recorded import Recorded
from runner import Runner

# What a program is made to tell besides: the graph.
TELLING = """
type graph-node(node).
type graph-link(node, node).
graph-node(A).
graph-link(A, B) :- neighbor(A, B).
"""


def require(holds, otherwise):
    if not holds:
        raise AssertionError(otherwise)


class Case:
    """A world (or the name of one of the examples), facts and further sections of it, on how many processes and threads it runs (None: as
    other programs), and what the check has to know: `unit` is the longest time that a message may take, with the pause of its receiver,
    if that is more than a tick."""

    def __init__(self, world, facts="", options=(), events="", sizes=None, **known):
        self.world, self.facts_given, self.options, self.events, self.sizes = world, facts, options, events, sizes
        self.known = known
        self.unit = known.get("unit", 1)

    @property
    def name(self):
        return self.world if isinstance(self.world, str) else self.world.name

    def run(self, runner, examples):
        named = isinstance(self.world, str)
        text = (examples / self.world).read_text() if named else self.world.text(self.facts_given) + self.events
        programs = set(re.findall(r'^file = "(.*)"', text, re.M))
        path, plain = examples / self.world if named and not programs else runner.folder / "world.toml", None
        if path.parent == runner.folder:
            path.write_text(text)
        if programs:
            plain = runner.folder / "plain/world.toml"
            plain.parent.mkdir(exist_ok=True)
            plain.write_text(text)
        for name in programs:
            program = (examples / name).read_text()
            plain.with_name(name).write_text(program)
            (runner.folder / name).write_text(program + TELLING)
        outcome = runner.run_sizes(path, self.options, self.sizes, plain_world=plain)
        self.facts, self.summary = outcome.facts, outcome.summary
        self.graph = networkx.Graph()
        self.graph.add_nodes_from(a for a, in self.facts.pop("graph-node"))
        self.graph.add_edges_from(self.facts.pop("graph-link", []))
        self.links = {a: sorted(self.graph[a]) for a in self.graph}
        require(self.summary["ended"] == self.known.get("ended", "quiet"), f"the run ended with {self.summary['ended']}")
        require(self.known.get("drops") or self.summary["dropped_messages"] == 0, "messages were dropped")

    @property
    def root(self):
        return self.facts["root"][0][0]

    @property
    def reached(self):
        """The part of the graph that is connected to the root."""
        return self.graph.subgraph(networkx.node_connected_component(self.graph, self.root))

    @property
    def messages(self):
        return self.summary["linear_messages"]

    def parts(self):
        return [self.graph.subgraph(part) for part in networkx.connected_components(self.graph)]

    def map(self, predicate):
        rows = self.facts[predicate]
        found = {row[0]: row[1] if len(row) == 2 else row[1:] for row in rows}
        require(len(found) == len(rows), f"{predicate} has two facts at one catom")
        return found

    def expect(self, what, found, wanted):
        require(found == wanted, f"{what}: {found}, not {wanted}")

    def at_most(self, what, found, bound):
        require(found <= bound, f"{what}: {found}, more than {bound}")


def flood(graph):
    """What a flood costs: a message from every catom to all its neighbours but the one that it has it from."""
    return 2 * graph.number_of_edges() - (graph.number_of_nodes() - 1)


# ---- what must hold, for each program


def echo(case):
    case.expect("total", case.facts["total"], [(case.root, len(case.reached))])
    case.expect("messages", case.messages, 2 * case.reached.number_of_edges())
    check_tree(case, case.facts["parent"], case.reached)


def check_tree(case, links, graph):
    tree = networkx.Graph(links)
    tree.add_nodes_from([case.root])
    require(networkx.is_tree(tree) and set(tree) == set(graph), "the tree does not span the part of the root")
    require(all(graph.has_edge(*link) for link in tree.edges), "the tree has links where no catoms touch")
    return tree


def articulation(case):
    part = case.reached
    case.expect("cut", {a for a, in case.facts["cut"]}, set(networkx.articulation_points(part)))
    case.expect("links", {frozenset(link) for link in case.facts["cut-link"]}, {frozenset(link) for link in networkx.bridges(part)})
    case.expect("finished", case.facts["finished"], [(case.root,)])
    case.expect("messages", case.messages, 2 * part.number_of_edges())
    # The token is in one place: its messages come one after the other. The first and the last evaluation take a tick.
    case.at_most("ticks", case.summary["ticks"], 2 * part.number_of_edges() * case.unit + 2 * case.unit)


def diffusing(case):
    def length(a, b, _):
        return 1 + (a * b + a + b) % 9

    case.expect("dist", case.map("dist"), networkx.single_source_dijkstra_path_length(case.graph, case.root, weight=length))
    case.expect("done", case.facts["done"], [(case.root,)])
    case.expect("neutral", {a for a, in case.facts["neutral"]}, set(case.graph) - {case.root})
    counts = {row["predicate"].split("/")[0]: row for row in case.summary["stats"]["predicates"]}
    case.expect("acknowledgements", counts["ack"]["messages"], counts["offer"]["messages"])
    for name in ("offer", "ack", "dist"):
        case.at_most(f"the last tick of {name}", counts[name]["last_active_tick"], counts["done"]["last_active_tick"])


def snapshot(case):
    recorded, under_way = case.map("recorded"), case.facts["under-way"]
    total = 100 * len(case.reached)
    case.expect("recorded at", set(recorded), set(case.reached))
    case.expect("links", sorted(row[:2] for row in under_way), sorted(p for a, b in case.reached.edges for p in ((a, b), (b, a))))
    case.expect("money", sum(recorded.values()) + sum(row[2] for row in under_way), total)
    case.expect("money in the end", sum(case.map("balance").values()), 100 * len(case.graph))
    payments = 40 * sum(1 for others in case.links.values() if others)
    case.expect("messages", case.messages, payments + 2 * case.reached.number_of_edges())
    going_on = any(row[2] for row in under_way) and set(recorded.values()) != {100}
    require(going_on or len(case.reached) < 40 or case.unit > 1, "nothing was going on")


def alternating_bit(case):
    text = case.map("say")
    received = {(a, b): t for a, b, t, _ in case.facts["received"]}
    wanted = {(a, b): text.get(b, "") for b, others in case.links.items() for a in others}
    if case.known.get("garbled"):
        require(received != wanted, "every letter has come in order, though frames overtake each other")
        return
    case.expect("received", received, wanted)
    letters = sum(len(t) for t in received.values())
    least = 2 * letters
    if case.known["loss"]:
        # What arrives: an answer to each frame that arrives, less those that are lost.
        require(case.messages > least, "nothing was sent twice")
        share = 1 - case.known["loss"] / 100
        case.at_most("messages", case.messages, 2 * letters * (1 / share ** 2 + 1 / share))
    elif case.unit == 1:
        case.expect("messages", case.messages, least)
    else:
        # A frame is repeated every ten ticks until its answer is back.
        require(case.messages >= least, "letters came without messages")
        case.at_most("messages", case.messages, least * (1 + (2 * case.unit + 2) // 10))


def luby(case):
    chosen, passed = case.map("chosen"), case.map("passed")
    require(set(chosen) | set(passed) == set(case.graph) and not set(chosen) & set(passed), "a catom has not decided once")
    for a, others in case.links.items():
        require((a in chosen) != any(b in chosen for b in others), f"@{a} is not chosen exactly if none of its neighbours is")
    rounds = max([*chosen.values(), *passed.values()])
    case.at_most("rounds", rounds, 2 * math.log2(len(case.graph)) + 2)
    case.at_most("messages", case.messages, 3 * rounds * 2 * case.graph.number_of_edges())
    case.expect("leavings", {name for name, rows in case.facts.items() if rows} - {"chosen", "passed"}, set())


def fragments(case):
    for a, b in case.graph.edges:
        case.graph.edges[a, b]["weight"] = (a + b) * 37 % 101 * 1_000_000 + max(a, b) * 1000 + min(a, b)
    wanted = networkx.minimum_spanning_tree(case.graph)
    case.expect("tree", sorted(case.facts["tree"]), sorted(link for a, b in wanted.edges for link in ((a, b), (b, a))))
    levels = {a: level for a, (level, _) in case.map("fragment").items()}
    bound = 0
    for part in case.parts():
        n = len(part)
        bound += 5 * n * math.log2(n) + 2 * part.number_of_edges()
        case.at_most("level", max(levels[a] for a in part), math.log2(n))
        finished = [a for a, in case.facts["finished"] if a in part]
        require(len(finished) == (2 if n > 1 else 0) and (n == 1 or part.has_edge(*finished)), f"{finished} have finished")
    case.at_most("messages", case.messages, bound)


def token_ring(case):
    privileged = [{a for a, holds in enumerate(step) if holds == 1} for step in Recorded(case.known["recording"]).values("privileged")]
    settle, lap = case.known["settle"], case.known["lap"]
    case.expect("steps", len(privileged), 2 * settle + 2 * lap + 1)
    for begin in (0, settle + lap):
        require(any(len(held) > 1 for held in privileged[begin:begin + settle]), "the ring was stable from the start")
        after = privileged[begin + settle:begin + settle + lap]
        require(all(len(held) <= 1 for held in after), "two have the privilege")
        case.expect("had the privilege in a lap", set().union(*after), set(case.graph))


def stabilizing_tree(case):
    hops = networkx.single_source_shortest_path_length(case.graph, case.root)
    chosen = {a: (hop, parent) for a, _, hop, parent in case.facts["chosen"]}
    alone = {a for a in case.graph if a != case.root and not case.links[a]}
    case.expect("catoms", set(chosen), set(case.graph))
    count = len(case.graph)
    for a in set(chosen) - alone:
        hop, parent = chosen[a]
        case.expect(f"hops of @{a}", hop, hops.get(a, count))
        near = [case.root] if a == case.root else [b for b in case.links[a] if hops.get(b, count) in (hop - 1, count)]
        require(parent in near, f"@{parent} is the parent of @{a}")
    start = 300 if "tap" in case.events else 1
    # A correction takes a tick, or waits for the clock, before the next one.
    step = case.unit + (case.unit > 1)
    case.at_most("rounds", case.summary["ticks"] - start, (count + max(hops.values()) + 4) * step)


def gossip(case):
    knows = case.map("knows")
    require(case.root in knows and networkx.is_connected(case.graph.subgraph(knows)), "the rumour has leapt")
    require(all(hop == 0 or any(knows.get(b) == hop - 1 for b in case.links[a]) for a, hop in knows.items()), "hops are not one more")
    told = len(knows) - 1 + case.known["patience"] * len(knows) if len(case.reached) > 1 else 0
    case.expect("messages", case.messages, 2 * told)


def reliable_broadcast(case):
    if case.known.get("killed"):
        # Those that were left have all accepted a message, or none has.
        require(networkx.is_connected(case.graph), "the test is to leave one part")
        accepted = collections.Counter(row[1:] for row in case.facts["accepted"])
        require(set(accepted.values()) <= {len(case.graph)}, f"accepted by {accepted}")
        case.at_most("messages accepted", len(accepted), case.known["sent"])
        return
    if isinstance(case.world, str):
        wanted = {"last words", "hello", "hello again"}
        for a in case.graph:
            case.expect(f"accepted at @{a}", sorted(row[3] for row in case.facts["accepted"] if row[0] == a), sorted(wanted))
        return
    wanted, messages = [], 0
    for part in case.parts():
        sent = [(a, 1, "one") for a in part if a % 20 == 0] + [(0, 2, "two")] * (0 in part)
        wanted += [(a, *message) for a in part for message in sent]
        messages += len(sent) * flood(part)
    case.expect("accepted", sorted(case.facts["accepted"]), sorted(wanted))
    case.expect("messages", case.messages, messages)


def raymond(case):
    wants = {a for a, in case.facts["wants"]} & set(case.reached)
    entered = case.facts["entered"]
    case.expect("entries", sorted(n for _, n in entered), list(range(1, 2 * len(wants) + 1)))
    case.expect("entries of each", collections.Counter(a for a, _ in entered), {a: 2 for a in wants})
    case.expect("privileges", len(case.facts["privilege"]), 1)
    tree = check_tree(case, [row[:2] for row in case.facts["towards"]], case.reached)
    case.at_most("messages", case.messages, flood(case.reached) + len(entered) * 2 * networkx.diameter(tree))


def echo_election(case):
    case.expect("leader", case.map("leader"), {a: max(part) for part in case.parts() for a in part})
    case.expect("following", {a: of for a, (of, _, _) in case.map("following").items()},
                {a: max(part) for part in case.parts() for a in part if a != max(part)})
    case.at_most("messages", case.messages, sum(2 * len(part) * part.number_of_edges() for part in case.parts()))
    case.expect("messages that tell the result", case.summary["exported_changes"], len(case.graph))


def flood_election(case):
    case.expect("best", case.map("best"), {a: max(part) for part in case.parts() for a in part})


def triangles(case):
    corners = networkx.triangles(case.graph)
    case.expect("corners", case.map("corners"), corners)
    clustering, wanted = case.map("clustering"), networkx.clustering(case.graph)
    case.expect("catoms with pairs of neighbours", set(clustering), {a for a, others in case.links.items() if len(others) > 1})
    require(all(math.isclose(c, wanted[a]) for a, c in clustering.items()), "other clustering coefficients")
    case.expect("triangles", case.facts["triangles"], [(case.root, sum(corners[a] for a in case.reached) // 3)])


def byzantine(case):
    liars = {a for a, in case.facts["liar"]}
    vote, decided = case.map("vote"), case.map("decided")
    honest = [[a for a in part if a not in liars] for part in case.parts()]
    split = [part for part in honest if len({decided[a] for a in part}) > 1
             or len({vote[a] for a in part}) == 1 and decided[part[0]] != vote[part[0]]]
    require(bool(split) == case.known["fails"], f"{len(split)} of {len(honest)} groups do not agree: {split[:3]}")
    case.at_most("messages", case.messages,
                 sum(3 * ((len(part) - 1) // 3 + 1) * len(part) * (len(part) - 1) for part in case.parts()))


def leader(case):
    """Which finds the connected parts as well."""
    case.expect("leader", case.map("leader"), {a: max(part) for part in case.parts() for a in part})
    case.expect("elected", {a for a, in case.facts["elected"]}, {max(part) for part in case.parts()})


def pagerank(case):
    rounds, ranks = 30, dict.fromkeys(case.graph, 1.0)
    for _ in range(rounds):
        ranks = {a: 0.15 + 0.85 * sum(ranks[b] / len(case.links[b]) for b in others) if others else 1.0 for a, others in case.links.items()}
    found = case.map("rank")
    case.expect("rounds", {a: row[0] for a, row in found.items()}, {a: rounds if others else 0 for a, others in case.links.items()})
    alike(case, {a: row[1] for a, row in found.items()}, ranks, 1e-9)
    if all(case.links.values()):
        # A round leaves 0.85 of what all ranks together are off, which is most in a star.
        wanted = {a: len(ranks) * rank for a, rank in networkx.pagerank(case.graph, tol=1e-12, max_iter=500).items()}
        alike(case, ranks, wanted, 0.85 ** rounds * sum(abs(1 - rank) for rank in wanted.values()) + 1e-9)


def pagerank_async(case):
    if all(case.links.values()):
        wanted = networkx.pagerank(case.graph, tol=1e-12, max_iter=500)
        residue = sum(case.map("residue").values())
        alike(case, case.map("rank"), {a: len(wanted) * rank for a, rank in wanted.items()}, residue / 0.15 + 1e-6)
    else:
        case.expect("catoms with a rank", set(case.map("rank")), set(case.graph))


def alike(case, found, wanted, apart):
    case.expect("catoms", set(found), set(wanted))
    worst = max(wanted, key=lambda a: abs(found[a] - wanted[a]))
    require(abs(found[worst] - wanted[worst]) <= apart, f"@{worst} has {found[worst]}, not {wanted[worst]}")


def judge_all(meldsim, examples, program, folder, cases):
    """Runs them one after the other, and says what came of each; ends with a message at the first that is not as it must be."""
    runner = Runner(meldsim, examples / f"{program}.meld", folder, TELLING)
    for case in cases:
        try:
            case.run(runner, examples)
            globals()[program](case)
        except AssertionError as error:
            sys.exit(f"{program} in {case.name}: {error}")
        print(f"{case.name}: {case.summary['catoms']} catoms, {case.graph.number_of_edges()} links, {case.summary['ticks']} ticks, "
              f"{case.messages} linear messages, {case.summary['exported_changes']} exported changes")
