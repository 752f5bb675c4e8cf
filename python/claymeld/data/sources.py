"""What a run is made from, as users of Python have it: programs and worlds as paths, as text or as dicts; constants as values."""

from __future__ import annotations

import json
import math
import os
import pathlib
import re
import tomllib
from collections.abc import Set
from typing import Any, Iterable, Mapping, Optional, Sequence, Union

from ..tool.calls import Path
from ..tool.errors import WorldError
from .scratch import Scratch

World = Union[Path, Mapping[str, Any], None]
# As meldsim has it where no world is beside the program.
DEFAULT_WORLD = 'lattice = "cubic"\n\n[[body]]\nshape = "box(10, 10, 10)"\n'


class Literal(str):
    """Text that stands for a value in Meld as it is, as in `run(..., start=Literal("vec3(0.0, 1.0, 2.0)"))`."""


def literal(value: Any) -> str:
    """A value of Python as Meld writes it: bool, int, float, str, list, set, tuple, and numpy's scalars and arrays.

    Raises
    ------
    TypeError, ValueError
        Meld has no such value: None, inf, nan.
    """
    if isinstance(value, Literal):
        return str(value)
    if hasattr(value, "tolist"):
        value = value.tolist()
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, int):
        return str(value)
    if isinstance(value, float):
        if not math.isfinite(value):
            raise ValueError(f"Meld has no {value}: a constant is a finite number")
        mantissa, e, exponent = repr(value).partition("e")
        return (mantissa if "." in mantissa else mantissa + ".0") + e + exponent
    if isinstance(value, str):
        escapes = {'"': '\\"', "\\": "\\\\", "\n": "\\n", "\t": "\\t", "\r": "\\r"}
        return '"' + "".join(escapes.get(c, c if c >= " " and c != "\x7f" else f"\\x{ord(c):02x}") for c in value) + '"'
    if isinstance(value, (list, tuple, set, frozenset)):
        opening, closing = ("[", "]") if isinstance(value, list) else (":(", ")") if isinstance(value, tuple) else ("{", "}")
        return opening + ", ".join(map(literal, value)) + closing
    raise TypeError(f"Meld has no value like {value!r}, a {type(value).__name__}; claymeld.Literal(\"...\") gives it as Meld writes it")


def program_path(program: Path, scratch: Scratch) -> tuple[str, list[str]]:
    """The file of a program, and further folders for what it includes. A str with a line break, or that ends with a full stop, is its
    text; then includes are relative to the working directory."""
    if isinstance(program, str) and ("\n" in program or program.rstrip().endswith(").")):
        return str(scratch.write("program.meld", program if program.endswith("\n") else program + "\n")), [os.getcwd()]
    return os.fspath(program), []


def world_path(world: World, program: str, scratch: Scratch, every: Optional[int], predicates: Optional[Sequence[str]]) -> Optional[str]:
    """The file of a world, with what is to be recorded; None where meldsim finds it as it should be."""
    text, home = None, os.getcwd()
    if isinstance(world, Mapping):
        text = toml(world)
    elif isinstance(world, str) and ("\n" in world or ("=" in world and not world.endswith(".toml"))):
        text = world
    if every is None and predicates is None:
        if text is None:
            return None if world is None else os.fspath(world)  # type: ignore[arg-type]
        changes: dict[str, Any] = {}
    else:
        changes = {name: value for name, value in (("every", every), ("predicates", None if predicates is None else list(predicates)))
                   if value is not None}
    if text is None:
        path = pathlib.Path(program).with_suffix(".toml") if world is None else pathlib.Path(os.fspath(world))  # type: ignore[arg-type]
        if world is None and not path.exists():
            text = DEFAULT_WORLD
        else:
            text, home = path.read_text(encoding="utf-8"), str(path.resolve().parent)
    try:
        parsed = tomllib.loads(text)
    except tomllib.TOMLDecodeError:
        # meldsim says where, and what to do about it.
        return str(scratch.write("world.toml", text))
    moved = _absolute(parsed, home)
    if changes and isinstance(parsed.get("record", {}), dict):
        if "record" not in parsed and not moved:
            # The lines stay where they are, for messages about them.
            return str(scratch.write("world.toml", f"{text}\n{toml({'record': changes})}"))
        parsed["record"] = {**parsed.get("record", {}), **changes}
        moved = True
    return str(scratch.write("world.toml", toml(parsed) if moved else text))


