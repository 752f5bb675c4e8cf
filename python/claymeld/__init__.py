"""Claymeld in Python: runs Meld programs with meldsim, and reads what the runs have written as pandas frames.

    import claymeld

    run = claymeld.run("gradient.meld", {"body": {"shape": "box(10, 10, 10)"}, "facts": {"source": "id == 0"}})
    run.facts("dist")                       # at the end
    run.recording.facts("dist", 7)          # after tick 7
    run.recording.why("dist(@42, _)")

docs/python.md tells all of it. Nothing but this file is imported until it is used.

The package has three layers, and imports go down only, in no circle: what users call, in this folder; values and files, in `data`;
calling the tool, in `tool`. tests/python/layers_test.py checks it.
"""

from __future__ import annotations

import importlib
from typing import TYPE_CHECKING, Any

__version__ = "0.1.0"  # That of runtime/base/version.h; a test compares them.

if TYPE_CHECKING:
    from .answers import Why
    from .data.sources import Literal
    from .data.tables import facts
    from .data.values import value
    from .live import Live, view
    from .pictures import Movie, Page, Picture
    from .recording import Recording, Recording as open
    from .running import Run, run
    from .sweeps import sweep
    from .tool.calls import find as find_meldsim
    from .tool.errors import (Interrupted, InternalError, LimitReached, MeldsimError, MeldWarning, ModuleRefused, ProgramError,
                              PropertyFailed, RecordingError, ToolNotFound, WorldError)

_HOMES = {"Why": "answers", "facts": "data.tables", "Movie": "pictures", "Page": "pictures", "Picture": "pictures",
          "Recording": "recording", "Run": "running", "run": "running", "Live": "live", "view": "live", "Literal": "data.sources",
          "sweep": "sweeps", "value": "data.values",
          **dict.fromkeys(("Interrupted", "InternalError", "LimitReached", "MeldsimError", "MeldWarning", "ModuleRefused", "ProgramError",
                           "PropertyFailed", "RecordingError", "ToolNotFound", "WorldError"), "tool.errors")}
_RENAMED = {"open": ("recording", "Recording"), "find_meldsim": ("tool.calls", "find")}

__all__ = ["Interrupted", "InternalError", "Literal", "LimitReached", "Live", "MeldWarning", "MeldsimError", "ModuleRefused", "Movie",
           "Page", "Picture", "ProgramError", "PropertyFailed", "Recording", "RecordingError", "Run", "ToolNotFound", "Why", "WorldError",
           "facts", "find_meldsim", "open", "run", "sweep", "value", "view"]


def __getattr__(name: str) -> Any:
    home, there = _RENAMED.get(name, (_HOMES.get(name, ""), name))
    if not home:
        raise AttributeError(f"module 'claymeld' has no attribute {name!r}")
    from .tool.packages import needed_for

    with needed_for(f"claymeld.{name}"):
        found = getattr(importlib.import_module(f"{__name__}.{home}"), there)
    globals()[name] = found
    return found


def __dir__() -> list[str]:
    return sorted([*globals(), *__all__])
