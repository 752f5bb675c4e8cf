"""Records runs and reads them with h5py: recording_test.py MELDSIM EXAMPLES. Each tick is there once, with the colours set in it;
what catoms draw stays with them where they go, whatever part of the run they are on."""

import collections
import pathlib
import sys
import tempfile

import h5py

from runner import Runner
from worlds import World, box

COLOURS = {0: (215, 60, 50), 1: (245, 190, 60), 2: (60, 120, 190)}
GREY = (176, 176, 176)


# Catoms that are coloured, labelled and joined by lines, and then scatter over several bricks.
SCATTER = """
type linear go(node, int Turn).
type mark(node, int).
go(A, 0).
mark(A, I)         :- id(A, I).
setColor(A, I, 2 * I, 200) :- id(A, I).
setLabel(A, "catom " ++ int2str(I)) :- id(A, I), I % 3 = 0.
drawLine(A, B)     :- id(A, I), neighbor(A, B), node2int(B) = I + 1.
go(A, 0), id(A, I) -o moveTo(A, 40 * I, 5, 0)@+3, go(A, 1)@+6.
go(A, 1), id(A, 2) -o setLabel(A, "late"), drawLine(A, @0)@+2, go(A, 2)@+4.
go(A, 2)           -o drawLine(A, A).
"""


def drawn(path):
    """Of every step, of each catom its number, place, colour and label; and the lines, by numbers."""
    with h5py.File(path) as file:
        data, steps = file["VTKHDF"], file["VTKHDF/Steps"]
        table = file["meld/texts/label"]
        ends, text = list(table["ends"]), table["text"][:].tobytes()
        labels = [text[begin:end].decode() for begin, end in zip([0, *ends], ends)] + [None]
        for step in range(steps.attrs["NSteps"]):
            part = steps["PartOffsets"][step]
            count, lines = data["NumberOfPoints"][part], data["Lines/NumberOfCells"][part]
            rows = {name: data["PointData"][name][offset[step]:offset[step] + count] for name, offset in steps["PointDataOffsets"].items()}
            places = data["Points"][steps["PointOffsets"][step]:][:count]
            catoms = {int(i): (place.tolist(), colour.tolist(), labels[label])
                      for i, place, colour, label in zip(rows["id"], places, rows["colour"], rows["label"])}
            ends = data["Lines/Connectivity"][steps["ConnectivityIdOffsets"][step, 1]:][:2 * lines].reshape(-1, 2)
            yield int(steps["Values"][step]), catoms, [(int(rows["id"][a]), int(rows["id"][b])) for a, b in ends]


def check_drawing(meldsim, folder):
    program, path = folder / "scatter.meld", folder / "scatter.vtkhdf"
    program.write_text(SCATTER)
    runner = Runner(meldsim, program, folder)
    world = folder / "scatter.toml"
    world.write_text(World("a row", "square", box((0, 0, 0), (6, 1, 1)), '[motion]\nkind = "lattice"\n[record]\nevery = 3').text())
    first = None
    for processes in (1, 2, 3):
        runner.run(program, world, processes, 1, ("--record", path))
        steps = list(drawn(path))
        first = first or steps
        if steps != first:
            sys.exit(f"{processes} processes: another picture than of one:\n{steps}\n{first}")
    chain = [(i, i + 1) for i in range(5)]
    for tick, catoms, lines in first[1:]:
        if [colour for _, colour, _ in catoms.values()] != [[i, 2 * i, 200] for i in range(6)]:
            sys.exit(f"tick {tick}: catoms have lost their colours: {catoms}")
        wanted = {0: "catom 0", 3: "catom 3"} | ({2: "late"} if tick >= 8 else {})
        if {i: label for i, (_, _, label) in catoms.items() if label is not None} != wanted:
            sys.exit(f"tick {tick}: catoms have lost their labels: {catoms}")
        extra = [(2, 0)] if 9 <= tick < 12 else []
        if lines != sorted(chain[:2] + extra + chain[2:] if tick < 12 else chain[:2] + chain[3:]):
            sys.exit(f"tick {tick}: the lines are {lines}")
    if not any(place[0] == 200 for _, catoms, _ in first for place, _, _ in catoms.values()):
        sys.exit("nobody has moved")


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
                    first, last = (rows[at:at + len(layers)]
                                   for at in (steps["PointDataOffsets/colour"][0], steps["PointDataOffsets/colour"][-1]))
                    if {tuple(map(int, row)) for row in first} != {GREY}:
                        sys.exit(f"the catoms are not grey at first: {collections.Counter(map(tuple, first))}")
                    if [tuple(map(int, row)) for row in last] != [COLOURS[layer] for layer in layers]:
                        sys.exit("the colours at the end are not those of the layers")
        check_drawing(meldsim, pathlib.Path(folder))


if __name__ == "__main__":
    main()
