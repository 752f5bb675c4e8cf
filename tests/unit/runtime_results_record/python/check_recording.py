"""Reads recordings as an outsider does: with h5py, by the published layout of VTKHDF, and with VTK's own reader if it is there.

Usage: check_recording.py WRITER layout|killed|full-disk|every-write|every-write-long|reopened|reopened-every-write|...-long
"""

import os
import random
import resource
import shutil
import struct
import subprocess
import sys
import tempfile
import xml.etree.ElementTree as xml

import h5py
import numpy as np

KINDS = ["Vertices", "Lines", "Polygons", "Strips"]


class Expected:
    """What write_recording.cpp records for an ensemble of this size and shift."""

    def __init__(self, count, shift):
        n = np.arange(count)
        x = n + float(shift)
        self.points = np.stack([x, 2 * x, -x], axis=1).astype("f4").reshape(-1, 3)
        self.id = 10 * n
        self.dist = n * n - shift
        self.force = np.stack([0.5 * x, x, 1.5 * x], axis=1).reshape(-1, 3)
        self.awake = ((n + shift) % 2).astype("u1")
        self.label = ["" if k % 3 == 0 else f"[{k}, é]" for k in n + shift]
        self.table = [(10 * k, j * k - shift, k + shift, 0.1 * (k + shift), j, f'"{k + shift}"')
                      for k in range(count) for j in range((k + shift) % 3)]


def rows(root, step, path, offset):
    """The rows of one column that belong to a step, found as VTK's reader finds them."""
    steps = root["Steps"]
    part = steps["PartOffsets"][step]
    assert steps["NumberOfParts"][step] == 1
    count = root["NumberOfPoints"][part]
    begin = steps[offset][step]
    column = root[path]
    assert begin + count <= column.shape[0], (path, step, begin, count, column.shape)
    return column[begin : begin + count]


def array(root, step, name):
    return rows(root, step, f"PointData/{name}", f"PointDataOffsets/{name}")


def texts(file, name):
    """The texts that an array's numbers stand for; -1, the last one, for none."""
    table = file["meld/texts"][name]
    ends, everything = table["ends"][:], table["text"][:].tobytes()
    return [everything[begin:end].decode() for begin, end in zip([0, *ends], ends)] + [""]


def table(file, step):
    """The facts of a step in the table "many"."""
    steps, many, columns = file["VTKHDF/Steps"], file["meld/facts/many"], {}
    count = steps["FactCounts/many"][step]
    for name, column in many.items():
        begin = steps["FactOffsets/many"][name][step]
        assert begin % column.chunks[0] == 0 and begin + count <= len(column)
        columns[name] = column[begin : begin + count].tolist()
    known = texts(file, "many.Name")
    return [(c, p, *place, known[n]) for c, p, place, n in zip(*(columns[name] for name in ("catom", "Product", "Place", "Name")))]


def check_steady(file, step):
    """The table "steady", in which one fact differs from step to step."""
    steps, columns = file["VTKHDF/Steps"], file["meld/facts/steady"]
    count = steps["FactCounts/steady"][step]
    begins = {name: steps["FactOffsets/steady"][name][step] for name in columns}
    assert count == 1500 and all(begin % columns[name].chunks[0] == 0 for name, begin in begins.items())
    values = np.arange(count)
    assert (columns["catom"][begins["catom"] :][:count] == values).all(), step
    values[step] = -1
    assert (columns["Value"][begins["Value"] :][:count] == values).all(), step


def labels(file, step, known):
    return [known[number] for number in array(file["VTKHDF"], step, "label")]


ANGLE, FAN = [0, 1, 1, 2], [29, 0, 29, 1, 29, 2]


