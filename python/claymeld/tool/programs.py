"""The programs that a wheel of packaging/wheel holds: where they are, what they need, and how they are started from a shell."""

from __future__ import annotations

import os
import pathlib
import sys
from typing import Optional

FOLDER = pathlib.Path(__file__).resolve().parents[1] / "programs"


def own(name: str) -> Optional[str]:
    """The program of this name in the package; None if the package holds none."""
    place = FOLDER / "bin" / name
    return str(place) if os.access(place, os.X_OK) else None


def packages() -> list[str]:
    """The packages of Debian whose libraries the programs need: PACKAGES has a line for each library."""
    lines = [line.split() for line in (FOLDER / "PACKAGES").read_text().splitlines()]
    return sorted({line[1] for line in lines if len(line) == 2})


def start() -> None:
    """A command of the wheel: becomes the program with the name under which it was called."""
    name = pathlib.Path(sys.argv[0]).name
    place = own(name)
    if place is None:
        sys.exit(f"{name}: this package holds no program {name}. Install the wheel again")
    os.execv(place, [name, *sys.argv[1:]])
