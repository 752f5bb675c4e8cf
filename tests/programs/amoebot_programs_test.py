"""Programs of amoebots from random shapes, with compasses of their own, under three kinds of activation: what comes out is judged here, on
the cells and the facts at the end, rounds and moves keep to the bounds of the papers, and some thousand ticks are the same on one to three
processes. The judge must refuse each program when it is broken in one place.

Usage: amoebot_programs_test.py MELDSIM EXAMPLES PROGRAM [FIRST_SEED [SEEDS]]
"""

import collections
import json
import pathlib
import random
import re
import subprocess
import sys
import tempfile

from amoebots import step
from distributed import require
from runner import literal, split

ACTIVATIONS = ("fair", "one", "random")
ALIKE = 2000            # Ticks that must be the same on any number of processes.


def piece(cells, first):
    """The cells that hang together with the first."""
    found, todo = set(), [first]
    while todo:
        cell = todo.pop()
        if cell in cells and cell not in found:
            found.add(cell)
            todo += [step(cell, d) for d in range(6)]
    return found


def pieces(cells):
    left, found = set(cells), []
    while left:
        found.append(piece(left, min(left)))
        left -= found[-1]
    return found


def connected(cells):
    return len(pieces(cells)) <= 1


def around(cells, by):
    xs, ys = zip(*cells)
    return {(x, y) for x in range(min(xs) - by, max(xs) + by + 1) for y in range(min(ys) - by, max(ys) + by + 1)}


def grown(rng, count, holes):
    """Random cells in one piece, across corners of bricks; without holes if that is asked for."""
    cells = {rng.choice([(31, 15), (30, 0), (0, 0)])}
    while len(cells) < count:
        cells.add(step(rng.choice(sorted(cells)), rng.randrange(6)))
        if not holes:
            cells |= around(cells, 1) - cells - outside_of(cells)
    return sorted(cells)


