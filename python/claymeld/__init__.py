"""Reads what runs of meldsim have written, as pandas frames: the facts of --facts-out and the recordings of --record."""

from .facts import facts
from .recording import Recording
from .values import value

__all__ = ["Recording", "facts", "value"]
