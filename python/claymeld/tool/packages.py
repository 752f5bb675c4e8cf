"""What other packages are for, and how a missing one is had."""

from __future__ import annotations

import contextlib
from typing import Iterator

# Of pyproject.toml; a test compares them. The extra that brings each; "": all installations have it.
EXTRAS = {"h5py": "", "numpy": "", "pandas": "", "matplotlib": "plot", "networkx": "graph"}


class MissingPackage(ModuleNotFoundError):
    """A package that this needs is not installed. `name` is its name."""


@contextlib.contextmanager
def needed_for(what: str) -> Iterator[None]:
    """Around an import: says of a package that is missing what needs it, and how it is installed."""
    try:
        yield
    except ModuleNotFoundError as error:
        name = (error.name or "").partition(".")[0]
        if name not in EXTRAS or isinstance(error, MissingPackage):
            raise
        whole = f"claymeld[{EXTRAS[name]}]" if EXTRAS[name] else "claymeld"
        raise MissingPackage(f"{what} needs {name}, which is not installed. Install it by `pip install '{whole}'`, or alone by "
                             f"`pip install {name}` (Debian: apt install python3-{name})", name=name) from None
