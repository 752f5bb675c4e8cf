"""Finds meldsim and calls it: with progress, with Ctrl-C that ends it at a tick, and with exceptions for what it says."""

from __future__ import annotations

import json
import os
import pathlib
import re
import shutil
import signal
import subprocess
import sys
import threading
import time
from typing import Any, Callable, NamedTuple, Optional, Sequence, Union

from .errors import Interrupted, ToolNotFound, error
from .programs import own

Path = Union[str, "os.PathLike[str]"]
VARIABLE = "CLAYMELD_MELDSIM"
# Seconds until the next signal is tried on a child that is to end: it ends within about two, with its files whole.
PATIENCE = 4.0
ANSI = re.compile(r"\x1b\[[0-9;]*[A-Za-z]")
PROGRESS = re.compile(r"^(tick \d+.* awake of |compiling |[\d,]+ of [\d,]+ runs).*$")


def find(path: Optional[Path] = None) -> str:
    """Where meldsim is: `path`; the variable CLAYMELD_MELDSIM; in this package, if its wheel holds the programs; PATH; or where Claymeld
    lies around this package.

    Raises
    ------
    ToolNotFound
        There is none, or it is no program.
    """
    given, whose = (path, "meldsim=") if path is not None else (os.environ.get(VARIABLE) or None, VARIABLE)
    if given is not None:
        found = shutil.which(os.fspath(given))
        if found is None:
            raise ToolNotFound(f"{whose} {os.fspath(given)!r} is no program that can be run. Give the path of the program meldsim")
        return found
    if (inside := own("meldsim")) is not None:
        return inside
    here = pathlib.Path(__file__).resolve().parents[2]  # The folder that has the package.
    # share/claymeld/python below a prefix; python/ in the repository; a prefix of Python.
    beside = [here.parents[2] / "bin" / "meldsim"] if len(here.parents) > 2 else []
    beside += [here.parent / "build" / "bin" / "meldsim", pathlib.Path(sys.prefix) / "bin" / "meldsim"]
    found = shutil.which("meldsim") or next((str(place) for place in beside if os.access(place, os.X_OK)), None)
    if found is None:
        raise ToolNotFound(f"there is no program meldsim: not in PATH, and not in {', '.join(str(place.parent) for place in beside)}. "
                           f"Build Claymeld (scripts/build) and add build/bin to PATH, or set {VARIABLE} to the program, or pass meldsim=")
    return found


class Done(NamedTuple):
    """How a child has ended: its exit code, standard output, what it has said, and whether it was interrupted by us."""

    code: int
    out: bytes
    said: str
    interrupted: bool


def wants_progress(asked: Optional[bool]) -> bool:
    """On a terminal, unless it is asked otherwise. Notebooks are none."""
    if asked is not None:
        return asked
    return sys.stderr is not None and sys.stderr.isatty()


