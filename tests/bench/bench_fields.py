"""Gradient and single-path collection on scattered devices, as the libraries `field` and `collect` compute them:

    bench_fields.py MELDSIM [--devices N] [--degree D] [--nodes FILE.csv --reach R] [--disturb]

Devices lie at random in a square so large that each has about D neighbours within reach; or where a file says, with the columns
node, x and y, as another simulator may write it, to compare with it on the same devices. With --disturb the source moves to another
corner after the field is there. Prints ticks, seconds of CPU and the peak of memory of the run, how many devices are reached, the
longest distance and the sum that arrives, by which other programs can be compared.
"""

import argparse
import csv
import json
import math
import pathlib
import random
import subprocess
import tempfile

PROGRAM = """use "field".
use "collect".
type source(node).
field-source(A)       :- source(A).
collect-next(A, B)    :- field-next(A, B).
collect-value(A, 1.0) :- id(A, _).
"""


def near(places, reach):
    """Pairs within reach, found in a grid of squares of that size."""
    squares = {}
    for node, (x, y) in enumerate(places):
        squares.setdefault((math.floor(x / reach), math.floor(y / reach)), []).append(node)
    for (i, j), nodes in squares.items():
        around = [other for di in (-1, 0, 1) for dj in (-1, 0, 1) for other in squares.get((i + di, j + dj), ())]
        for node in nodes:
            for other in around:
                if node < other and math.dist(places[node], places[other]) <= reach:
                    yield node, other


def main():
    arguments = argparse.ArgumentParser()
    arguments.add_argument("meldsim", type=pathlib.Path)
    arguments.add_argument("--devices", type=int, default=10000)
    arguments.add_argument("--degree", type=float, default=20)
    arguments.add_argument("--nodes", type=pathlib.Path)
    arguments.add_argument("--reach", type=float, default=1.0)
    arguments.add_argument("--disturb", action="store_true")
    arguments.add_argument("--threads", default="1")
    given = arguments.parse_args()
    if given.nodes:
        with open(given.nodes, newline="") as file:
            places = [(float(row["x"]), float(row["y"])) for row in csv.DictReader(file)]
    else:
        side = given.reach * math.sqrt(math.pi * given.devices / given.degree)
        draw = random.Random(1)
        places = [(draw.random() * side, draw.random() * side) for _ in range(given.devices)]
    with tempfile.TemporaryDirectory() as scratch:
        folder = pathlib.Path(scratch)
        with open(folder / "links.csv", "w", newline="") as file:
            csv.writer(file).writerows([("from", "to"), *near(places, given.reach)])
        with open(folder / "nodes.csv", "w", newline="") as file:
            csv.writer(file).writerows([("node", "x", "y"), *((node, repr(x), repr(y)) for node, (x, y) in enumerate(places))])
        event = f'[[event]]\ntick = 400\ntake = {{ source = "id == 0" }}\ngive = {{ source = "id == {len(places) - 1}" }}\n'
        (folder / "world.toml").write_text('lattice = "graph"\nlinks = "links.csv"\nnodes = "nodes.csv"\n[facts]\nsource = "id == 0"\n' +
                                           (event if given.disturb else ""))
        (folder / "program.meld").write_text(PROGRAM)
        command = [given.meldsim.resolve(), "run", "program.meld", "--world", "world.toml", "--threads", given.threads, "--json"]
        subprocess.run([*command, "--ticks", "1"], cwd=folder, check=True, capture_output=True)  # Compiles.
        done = subprocess.run([*command, "--facts-out", "facts"], cwd=folder, check=True, capture_output=True, text=True)
        summary = json.loads(done.stdout)
        distances, total = [], 0.0
        last = len(places) - 1 if given.disturb else 0
        for line in (folder / "facts").read_text().splitlines():
            if line.startswith("field-dist("):
                distances.append(float(line.split(", ")[1][:-2]))
            elif line.startswith(f"collect-total(@{last},"):
                total = float(line.split(", ")[1][:-2])
        print(json.dumps(summary))
        print(f"devices {len(places)} reached {len(distances)} far {max(distances):.6f} total {total:.1f}")


if __name__ == "__main__":
    main()