def check_cells(root, step, lines):
    """Each catom is a vertex, and lines are between them, in the arithmetic of the readers of VTK 9.3 and of 9.4."""
    steps = root["Steps"]
    part = steps["PartOffsets"][step]
    count = root["NumberOfPoints"][part]
    for kind, name in enumerate(KINDS):
        cells = root[name]["NumberOfCells"][part]
        ends = [np.arange(count), np.array(lines, int), [], []][kind]
        size = 2 if kind == 1 else 1
        assert cells == len(ends) // size
        assert root[name]["NumberOfConnectivityIds"][part] == len(ends)
        cell_offset = steps["CellOffsets"][step, kind]
        passed, before = 0, 0
        for earlier in root[name]["NumberOfCells"][:part]:
            if passed >= cell_offset:
                break
            before += 1
            passed += earlier
        for begin in {cell_offset + part, cell_offset + before}:
            offsets = root[name]["Offsets"][begin : begin + cells + 1]
            assert (offsets == size * np.arange(cells + 1)).all() and len(offsets) == cells + 1, (step, name, begin, offsets)
        begin = steps["ConnectivityIdOffsets"][step, kind]
        assert (root[name]["Connectivity"][begin : begin + len(ends)] == ends).all()


def check_with_vtk(path, expected):
    try:
        from vtkmodules.util.numpy_support import vtk_to_numpy
        from vtkmodules.vtkIOHDF import vtkHDFReader
    except ImportError:
        return
    reader = vtkHDFReader()
    reader.SetFileName(path)
    reader.UpdateInformation()
    assert reader.GetNumberOfSteps() == len(expected), reader.GetNumberOfSteps()
    for step, (time, ensemble, names, _, lines) in enumerate(expected):
        reader.SetStep(step)
        reader.Update()
        data = reader.GetOutput()
        assert data.GetNumberOfPoints() == len(ensemble.id), (step, data.GetNumberOfPoints())
        assert data.GetNumberOfVerts() == len(ensemble.id)
        assert data.GetNumberOfLines() == len(lines) // 2
        if len(ensemble.id) == 0:
            continue
        assert (vtk_to_numpy(data.GetPoints().GetData()) == ensemble.points).all()
        for name in names:
            found = vtk_to_numpy(data.GetPointData().GetArray(name))
            assert (found == getattr(ensemble, name)).all(), (step, name)
    print("read with VTK's own reader as well")


def check_line_sidecar(path, file, expected):
    """Steps without lines are left out, and the one in which neither catoms nor lines have moved."""
    grids = xml.parse(path + ".lines.xdmf").getroot().findall("./Domain/Grid/Grid")
    shown = [(time, ensemble, lines) for time, ensemble, _, _, lines in expected if lines and time != 2.75]
    assert len(grids) == len(shown)
    for grid, (time, ensemble, lines) in zip(grids, shown):
        assert float(grid.find("Time").get("Value")) == time
        topology = grid.find("Topology")
        assert (topology.get("TopologyType"), topology.get("NodesPerElement")) == ("Polyline", "2")
        assert int(topology.get("NumberOfElements")) == len(lines) // 2
        selection, source = topology.findall("DataItem/DataItem")
        begin, stride, count = map(int, selection.text.split())
        assert stride == 1
        assert list(file[source.text.split(":")[1]][begin : begin + count]) == lines
        assert grid.find("Geometry/DataItem").get("Dimensions") == f"{len(ensemble.id)} 3"


def check_sidecar(path, file, expected):
    """Steps without catoms are left out, and the one in which only lines are new."""
    grids = xml.parse(path + ".xdmf").getroot().findall("./Domain/Grid/Grid")
    shown = [entry for entry in expected if len(entry[1].id) > 0 and entry[0] != 0.5]
    assert len(grids) == len(shown)
    for grid, (time, ensemble, names, _, _) in zip(grids, shown):
        assert float(grid.find("Time").get("Value")) == time
        assert int(grid.find("Topology").get("NumberOfElements")) == len(ensemble.id)
        items = {"points": grid.find("Geometry/DataItem")}
        for attribute in grid.findall("Attribute"):
            items[attribute.get("Name")] = attribute.find("DataItem")
        assert set(items) >= {"points", "id", *names}
        for name in ["points", "id", *names]:
            selection, source = items[name].findall("DataItem")
            name_of_file, path_in_file = source.text.split(":")
            assert name_of_file == os.path.basename(path)
            column = file[path_in_file]
            begin, stride, count = np.array(selection.text.split(), int).reshape(3, -1)
            assert (stride == 1).all() and list(count) == [int(n) for n in items[name].get("Dimensions").split()]
            found = column[begin[0] : begin[0] + count[0]]
            assert (found == getattr(ensemble, name)).all()