class Child:
    """meldsim at work. It is in a session of its own, so that a Ctrl-C reaches it once, from us; it ends when we are killed."""

    def __init__(self, command: Sequence[str], progress: bool = False) -> None:
        self.command = list(command)
        self.interrupted = False
        self._timers: list[threading.Timer] = []
        # The kernel tells it when its parent is gone, as when a notebook's kernel is killed.
        leash = ["setpriv", "--pdeathsig", "TERM", "--"] if shutil.which("setpriv") else []
        self._pieces: dict[str, list[bytes]] = {"out": [], "said": []}
        self._shown = 0
        if progress:
            # It draws its line only on a terminal.
            ours, theirs = os.openpty()
        else:
            ours, theirs = os.pipe()
        try:
            self.process = subprocess.Popen([*leash, *self.command], stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, stderr=theirs,
                                            start_new_session=True)
        except BaseException:
            os.close(ours)
            raise
        finally:
            os.close(theirs)
        assert self.process.stdout is not None
        out = self.process.stdout.fileno()
        self._readers = [threading.Thread(target=self._read, args=(out, "out", None), daemon=True),
                         threading.Thread(target=self._read, args=(ours, "said", self._show if progress else None), daemon=True)]
        for reader in self._readers:
            reader.start()
        self._ours = ours

    def interrupt(self) -> None:
        """Ends it after a tick; any thread may call. wait() returns when it has ended. Asked again, it ends at once."""
        # Whoever has ignored SIGINT, as under nohup, has a child that ignores it too: then other signals follow.
        signals = [signal.SIGTERM, signal.SIGKILL] if self.interrupted else [signal.SIGINT, signal.SIGTERM, signal.SIGKILL]
        self.interrupted = True
        self._signal(signals[0])
        for number, harder in enumerate(signals[1:], 1):
            timer = threading.Timer(number * PATIENCE, self._signal, (harder,))
            timer.daemon = True
            timer.start()
            self._timers.append(timer)

    def first_line(self) -> Optional[bytes]:
        """Waits for the first line that it prints; None if it ends without one."""
        while b"\n" not in (out := b"".join(self._pieces["out"])):
            # It may have printed it and ended.
            if self.process.poll() is not None and not self._readers[0].is_alive():
                return None
            time.sleep(0.01)
        return out.partition(b"\n")[0]

    def wait(self) -> Done:
        """Waits for its end. A KeyboardInterrupt ends it, and is not raised again."""
        while True:
            try:
                self.process.wait()
                break
            except KeyboardInterrupt:
                self.interrupt()
        for timer in self._timers:
            timer.cancel()
        for reader in self._readers:
            # Somebody whom it has started may still hold the pipe.
            reader.join(PATIENCE)
        assert self.process.stdout is not None
        if not any(reader.is_alive() for reader in self._readers):
            self.process.stdout.close()
            os.close(self._ours)
        if self._shown:
            self._show(b"\r\n")
        return Done(self.process.returncode, b"".join(self._pieces["out"]), clean(b"".join(self._pieces["said"])), self.interrupted)

    def _signal(self, number: int) -> None:
        try:
            self.process.send_signal(number)
        except ProcessLookupError:
            pass

    def _read(self, descriptor: int, name: str, show: Optional[Callable[[bytes], None]]) -> None:
        while True:
            try:
                piece = os.read(descriptor, 1 << 16)
            except OSError:  # A terminal whose other end is closed.
                return
            if not piece:
                return
            self._pieces[name].append(piece)
            if show is not None:
                show(piece)

    def _show(self, piece: bytes) -> None:
        """The latest line of progress over the one before, also where nobody understands "erase the line"."""
        line = ANSI.sub("", piece.decode("utf-8", "replace")).replace("\n", "\r").rstrip("\r").rpartition("\r")[2]
        if sys.stderr is not None and (line == "" or PROGRESS.match(line)):
            sys.stderr.write("\r" + line.ljust(self._shown) + ("\r" if line == "" else ""))
            sys.stderr.flush()
            self._shown = len(line)


def clean(said: bytes) -> str:
    """What was said, without colours and progress."""
    lines = ANSI.sub("", said.decode("utf-8", "replace")).replace("\r\n", "\n").split("\n")
    kept = [line.rpartition("\r")[2] for line in lines]
    return "\n".join(line for line in kept if not PROGRESS.match(line)).strip("\n").removeprefix("meldsim: ")


def call(words: Sequence[Any], *, meldsim: Optional[Path] = None, codes: Sequence[int] = (0,)) -> Done:
    """Calls meldsim; raises unless it ends with one of these codes.

    Raises
    ------
    MeldsimError
        By its exit code.
    Interrupted
        Ctrl-C has ended it.
    """
    command = [find(meldsim), *map(os.fspath, words)]
    done = Child(command).wait()
    if done.interrupted:
        raise Interrupted(command=command)
    if done.code not in codes:
        # What it warns of has been told when the run was.
        raise error(done.code, done.said.rpartition("\nmeldsim: ")[2], command)
    return done


def ask(words: Sequence[Any], *, meldsim: Optional[Path] = None) -> dict[str, Any]:
    """The answer as JSON to a question: exit code 1 with an answer says that there is nothing."""
    done = call([*words, "--json", "--quiet"], meldsim=meldsim, codes=(0, 1))
    if not done.out.strip():
        raise error(done.code, done.said, [*map(os.fspath, words)])
    answer: dict[str, Any] = json.loads(done.out)
    return answer


def version(meldsim: Optional[Path] = None) -> str:
    """The version of meldsim, "0.1.0"."""
    return call(["--version"], meldsim=meldsim).out.decode().split()[-1]


def has(command: str, option: str = "", meldsim: Optional[Path] = None) -> bool:
    """Whether this meldsim has a command, and the command an option."""
    done = call(["help", command], meldsim=meldsim, codes=(0, 1, 2))
    return done.code == 0 and f"meldsim {command}".encode() in done.out and option.encode() in done.out
