"""What goes wrong, as exceptions: one for each exit code of meldsim (docs/commands.md, "Exit codes")."""

from __future__ import annotations

import signal
from typing import Any, Sequence

from .programs import own, packages


class MeldsimError(Exception):
    """meldsim has ended with an error.

    Attributes
    ----------
    message : str
        What it has said, with the place and the cure.
    exit_code : int
        Its exit code; negative if a signal has killed it.
    command : list of str
        The words of the command.
    run : claymeld.Run or None
        What there is of the run: its recording ends with the last good tick. None if it has not begun, or if it was no run.
    """

    def __init__(self, message: str, exit_code: int = 0, command: Sequence[str] = (), run: Any = None) -> None:
        super().__init__(message)
        self.message = message
        self.exit_code = exit_code
        self.command = list(command)
        # Any, since a run is made by calling the tool: its type is two layers above this one.
        self.run = run


class ToolNotFound(MeldsimError):
    """There is no meldsim, or this one lacks a command or libraries of the system."""


class ProgramError(MeldsimError):
    """The program is wrong, or its run has failed: an overflow, a division by zero (exit code 1)."""


class WorldError(MeldsimError):
    """The world, an option or a question is wrong, or a file cannot be read or written (exit code 2)."""


class PropertyFailed(MeldsimError):
    """The run is not as `expect` and `never` say (exit code 3). `failures` has what they are and what was found."""

    failures: list[tuple[str, str]] = []


class LimitReached(MeldsimError):
    """A limit of the run, of time, memory or the disk (exit code 4)."""


class ModuleRefused(MeldsimError):
    """A compiled module that cannot be used (exit code 5)."""


class RecordingError(MeldsimError, ValueError):
    """A recording, a checkpoint or a file of facts that is damaged, of another version, or none (exit code 6)."""


class InternalError(MeldsimError):
    """A bug of Claymeld (exit code 70)."""


class Interrupted(KeyboardInterrupt):
    """Ctrl-C, or the stop button of a notebook, while meldsim was at work (exit code 130). It has ended after a tick; `run` has what there
    is of the run, with its recording; `command` the words of the command."""

    exit_code = 130

    def __init__(self, run: Any = None, command: Sequence[str] = ()) -> None:
        super().__init__("interrupted" if run is None else f"interrupted after tick {run.summary.get('ticks', '?')}")
        self.run = run
        self.command = list(command)


class MeldWarning(UserWarning):
    """What meldsim warns of in a run that ends well."""


BY_CODE: dict[int, type[MeldsimError]] = {1: ProgramError, 2: WorldError, 3: PropertyFailed, 4: LimitReached, 5: ModuleRefused,
                                          6: RecordingError, 70: InternalError}


def error(code: int, said: str, command: Sequence[str], run: Any = None) -> MeldsimError:
    """The exception of an exit code, with what was said."""
    if code < 0:
        name = signal.Signals(-code).name if -code in signal.valid_signals() else str(-code)
        cause = "; the machine may be out of memory" if -code == signal.SIGKILL else ""
        said = f"{said}\n".lstrip() + f"meldsim was killed by {name}{cause}"
    # The system's loader says which library is missing, and with what exit code.
    if code == 127 and command[:1] == [own("meldsim")]:
        return ToolNotFound(f"{said}\nThe programs of this wheel need libraries of Debian 12: apt-get install {' '.join(packages())}", code,
                            command, run)
    return BY_CODE.get(code, MeldsimError)(said or f"meldsim ended with exit code {code} and said nothing", code, command, run)