def check_layout(writer, folder):
    path = os.path.join(folder, "a run.vtkhdf")
    subprocess.run([writer, "layout", path], check=True)
    assert sorted(os.listdir(folder)) == ["a run.vtkhdf", "a run.vtkhdf.lines.xdmf", "a run.vtkhdf.xdmf"]
    first, moved, fewer, nobody, big = (Expected(*e) for e in [(100, 0), (100, 1), (30, 2), (0, 0), (200000, 3)])
    mixed, nearly = Expected(100, 1), Expected(200000, 3)
    mixed.dist = first.dist
    nearly.dist[70000], nearly.awake[199999], nearly.force[131072, 0] = 5, 2, 0.25
    three = ["dist", "awake", "force"]
    expected = [
        (0.0, first, three[:2], ["force"], []),
        (0.5, first, three[:2], ["force"], ANGLE),
        (1.0, mixed, three[:2], ["force"], ANGLE),
        (1.5, fewer, three, [], FAN),
        (2.0, nobody, three, [], []),
        (2.5, big, three, [], ANGLE),
        (2.75, nearly, three, [], ANGLE),
        (3.0, first, ["dist"], ["awake", "force"], []),
    ]
    with h5py.File(path, "r") as file:
        root = file["VTKHDF"]
        assert list(root.attrs["Version"]) == [2, 0]
        assert root.attrs["Type"] == b"PolyData"
        kind = root.attrs.get_id("Type").get_type()
        assert kind.get_size() == 8 and kind.get_cset() == h5py.h5t.CSET_ASCII and not kind.is_variable_str()
        steps = root["Steps"]
        assert steps.attrs["NSteps"] == len(expected)
        assert list(steps["Values"]) == [entry[0] for entry in expected]
        assert steps["CellOffsets"].shape == steps["ConnectivityIdOffsets"].shape == (len(expected), 4)
        for step, (_, ensemble, names, missing, lines) in enumerate(expected):
            assert (rows(root, step, "Points", "PointOffsets") == ensemble.points).all()
            assert (array(root, step, "id") == ensemble.id).all()
            for name in names:
                assert (array(root, step, name) == getattr(ensemble, name)).all(), (step, name)
            for name in missing:
                blank = array(root, step, name)
                assert np.isnan(blank).all() if blank.dtype.kind == "f" else (blank == 0).all()
            check_cells(root, step, lines)
            assert table(file, step) == (moved if ensemble is mixed else ensemble).table, step
        for begins in steps["FactOffsets/many"].values():
            assert begins[1] == begins[0] != begins[2], "what has not changed is not written again"

        known = texts(file, "label")
        assert len(set(known)) == len(known)
        for step, (_, ensemble, _, _, _) in enumerate(expected):
            label = moved.label if ensemble is mixed else ensemble.label
            assert labels(file, step, known) == label, step

        offsets = {name: list(column) for name, column in steps["PointDataOffsets"].items()}
        assert set(offsets) == {"id", "label", *three}
        # Nothing changed: all offsets repeat. Then one array is the same, the others are not.
        assert steps["PointOffsets"][1] == steps["PointOffsets"][0] != steps["PointOffsets"][2]
        assert all(offsets[name][1] == offsets[name][0] for name in ["id", "dist", "awake", "label"])
        assert offsets["dist"][2] == offsets["dist"][0] and offsets["id"][2] == offsets["id"][0]
        assert offsets["awake"][2] != offsets["awake"][0]
        for name in ["Points", *(f"PointData/{name}" for name in offsets)]:
            column = root[name]
            begins = steps["PointOffsets"] if name == "Points" else offsets[os.path.basename(name)]
            assert all(begin % column.chunks[0] == 0 for begin in begins), "steps begin on chunk boundaries"
        dist = root["PointData/dist"]
        before, after = ([dist.id.read_direct_chunk((offsets["dist"][step] + at,)) for at in range(0, 200000, dist.chunks[0])]
                         for step in (5, 6))
        assert [at for at, chunk in enumerate(after) if chunk != before[at]] == [70000 // dist.chunks[0]]

        run = file["meld"]
        assert run.attrs["format"] == b"claymeld recording" and run.attrs["version"] == 1
        assert int(run.attrs["seed"]) == 0xFEDCBA9876543210
        assert run.attrs["lattice"] == b"fcc" and run.attrs["radius_metres"] == 0.5e-3
        assert run["program"][()].decode() == "dist(A, 0) :- source(A). ⟶"
        assert run["world"][()].decode() == 'lattice = "fcc"'
        assert [text.decode() for text in run["arguments"]] == ["run", "a file.meld"]
        check_sidecar(path, file, expected)
        check_line_sidecar(path, file, expected)
    check_with_vtk(path, expected)


def check_steps(path, at_least):
    """All steps that an endless recording lists are complete and correct."""
    with h5py.File(path, "r") as file:
        root = file["VTKHDF"]
        count = root["Steps"].attrs["NSteps"]
        known = texts(file, "label") if "label" in file["meld/texts"] else []
        assert count >= at_least, (count, at_least)
        for step in range(count):
            ensemble = Expected(1000, step)
            assert (rows(root, step, "Points", "PointOffsets") == ensemble.points).all(), step
            assert (array(root, step, "dist") == ensemble.dist).all(), step
            assert (array(root, step, "awake") == ensemble.awake).all(), step
            assert labels(file, step, known) == ensemble.label, step
            assert table(file, step) == ensemble.table, step
    return count


def check_killed(writer, folder):
    dice = random.Random(7)
    for trial in range(20):
        path = os.path.join(folder, f"{trial}.vtkhdf")
        process = subprocess.Popen([writer, "endless", path], stdout=subprocess.PIPE, text=True)
        last = dice.randrange(1, 150)
        for line in process.stdout:
            if int(line) == last:
                break
        # The writer is now somewhere in a later step.
        for _ in range(dice.randrange(20000)):
            pass
        process.kill()
        process.wait()
        check_steps(path, last)


WRITE, LENGTH, SAID, NAMED = range(4)


def listed_writes(path):
    """What write_log.cpp has listed: the inode, the kind, where, and the bytes."""
    with open(path, "rb") as log:
        while header := log.read(32):
            inode, kind, at, size = struct.unpack("<4Q", header)
            yield inode, kind, at, log.read(size)


def check_some_steps(path, said, total, every, most=None):
    """A reader that comes now finds all steps that were said to be there, and tables that agree. Returns the number of steps."""
    with h5py.File(path, "r") as file:
        root = file["VTKHDF"]
        steps = root["Steps"]
        count = int(steps.attrs["NSteps"])
        assert said <= count <= (most or min(said + 1, total)), (said, count)
        assert list(steps["Values"]) == list(range(count)), (count, list(steps["Values"]))
        columns = []
        steps.visititems(lambda _, column: columns.append(column) if isinstance(column, h5py.Dataset) else None)
        assert {len(column) for column in columns} == {count}
        known = texts(file, "label") if "label" in file["meld/texts"] else []
        arrays = set(steps["PointDataOffsets"])
        for step in range(count) if every else sorted({0, count // 2, count - 1} if count else ()):
            ensemble = Expected(20 + 30 * (step // 2), step)
            assert (rows(root, step, "Points", "PointOffsets") == ensemble.points).all(), step
            assert (array(root, step, "id") == ensemble.id).all() and (array(root, step, "dist") == ensemble.dist).all(), step
            assert labels(file, step, known) == ensemble.label, step
            check_cells(root, step, [0, 1] * (step % 3))
            assert table(file, step) == (ensemble.table if step > 0 else []), step
            check_steady(file, step)
            if "force" in arrays:
                force = array(root, step, "force")
                assert (force == ensemble.force).all() if step >= 5 else np.isnan(force).all(), step
        return count


PAGE = 4096


def cut_short(file, at, data):
    """The beginnings of a write that a kill may leave alone, where they change only a part of what was there: the system writes page by
    page."""
    old = os.pread(file.fileno(), len(data), at)
    for cut in range(PAGE - at % PAGE, len(old), PAGE):
        if data[:cut] != old[:cut] and data[cut : len(old)] != old[cut:]:
            yield data[:cut]


def check_every_write(writer, folder, steps=40, stride=11, every=False, prefix="", check=check_some_steps):
    """The writer, killed after each of its writes (after every `stride`-th) and in the midst of them (in every `stride`-th, or in all of
    a short recording): all steps that it had told are there."""
    path, log = os.path.join(folder, "a.vtkhdf"), os.path.join(folder, "log")
    subprocess.run([writer, f"{prefix}{steps}", path], check=True, stdout=subprocess.PIPE, env={**os.environ, "WRITE_LOG": log})
    inode, killed = os.stat(path).st_ino, os.path.join(folder, "killed.vtkhdf")
    said, seen, tried, cuts = 0, 0, 0, 0
    # Before the file has its name nobody looks for it.
    named = not any(where == inode and kind == NAMED for where, kind, _, _ in listed_writes(log))
    with open(killed, "w+b", buffering=0) as file:
        for number, (where, kind, at, data) in enumerate(listed_writes(log)):
            if kind == SAID:
                said = int(data.split()[-1])
            if where != inode or kind == SAID:
                continue
            if kind == NAMED:
                named = True
            if kind == WRITE:
                for beginning in cut_short(file, at, data) if named else ():
                    cuts += 1
                    os.pwrite(file.fileno(), beginning, at)
                    if steps <= 40 or cuts % stride == 0:
                        try:
                            check(killed, said, steps, every)
                        except Exception as error:
                            raise AssertionError(f"killed in write {number} of {len(data)} at {at}, {said} steps told") from error
                os.pwrite(file.fileno(), data, at)
            elif kind == LENGTH:
                os.ftruncate(file.fileno(), at)
            if named and (kind == NAMED or said == 0 or number % stride == 0):
                try:
                    seen = max(seen, check(killed, said, steps, every))
                except Exception as error:
                    raise AssertionError(f"killed after write {number}, {kind} of {len(data)} at {at}, {said} steps told") from error
                tried += 1
    assert said == steps
    check(killed, steps, steps, True)
    with open(killed, "rb") as made, open(path, "rb") as whole:
        assert made.read() == whole.read(), "the list of writes lacks some"
    print(f"{tried} kills after writes, {cuts} writes cut short, {os.path.getsize(path)} bytes")


def check_every_write_long(writer, folder):
    check_every_write(writer, folder, steps=40, stride=3, every=True)
    # So many chunks that their indexes grow several times; a sample, for there are some forty thousand writes.
    # Nothing is in its place: else it would have its name only at the end.
    for name in ("log", "a.vtkhdf"):
        os.unlink(os.path.join(folder, name))
    check_every_write(writer, folder, steps=600, stride=97)


def contents(path):
    """All that a reader can find: data, shapes, attributes and links."""
    found = {}
    with h5py.File(path, "r") as file:
        def visit(name, item):
            entry = dict(item.attrs.items()), {}
            if isinstance(item, h5py.Dataset):
                entry = entry[0], (item.shape, item.chunks, str(item.dtype), item[()] if item.shape == () else item[...].tolist())
            found[name] = repr(entry)
        file.visititems(visit)
        found["link"] = file["VTKHDF"].get("Steps", getlink=True).path
        if "meld/changes" in file:
            found["link of changes"] = file["meld/changes"].get("Steps", getlink=True).path
    return found


def check_same(path, wanted):
    """Two recordings hold the same, and so do their sidecars, but for the name of the file."""
    assert contents(path) == contents(wanted), [name for name, entry in contents(wanted).items() if contents(path).get(name) != entry]
    for sidecar in (".xdmf", ".lines.xdmf"):
        texts = []
        for each in (path, wanted):
            with open(each + sidecar, encoding="utf-8") as file:
                texts.append(file.read().replace(os.path.basename(each), "NAME"))
        assert texts[0] == texts[1], sidecar


def write_some(writer, *words, **environment):
    done = subprocess.run([writer, *map(str, words)], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True,
                          env={**os.environ, **environment})
    return done.returncode, done.stderr


def check_reopened(writer, folder, steps=29):
    """A recording that was saved after some steps, and got more or fewer afterwards, ends as if it had never stopped."""
    path, wanted, state = (os.path.join(folder, name) for name in ("a.vtkhdf", "wanted.vtkhdf", "state"))
    assert write_some(writer, steps, wanted) == (0, "")
    for saved, written, closed in [(6, 6, False), (6, 7, False), (7, 7, True), (7, 9, False), (9, 30, True), (29, 40, True)]:
        os.path.exists(path) and os.unlink(path)
        assert write_some(writer, written, path, state, saved, *["closed"] * closed) == (0, "")
        assert write_some(writer, steps, path, state) == (0, ""), (saved, written, closed)
        check_same(path, wanted)
        # Once more, from what is whole.
        assert write_some(writer, steps, path, state) == (0, ""), (saved, written, closed)
        check_same(path, wanted)
    # What is not the recording that was saved is left as it is.
    write_some(writer, 20, path, state, 10, "closed")
    os.rename(path, path + ".whole")
    with open(path + ".whole", "rb") as whole:
        data = whole.read()
    shutil.copyfile(path + ".whole", path)
    with h5py.File(path, "r+") as changed:
        changed["VTKHDF/PointData/dist"][int(changed["VTKHDF/Steps/PointDataOffsets/dist"][9]) + 3] += 1
    with open(path, "rb") as changed:
        changed_data = changed.read()

    def with_number(place, row, number):
        shutil.copyfile(path + ".whole", path)
        with h5py.File(path, "r+") as file:
            file[place][row] = number
        with open(path, "rb") as file:
            return file.read()

    parts = [with_number("VTKHDF/Lines/NumberOfCells", 0, number) for number in (-1, 1 << 20, 1 << 62)]
    parts += [with_number("VTKHDF/NumberOfPoints", 0, -1)]
    texts = [with_number("meld/texts/" + next(iter(h5py.File(path)["meld/texts"])) + "/ends", 0, -1)]
    for other, says in [(None, "it is gone"), (b"x", "it is shorter than it was"), (b"x" * 10_000_000, "signature not found"),
                        (data[:8], "shorter"), (data[:5000], "shorter"), (changed_data, "its step 9 is not the one that was written"),
                        *[(part, "its part 0 has other catoms or lines than were written") for part in parts],
                        *[(text, "its strings are not those that were written") for text in texts]]:
        os.path.exists(path) and os.unlink(path)
        if other is not None:
            with open(path, "wb") as file:
                file.write(other)
        code, words = write_some(writer, 30, path, state)
        assert code == 2 and "cannot go on with" in words and says in words, (says, code, words)
        if other is not None:
            with open(path, "rb") as file:
                assert file.read() == other, "a file that is refused has changed"


def check_reopened_every_write(writer, folder, stride=83, cases=((6, 9, True), (10, 13, False)), prefix="", check=check_some_steps):
    """Whoever goes on with a recording and is killed after any of its writes leaves the steps that were saved, to go on with again."""
    path, wanted, state, log = (os.path.join(folder, name) for name in ("a.vtkhdf", "wanted.vtkhdf", "state", "log"))
    steps, tried = 16, 0
    assert write_some(writer, f"{prefix}{steps}", wanted) == (0, "")
    for saved, written, closed in cases:
        os.path.exists(path) and os.unlink(path)
        assert write_some(writer, f"{prefix}{written}", path, state, saved, *["closed"] * closed) == (0, "")
        killed = os.path.join(folder, "killed.vtkhdf")
        shutil.copyfile(path, killed)
        assert write_some(writer, f"{prefix}{steps}", path, state, WRITE_LOG=log) == (0, "")
        inode, said = os.stat(path).st_ino, saved
        with open(killed, "r+b", buffering=0) as file:
            for number, (where, kind, at, data) in enumerate(listed_writes(log)):
                if kind == SAID:
                    said = int(data.split()[-1])
                if where != inode or kind not in (WRITE, LENGTH):
                    continue
                if kind == WRITE:
                    os.pwrite(file.fileno(), data, at)
                else:
                    os.ftruncate(file.fileno(), at)
                if number % stride != 0:
                    continue
                try:
                    check(killed, said, max(steps, written), False, most=max(written, said + 1))
                    # Its place is where it was.
                    shutil.copyfile(killed, path)
                    went_on = write_some(writer, f"{prefix}{steps}", path, state)
                    assert went_on == (0, ""), went_on
                    check_same(path, wanted)
                except Exception as error:
                    raise AssertionError(f"killed after write {number}, {kind} of {len(data)} at {at}, {said} steps told") from error
                tried += 1
        os.unlink(log)
    print(f"{tried} kills")


def check_reopened_every_write_long(writer, folder):
    cases = ((6, 6, False), (6, 7, False), (6, 9, True), (10, 13, False), (11, 40, True))
    check_reopened_every_write(writer, folder, stride=3, cases=cases)


def check_full_disk(writer, folder):
    """A limit on the size of files stands for the disk: it, too, fails in the middle of a write."""
    for limit in [0, 1000, 5000, 10_000, 50_000, 500_000, 1_000_003, 2_000_000, 5_000_001]:
        path = os.path.join(folder, f"{limit}.vtkhdf")
        with open(path, "w") as earlier:
            earlier.write("a recording of yesterday")
        result = subprocess.run(
            [writer, "endless", path],
            preexec_fn=lambda: resource.setrlimit(resource.RLIMIT_FSIZE, (limit, limit)),
            capture_output=True,
            text=True,
            timeout=60,
        )
        assert result.returncode == 4, (limit, result)
        assert result.stderr.count("\n") == 1 and "cannot write" in result.stderr, result.stderr
        with open(path) as earlier:
            assert earlier.read() == "a recording of yesterday"
        # The new one is beside it, with all steps that were told, and the message says where; or there is none.
        told = int(result.stdout.split()[-1]) if result.stdout else 0
        beside = [name for name in os.listdir(folder) if name.startswith(f"{limit}.part-")]
        if told > 0:
            assert os.path.join(folder, beside[0]) in result.stderr, result.stderr
        for name in beside:
            check_steps(os.path.join(folder, name), told)


if __name__ == "__main__":
    checks = {"layout": check_layout, "killed": check_killed, "full-disk": check_full_disk,
              "every-write": check_every_write, "every-write-long": check_every_write_long, "reopened": check_reopened,
              "reopened-every-write": check_reopened_every_write, "reopened-every-write-long": check_reopened_every_write_long}
    with tempfile.TemporaryDirectory() as temporary:
        checks[sys.argv[2]](sys.argv[1], temporary)