def pierced(rng, cells):
    """Without some of the cells, many of them inside, and still in one piece."""
    left = set(cells)
    for cell in rng.sample(cells, len(cells) // 3):
        left -= {cell} if connected(left - {cell}) else set()
    return sorted(left)


# Shapes that are not likely by chance: where an amoebot is alone, has agents on both sides of a line, or joins two rings.
RING = [(1, 0), (0, 1), (-1, 1), (-1, 0), (0, -1), (1, -1)]
SMALL = [[(0, 0)], [(0, 0), (1, 0)], [(x, 0) for x in range(9)], RING, RING + [(x + 2, y) for x, y in RING[:3] + RING[4:]],
         [(x, y) for x in range(9) for y in range(9) if x % 2 == 0 or y % 4 == 0]]


class Outcome:
    """The facts at the end, who is in which cell with its head, and the counts of the summary."""

    def __init__(self, text, told):
        self.facts = collections.defaultdict(list)
        for line in text.splitlines():
            name, arguments = re.fullmatch(r"([^(]+)\((.*)\)\.", line).groups()
            self.facts[name].append(tuple(literal(word) for word in split(arguments)))
        self.ended = told["ended"]
        self.cells = {row[0]: row[1:3] for row in self.facts["stands"]}
        counts = re.search(r"(\d[\d,]*) expansions, (\d[\d,]*) contractions, (\d[\d,]*) handovers", json.dumps(told))
        expansions, contractions, handovers = (int(word.replace(",", "")) for word in counts.groups())
        self.moves = expansions + contractions + 2 * handovers
        self.rounds = int(re.search(r"in (\d[\d,]*) rounds", json.dumps(told) + " in 0 rounds").group(1).replace(",", ""))


# ---- what must be at the end


def spanning_forest(outcome, roots):
    parents = {a: b for a, _, b in outcome.facts["parent"]}
    require(len(parents) == len(outcome.facts["parent"]), "somebody has two parents")
    require(set(parents) == set(outcome.cells) - roots, "not all have a parent, or a root has one")
    for a, b in parents.items():
        require(outcome.cells[b] in [step(outcome.cells[a], d) for d in range(6)], f"@{a} does not touch its parent @{b}")
        seen = {a}
        while b not in roots:
            require(b not in seen, f"the parents of @{a} go round in a circle")
            seen.add(b)
            b = parents[b]
    require(outcome.moves == 0, "somebody has moved")
    # In each round each that touches a tree joins it.
    require(outcome.rounds <= len(parents) + 1, f"{outcome.rounds} rounds")


def erosion_election(outcome, _):
    leaders, eroded = {a for a, in outcome.facts["leader"]}, {a for a, in outcome.facts["eroded"]}
    require(len(leaders) == 1, f"{leaders} lead")
    require(eroded == set(outcome.cells) - leaders, "not all others have given up")
    require(outcome.rounds <= len(outcome.cells), f"{outcome.rounds} rounds")


def outside_of(cells):
    """The empty cells in a box around all that are not in a hole."""
    empty = around(cells, 1) - cells
    return piece(empty, min(empty))


def boundary(cells, empty):
    """How many rows of empty cells of one piece amoebots have around them: the length of the boundary."""
    return sum(step(cell, d) in empty and step(cell, (d + 1) % 6) in cells for cell in cells for d in range(6))


def boundary_election(outcome, _):
    cells = set(outcome.cells.values())
    outside = outside_of(cells)
    holes = pieces(around(cells, 1) - cells - outside)
    leaders, followers = ({a for a, in outcome.facts[name]} for name in ("leader", "follower"))
    require(len(leaders) == 1, f"{leaders} lead")
    require(followers == set(outcome.cells) - leaders, "not all others follow")
    (leader,) = leaders
    require(any(step(outcome.cells[leader], d) in outside for d in range(6)), "the leader is not at the outer boundary")
    length = boundary(cells, outside)
    turns = collections.Counter(turns for _, _, turns in outcome.facts["border"])
    require(turns[6] == min(length, 1) and set(turns) <= {6, -6} and turns[-6] <= len(holes),
            f"{len(holes)} holes, and boundaries turn by {turns}")
    # Measured, 2 L to 4 L; the news that there is a leader reaches another amoebot in each round.
    require(outcome.rounds <= 20 * length + len(cells), f"{outcome.rounds} rounds, where the outer boundary has {length} agents")
    print(f"L = {length}, {len(holes)} holes" + (f", {outcome.rounds / length:.1f} L rounds" if outcome.rounds and length else ""))


def shape(outcome, seeds):
    count = len(outcome.cells)
    require({a: phase for a, _, _, phase in outcome.facts["stands"]} == dict.fromkeys(outcome.cells, 3), "not all are retired")
    require(len(set(outcome.cells.values())) == count, "two are in one cell")
    # At most n cells behind others, and once round what is built, 2 n cells; two moves each. The paper has O(n^2).
    require(0 < outcome.moves <= 6 * count ** 2, f"{outcome.moves} moves of {count} amoebots")
    (seed,) = seeds
    x, y = outcome.cells[seed]
    return {(u - x, v - y) for u, v in outcome.cells.values()}


def hexagon_formation(outcome, seeds):
    cells = shape(outcome, seeds)
    rings = collections.Counter(max(abs(x), abs(y), abs(x + y)) for x, y in cells)
    outer = max(rings)
    require(all(rings[r] == max(6 * r, 1) for r in range(outer)), f"the rings have {dict(rings)} amoebots")
    # The last ring is one piece.
    require(connected({(x, y) for x, y in cells if max(abs(x), abs(y), abs(x + y)) == outer}), "the outermost ring is in pieces")


def line_formation(outcome, seeds):
    cells = shape(outcome, seeds)
    require(any(cells == {(i * step((0, 0), d)[0], i * step((0, 0), d)[1]) for i in range(len(cells))} for d in range(6)),
            f"no line from the seed: {sorted(cells)}")


def coating(outcome, cells_of_object):
    thing = {outcome.cells[a] for a, in outcome.facts["object"]}
    (first,) = (a for a, in outcome.facts["first"])
    cells = {(x + outcome.cells[first][0], y + outcome.cells[first][1]) for x, y in shape(outcome, {first})}
    require(thing == cells_of_object, "the object has moved")
    layer, left = thing, cells - thing
    while left:
        around_it = {step(cell, d) for cell in layer for d in range(6)} - thing - (cells - left)
        here = around_it & left
        require(here and (here == around_it or here == left), f"{len(here)} of {len(around_it)} cells of a layer, and {len(left)} amoebots")
        require(here == around_it or connected(here), "the outermost layer is in pieces")
        thing, left, layer = thing | here, left - here, around_it


def energy_sharing(outcome, sources):
    energy, acted, harvested = ({row[0]: row[1] for row in outcome.facts[name]} for name in ("energy", "acted", "harvested"))
    require(set(energy) == set(acted) == set(outcome.cells), "somebody has no battery, or two")
    require(all(0 <= units <= 10 for units in energy.values()), f"batteries have {energy}")
    require(all(times > 0 for times in acted.values()), f"not all have acted: {acted}")
    require(all(harvested[a] == 0 for a in set(outcome.cells) - sources), "energy from nowhere")
    under_way = sum(units for _, units in outcome.facts["given"])
    require(sum(harvested.values()) == sum(energy.values()) + 5 * sum(acted.values()) + under_way, "energy is lost, or comes from nothing")
    spanning_forest_of(outcome, sources)
    # In the paper O(n) rounds; each source gives a unit in a round, and a battery holds ten.
    require(outcome.rounds <= 40 * len(outcome.cells), f"{outcome.rounds} rounds")


def spanning_forest_of(outcome, roots):
    rounds, outcome.rounds = outcome.rounds, 0
    spanning_forest(outcome, roots)
    outcome.rounds = rounds


# ---- the programs: how many amoebots, whether their shapes may have holes, who is given what fact, until when, and what breaks it

Program = collections.namedtuple("Program", "count holes fact given until chirality breaks")
FORMED = "N = count : { stands(_, _, _, 3) }, N = @world"
SHAPE_BREAKS = [
    ("-o pull(A, P), drawn(B, A)", "-o pull(A, P)"),
    ("becomes(A, follower, P).\n\n", "becomes(A, follower, (P + 3) % 6).\n\n"),
]
PROGRAMS = {
    "spanning_forest": Program(60, True, "root", 3, "N = count : { joined(_) }, N = @world", "own",
                               [("port(A, P, B, _, _), joined(B)", "port(A, P, B, _, _)")]),
    "erosion_election": Program(60, False, None, 0, "leader(_)", "own", [("runs(A, 1) -o", "runs(A, N), N < 3 -o")]),
    "boundary_election": Program(90, True, None, 0, "N = count : { informed(_) }, N = @world", "common",
                                 [("token(A, P, _, P, 0, 0, _, T)", "token(A, P, _, P, _, _, _, T)"),
                                  ("token(A, P, _, P, 0, 0, _, T)", "token(A, P, _, _, 0, 0, _, T)"),
                                  ("border(A, _, 6)", "border(A, _, _)"), ("E > D -o", "E <> D -o")]),
    "hexagon_formation": Program(45, True, "seed", 1, FORMED, "common",
                                 [*SHAPE_BREAKS, ("not built(A, (P + 5) % 6)", "not built(A, (P + 4) % 6)")]),
    "line_formation": Program(24, True, "seed", 1, FORMED, "common", [*SHAPE_BREAKS, ("(P + 3) % 6) :- marked", "(P + 2) % 6) :- marked")]),
    "coating": Program(40, True, None, 0, FORMED, "common",
                       [*SHAPE_BREAKS, ("marked(A, 0) :- first(A)", "marked(A, 0) :- first(A), object(A)"),
                        ("not built(A, (P + 5) % 6)", "not built(A, (P + 1) % 6)")]),
    "energy_sharing": Program(30, True, "source", 2, "N = count : { acted(_, K), K > 0 }, N = @world", "own",
                              [("energy(A, E - G), child", "energy(A, E), child"),
                               ("harvested(A, H + G), inhibited(A, S)", "harvested(A, H + G), inhibited(A, false)")]),
}


# Programs that are run from the small shapes too, and from random ones with many holes.
IN_SMALL = {"boundary_election"}


def run(meldsim, folder, program, options, processes=1):
    facts = folder / "out.facts"
    facts.unlink(missing_ok=True)
    command = [meldsim, "run", folder / f"{program}.meld", "--world", folder / "world.toml", "--json", "--facts-out", facts,
               "-n", str(processes), *options]
    done = subprocess.run(command, capture_output=True, text=True, timeout=280)
    require(done.returncode in (0, 3), f"{command} ended with {done.returncode}:\n{done.stderr}")
    return Outcome(facts.read_text(), json.loads(done.stdout)), facts.read_text()


def coated(rng, count):
    """An object, a parallelogram, with a blob of amoebots around one that touches it: the cells of the object, of all, and the facts."""
    width, height = rng.randint(1, 8), rng.randint(1, 5)
    thing = {(28 + x, 13 + y) for x in range(width) for y in range(height)}
    first = rng.choice(sorted({step(cell, d) for cell in thing for d in range(6)} - thing))
    cells, blob = thing | {first}, [first]
    while len(blob) < count:
        cell = step(rng.choice(blob), rng.randrange(6))
        if cell not in cells:
            cells.add(cell)
            blob.append(cell)
    region = [f"cell == ({x}, {y}, 0)" for x, y in sorted(thing)]
    return thing, sorted(cells), f'[facts]\nobject = {json.dumps(region)}\nfirst = "cell == ({first[0]}, {first[1]}, 0)"\n'


def world(rng, name, activation, seed, cells):
    program = PROGRAMS[name]
    if name == "coating":
        given, cells, facts = coated(rng, program.count)
        return given, placed(cells, facts, program, activation, seed)
    if not cells:
        cells = grown(rng, program.count, program.holes)
        cells = pierced(rng, cells) if name in IN_SMALL else cells
    given = {rng.randrange(len(cells))} if program.given == 1 else set(rng.sample(range(len(cells)), program.given))
    facts = f"[facts]\n{program.fact} = {json.dumps([f'id == {a}' for a in sorted(given)])}\n" if given else ""
    return given, placed(cells, facts, program, activation, seed)


def placed(cells, facts, program, activation, seed):
    return (f'lattice = "hex"\nseed = {seed}\n[[body]]\ncells = {json.dumps(cells)}\n{facts}'
            f'[motion]\nkind = "amoebot"\nactivation = "{activation}"\ncompass = "own"\nchirality = "{program.chirality}"\n')


def judge(meldsim, folder, name, activation, seed, divided, cells=None):
    program = PROGRAMS[name]
    given, text = world(random.Random(f"{name} {seed}"), name, activation, seed, cells)
    (folder / "world.toml").write_text(text)
    if divided:
        some = {run(meldsim, folder, name, ("--ticks", str(ALIKE)), processes)[1] for processes in (1, 2, 3)}
        require(len(some) == 1, "other facts on other numbers of processes")
    outcome, _ = run(meldsim, folder, name, ("--ticks", "300000", "--watch", program.until))
    require(outcome.ended != "ticks", "it does not come to an end")
    globals()[name](outcome, given)
    return outcome


def copied(examples, folder, name, right="", wrong=""):
    texts = {path: (examples / path).read_text() for path in {f"{name}.meld", "amoebot_shapes.meld"}}
    require(not right or any(right in text for text in texts.values()), f"{name} has no '{right}' that could be broken")
    for path, text in texts.items():
        (folder / path).write_text(text.replace(right, wrong) if right else text)


def main():
    meldsim, examples, name = sys.argv[1], pathlib.Path(sys.argv[2]), sys.argv[3]
    first, count = (int(word) for word in [*sys.argv[4:6], *(1, 2)[len(sys.argv) - 4:]])
    with tempfile.TemporaryDirectory() as scratch:
        folder = pathlib.Path(scratch)
        copied(examples, folder, name)
        trials = [(seed, activation, None) for seed in range(first, first + count) for activation in ACTIVATIONS]
        if name in IN_SMALL:
            trials += [(first, ACTIVATIONS[i % len(ACTIVATIONS)], cells) for i, cells in enumerate(SMALL)]
        for seed, activation, cells in trials:
            try:
                outcome = judge(meldsim, folder, name, activation, seed, seed == first, cells)
            except AssertionError as error:
                sys.exit(f"{name}, seed {seed}, activation {activation}: {error}\n{(folder / 'world.toml').read_text()}")
            print(f"seed {seed}, {activation}: {len(outcome.cells)} amoebots, {outcome.moves} moves, {outcome.rounds or 'no'} rounds")
        for right, wrong in PROGRAMS[name].breaks:
            copied(examples, folder, name, right, wrong)
            for seed in range(first, first + 5):
                try:
                    judge(meldsim, folder, name, "fair", seed, False)
                except AssertionError as error:
                    print(f"with '{wrong}' it is refused: {str(error)[:80]}")
                    break
            else:
                sys.exit(f"{name} with '{wrong}': nobody notices")


if __name__ == "__main__":
    main()
