"""Metamodules take another shape by hole motion (hole_motion.meld), on any number of processes and with several seeds: nobody is lost,
holes come into being and go, and in the end the target is full.

Usage: hole_motion_test.py MELDSIM EXAMPLES
"""

import json
import pathlib
import re
import subprocess
import sys
import tempfile

from lattice import components, touching

SIZES = "sphere(10)", "box(60, 9, 1)"
SMALL = "sphere(5)", "box(20, 7, 1)"
LOG = "type linear was(node, int, int, int).\ntick(A, T), cell(A, X, Y, _), T % 20 = 1 -o was(A, T, X, Y).\n"


def run(meldsim, program, world, seed, processes, ticks):
    """The facts at the end, and the outcome."""
    facts = world.with_suffix(".facts")
    command = [meldsim, "run", program, "--world", world, "--seed", str(seed), "-n", str(processes), "--ticks", str(ticks), "--json",
               "--facts-out", facts]
    done = subprocess.run(command, capture_output=True, text=True, timeout=280, check=True)
    return facts.read_text(), json.loads(done.stdout)["outcomes"]


def holes(cells):
    """How many empty cells have all six neighbours."""
    around = [(1, 0), (0, 1), (-1, 1), (-1, 0), (0, -1), (1, -1)]
    empty = {(x + i, y + j) for x, y in cells for i, j in around} - cells
    return sum(all((x + i, y + j) in cells for i, j in around) for x, y in empty)


def most_holes(facts):
    """The most holes at once; everybody hangs together all the time."""
    ticks = {}
    for catom, tick, x, y in re.findall(r"^was\(@(\d+), (\d+), (-?\d+), (-?\d+)\)", facts, re.M):
        ticks.setdefault(int(tick), {})[int(catom)] = (int(x), int(y))
    count = len(next(iter(ticks.values())))
    for cells in ticks.values():
        links = touching("hex", {catom: (*cell, 0) for catom, cell in cells.items()})
        assert len(set(cells.values())) == count and len(list(components(links))) == 1, cells
    return max(holes(set(cells.values())) for cells in ticks.values())


def main():
    meldsim, examples = sys.argv[1:]
    with tempfile.TemporaryDirectory() as folder:
        world, program = pathlib.Path(folder) / "bar.toml", pathlib.Path(folder) / "hole_motion.meld"
        text = pathlib.Path(examples, "hole_motion.toml").read_text()
        for large, small in zip(SIZES, SMALL):
            assert large in text
            text = text.replace(large, small)
        world.write_text(text)
        program.write_text(pathlib.Path(examples, "hole_motion.meld").read_text() + LOG)
        most = 0
        for seed in (1, 2, 3):
            some = [run(meldsim, program, world, seed, processes, 200) for processes in (1, 2, 3)]
            assert some.count(some[0]) == 3, some
            most = max(most, most_holes(some[0][0]))
            _, outcomes = run(meldsim, program, world, seed, 1, 6000)
            assert any("target reached" in line for line in outcomes), (seed, outcomes)
            print(f"seed {seed}: {outcomes}")
    assert most > 0, "there was never a hole"
    print(f"{most} holes at once")


if __name__ == "__main__":
    main()
