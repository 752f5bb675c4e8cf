"""Recordings of `meldsim run --record` as pandas frames."""

import json

import h5py
import numpy
import pandas

from .facts import NUMBERS
from .values import value


class Recording:
    """A recording, also one that is still being written or whose run was killed: it has the steps that are whole when it is opened.

        with Recording("run.vtkhdf") as recording:
            recording.catoms(-1)
            recording.facts("dist")
    """

    def __init__(self, path):
        self._file = h5py.File(path, "r")
        kind = self._file["meld"].attrs.get("format") if "meld" in self._file else None
        if kind not in (b"claymeld recording", "claymeld recording"):
            self._file.close()
            raise ValueError(f"{path} is no recording that meldsim run --record has written")
        self._data = self._file["VTKHDF"]
        # The name Steps means another table after each step that is written, so it is looked up once.
        self._steps = self._data["Steps"]
        self.ticks = numpy.asarray(self._steps["Values"][: self._steps.attrs["NSteps"]]).astype("int64")
        listed = json.loads(self._file["meld/predicates"][()]) if "predicates" in self._file["meld"] else []
        self._predicates = {predicate["name"]: predicate for predicate in listed}
        self._texts = {}

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self._file.close()

    def __len__(self):
        return len(self.ticks)

    @property
    def predicates(self):
        """The names of the recorded predicates."""
        return list(self._predicates)

    def catoms(self, step=-1):
        """Of each catom in a step its number, position (in diameters), colour, and label and diameter if they are recorded."""
        step = self._number(step)
        positions = self._rows(self._data["Points"], self._steps["PointOffsets"][step], self._count(step))
        colours = self._array("colour", step)
        columns = {"catom": self._array("id", step), **dict(zip("xyz", positions.T)), **dict(zip(("red", "green", "blue"), colours.T))}
        if "label" in self._data["PointData"]:
            columns["label"] = self._strings("label", self._array("label", step))
        if "diameter" in self._data["PointData"]:
            columns["diameter"] = self._array("diameter", step)
        return pandas.DataFrame(columns)

    def facts(self, predicate, step=None):
        """The facts of a predicate in a step, as `claymeld.facts` has them; without a step those of all, with the column "tick" first."""
        if predicate not in self._predicates:
            raise KeyError(f"no predicate '{predicate}' is recorded; these are: {', '.join(self._predicates) or 'none'}")
        if step is not None:
            return self._facts(self._predicates[predicate], self._number(step))
        frames = [self._facts(self._predicates[predicate], number) for number in range(len(self))]
        for tick, frame in zip(self.ticks, frames):
            frame.insert(0, "tick", tick)
        return pandas.concat(frames, ignore_index=True) if frames else pandas.DataFrame()

    def _number(self, step):
        if not -len(self) <= step < len(self):
            raise IndexError(f"there is no step {step}; the recording has {len(self)}")
        return step % len(self)

    def _count(self, step):
        return self._data["NumberOfPoints"][self._steps["PartOffsets"][step]]

    @staticmethod
    def _rows(column, begin, count):
        return column[begin : begin + count]

    def _array(self, name, step):
        return self._rows(self._data["PointData"][name], self._steps["PointDataOffsets"][name][step], self._count(step))

    def _strings(self, name, numbers):
        """The strings that an array's numbers stand for; -1 for none."""
        known = self._texts.get(name, [])
        if len(known) <= numbers.max(initial=-1):
            table = self._file["meld/texts"][name]
            ends, everything = table["ends"][:], table["text"][:].tobytes()
            known = [everything[begin:end].decode("utf-8", "surrogateescape") for begin, end in zip([0, *ends], ends)]
            self._texts[name] = known
        return [known[number] if number >= 0 else None for number in numbers]

    def _facts(self, predicate, step):
        name, arguments = predicate["name"], predicate["arguments"]
        if predicate["table"]:
            begins, count = self._steps["FactOffsets"][name], self._steps["FactCounts"][name][step]
            table = self._file["meld/facts"][name]
            cells = {column: self._rows(table[column], begins[column][step], count) for column in table}
        else:
            there = self._array(f"{name}.facts" if arguments else name, step) > 0
            cells = {"catom": self._array("id", step)[there]}
            cells.update((argument["name"], self._array(argument["array"], step)[there]) for argument in arguments)
        columns = {"catom": cells["catom"]}
        for argument in arguments:
            columns.update(self._columns(argument, cells[argument["name"]]))
        return pandas.DataFrame(columns)

    def _columns(self, argument, cells):
        name, kind = argument["name"], argument["type"]
        if kind == "vec3":
            return {f"{name}.{axis}": cells[:, number] for number, axis in enumerate("xyz")}
        if kind in NUMBERS:
            return {name: cells.astype(NUMBERS[kind])}
        return {name: pandas.Series([value(text) for text in self._strings(argument["array"], cells)], dtype=object)}
