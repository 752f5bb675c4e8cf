"""Clocks that give turns: turns_test.py --meldc PATH --meldsim PATH [unittest options]

Who acts in which tick is compared with a plain model of docs/networks.md, "Turns", on random graphs with random changes of priorities, on
any number of processes and through a checkpoint. A program is right under them that is wrong where all act at once.
"""
import math
import pathlib
import random
import re
import sys

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1]))

from frame import CAMPAIGN, Case, main  # noqa: E402

# What a node does with a message of so many hops is a fact: whom it sends the next one, and whose priority it changes.
PROGRAM = """{order}
type linear go(node, int).
type sends(node, int, node).
type asks(node, int, int, node, float).
type did(node, int).
{facts}
go(A, K) -o did(A, K), {{ B | sends(A, K, B), neighbor(A, B) | go(B, K - 1) }},
    {{ B, P | asks(A, K, 0, B, P) | set-priority(B, P) }},
    {{ B, P | asks(A, K, 1, B, P) | update-priority(B, P) }},
    {{ B, P | asks(A, K, 2, B, P) | add-priority(B, P) }},
    {{ B | asks(A, K, 3, B, _) | remove-priority(B) }},
    {{ B | asks(A, K, 4, B, _) | schedule-next(B) }},
    {{ B, P | asks(A, K, 5, B, P) | set-default-priority(B, P) }}.
"""
INDEPENDENT = """type linear undecided(node).
type in(node).
type out(node).
undecided(A).
undecided(A), neighbor(A, B), in(B) -o out(A).
undecided(A) -o in(A).
"""
LEAST = -math.inf


class Node:
    def __init__(self):
        self.lasting, self.passing, self.since = LEAST, None, None
        self.works, self.acted, self.messages = True, False, []

    def priority(self):
        return self.lasting if self.passing is None else self.passing

    def change(self, kind, value):
        if kind == 0:
            self.passing = value if value > self.priority() else self.passing
        elif kind == 2:
            self.passing = (0 if self.priority() == LEAST else self.priority()) + value
        elif kind == 5:
            self.lasting = value
        else:
            self.passing = {1: value, 3: None, 4: math.inf}[kind]


def model(sequential, upwards, links, first, sends, asks):
    """The facts did(node, hops) by the ticks in which they begin to hold, and how many catoms act in all."""
    nodes = [Node() for _ in range(len(links))]
    for node, hops in first:
        nodes[node].messages.append(hops)
    sign = -1 if upwards else 1
    changes, did, acts = [], {}, 0
    for tick in range(1, 10_000):
        for node, kind, value in changes:
            nodes[node].change(kind, sign * value)
        for n in nodes:
            if n.acted and not n.works:
                n.passing = None
            n.acted = False
            n.since = None if not n.works else tick if n.since is None else n.since
        claims = {i: (-n.priority(), n.since, i) for i, n in enumerate(nodes) if n.works}
        if not claims and not changes:
            return did, acts
        if sequential:
            turn = [min(claims, key=claims.get)] if claims else []
        else:
            turn = [i for i in claims if all(claims[i] < claims[j] for j in links[i] if j in claims)]
        changes, sent = [], []
        for i in sorted(turn):
            acts += 1
            nodes[i].works, nodes[i].acted, nodes[i].since = False, True, None
            messages, nodes[i].messages = sorted(nodes[i].messages), []
            for hops in messages:
                if not any((i, hops) in before for before in did.values()):
                    did.setdefault(tick, set()).add((i, hops))
                sent += [(j, hops - 1) for j in sends.get((i, hops), ())]
                for kind in range(6):
                    changes += [(j, k, value) for k, j, value in asks.get((i, hops), ()) if k == kind]
        for j, hops in sent:
            nodes[j].messages.append(hops)
            nodes[j].works = True
    raise AssertionError("the model does not come to rest")


