"""The arrays of a recording, step by step: its layout in HDF5 (docs/recordings.md) and nothing else."""

from __future__ import annotations

import contextlib
import json
import os
from typing import Any, Iterator, Optional

import h5py
import numpy
from numpy.typing import NDArray

from .errors import RecordingError
from .tool import Path

FORMAT, VERSION = "claymeld recording", 1


class Steps:
    """A recording, also one that is still being written or whose run was killed: it has the steps that are whole when it is opened."""

    def __init__(self, path: Path) -> None:
        self.path = os.fspath(path)
        self._texts: dict[str, list[str]] = {}
        self._columns: dict[str, NDArray[numpy.int64]] = {}
        self._counts: dict[str, tuple[tuple[int, int], int]] = {}
        try:
            self._file = h5py.File(self.path, "r")
        except FileNotFoundError:
            raise FileNotFoundError(f"there is no file {self.path}") from None
        except OSError as problem:
            raise RecordingError(f"{self.path} cannot be read as a recording: it is no HDF5 file, or not all of one ({problem}). "
                                 "`meldsim run --record` writes recordings", 6) from None
        try:
            with self._damage():
                meld = self._file["meld"].attrs if "meld" in self._file else {}
                if _text(meld.get("format", "")) != FORMAT:
                    raise RecordingError(f"{self.path} is no recording that meldsim run --record has written", 6)
                if int(meld["version"]) != VERSION:
                    raise RecordingError(f"{self.path} is a recording of version {int(meld['version'])}, and this package reads version "
                                         f"{VERSION}: use the package that came with the meldsim that wrote it", 6)
                self._data = self._file["VTKHDF"]
                # The name Steps means another table after each step that is written, so it is looked up once.
                self._steps = self._data["Steps"]
                self.ticks: NDArray[numpy.int64] = numpy.asarray(self._steps["Values"][: self._steps.attrs["NSteps"]]).astype("int64")
                self.lattice: str = _text(meld["lattice"])
                self.seed: int = int(meld["seed"]) & (1 << 64) - 1
                self.radius: float = float(meld["radius_metres"])
                self.predicates: dict[str, dict[str, Any]] = {predicate["name"]: predicate for predicate in self.json("predicates", [])}
                self.arrays = list(self._data["PointData"])
        except BaseException:
            self._file.close()
            raise

    def close(self) -> None:
        self._file.close()

    @contextlib.contextmanager
    def _damage(self) -> Iterator[None]:
        """What the library reports of a file that does not hold what it should."""
        try:
            yield
        except RecordingError:
            raise
        except (KeyError, OSError, RuntimeError, TypeError, ValueError, IndexError, AttributeError) as problem:
            if not self._file:
                raise ValueError(f"the recording {self.path} is closed") from None
            raise RecordingError(f"{self.path} is damaged: {problem}. `meldsim replay` cannot mend it; run again", 6) from problem

    # ---- what is there once

    def text(self, name: str) -> str:
        """A text of the run: "program" or "world"."""
        with self._damage():
            return _text(self._file["meld"][name][()])

    def json(self, name: str, missing: Any = None) -> Any:
        with self._damage():
            return json.loads(self._file["meld"][name][()]) if name in self._file["meld"] else missing

    def words(self) -> list[str]:
        """The command of the run."""
        with self._damage():
            return [_text(word) for word in self._file["meld/arguments"][()]]

    # ---- what is there for a step, by its number

    def count(self, step: int) -> int:
        """The number of catoms."""
        with self._damage():
            if "/counts" not in self._columns:
                self._columns["/counts"] = self._data["NumberOfPoints"][:][self._column("PartOffsets")]
            return int(self._columns["/counts"][step])

    def positions(self, step: int) -> NDArray[numpy.float32]:
        """In diameters, (catoms, 3)."""
        with self._damage():
            return self._rows(self._data["Points"], self._column("PointOffsets")[step], self.count(step))

    def array(self, name: str, step: int) -> NDArray[Any]:
        """A value for each catom, (catoms,) or (catoms, parts)."""
        with self._damage():
            return self._rows(self._data["PointData"][name], self._column(f"PointDataOffsets/{name}")[step], self.count(step))

    def same_positions(self, step: int, other: int) -> bool:
        """Whether the catoms and their places are stored once for both; they may be the same if they are not."""
        with self._damage():
            offsets = [self._column("PointOffsets"), self._column("PointDataOffsets/id")]
            return self.count(step) == self.count(other) and all(offset[step] == offset[other] for offset in offsets)

    def fact_count(self, predicate: str, step: int) -> int:
        info = self.predicates[predicate]
        if info["table"]:
            with self._damage():
                return int(self._column(f"FactCounts/{predicate}")[step])
        name = f"{predicate}.facts" if info["arguments"] else predicate
        with self._damage():
            # What has not changed since the step before is stored once, and counted once.
            rows = (int(self._column(f"PointDataOffsets/{name}")[step]), self.count(step))
        if self._counts.get(name, (None, 0))[0] != rows:
            self._counts[name] = rows, int((self.array(name, step) > 0).sum())
        return self._counts[name][1]

    def fact_rows(self, predicate: str, step: int) -> dict[str, NDArray[Any]]:
        """The facts of a recorded predicate: "catom" and the arguments, each (facts,); a vec3 is (facts, 3). What is no number is the
        number of a text."""
        info = self.predicates[predicate]
        if info["table"]:
            with self._damage():
                begins, count = f"FactOffsets/{predicate}", int(self._column(f"FactCounts/{predicate}")[step])
                table = self._file["meld/facts"][predicate]
                return {column: self._rows(table[column], self._column(f"{begins}/{column}")[step], count) for column in table}
        there = self.array(f"{predicate}.facts" if info["arguments"] else predicate, step) > 0
        rows = {"catom": self.array("id", step)[there]}
        rows.update((argument["name"], self.array(argument["array"], step)[there]) for argument in info["arguments"])
        return rows

    def digest(self, step: int) -> str:
        """Of the whole state, as --digest writes it."""
        with self._damage():
            low, high = (int(self._column(f"StateDigest{half}")[step]) & (1 << 64) - 1 for half in ("Low", "High"))
            return f"{high:016x}{low:016x}"

    def strings(self, name: str, numbers: NDArray[Any]) -> list[Optional[str]]:
        """The strings that an array's numbers stand for; None for -1."""
        known = self._texts.get(name, [])
        if len(known) <= numbers.max(initial=-1):
            with self._damage():
                table = self._file["meld/texts"][name]
                ends, everything = table["ends"][:], table["text"][:].tobytes()
                known = [everything[begin:end].decode("utf-8", "surrogateescape") for begin, end in zip([0, *ends], ends)]
            self._texts[name] = known
        with self._damage():
            return [known[number] if number >= 0 else None for number in numbers]

    def _column(self, name: str) -> NDArray[numpy.int64]:
        """A column of the table of steps, (steps,), which is read once."""
        if name not in self._columns:
            self._columns[name] = self._steps[name][: len(self.ticks)]
        return self._columns[name]

    @staticmethod
    def _rows(column: Any, begin: Any, count: int) -> NDArray[Any]:
        rows: NDArray[Any] = column[begin : begin + count]
        if len(rows) != count:
            raise ValueError(f"{column.name} has {len(rows)} rows of {count} from {begin} on")
        return rows


def _text(value: Any) -> str:
    return value.decode("utf-8", "surrogateescape") if isinstance(value, bytes) else str(value)
