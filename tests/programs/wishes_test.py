"""Random requests to move, several of one catom in one tick: the outcome does not depend on the number of processes, nor do the counts of
refusals and their reasons; and there are as many refusals as facts of `failed`.

Usage: wishes_test.py MELDSIM [FIRST_SEED [SEEDS]]
"""

import collections
import json
import random
import re
import sys

from seeds import Divided

ACTIONS = {
    "moveTo": "int, int, int",
    "slide": "int, int",
    "turn": "int, int",
    "moveAround": "node, node",
    "create": "int",
    "destroy": "node",
    "give": "node",
}

PROGRAM = "".join(f"type linear wants-{name}(node, int, {types}).\n" for name, types in ACTIONS.items())
for name, types in ACTIONS.items():
    arguments = ", ".join("XYZ"[: len(types.split(","))])
    PROGRAM += f"wants-{name}(A, T, {arguments}), tick(A, T) -o {name}(A, {arguments}).\n"
PROGRAM += """type linear lost(node, int).
type stands(node, int, int, int).
failed(A, K) -o lost(A, K).
stands(A, X, Y, Z) :- cell(A, X, Y, Z).
"""

CODES = {action: code for code, action in enumerate(
    ("create", "destroy", "give", "moveTo", "slide", "turn", "moveAround"), start=1)}

PORTS = {"square": 4, "hex": 6, "cubic": 6, "fcc": 12}


def world(seed):
    """A few catoms in two or three clusters far apart, with requests in two ticks."""
    rng = random.Random(seed)
    lattice = rng.choice(sorted(PORTS))
    flat = lattice in ("square", "hex")
    cells = set()
    while len(cells) < rng.randint(2, 9):
        cells.add((rng.choice([0, 1, 2, 7, 8, 20, 21, 40]), rng.choice([0, 1, 2, 20]), 0 if flat else rng.choice([0, 0, 1])))
    cells = sorted(cells)
    places = cells + [(rng.choice([0, 3, 39, 60]), rng.choice([2, 21]), 0) for _ in range(3)]

    def arguments(name):
        if name == "moveTo":
            return rng.choice(places)
        kinds = ACTIONS[name].split(", ")
        return [f'"@{rng.randrange(len(cells) + 1)}"' if kind == "node" else rng.randrange(PORTS[lattice]) for kind in kinds]

    facts = {name: [] for name in ACTIONS}
    for catom in range(len(cells)):
        for tick in (2, 3):
            for _ in range(rng.randint(0, 4)):
                name = rng.choice([*ACTIONS, "moveAround", *["moveTo"] * 9])
                listed = ", ".join(str(x) for x in arguments(name))
                facts[name].append(f'{{ where = "id == {catom}", args = [{tick}, {listed}] }}')
    shown = [f"[{x}, {y}]" if flat else f"[{x}, {y}, {z}]" for x, y, z in cells]
    lines = [f'lattice = "{lattice}"', "held = 1", "[[body]]", f"cells = [{', '.join(shown)}]"]
    lines += ["[motion]", 'kind = "lattice"', "capacity = 3", "[facts]"]
    lines += [f"wants-{name} = [{', '.join(given)}]" for name, given in facts.items() if given]
    return "\n".join(lines) + "\n"


class Wishes(Divided):
    """With the refusals of the summary. Where no catom was destroyed, each that failed is known by a fact too."""
    counted = 0

    def outcome(self, folder, processes, threads):
        self.options = ["--json", "--ticks", "8", "--facts-out", folder / "facts"]
        code, said, errors = super().outcome(folder, processes, threads)
        if code != 0:
            return code, said, errors
        refused = json.loads(said)["refused_actions"]
        facts = (folder / "facts").read_text()
        self.compare_counts(refused, facts, (folder / "wishes.toml").read_text())
        return code, facts + "\n".join(map(str, refused)), errors

    def compare_counts(self, refused, facts, world):
        refusals = collections.Counter()
        for each in refused:
            refusals[CODES[each["action"]]] += each["count"]
        failed = collections.Counter(int(code) for code in re.findall(r"^lost\(@\d+, (\d+)\)", facts, re.M))
        assert failed <= refusals, f"{world}\n{facts}\n{refused}"
        wanted = re.search(r"^wants-destroy = (.*)$", world, re.M)
        if refusals[CODES["destroy"]] == (wanted.group(1).count("where") if wanted else 0):
            assert failed == refusals, f"{world}\n{facts}\n{refused}"
            self.counted += 1


def main():
    meldsim, first, seeds = sys.argv[1], *(int(word) for word in (sys.argv[2:] + ["0", "24"][len(sys.argv) - 2 :])[:2])
    wishes = Wishes(meldsim, "wishes", [(1, 1), (2, 2), (3, 1)], [])
    code = wishes.compare(((seed, PROGRAM, world(seed)) for seed in range(first, first + seeds)), lambda facts: "lost" in facts)
    print(f"in {wishes.counted} runs nobody was destroyed")
    return code if wishes.counted > 0 else 1


if __name__ == "__main__":
    sys.exit(main())
