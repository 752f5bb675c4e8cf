"""The arrays of a recording, step by step: its layout in HDF5 (docs/recordings.md) and nothing else."""

from __future__ import annotations

import functools
import json
import os
import time
from typing import Any, Callable, Optional, TypeVar

import h5py
import numpy
from numpy.typing import NDArray

from ..tool.calls import Path
from ..tool.errors import RecordingError
from .hdf5 import LOCK

FORMAT, VERSION = "claymeld recording", 2
# One in which no step holds changes alone says that it is of the first.
READ = (1, VERSION)
# A write takes some microseconds, in which a reader can find a part of the old and a part of the new: waits before what did not fit is read
# again, and how long ago a file that is being written was written at most, in seconds.
WAITS = (0.001, 0.002, 0.004, 0.008, 0.016)
RECENT = 2.0

Method = TypeVar("Method", bound=Callable[..., Any])
# What the library reports of a file that does not hold what it should, and what that leads to here.
UNREAD = (KeyError, OSError, RuntimeError, TypeError, ValueError, IndexError, AttributeError)


def _reads(method: Method) -> Method:
    """For methods that read the file, and only read: what is wrong with it becomes a RecordingError."""

    @functools.wraps(method)
    def reading(self: Steps, *words: Any) -> Any:
        try:
            return _read(self.path, lambda: method(self, *words))
        except RecordingError:
            raise
        except UNREAD as problem:
            if not self._file:
                raise ValueError(f"the recording {self.path} is closed") from None
            raise RecordingError(f"{self.path} is damaged: {problem}. `meldsim replay` cannot mend it; run again", 6) from problem

    return reading  # type: ignore[return-value]


def _read(path: str, action: Callable[[], Any]) -> Any:
    """The action's result: threads come one after the other, and what was read while the file was being written is read again."""
    for wait in WAITS:
        try:
            with LOCK:
                return action()
        except RecordingError:
            raise
        except UNREAD:
            if not _is_being_written(path):
                raise
        time.sleep(wait)
    with LOCK:
        return action()


def _is_being_written(path: str) -> bool:
    """Whether it was written a moment ago."""
    try:
        return abs(time.time() - os.stat(path).st_mtime) < RECENT
    except OSError:
        return False