class Turns(Case):
    def world(self, kind, rest):
        return self.write(f"{kind}.toml", f'{rest}[clock]\nkind = "{kind}"\n')

    def ticks(self, text):
        """The facts that a run tells of, by ticks."""
        did = {}
        for tick, node, hops in re.findall(r"^tick (\d+): .*: A = @(\d+), K = (\d+)$", text, re.MULTILINE):
            did.setdefault(int(tick), set()).add((int(node), int(hops)))
        return did

    def case(self, draw):
        n = draw.randint(2, 9)
        edges = {(i, i + 1) for i in range(n - 1)}
        edges |= {tuple(sorted(draw.sample(range(n), 2))) for _ in range(draw.randint(0, n))}
        links = [sorted({b for a, b in edges if a == i} | {a for a, b in edges if b == i}) for i in range(n)]
        hops = draw.randint(2, 6)
        first = sorted({(draw.randrange(n), hops) for _ in range(draw.randint(1, 3))})
        sends, asks = {}, {}
        for i in range(n):
            for k in range(1, hops + 1):
                if k > 1 and draw.random() < 0.9:
                    sends[i, k] = sorted(draw.sample(links[i], draw.randint(1, min(2, len(links[i])))))
                if draw.random() < 0.6:
                    # One of a kind, as the order among those of one is that of their bindings.
                    asks[i, k] = [(kind, draw.randrange(n), draw.randint(-3, 3))
                                  for kind in sorted(draw.sample(range(6), draw.randint(1, 2)))]
        links_of_world = ", ".join(f"[{a}, {b}]" for a, b in sorted(edges))
        return f'lattice = "graph"\nnodes = {n}\nlinks = [{links_of_world}]\n', links, first, sends, asks

    def write_program(self, first, sends, asks, order=""):
        facts = [f"go(@{a}, {k})." for a, k in first]
        facts += [f"sends(@{i}, {k}, @{j})." for (i, k), all_of in sends.items() for j in all_of]
        facts += [f"asks(@{i}, {k}, {kind}, @{j}, {float(value)})." for (i, k), all_of in asks.items() for kind, j, value in all_of]
        self.write("p.meld", PROGRAM.format(order=order, facts="\n".join(facts)))

    def test_who_acts_when_is_as_in_the_model(self):
        draw = random.Random(11)
        self.write("tell.meld", "tell(A, K) :- did(A, K).\n")
        for number in range(24 if CAMPAIGN else 9):
            graph, links, first, sends, asks = self.case(draw)
            sequential, upwards = number % 2 == 1, number % 3 == 0
            self.write_program(first, sends, asks, "priority @order asc." if upwards else "")
            world = self.world("sequential" if sequential else "priority", graph)
            expected, acts = model(sequential, upwards, links, first, sends, asks)
            for processes in (1, 2 + number % 3):
                with self.subTest(number=number, processes=processes):
                    out, _ = self.call("meldsim", "run", "p.meld", "--world", world, "--watch", "tell.meld", "-n", processes)
                    self.assertEqual(self.ticks(out), expected)
                    evaluations = next(line.split()[1] for line in out.splitlines() if line.strip().startswith("evaluations"))
                    self.assertEqual(int(evaluations.replace(",", "")), acts)

    def test_neighbours_do_not_decide_alike(self):
        self.write("p.meld", INDEPENDENT)
        never = ("--never", "in(A), neighbor(A, B), in(B)", "--expect", "not (in(A), out(A))")
        for lattice, size in (("square", "9, 7, 1"), ("hex", "6, 6, 1"), ("fcc", "4, 4, 3")):
            space = f'lattice = "{lattice}"\n[[body]]\nshape = "box({size})"\n'
            for kind in ("priority", "sequential"):
                world, facts = self.world(kind, space), set()
                for processes in (1, 2, 3):
                    with self.subTest(lattice=lattice, kind=kind, processes=processes):
                        out, _ = self.call("meldsim", "run", "p.meld", "--world", world, "-n", processes, "--quiet",
                                           "--facts-out", "-", *never)
                        facts.add(out)
                self.assertEqual(len(facts), 1)
            # Where all act at once they do.
            self.call("meldsim", "run", "p.meld", "--world", self.world("synchronous", space), *never[:2], code=3)

    def test_turns_go_on_after_a_checkpoint(self):
        draw = random.Random(5)
        for number in range(6 if CAMPAIGN else 2):
            graph, links, first, sends, asks = self.case(draw)
            self.write_program(first, sends, asks)
            world = self.world(("priority", "sequential")[number % 2], graph)
            whole, _ = self.call("meldsim", "run", "p.meld", "--world", world, "--digest", "-", "--quiet")
            for processes in (1, 2):
                with self.subTest(number=number, processes=processes):
                    folder = f"c{number}{processes}"
                    self.call("meldsim", "run", "p.meld", "--world", world, "--ticks", 3, "--checkpoint", folder,
                              "--digest", "d.txt", "--quiet", "-n", processes)
                    self.call("meldsim", "resume", folder, "--ticks", 10000, "--quiet")
                    self.assertEqual(self.read("d.txt").decode(), whole)

    def test_keys_of_other_clocks_are_errors(self):
        self.write("p.meld", INDEPENDENT)
        for kind in ("priority", "sequential"):
            world = self.world(kind, 'lattice = "square"\n[[body]]\nshape = "box(2, 2, 1)"\n')
            self.write("w.toml", self.read(world).decode() + "rate = 0.5\n")
            _, err = self.call("meldsim", "run", "p.meld", "--world", "w.toml", code=2)
            self.assertIn("`rate` says nothing of what is", err)


if __name__ == "__main__":
    main("meldc", "meldsim")
