"""Reads recordings with steps that hold changes alone, as an outsider does: with h5py, by what docs/recordings.md says of them.

Usage: check_changes.py LISTED_WRITER read|reopened|every-write
"""

import functools
import os
import sys
import tempfile

import h5py
import numpy as np

from check_recording import check_every_write, check_reopened_every_write, check_same, check_with_vtk, texts, write_some

COUNT = 70000


class Many:
    """What write_recording.cpp records of many catoms in a step."""

    def __init__(self, before=None, step=0):
        n = np.arange(COUNT)
        if before is None:
            x = n.astype(float)
            self.points = np.stack([x, 2 * x, -x], axis=1).astype("f4")
            self.id, self.dist, self.awake = 10 * n, n.copy(), (n % 2).astype("u1")
            self.force = np.stack([0.5 * x, x, 1.5 * x], axis=1)
            self.label = np.array([""] * COUNT, dtype=object)
            return
        for name in ("points", "id", "dist", "awake", "force", "label"):
            setattr(self, name, getattr(before, name).copy())
        if step % 6 == 3:
            return
        self.dist[7919 * step % COUNT] = -step
        self.dist[31 * step % COUNT] = -2 * step
        if step % 2 == 1:
            self.points[13 * step % COUNT] = step
        self.label[5 * step % COUNT] = f"step {step % 4}"
        self.awake[3 * step % COUNT] = 2 + step % 3
        self.force[17 * step % COUNT] = [step, 2 * step, 3 * step]
        if is_whole(step):
            self.dist[: COUNT // 3] = n[: COUNT // 3] + step


def is_whole(step):
    return step == 0 or (step % 6 != 3 and step % 9 == 5)


@functools.cache
def many(step):
    return Many(many(step - 1), step) if step > 0 else Many()


def check_table(table):
    """All columns of a table of steps agree. Returns how many steps it has."""
    columns = []
    table.visititems(lambda _, column: columns.append(column) if isinstance(column, h5py.Dataset) else None)
    assert {len(column) for column in columns} == {table.attrs["NSteps"]}
    return int(table.attrs["NSteps"])


def of_step(file, table, row, name):
    """An array of a step: the rows of the whole step before it, and what has changed since."""
    root = file["VTKHDF"]
    points = name == "points"
    count = root["NumberOfPoints"][table["PartOffsets"][row]]
    begin = table["PointOffsets" if points else f"PointDataOffsets/{name}"][row]
    column = root["Points" if points else f"PointData/{name}"]
    rows = column[begin : begin + count]
    assert len(rows) == count == COUNT
    place = "Points" if points else f"PointData/{name}"
    if "StepNumber" in table and name != "id":
        begin, end = table["PointChanges" if points else f"PointDataChanges/{name}"][row]
        changes = file["meld/changes"][place]
        for at, value in zip(changes["row"][begin:end], changes["value"][begin:end]):
            rows[at] = value
    return rows


def check_many_steps(path, said, total, every, most=None):
    """A reader that comes now finds all steps that were said to be there. Returns their number."""
    with h5py.File(path, "r") as file:
        whole, changes = file["VTKHDF/Steps"], file["meld/changes/Steps"]
        whole_steps, change_steps = whole["Values"][:].astype(int).tolist(), changes["Values"][:].astype(int).tolist()
        assert check_table(whole) == len(whole_steps) and check_table(changes) == len(change_steps)
        assert all(is_whole(step) for step in whole_steps) and not any(is_whole(step) for step in change_steps)
        assert changes["StepNumber"][:].tolist() == change_steps
        count = len(whole_steps) + len(change_steps)
        assert sorted(whole_steps + change_steps) == list(range(count)), (whole_steps, change_steps)
        assert said <= count <= (most or min(said + 1, total)), (said, count)
        known = np.array(texts(file, "label"), dtype=object) if "label" in file["meld/texts"] else np.array([""], dtype=object)
        places = {step: (whole, row) for row, step in enumerate(whole_steps)}
        places.update((step, (changes, row)) for row, step in enumerate(change_steps))
        for step in range(count) if every else sorted({0, count - 1} if count else ()):
            table, row = places[step]
            for name in ("points", "id", "dist", "awake", "force"):
                assert (of_step(file, table, row, name) == getattr(many(step), name)).all(), (step, name)
            assert (known[of_step(file, table, row, "label")] == many(step).label).all(), step
            lines = step % 3
            assert file["VTKHDF/Lines/NumberOfCells"][table["PartOffsets"][row]] == lines
            begin = table["ConnectivityIdOffsets"][row, 1]
            assert file["VTKHDF/Lines/Connectivity"][begin : begin + 2 * lines].tolist() == [0, 1] * lines
            begin, facts = table["FactOffsets/steady/Value"][row], np.arange(1500)
            facts[step] = -1
            assert (file["meld/facts/steady/Value"][begin : begin + 1500] == facts).all(), step
        return count


def check_read(writer, folder):
    path = os.path.join(folder, "a.vtkhdf")
    assert write_some(writer, "many-40", path) == (0, "")
    assert check_many_steps(path, 40, 40, True) == 40
    with h5py.File(path) as file:
        assert file["meld"].attrs["version"] == 2
        # Two rows and their values in a step, not a column.
        assert len(file["meld/changes/PointData/dist/row"]) < 100
    # Readers that know nothing of changes see the whole steps, and these as they are.
    steps = [step for step in range(40) if is_whole(step)]
    check_with_vtk(path, [(step, many(step), ("dist", "awake", "force"), None, [0, 1] * (step % 3)) for step in steps])


def check_reopened(writer, folder):
    """A recording that was saved after some steps, and got more or fewer afterwards, ends as if it had never stopped."""
    path, wanted, state = (os.path.join(folder, name) for name in ("a.vtkhdf", "wanted.vtkhdf", "state"))
    assert write_some(writer, "many-16", wanted) == (0, "")
    for saved, written, closed in [(1, 1, False), (4, 9, True), (6, 7, False), (15, 16, True)]:
        os.path.exists(path) and os.unlink(path)
        assert write_some(writer, f"many-{written}", path, state, saved, *["closed"] * closed) == (0, "")
        for _ in range(2):
            assert write_some(writer, "many-16", path, state) == (0, ""), (saved, written, closed)
            check_same(path, wanted)
    # What has changed since is a part of what was saved.
    assert write_some(writer, "many-12", path, state, 10, "closed") == (0, "")
    with h5py.File(path, "r+") as file:
        file["meld/changes/PointData/dist/value"][-5] += 1
    code, words = write_some(writer, "many-16", path, state)
    assert code == 2 and "its step 9 is not the one that was written" in words, (code, words)
    # Killed while it goes on.
    for name in ("a.vtkhdf", "wanted.vtkhdf"):
        os.unlink(os.path.join(folder, name))
    check_reopened_every_write(writer, folder, stride=211, cases=((6, 9, True),), prefix="many-", check=check_many_steps)


def check_kills(writer, folder):
    check_every_write(writer, folder, steps=18, stride=23, prefix="many-", check=check_many_steps)


if __name__ == "__main__":
    checks = {"read": check_read, "reopened": check_reopened, "every-write": check_kills}
    with tempfile.TemporaryDirectory() as temporary:
        checks[sys.argv[2]](sys.argv[1], temporary)
