"""The events that a world plans: its [[event]] tables, tick by tick."""

from __future__ import annotations

import math
import re
from typing import Any, Mapping, Optional

import pandas

# As in runtime/base/units.cpp.
SECONDS = {"": 1.0, "ns": 1e-9, "us": 1e-6, "µs": 1e-6, "ms": 1e-3, "s": 1.0, "min": 60.0, "m": 60.0, "h": 3600.0, "d": 86400.0}

# In the order in which they happen.
FAILURES = ("kill", "hang", "restart", "cut", "heal", "join", "jam")


def events(world: Mapping[str, Any], last: int) -> pandas.DataFrame:
    """Those up to a last tick; see `Recording.events`."""
    tables = world.get("event", [])
    rows: list[tuple[Optional[int], str, Optional[str], Any]] = []
    for event in [tables] if isinstance(tables, Mapping) else tables:
        first = event["tick"] if "tick" in event else _tick_of(event["time"], world)
        whole: list[tuple[str, Optional[str], Any]] = [(kind, None, event[kind]) for kind in FAILURES if kind in event]
        whole += [(kind, name, what) for kind in ("take", "give") for name, what in event.get(kind, {}).items()]
        if first is None:
            rows += [(None, *row) for row in whole]
            continue
        ticks = range(first, last + 1, event.get("every", 1))[: event.get("times", 1)]
        rows += [(tick, *row) for tick in ticks for row in whole]
    rows.sort(key=_place)
    return pandas.DataFrame(rows, columns=["tick", "kind", "predicate", "what"]).astype({"tick": "Int64"})


def _place(row: tuple[Optional[int], str, Optional[str], Any]) -> float:
    return math.inf if row[0] is None else row[0]


def _tick_of(time: Any, world: Mapping[str, Any]) -> Optional[int]:
    """As meldsim has it: the whole ticks that fit, but at least one. None where the physics chooses how long a tick is."""
    motion = world.get("motion", {})
    if motion.get("kind") not in ("bodies", "ode"):
        tick = seconds(world.get("time", {}).get("tick", "1ms"))
    elif "step" in motion:
        tick = seconds(motion["step"]) * motion.get("steps", 1)
    else:
        return None
    return max(math.floor(seconds(time) / tick * (1 + 1e-12)), 1)


def seconds(time: Any) -> float:
    """A time of a world file: a number of seconds, or a text with a unit, "200ms"."""
    if not isinstance(time, str):
        return float(time)
    match = re.fullmatch(r"\s*([0-9.eE+-]*[0-9.])\s*([^\d\s]*)\s*", time)
    if match is None or match[2] not in SECONDS:
        raise ValueError(f"{time!r} is no time")
    return float(match[1]) * SECONDS[match[2]]
