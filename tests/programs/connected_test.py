"""Random wishes to move in a world with keep_connected: after each tick the ensemble is connected, whatever moves at once; the outcome does
not depend on the number of processes; and no move is lost: when nobody moves any more, nobody is kept back by others.

Usage: connected_test.py MELDSIM [FIRST_SEED [SEEDS]]
"""

import collections
import json
import random
import re
import sys

from lattice import components, position, touching
from seeds import Divided

CUBES = ("slide", "turn", "moveAround")
MOVES = {"square": CUBES, "cubic": CUBES, "hex": ("moveAround",), "fcc": ("moveAround",)}
PORTS = {"square": 4, "hex": 6, "cubic": 6, "fcc": 12}
ARGUMENTS = {"slide": "int, int", "turn": "int, int", "moveAround": "node, node"}

# Each catom asks for all that it wishes until it has moved once. So a run comes to rest; there, whoever still asks is refused for ever.
PROGRAM = "".join(f"type wish-{name}(node, {types}).\n" for name, types in ARGUMENTS.items())
PROGRAM += "".join(f"type action {name}(node, {types}) while.\n{name}(A, X, Y) :- wish-{name}(A, X, Y), not moved(A).\n"
                   for name, types in ARGUMENTS.items())
PROGRAM += """type began(node, int, int, int).
type moved(node).
type linear was(node, int, int, int, int).
moved(A) :- began(A, X, Y, Z), not cell(A, X, Y, Z).
tick(A, T), cell(A, X, Y, Z) -o was(A, T, X, Y, Z).
"""

# More than there are catoms, of which each moves at most once.
TICKS = 70


def neighbours(lattice, cell):
    """The cells that touch one, in no order."""
    x, y, z = cell
    around = [(x + i, y + j, z + k) for i in (-1, 0, 1) for j in (-1, 0, 1) for k in (-1, 0, 1) if (i, j, k) != (0, 0, 0)]
    if lattice in ("square", "hex"):
        around = [other for other in around if other[2] == 0]
    place = position(lattice, cell)
    return [other for other in around if abs(sum((a - b) ** 2 for a, b in zip(place, position(lattice, other))) - 1) < 1e-6]


def world(seed):
    """A connected ensemble with holes, across the corners of bricks, and for each catom some wishes."""
    rng = random.Random(seed)
    lattice = sorted(PORTS)[seed % len(PORTS)]
    wanted = rng.randint(4, 60)
    cells = {rng.choice([(0, 0, 0), (31, 15, 0), (7, 7, 0 if lattice in ("square", "hex") else 7)])}
    # Growing at those added last makes branches.
    recent = list(cells)
    while len(cells) < wanted:
        cell = rng.choice(neighbours(lattice, rng.choice(recent[-rng.choice([2, 8, 60]):])))
        if cell not in cells:
            cells.add(cell)
            recent.append(cell)
    # Catoms are numbered as the run numbers them; wishes and places are given by cell.
    facts = collections.defaultdict(list)
    for cell in sorted(cells):
        where = "cell == ({}, {}, {})".format(*cell)
        facts["began"].append(f'{{ where = "{where}", args = [{cell[0]}, {cell[1]}, {cell[2]}] }}')
        name = rng.choice(MOVES[lattice])
        # Most pairs of catoms are not beside each other.
        for _ in range(rng.randint(0, 40 if name == "moveAround" else 6)):
            shown = [f'"@{rng.randrange(len(cells))}"' if name == "moveAround" else str(rng.randrange(PORTS[lattice])) for _ in range(2)]
            facts[f"wish-{name}"].append(f'{{ where = "{where}", args = [{", ".join(shown)}] }}')
    listed = ", ".join("[{}, {}]".format(*c) if lattice in ("square", "hex") else "[{}, {}, {}]".format(*c) for c in sorted(cells))
    lines = [f'lattice = "{lattice}"', "[[body]]", f"cells = [{listed}]", "[motion]", 'kind = "lattice"']
    lines += ["keep_connected = true", "[facts]"]
    lines += [f"{name} = [{', '.join(given)}]" for name, given in facts.items()]
    return "\n".join(lines) + "\n"


class Connected(Divided):
    """What was where after each tick, which must be connected; and how many requests lost against others in the last ticks."""
    moves = at_once = conflicts = 0

    def outcome(self, folder, processes, threads):
        text = (folder / "connected.toml").read_text()
        lattice = re.search(r'lattice = "(\w+)"', text).group(1)
        refused = []
        for ticks in (TICKS, TICKS + 1):
            self.options = ["--json", "--ticks", str(ticks), "--facts-out", folder / "facts"]
            code, said, errors = super().outcome(folder, processes, threads)
            if code != 0:
                return code, said, errors
            counts = [each["count"] for each in json.loads(said)["refused_actions"] if each["reason"] == "conflict"]
            refused.append(sum(counts))
        facts = (folder / "facts").read_text()
        self.look_at(lattice, facts, refused, text)
        return code, facts + said.partition('"refused_actions"')[2].partition("]")[0], errors

    def look_at(self, lattice, facts, refused, text):
        ticks = collections.defaultdict(dict)
        for found in re.finditer(r"^was\(@(\d+), (\d+), (-?\d+), (-?\d+), (-?\d+)\)", facts, re.M):
            catom, tick, *cell = map(int, found.groups())
            ticks[tick][catom] = tuple(cell)
        assert len(ticks) > TICKS - 1, text
        last = None
        for tick in sorted(ticks):
            cells = ticks[tick]
            assert len(set(cells.values())) == len(cells), f"two catoms in one cell in tick {tick}\n{text}"
            parts = len(list(components(touching(lattice, cells))))
            assert parts == 1, f"{parts} parts in tick {tick}\n{text}{facts}"
            moved = sum(cells[catom] != last[catom] for catom in cells) if last else 0
            self.moves += moved
            self.at_once += moved > 1
            last = cells
        self.conflicts += refused[0]
        # All who could move alone in the end have moved: a request that loses then would lose for ever.
        assert refused[0] == refused[1], f"{refused} requests lose against others in the end\n{text}"


def main():
    meldsim, first, seeds = sys.argv[1], *(int(word) for word in (sys.argv[2:] + ["0", "24"][len(sys.argv) - 2 :])[:2])
    connected = Connected(meldsim, "connected", [(1, 1), (2, 2), (3, 1), (4, 1)], [])
    code = connected.compare(((seed, PROGRAM, world(seed)) for seed in range(first, first + seeds)), lambda facts: "was" in facts)
    print(f"{connected.moves} moves; in {connected.at_once} ticks several at once; {connected.conflicts} requests lost against others")
    return code if min(connected.moves, connected.at_once, connected.conflicts) > 0 else 1


if __name__ == "__main__":
    sys.exit(main())
