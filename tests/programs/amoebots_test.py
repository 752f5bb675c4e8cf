"""Amoebots against a plain model of the papers' rules (amoebots.py), on several processes and threads.

Wishes: random requests, several of one amoebot and tick. After each tick everything that amoebots sense is as in the model, and so are the
counts of moves and refusals. A run that goes on from a checkpoint ends alike.
Walks: each amoebot that is activated asks for a random move. Whoever is activated in one tick has no neighbour or cell in common with
another who is, and rounds are fair.

Usage: amoebots_test.py MELDSIM [FIRST_SEED [SEEDS]]
"""

import collections
import json
import random
import re
import shutil
import subprocess
import sys

from amoebots import CODES, Amoebots, Compass, Request, step
from seeds import Divided

TICKS = 24
SENSED = """type linear was(node, int, int, int).
type linear tailed(node, int, int).
type linear headed(node, int, int).
type linear two(node, int).
type linear touched(node, int, int, node, int, int).
type linear free(node, int, int).
type linear beside(node, int, node).
type linear counted(node, int, int).
type linear calm(node, int).
type linear open(node, int, int).
type linear met(node, int, int, node).
tick(A, T), cell(A, X, Y, _) -o was(A, T, X, Y).
tick(A, T), tail(A, D) -o tailed(A, T, D).
tick(A, T), head(A, D) -o headed(A, T, D).
tick(A, T), expanded(A) -o two(A, T).
tick(A, T), port(A, P, B, Q, N) -o touched(A, T, P, B, Q, N).
tick(A, T), vacant(A, P) -o free(A, T, P).
tick(A, T), neighbor(A, B) -o beside(A, T, B).
tick(A, T), neighborCount(A, N) -o counted(A, T, N).
tick(A, T), not port(A, _, _, _, 2) -o calm(A, T).
tick(A, T), P = T % 14 - 1, vacant(A, P) -o open(A, T, P).
tick(A, T), P = T % 14 - 1, port(A, P, B, _, _) -o met(A, T, P, B).
"""
WISHES = SENSED + "type linear lost(node, int, int).\nfailed(A, K), tick(A, T) -o lost(A, T, K).\n"
for name in ("expand", "push", "pull"):
    WISHES += f"type linear wants-{name}(node, int, int).\nwants-{name}(A, T, P), tick(A, T) -o {name}(A, P).\n"
WISHES += "type linear wants-contract(node, int, string).\nwants-contract(A, T, E), tick(A, T) -o contract(A, E).\n"
WALKS = SENSED + """type linear acted(node, int).
type linear moves(node, int).
activated(A), tick(A, T) -o acted(A, T), moves(A, randint(12)).
moves(A, P), expanded(A), P < 2 -o contract(A, "head").
moves(A, P), expanded(A), P = 2 -o contract(A, "tail").
moves(A, P), expanded(A) -o pull(A, P).
moves(A, P), P < 6, vacant(A, P) -o expand(A, P).
moves(A, P), P < 6 -o push(A, P).
moves(A, P) -o 1.
"""


def grown(rng):
    """Cells of an ensemble, most of them connected, across corners of bricks."""
    cells = {rng.choice([(0, 0), (31, 15), (30, -1)])}
    wanted = rng.randint(2, 30)
    while len(cells) < wanted:
        start = rng.choice(sorted(cells))
        cells.add(step(start, rng.randrange(6)) if rng.random() < 0.95 else (start[0] + rng.choice([-3, 2, 40]), start[1] + 2))
    return sorted(cells)


def world(seed, activation=None):
    rng = random.Random(seed)
    cells = grown(rng)
    facts = collections.defaultdict(list)
    for x, y in cells if activation is None else []:
        for tick in range(1, TICKS):
            for _ in range(rng.choice([0, 1, 1, 1, 2, 3])):
                name = rng.choice(["expand", "expand", "contract", "push", "pull", "pull"])
                argument = rng.choice(['"head"', '"tail"', '"head"', '"foot"'][: rng.choice([3, 3, 4])]) if name == "contract" \
                    else rng.randint(-1 if rng.random() < 0.1 else 0, 12 if name == "pull" else 6 if rng.random() < 0.1 else 5)
                facts[f"wants-{name}"].append(f'{{ where = "cell == ({x}, {y}, 0)", args = [{tick}, {argument}] }}')
    lines = ['lattice = "hex"', f"seed = {seed + 7}", "[[body]]", f"cells = [{', '.join(f'[{x}, {y}]' for x, y in cells)}]"]
    lines += ["[motion]", 'kind = "amoebot"']
    lines += [f'activation = "{activation}"'] if activation else []
    lines += [f'{key} = "own"' for key in ("compass", "chirality") if rng.random() < 0.7]
    lines += ["keep_connected = true"] if rng.random() < 0.4 else []
    lines += ["[facts]"] + [f"{name} = [{', '.join(given)}]" for name, given in facts.items()]
    return "\n".join(lines) + "\n"


