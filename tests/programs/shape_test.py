#!/usr/bin/env python3
"""Shape change as users run it: a cube becomes a bar of exactly as many cells, the same on any number of processes and
threads, checked against the bar's own cells; and the example's own world ends alike on 1 to 4 processes."""
import pathlib
import sys
import tempfile

from runner import CAMPAIGN, SIZES, Runner

WORLD = """lattice = "cubic"
[[body]]
shape = "box(8, 8, 8)"
[target]
shape = "box(4, 4, 32)"
cells = "mass"
[facts]
given-seed = ["cell == (0, 0, 0)"]
[motion]
kind = "lattice"
capacity = 1
"""
# The way along it is longer than `reach` allows at first.
THIN = WORLD.replace("box(8, 8, 8)", "box(5, 5, 5)").replace("box(4, 4, 32)", "box(1, 1, 125)")
# So far from the cube that most units find no way and stand in front of those that could still merge.
BEYOND = WORLD.replace("box(4, 4, 32)", "move(box(2, 2, 128), 0, 0, 60)")
BAR = {(x, y, z) for x in range(-2, 2) for y in range(-2, 2) for z in range(-16, 16)}


def distances(cells, seed):
    known, edge = {seed: 0}, [seed]
    while edge:
        x, y, z = edge.pop(0)
        for step in ((1, 0, 0), (-1, 0, 0), (0, 1, 0), (0, -1, 0), (0, 0, 1), (0, 0, -1)):
            there = (x + step[0], y + step[1], z + step[2])
            if there in cells and there not in known:
                known[there] = known[x, y, z] + 1
                edge.append(there)
    return known


def check_bar(outcome):
    cells = set(outcome.cell_of.values())
    assert len(outcome.cell_of) == 512, f"{len(outcome.cell_of)} catoms"
    assert cells == BAR, f"outside the bar: {sorted(cells - BAR)[:5]}, empty: {sorted(BAR - cells)[:5]}"
    assert {outcome.cell_of[catom] for catom, in outcome.facts["joined"]} == BAR, "not all have joined"
    assert not outcome.facts["cost"], "somebody still knows a way to an empty cell"
    assert not outcome.facts["loaded"], "units are left"
    assert outcome.summary["outcomes"][0].startswith("target reached in"), outcome.summary["outcomes"]


def main():
    meldsim, examples = sys.argv[1], pathlib.Path(sys.argv[2])
    with tempfile.TemporaryDirectory() as folder:
        runner = Runner(meldsim, examples / "shape_change.meld", folder)
        world = pathlib.Path(folder) / "bar.toml"
        world.write_text(WORLD)
        outcome = runner.run_sizes(world)
        check_bar(outcome)
        print(f"cube to bar: {outcome.summary['outcomes'][0]} on {len(SIZES)} sizes")
        world.write_text(THIN)
        for options, result in (((), "target not reached"), (("--set", "reach=60.0"), "target reached")):
            ended = runner.run_plainly(world, 1, 1, options)
            assert ended[1].startswith(result), f"a thin bar {options}: {ended[1]}"
        world.write_text(BEYOND)
        ended = runner.run_plainly(world, 1, 1, ("--set", "reach=4.0", "--timeout", "60"))
        assert ended[1].startswith("target not reached"), f"a bar beyond reach: {ended[1]}"
        own = None
        sizes = ((1, 1), (1, 2), (2, 1), (3, 1), (4, 2)) if CAMPAIGN else ((1, 1), (3, 1))
        for processes, threads in sizes:
            ended = runner.run_plainly(examples / "shape_change.toml", processes, threads)
            own = own or ended
            assert ended == own, f"{processes} processes of {threads} threads end otherwise"
        assert "target reached" in own[1], own[1]
        print(f"cube to trumpet: {own[1]} on {len(sizes)} sizes")


if __name__ == "__main__":
    main()
