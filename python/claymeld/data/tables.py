"""The facts at the end of a run, of `meldsim run --facts-out` with a folder of CSV files or an HDF5 file."""

import json
import os
from typing import Any, Callable, Mapping, Optional

import h5py
import pandas

from ..tool.calls import Path
from ..tool.errors import RecordingError
from .hdf5 import LOCK
from .values import unescaped, value

CREATOR = "claymeld"
# Of facts in HDF5.
VERSION = 1
# Types of Meld whose columns are numbers; all others are text in files.
NUMBERS = {"int": "int64", "node": "int64", "float": "float64", "bool": "bool"}

Read = Callable[[str], pandas.DataFrame]


def facts(path: Path, predicate: Optional[str] = None) -> Any:
    """A dict with a frame for each predicate, or the frame of one.

    The first column, "catom", is the number of the catom; the others are the arguments, named as the program declares them. Catoms are
    int64, ints int64, floats float64, bools bool, vec3 three columns, strings str; lists and the like are Python's.
    """
    path = os.fspath(path)
    if os.path.isdir(path):
        return _chosen(path, predicate, *_folder(path))
    if h5py.is_hdf5(path):
        return _chosen(path, predicate, *_hdf5(path))
    raise ValueError(f"{path} is neither a folder of CSV files nor an HDF5 file that meldsim run --facts-out has written")


def typed(frame: pandas.DataFrame, types: Mapping[str, str]) -> pandas.DataFrame:
    """The frame with the values of its text columns, whose types in Meld are given by column."""
    for name, type_of_column in types.items():
        if type_of_column not in NUMBERS:
            convert = unescaped if type_of_column == "string" else value
            frame[name] = [convert(text) for text in frame[name]]
            frame[name] = frame[name].astype(object)
    frame.attrs["types"] = dict(types)
    return frame


def _chosen(path: str, predicate: Optional[str], names: list[str], read: Read) -> Any:
    if predicate is None:
        return {name: read(name) for name in names}
    if predicate not in names:
        raise KeyError(f"{path} has no table '{predicate}'; it has {', '.join(names) or 'none'}")
    return read(predicate)


def _folder(path: str) -> tuple[list[str], Read]:
    try:
        with open(os.path.join(path, "datapackage.json"), encoding="utf-8") as file:
            package = json.load(file)
    except FileNotFoundError:
        package = {}
    if package.get("created_by") != CREATOR:
        raise ValueError(f"{path} is no folder that meldsim run --facts-out has written: its datapackage.json is missing or another's")
    tables = {resource["name"]: resource for resource in package["resources"]}

    def read(name: str) -> pandas.DataFrame:
        types = {field["name"]: field["meld"] for field in tables[name]["schema"]["fields"]}
        # As they stand: text is not taken for numbers or for missing, and floats are those that were written.
        dtypes = {column: NUMBERS.get(kind, str) for column, kind in types.items()}
        frame = pandas.read_csv(os.path.join(path, tables[name]["path"]), dtype=dtypes, keep_default_na=False, na_filter=False,
                                float_precision="round_trip", encoding="utf-8")
        return typed(frame, types)

    return list(tables), read


def _hdf5(path: str) -> tuple[list[str], Read]:
    with LOCK, h5py.File(path, "r") as file:
        kind = file.attrs.get("format")
        if kind != "claymeld facts":
            raise ValueError(f"{path} is no file that meldsim run --facts-out has written: its format is {kind!r}")
        version = file.attrs.get("version")
        if version != VERSION:
            raise RecordingError(f"{path} has facts in version {'none' if version is None else int(version)} of the format, and this "
                                 f"package reads version {VERSION}: use the package that came with the meldsim that wrote it", 6)
        names = list(file)

    def read(name: str) -> pandas.DataFrame:
        with LOCK, h5py.File(path, "r") as file:
            table = file[name]
            types = dict(zip(table.dtype.names, table.attrs["types"]))
            rows = table[:]
        columns = {column: rows[column] if kind in NUMBERS else [text.decode("utf-8") for text in rows[column]]
                   for column, kind in types.items()}
        return typed(pandas.DataFrame(columns), types)

    return names, read