def read(facts, name):
    """The facts of a predicate, each as numbers."""
    return [tuple(int(word.strip(" @")) for word in found.split(",")) for found in re.findall(rf"^{name}\(([^)]*)\)", facts, re.M)]


def sensed(model, tick):
    """What amoebots of the model sense, as facts."""
    rows = collections.Counter()
    for amoebot, (head, tail) in model.shape.items():
        rows["was", amoebot, tick, *head] += 1
        if head != tail:
            direction = next(d for d in range(6) if step(tail, model.compass[amoebot].lattice(d)) == head)
            rows["headed", amoebot, tick, direction] += 1
            rows["tailed", amoebot, tick, (direction + 3) % 6] += 1
            rows["two", amoebot, tick] += 1
        others = model.touches(amoebot)
        for port, other, there, count in others:
            rows["touched", amoebot, tick, port, other, there, count] += 1
        for other in {other for _, other, _, _ in others}:
            rows["beside", amoebot, tick, other] += 1
        rows["counted", amoebot, tick, len({other for _, other, _, _ in others})] += 1
        for port in model.vacant(amoebot):
            rows["free", amoebot, tick, port] += 1
        # The same, asked of one port, or whether there is any.
        known = tick % 14 - 1
        if known in model.vacant(amoebot):
            rows["open", amoebot, tick, known] += 1
        for other in [other for port, other, _, _ in others if port == known]:
            rows["met", amoebot, tick, known, other] += 1
        if all(count == 1 for _, _, _, count in others):
            rows["calm", amoebot, tick] += 1
    return rows


NAMES = ("was", "headed", "tailed", "two", "touched", "beside", "counted", "free", "calm", "open", "met")


