"""The random programs as users run them: processes_test.py --random PATH --meldc PATH --meldsim PATH [unittest options]

test_random runs its trials in one process, on parts over a virtual network. Here each trial becomes a program and a world, and meldsim
runs it on 1 to 4 processes over MPI with 1 or 2 threads: digests of all ticks, facts and endings are the same.
"""
import collections
import pathlib
import re
import sys

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1]))

from frame import CAMPAIGN, TOOLS, Case, main  # noqa: E402

# The first seed of each kind, and how many are taken; kinds are options of test_random.
TRIALS = {(): 1, ("--failures",): 20001, ("--graphs",): 40001, ("--graphs", "--failures"): 60001}
SEEDS = 30 if CAMPAIGN else 2
SETTINGS = [(2, 1), (3, 2), (4, 1), (1, 2)] if CAMPAIGN else [(3, 2), (2, 1)]
# Bursts follow each other whether what came before has come to rest or not.
BURST_TICKS, TICKS = 45, 220
NETWORKS = ["", "", '[network]\nkind = "latency"\nleast = 1\nmost = 3\n', '[clock]\nkind = "random"\nrate = 0.5\nmost = 3\n',
            '[network]\nkind = "lossy"\nloss = 0.1\nretry = 2\ntries = 15\n[clock]\nkind = "drift"\nmost = 4\n']


def types_of(program, predicate):
    """The words of its arguments after the catom."""
    declared = re.search(rf"^type (?:linear |route )?{re.escape(predicate)}\((.*)\)\.$", program, re.MULTILINE).group(1)
    return [argument.split()[0] for argument in declared.split(",")[1:]]


def value(word, kind):
    """A given argument as a world writes it: floats are given in quarters."""
    return {"node": f'"@{word}"', "float": str(int(word) / 4), "bool": str(word != "0").lower()}.get(kind, word)


class World:
    """A world as its file says it, from the lines `//: ...` of a trial."""

    def __init__(self, text):
        self.program = "\n".join(line for line in text.splitlines() if not line.startswith("//:"))
        self.seed, self.lattice, self.given, self.cells, self.links, burst = 0, "", [], [], [], -1
        # By tick: what its event does, by key.
        self.events = collections.defaultdict(lambda: collections.defaultdict(list))
        for line in text.splitlines():
            if not line.startswith("//: "):
                continue
            first, *words = line[4:].split()
            match first:
                case "seed": self.seed = int(words[0])
                case "lattice": self.lattice = words[0]
                case "given": self.given.append(words[0])
                case "catom": self.cells.append(words[0].split(","))
                case "link": self.links.append(words)
                case "burst": burst += 1
                case _: self.change(burst * BURST_TICKS + int(first) + 1, *words)

    def where(self, cell):
        x, y, z = cell.split(",")
        return f"id == {x}" if self.lattice == "graph" else f"cell == ({x}, {y}, {z})"

    def change(self, tick, kind, cell, *words):
        if kind in ("add", "move"):
            return  # Worlds have no event for it.
        event, where = self.events[tick], self.where(cell)
        region = f'"{where}"'
        if kind in ("give", "take"):
            predicate = self.given[int(words[0])]
            arguments = ", ".join(map(value, words[1:], types_of(self.program, predicate)))
            event[f"{kind} {predicate}"].append(f'{{ where = "{where}", args = [{arguments}] }}')
        elif kind == "remove":
            event["kill"].append(region)
        elif kind == "hang":
            event["hang"].append(region)
            self.events[tick + int(words[0])]["restart"].append(region)
        elif kind == "restart":
            event["restart"].append(region)
        elif kind == "join":
            event["join"].append(f'[{cell.split(",")[0]}, {words[0].split(",")[0]}]')
        elif kind in ("cut", "heal"):
            event[kind].append(f'{{ between = [{region}, "{self.where(words[0])}"] }}')

    def files(self):
        """All of them by name: the program, the world, and its graph if it is one."""
        files = {"p.meld": self.program}
        world = f'lattice = "{self.lattice}"\nseed = {self.seed}\n'
        if self.lattice == "graph":
            files["links.csv"] = "".join(f"{a},{b}\n" for a, b in self.links)
            files["nodes.csv"] = "node\n" + "".join(f"{x}\n" for x, _, _ in self.cells)
            world += 'nodes = "nodes.csv"\nlinks = "links.csv"\n'
        else:
            world += "[[body]]\ncells = [" + ", ".join(f"[{x}, {y}, {z}]" for x, y, z in self.cells) + "]\n"
        world += NETWORKS[self.seed // 1000 % len(NETWORKS)]
        for tick, event in sorted(self.events.items()):
            world += f"[[event]]\ntick = {tick}\n"
            for key in ("give", "take"):
                given = {name.split()[1]: facts for name, facts in event.items() if name.startswith(key + " ")}
                if given:
                    world += f"{key} = {{ " + ", ".join(f"{name} = [{', '.join(facts)}]" for name, facts in given.items()) + " }\n"
            for key in ("kill", "hang", "restart", "cut", "heal", "join"):
                if event[key]:
                    world += f"{key} = [{', '.join(event[key])}]\n"
        return {**files, "w.toml": world}


class Processes(Case):
    def found(self, processes, threads):
        """What a run says and leaves."""
        done = self.run_tool("meldsim", "run", "p.meld", "--world", "w.toml", "--ticks", TICKS, "--quiet", "--digest", "digests",
                             "--facts-out", "facts", "-n", processes, "--threads", threads, seconds=120)
        said = [line for line in done.stderr.splitlines() if "meldsim: " in line and "matches no catom" not in line]
        self.assertIn(done.returncode, (0, 1, 4), said or done.stderr)
        return done.returncode, said, self.read("digests"), self.read("facts") if done.returncode == 0 else b""

    def test_all_processes_and_threads_do_the_same(self):
        ended = collections.Counter()
        for options, first in TRIALS.items():
            for seed in range(first, first + SEEDS):
                with self.subTest(options=options, seed=seed):
                    text, _ = self.call(TOOLS.random, "--show", seed, *options)
                    for name, content in World(text).files().items():
                        self.write(name, content)
                    alone = self.found(1, 1)
                    ended[alone[0]] += 1
                    for processes, threads in SETTINGS:
                        self.assertEqual(self.found(processes, threads), alone, f"{processes} processes, {threads} threads")
        # Most programs have no mistake.
        self.assertGreater(ended[0], sum(ended.values()) / 2)


if __name__ == "__main__":
    main("random", "meldc", "meldsim")