class Steps:
    """A recording, also one that is still being written or whose run was killed: it has the steps that are whole when it is opened."""

    def __init__(self, path: Path) -> None:
        self.path = os.fspath(path)
        self._texts: dict[str, list[str]] = {}
        self._columns: dict[str, NDArray[numpy.int64]] = {}
        self._counts: dict[str, tuple[tuple[int, int, int, int], int]] = {}
        try:
            self._file = _read(self.path, lambda: h5py.File(self.path, "r"))
        except FileNotFoundError:
            raise FileNotFoundError(f"there is no file {self.path}") from None
        except OSError as problem:
            raise RecordingError(f"{self.path} cannot be read as a recording: it is no HDF5 file, or not all of one ({problem}). "
                                 "`meldsim run --record` writes recordings", 6) from None
        try:
            self._read_what_it_is()
        except BaseException:
            self.close()
            raise

    def close(self) -> None:
        with LOCK:
            self._file.close()

    @_reads
    def _read_what_it_is(self) -> None:
        meld = self._file["meld"].attrs if "meld" in self._file else {}
        if _text(meld.get("format", "")) != FORMAT:
            raise RecordingError(f"{self.path} is no recording that meldsim run --record has written", 6)
        if int(meld["version"]) not in READ:
            raise RecordingError(f"{self.path} is a recording of version {int(meld['version'])}, and this package reads versions "
                                 f"{READ[0]} and {READ[1]}: use the package that came with the meldsim that wrote it", 6)
        self._data = self._file["VTKHDF"]
        # The name Steps means another table after each step that is written, so it is looked up once.
        self._tables = [self._data["Steps"]]
        self._changes = self._file.get("meld/changes")
        if self._changes is not None:
            self._tables.append(self._changes["Steps"])
        self._sizes = [int(table.attrs["NSteps"]) for table in self._tables]
        self._places = self._place_steps()
        self.ticks: NDArray[numpy.int64] = self._column("Values").astype("int64")
        self.lattice: str = _text(meld["lattice"])
        self.seed: int = int(meld["seed"]) & (1 << 64) - 1
        self.radius: float = float(meld["radius_metres"])
        self.predicates: dict[str, dict[str, Any]] = {predicate["name"]: predicate for predicate in self.json("predicates", [])}
        self.arrays: list[str] = list(self._data["PointData"])
        self.has_joints = "joints" in self._file["meld"]

    def _place_steps(self) -> list[tuple[int, int]]:
        """Of each step its table, 0 for whole ones and 1 for changes, and its row there. What the second table has after a step that the
        first one lacks has been written in the meantime, and is left out."""
        whole = self._sizes[0]
        numbers = self._tables[1]["StepNumber"][: self._sizes[1]].tolist() if len(self._tables) > 1 else []
        places: list[tuple[int, int]] = []
        for row, number in enumerate(numbers):
            missing = number - len(places)
            begin = len(places) - row
            if missing < 0 or begin + missing > whole:
                return places
            places += [(0, begin + more) for more in range(missing)] + [(1, row)]
        return places + [(0, row) for row in range(len(places) - len(numbers), whole)]

    # ---- what is there once

    @_reads
    def text(self, name: str) -> str:
        """A text of the run: "program" or "world"."""
        return _text(self._file["meld"][name][()])

    @_reads
    def json(self, name: str, missing: Any = None) -> Any:
        return json.loads(self._file["meld"][name][()]) if name in self._file["meld"] else missing

    @_reads
    def words(self) -> list[str]:
        """The command of the run."""
        return [_text(word) for word in self._file["meld/arguments"][()]]

    # ---- what is there for a step, by its number

    @_reads
    def count(self, step: int) -> int:
        """The number of catoms."""
        if "/counts" not in self._columns:
            self._columns["/counts"] = self._data["NumberOfPoints"][:][self._column("PartOffsets")]
        return int(self._columns["/counts"][step])

    @_reads
    def positions(self, step: int) -> NDArray[numpy.float32]:
        """In diameters, (catoms, 3)."""
        rows = self._rows(self._data["Points"], self._column("PointOffsets")[step], self.count(step))
        return self._changed(rows, "Points", "PointChanges", step)

    @_reads
    def array(self, name: str, step: int) -> NDArray[Any]:
        """A value for each catom, (catoms,) or (catoms, parts)."""
        rows = self._rows(self._data["PointData"][name], self._column(f"PointDataOffsets/{name}")[step], self.count(step))
        return self._changed(rows, f"PointData/{name}", f"PointDataChanges/{name}", step)

    @_reads
    def same_positions(self, step: int, other: int) -> bool:
        """Whether the catoms and their places are stored once for both; they may be the same if they are not."""
        offsets = [self._column("PointOffsets"), self._column("PointDataOffsets/id")]
        moved = self._range("PointChanges", step) == self._range("PointChanges", other)
        return moved and self.count(step) == self.count(other) and all(offset[step] == offset[other] for offset in offsets)

    @_reads
    def fact_count(self, predicate: str, step: int) -> int:
        info = self.predicates[predicate]
        if info["table"]:
            return int(self._column(f"FactCounts/{predicate}")[step])
        name = f"{predicate}.facts" if info["arguments"] else predicate
        # What has not changed since the step before is stored once, and counted once.
        rows = (int(self._column(f"PointDataOffsets/{name}")[step]), self.count(step), *self._range(f"PointDataChanges/{name}", step))
        if self._counts.get(name, (None, 0))[0] != rows:
            self._counts[name] = rows, int((self.array(name, step) > 0).sum())
        return self._counts[name][1]

    @_reads
    def fact_rows(self, predicate: str, step: int) -> dict[str, NDArray[Any]]:
        """The facts of a recorded predicate: "catom" and the arguments, each (facts,); a vec3 is (facts, 3). What is no number is the
        number of a text."""
        info = self.predicates[predicate]
        if info["table"]:
            begins, count = f"FactOffsets/{predicate}", int(self._column(f"FactCounts/{predicate}")[step])
            table = self._file["meld/facts"][predicate]
            return {column: self._rows(table[column], self._column(f"{begins}/{column}")[step], count) for column in table}
        there = self.array(f"{predicate}.facts" if info["arguments"] else predicate, step) > 0
        rows = {"catom": self.array("id", step)[there]}
        rows.update((argument["name"], self.array(argument["array"], step)[there]) for argument in info["arguments"])
        return rows

    @_reads
    def joint_rows(self, step: int) -> dict[str, NDArray[Any]]:
        """The joints that there were in this step or in those before: each column, (joints,) or (joints, 3)."""
        count, table = int(self._column("JointCount")[step]), self._file["meld/joints"]
        return {column: self._rows(table[column], self._column(f"JointOffsets/{column}")[step], count) for column in table}

    @_reads
    def digest(self, step: int) -> str:
        """Of the whole state, as --digest writes it."""
        low, high = (int(self._column(f"StateDigest{half}")[step]) & (1 << 64) - 1 for half in ("Low", "High"))
        return f"{high:016x}{low:016x}"

    @_reads
    def strings(self, name: str, numbers: NDArray[Any]) -> list[Optional[str]]:
        """The strings that an array's numbers stand for; None for -1."""
        known = self._texts.get(name, [])
        if len(known) <= numbers.max(initial=-1):
            table = self._file["meld/texts"][name]
            ends, everything = table["ends"][:], table["text"][:].tobytes()
            known = [everything[begin:end].decode("utf-8", "surrogateescape") for begin, end in zip([0, *ends], ends)]
            self._texts[name] = known
        return [known[number] if number >= 0 else None for number in numbers]

    def _column(self, name: str) -> NDArray[numpy.int64]:
        """A column of the tables of steps, (steps,), which is read once."""
        if name not in self._columns:
            tables = [table[name][:size] for table, size in zip(self._tables, self._sizes)]
            self._columns[name] = tables[0][: len(self._places)] if len(tables) == 1 else numpy.array(
                [tables[table][row] for table, row in self._places], dtype=tables[0].dtype)
        return self._columns[name]

    def _range(self, name: str, step: int) -> tuple[int, int]:
        """Which changes of a column count in a step; of a whole step none."""
        table, row = self._places[step]
        if table == 0 or name not in self._tables[1]:
            return 0, 0
        if name not in self._columns:
            self._columns[name] = self._tables[1][name][: self._sizes[1]]
        begin, end = self._columns[name][row].tolist()
        if not 0 <= begin <= end:
            raise ValueError(f"changes {begin} to {end} of {name} cannot be")
        return begin, end

    def _changed(self, rows: NDArray[Any], place: str, name: str, step: int) -> NDArray[Any]:
        """The rows of a step, made of those of the whole step before it and of the changes since; of one row the last counts."""
        begin, end = self._range(name, step)
        if begin < end:
            at, values = (self._rows(self._changes[place][part], begin, end - begin) for part in ("row", "value"))
            if at.min() < 0 or at.max() >= len(rows):
                raise ValueError(f"{place} changes where no row is")
            # From the last on, each row once: numpy does not promise an order of what is assigned twice.
            at, last = numpy.unique(at[::-1], return_index=True)
            rows[at] = values[::-1][last]
        return rows

    @staticmethod
    def _rows(column: Any, begin: Any, count: int) -> NDArray[Any]:
        rows: NDArray[Any] = column[begin : begin + count]
        if len(rows) != count:
            raise ValueError(f"{column.name} has {len(rows)} rows of {count} from {begin} on")
        return rows


def _text(value: Any) -> str:
    return value.decode("utf-8", "surrogateescape") if isinstance(value, bytes) else str(value)