# mesh('part.stl', ...) in a shape or region.
_MODEL = re.compile(r"""(\bmesh\s*\(\s*(?:file\s*=\s*)?)(['"])(.+?)\2""")
# Keys that name a file, by the table that has them; "" is the world itself.
_NAMES = {"": ("links", "nodes"), "body": ("cells", "positions"), "program": ("file",)}
# What holds values of the program, no shapes.
_VALUES = ("args", "set", "components")


def _absolute(world: dict[str, Any], home: str) -> bool:
    """Names of files in a world are relative to it; makes them absolute, and says whether there were any."""
    found = False

    def absolute(name: str) -> str:
        nonlocal found
        found = found or not os.path.isabs(name)
        return os.path.join(home, name)

    def model(match: re.Match[str]) -> str:
        # Names in shapes have no escapes.
        quote = match[2] if match[2] not in home else "'" if match[2] == '"' else '"'
        return match[1] + quote + absolute(match[3]) + quote

    def changed(value: Any, key: str, table: str) -> Any:
        if isinstance(value, str):
            return absolute(value) if key in _NAMES.get(table, ()) else _MODEL.sub(model, value)
        if isinstance(value, list):
            return [changed(item, key, table) for item in value]
        if isinstance(value, dict):
            return {name: item if name in _VALUES else changed(item, name, key) for name, item in value.items()}
        return value

    world.update(changed(world, "", ""))
    return found


def toml(world: Mapping[str, Any]) -> str:
    """A world as TOML. Numbers and arrays of numpy, edges of networkx and whatever else can be gone through become numbers and arrays.

    Raises
    ------
    WorldError
        A value that TOML does not have, such as None, or a key that is no text.
    """
    plain = _table(world, "")
    lines = [f"{_key(key)} = {_toml(value)}" for key, value in plain.items() if not _is_table(value)]
    for key, value in plain.items():
        if _is_table(value):
            for table in [value] if isinstance(value, dict) else value:
                lines += ["", f"[{_key(key)}]" if isinstance(value, dict) else f"[[{_key(key)}]]"]
                lines += [f"{_key(name)} = {_toml(item)}" for name, item in table.items()]
    return "\n".join(lines).lstrip("\n") + "\n"


def _table(value: Mapping[Any, Any], place: str) -> dict[str, Any]:
    for key in value:
        if not isinstance(key, str):
            where = f"the world's {place}" if place else "the world"
            raise WorldError(f"{where} has the key {key!r} of type {type(key).__name__}, and the keys of a world are text. "
                             f"Write {str(key)!r}, or a list", 2)
    return {str(key): _plain(item, f"{place}.{key}" if place else str(key)) for key, item in value.items()}


def _plain(value: Any, place: str) -> Any:
    """A value as bool, int, float, str, list and dict, which TOML has."""
    if isinstance(value, (bool, int, float, str)) and type(value).__module__ != "numpy":
        return value
    if hasattr(value, "tolist"):  # numpy, pandas
        listed = value.tolist()
        # What numpy has no other form for, as a time, comes back as it was.
        if not hasattr(listed, "tolist"):
            return _plain(listed, place)
    if isinstance(value, os.PathLike):
        return os.fspath(value)
    if hasattr(value, "nodes") and hasattr(value, "edges"):
        raise WorldError(f"the world's {place} is a graph, a {type(value).__name__}. Write `links = G.edges`", 2)
    # The edges of networkx are a set of pairs as well as a mapping.
    if isinstance(value, Mapping) and not isinstance(value, Set):
        return _table(value, place)
    if isinstance(value, (set, frozenset)):
        # In an order that is the same in each run.
        value = sorted(value, key=repr)
    if isinstance(value, Iterable) and not isinstance(value, (bytes, bytearray)):
        return [_plain(item, f"{place}[{number}]") for number, item in enumerate(value)]
    raise WorldError(f"the world's {place} is {value!r}, and a world has no value like it, a {type(value).__name__}", 2)


def _is_table(value: Any) -> bool:
    return isinstance(value, dict) or (isinstance(value, list) and len(value) > 0 and all(isinstance(item, dict) for item in value))


def _key(key: str) -> str:
    return key if key and all(c.isascii() and (c.isalnum() or c in "-_") for c in key) else _string(key)


def _string(text: str) -> str:
    # JSON's form is TOML's, but for one character.
    return json.dumps(text, ensure_ascii=False).replace("\x7f", "\\u007f")


def _toml(value: Any) -> str:
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, int):
        return int.__repr__(value)
    if isinstance(value, float):
        return float.__repr__(value)
    if isinstance(value, str):
        return _string(value)
    if isinstance(value, list):
        return f"[{', '.join(map(_toml, value))}]"
    return "{ " + ", ".join(f"{_key(name)} = {_toml(item)}" for name, item in value.items()) + " }"
