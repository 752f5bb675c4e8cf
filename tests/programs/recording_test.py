"""Records a run and reads it with h5py: recording_test.py MELDSIM EXAMPLES. Each tick is there once, with the colours set in it."""

import collections
import pathlib
import sys
import tempfile

import h5py

from runner import Runner
from worlds import World, box

COLOURS = {0: (215, 60, 50), 1: (245, 190, 60), 2: (60, 120, 190)}
GREY = (176, 176, 176)


def main():
    meldsim, examples = sys.argv[1], pathlib.Path(sys.argv[2])
    with tempfile.TemporaryDirectory() as folder:
        runner = Runner(meldsim, examples / "height_colour.meld", folder)
        for every, ticks in ((1, [0, 1, 2]), (2, [0, 2])):
            world = runner.folder / "world.toml"
            world.write_text(World("a bar", "cubic", box((0, 0, -9), (2, 2, 10)), f"[record]\nevery = {every}").text())
            for processes in (1, 3):
                path = runner.folder / "run.vtkhdf"
                text, _, _ = runner.run(runner.program, world, processes, 1, ("--record", path))
                layers = [int(line[:-2].split(", ")[1]) for line in text.splitlines() if line.startswith("colour(")]
                with h5py.File(path) as file:
                    steps = file["VTKHDF/Steps"]
                    if list(steps["Values"]) != ticks:
                        sys.exit(f"every {every}: the recorded ticks are {list(steps['Values'])}, not {ticks}")
                    rows = file["VTKHDF/PointData/colour"]
                    first, last = (rows[at:at + len(layers)] for at in (steps["PointDataOffsets/colour"][0], steps["PointDataOffsets/colour"][-1]))
                    if {tuple(map(int, row)) for row in first} != {GREY}:
                        sys.exit(f"the catoms are not grey at first: {collections.Counter(map(tuple, first))}")
                    if [tuple(map(int, row)) for row in last] != [COLOURS[layer] for layer in layers]:
                        sys.exit("the colours at the end are not those of the layers")


if __name__ == "__main__":
    main()