class Compared(Divided):
    """A run, and what the model says of it."""
    seen = collections.Counter()

    def outcome(self, folder, processes, threads):
        text = (folder / "amoebots.toml").read_text()
        checkpoint = folder / f"half-{processes}-{threads}"
        self.options = ["--json", "--ticks", str(TICKS), "--facts-out", folder / "facts"]
        code, said, errors = super().outcome(folder, processes, threads)
        if code != 0:
            return code, said, errors
        facts, summary = (folder / "facts").read_text(), json.loads(said)
        self.look_at(facts, summary, text)
        # Half of it, and the rest from its checkpoint.
        if (processes, threads) == (2, 1):
            self.options = ["--ticks", str(TICKS // 2), "--checkpoint", checkpoint, "--facts-out", folder / "again"]
            half = super().outcome(folder, processes, threads)
            rest = subprocess.run([self.meldsim, "resume", checkpoint, "-n", "3", "--ticks", str(TICKS), "--json", "--quiet"],
                                  capture_output=True, text=True, timeout=600)
            assert half[0] == rest.returncode == 0, f"{half}{rest}"
            assert (folder / "again").read_text() == facts, f"a run that went on differs\n{text}"
            again = json.loads(rest.stdout)
            for key in ("refused_actions", "outcomes"):
                assert again[key] == summary[key], f"{again[key]}\n{summary[key]}\n{text}"
            shutil.rmtree(checkpoint)
        return code, facts + json.dumps([summary["refused_actions"], summary["outcomes"]]), errors

    def model(self, facts, text):
        seed = int(re.search(r"seed = (\d+)", text).group(1))
        heads = {row[0]: row[2:] for row in read(facts, "was") if row[1] == 1}
        compass, chirality = (f'{key} = "own"' in text for key in ("compass", "chirality"))
        return Amoebots(heads, {a: Compass(seed, a, compass, chirality) for a in heads}, "keep_connected = true" in text)

    def observed(self, facts):
        rows = collections.defaultdict(collections.Counter)
        for name in NAMES:
            for row in read(facts, name):
                rows[row[1]][(name, *row)] += 1
        return rows

    def compare_tick(self, model, tick, observed, text):
        expected = sensed(model, tick)
        assert expected == observed[tick], \
            f"tick {tick}: missing {expected - observed[tick]}, too many {observed[tick] - expected}\n{text}"


class Wishes(Compared):
    def look_at(self, facts, summary, text):
        model, observed = self.model(facts, text), self.observed(facts)
        starts = {cell: amoebot for amoebot, (cell, _) in model.shape.items()}
        requests = collections.defaultdict(list)
        for name in CODES:
            line = re.search(rf"^wants-{name} = (.*)$", text, re.M)
            given = line.group(1) if line else ""
            for x, y, tick, argument in re.findall(r"cell == \((-?\d+), (-?\d+), 0\)\", args = \[(\d+), ([^\]]*)\]", given):
                shown = argument.strip('"') if name == "contract" else int(argument)
                requests[int(tick)].append(Request(name, starts[int(x), int(y)], shown))
        lost = collections.Counter()
        for tick in range(1, TICKS + 1):
            for (amoebot, code), count in model.carry_out(requests[tick - 1]).items():
                lost[amoebot, tick, code] += count
            self.compare_tick(model, tick, observed, text)
        assert lost == collections.Counter(read(facts, "lost")), text
        refused = {(each["action"], each["reason"]): each["count"] for each in summary["refused_actions"]}
        assert refused == dict(model.refused), f"{refused}\n{model.refused}\n{text}"
        moved = " ".join(summary["outcomes"])
        for kind in ("expansions", "contractions", "handovers"):
            assert f"{model.moved[kind]} {kind}" in moved, f"{moved}\n{model.moved}\n{text}"
        self.seen += model.moved
        self.seen.update(f"{action}: {why}" for action, why in model.refused)


class Walks(Compared):
    def look_at(self, facts, summary, text):
        model, observed = self.model(facts, text), self.observed(facts)
        way = re.search(r'activation = "(\w+)"', text).group(1)
        acted = collections.defaultdict(list)
        for amoebot, tick in read(facts, "acted"):
            acted[tick].append(amoebot)
        for tick in range(1, TICKS + 1):
            self.follow(model, observed[tick])
            self.compare_tick(model, tick, observed, text)
            assert way != "all" or sorted(acted[tick]) == sorted(model.shape), f"tick {tick}: {acted[tick]}\n{text}"
            assert way != "one" or len(acted[tick]) == 1, f"tick {tick}: {acted[tick]}\n{text}"
            if way in ("random", "fair"):
                self.look_apart(model, acted[tick], f"tick {tick}\n{text}")
        together = collections.Counter(amoebot for list_ in acted.values() for amoebot in list_)
        assert way != "fair" or max(together.values(), default=0) <= 1, f"twice in a round: {together}\n{text}"
        assert sum(together.values()) == int(re.search(r"; ([\d,]+) activations", " ".join(summary["outcomes"])).group(1).replace(",", ""))
        self.seen[f"activations, {way}"] += sum(together.values())
        self.seen["at once"] += sum(len(all_) > 1 for all_ in acted.values()) if way in ("random", "fair") else 0

    def follow(self, model, rows):
        """Takes the shapes of this tick from what amoebots sense of themselves."""
        heads = {row[1]: row[3:] for row in rows if row[0] == "was"}
        tails = {row[1]: row[3] for row in rows if row[0] == "tailed"}
        for amoebot, head in heads.items():
            tail = step(head, model.compass[amoebot].lattice(tails[amoebot])) if amoebot in tails else head
            model.shape[amoebot] = (head, tail)

    def look_apart(self, model, amoebots, where):
        seen = {}
        for amoebot in amoebots:
            around = {("cell", cell) for cell in [*model.shape[amoebot], *model.places(amoebot)]}
            around |= {("amoebot", other) for _, other, _, _ in model.touches(amoebot)}
            for each in around:
                assert each not in seen, f"{amoebot} and {seen[each]} both see {each} in {where}"
                seen[each] = amoebot


def main():
    meldsim, first, seeds = sys.argv[1], *(int(word) for word in (sys.argv[2:] + ["0", "10"][len(sys.argv) - 2 :])[:2])
    settings = [(1, 1), (1, 2), (2, 1), (3, 2), (4, 1)]
    every = range(first, first + seeds)
    wishes = Wishes(meldsim, "amoebots", settings, [])
    code = wishes.compare(((seed, WISHES, world(seed)) for seed in every), lambda facts: "two(" in facts)
    walks = Walks(meldsim, "amoebots", settings, [])
    ways = ("fair", "random", "one", "all")
    code |= walks.compare(((seed, WALKS, world(seed, ways[seed % 4])) for seed in every), lambda facts: "acted" in facts)
    seen = Wishes.seen + Walks.seen
    print("\n".join(f"{count:6} {what}" for what, count in sorted(seen.items())))
    wanted = ["expansions", "contractions", "handovers", "at once"] if seeds >= 16 else []
    missing = [what for what in wanted if not seen[what]]
    if missing:
        print(f"these happened in no run: {missing}")
    return code if not missing else 1


if __name__ == "__main__":
    sys.exit(main())
