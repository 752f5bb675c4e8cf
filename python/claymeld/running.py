"""Runs of programs: claymeld.run()."""

from __future__ import annotations

import json
import os
import re
import warnings
import xml.etree.ElementTree
from typing import TYPE_CHECKING, Any, Mapping, NamedTuple, Optional, Sequence, Union

from .data.scratch import Scratch
from .data.sources import World, literal, program_path, world_path
from .tool.calls import Child, Done, Path, find, wants_progress
from .tool.errors import Interrupted, MeldWarning, PropertyFailed, error
from .tool.packages import needed_for

if TYPE_CHECKING:
    from .live import Live
    from .pictures import Page
    from .recording import Recording

# What catoms print goes where messages go.
PRINTED = re.compile(r"@\d+: ")
Bodies = Union[str, Sequence[str]]


class Run:
    """A run that is over.

    Attributes
    ----------
    summary : dict
        The summary of `meldsim run --json`: "ended", "ticks", "catoms", "run_seconds" and so on (docs/commands.md). Empty if the run has
        failed before its end.
    output : str
        What its catoms have printed, and what meldsim has said. Warnings are MeldWarning as well.
    command : list of str
        The command.
    """

    def __init__(self, scratch: Scratch, command: list[str], outputs: _Outputs, summary: dict[str, Any], output: str) -> None:
        self.summary, self.output, self.command = summary, output, command
        self._scratch, self._outputs = scratch, outputs
        self._recording: Optional[Recording] = None

    @property
    def ended(self) -> str:
        """Why it has ended: "quiet", "ticks", "finished", "watched" (`until` has come true) or "interrupted"; "failed" if it has failed."""
        return str(self.summary.get("ended", "failed"))

    @property
    def recording(self) -> Recording:
        """Its recording. A temporary one lasts as long as this object or the recording.

        Raises
        ------
        ValueError
            The run was not recorded, or has failed before its first step.
        """
        if self._recording is None:
            path = self._outputs.record
            if path is None or not os.path.exists(path):
                raise ValueError("there is no recording of this run: it was run with record=False, or failed before its first step")
            with needed_for("a recording"):
                from .recording import Recording  # Not before it is used: it takes pandas and h5py.

            self._recording = Recording(path, meldsim=self.command[0])
            self._recording._scratch = self._scratch
        return self._recording

    def facts(self, predicate: Optional[str] = None) -> Any:
        """The facts at the end: a frame for a predicate, or without one a dict of frames, as `claymeld.facts` has them.

        Raises
        ------
        KeyError
            There is no such predicate.
        ValueError
            The run was run with facts=False and not recorded, or a tick has failed halfway.
        """
        path = self._outputs.facts
        if path is not None and os.path.exists(path):
            with needed_for("facts()"):
                from .data.tables import facts

            return facts(path, predicate)
        return self.recording.facts(predicate) if predicate is not None else self.recording.all_facts()

    def view(self, **options: Any) -> Union[Page, Live]:
        """The run as an interactive page in a notebook's cell; arguments and errors are those of `Recording.view`. With live=True a server
        stands behind the page.

        Raises
        ------
        ValueError
            The run was not recorded, or has failed before its first step.
        """
        return self.recording.view(**options)

    def __repr__(self) -> str:
        what = ", ".join(f"{self.summary[key]:,} {key}" for key in ("ticks", "catoms") if key in self.summary)
        return f"<Run: ended {self.ended}{', ' if what else ''}{what}>"

    def _repr_mimebundle_(self, include: Any = None, exclude: Any = None) -> Optional[dict[str, Any]]:
        try:
            return {**self.recording._repr_mimebundle_(), "text/plain": repr(self)}
        except ValueError:
            return {"text/plain": repr(self)}


class _Outputs(NamedTuple):
    record: Optional[str]
    facts: Optional[str]
    junit: Optional[str]


def run(program: Path, world: World = None, *, ticks: Optional[int] = None, until: Optional[Bodies] = None, seed: Optional[int] = None,
        processes: int = 1, threads: int = 1, record: Union[bool, Path] = True, every: Optional[int] = None,
        predicates: Optional[Sequence[str]] = None, facts: Union[bool, Path] = True, expect: Bodies = (), never: Bodies = (),
        arguments: Sequence[Any] = (), constants: Optional[Mapping[str, Any]] = None, timeout: Optional[float] = None,
        options: Sequence[Any] = (), progress: Optional[bool] = None, meldsim: Optional[Path] = None, **set: Any) -> Run:
    """Runs a program until nothing is left to do.

    Parameters
    ----------
    program : path or str
        A .meld file or a compiled module; or the text of a program: a str with a line break in it, or that ends with ").".
    world : path, str, dict or None
        A .toml file; or its text: a str with a line break or a "=" in it; or a dict with the same keys. None: the .toml beside the
        program, or else a cube of 1,000 catoms.
    ticks : int
        Stop after so many ticks. A program that never becomes quiet needs this, or `until`.
    until : str or list of str
        Bodies in Meld: stop after the tick in which one begins to hold.
    seed : int
        Of all random numbers; None: the world's.
    processes, threads : int
        MPI processes, and threads in each. The results are the same.
    record : bool or path
        Where to record the run; True: in a temporary file, which goes with the run.
    every : int
        Ticks between two recorded steps; None: as the world says, or else each.
    predicates : list of str
        Predicates that are recorded with each step; None: as the world says, or else none. Facts of others are had by running again.
    facts : bool or path
        Where to write the facts at the end, `.h5` or a folder with a "/" behind it; True: in a temporary file; False: nowhere.
    expect, never : str or list of str
        Bodies that must hold at the end, and that may hold after no tick.
    arguments : list
        Values of @arg1, @arg2 and so on.
    constants, **set
        Values of the program's constants, by name: bool, int, float, str, list, set, tuple, or `claymeld.Literal`. `constants` is for
        names that are parameters here.
    timeout : float
        Seconds after which it ends with LimitReached.
    options : list
        Further words for `meldsim run`, such as ["--strict", "-I", folder].
    progress : bool
        Whether a line shows how far it is; None: on a terminal.
    meldsim : path
        The program; None: as `claymeld.find_meldsim` finds it.

    Returns
    -------
    Run

    Raises
    ------
    ProgramError, WorldError, PropertyFailed, LimitReached, MeldsimError
        By what is wrong. Its attribute `run` has the recording up to the last good tick.
    Interrupted
        Ctrl-C: the run has ended after a tick; `run` has it, with its recording. It is a KeyboardInterrupt.
    """
    wanted = {**(constants or {}), **set}
    call = Call(program, world, dict(ticks=ticks, until=until, seed=seed, processes=processes, threads=threads, record=record, every=every,
                                     predicates=predicates, facts=facts, expect=expect, never=never, arguments=arguments,
                                     constants=wanted, timeout=timeout, options=options, meldsim=meldsim))
    return call.finish(call.start(wants_progress(progress)).wait())


def _words(bodies: Optional[Bodies]) -> list[str]:
    return [] if bodies is None else [bodies] if isinstance(bodies, str) else list(bodies)


class Call:
    """One call of `meldsim run`: its command, and what becomes of its end. `wanted` has the parameters of run() by name."""

    def __init__(self, program: Path, world: World, wanted: Mapping[str, Any]) -> None:
        self.scratch = Scratch()
        path, folders = program_path(program, self.scratch)
        place = world_path(world, path, self.scratch, wanted.get("every"), wanted.get("predicates"))
        words: list[Any] = ["run", path, "--json"]
        for folder in folders:
            words += ["-I", folder]
        for name, value in (("world", place), ("ticks", wanted.get("ticks")), ("seed", wanted.get("seed")),
                            ("processes", wanted.get("processes", 1)), ("threads", wanted.get("threads", 1)),
                            ("timeout", wanted.get("timeout"))):
            if value is not None:
                words += [f"--{name}", value]
        for name, option in (("until", "watch"), ("expect", "expect"), ("never", "never")):
            for body in _words(wanted.get(name)):
                words += [f"--{option}", body]
        for name, value in wanted.get("constants", {}).items():
            words += ["--set", f"{name}={literal(value)}"]
        for value in wanted.get("arguments", ()):
            words += ["--arg", literal(value)]
        watched = any(map(wanted.get, ("until", "expect", "never")))
        self.outputs = _Outputs(record=self._output(wanted.get("record", False), "run.vtkhdf"),
                                facts=self._output(wanted.get("facts", False), "facts.h5"),
                                junit=self._output(watched, "junit.xml"))
        for option, file in zip(("record", "facts-out", "junit"), self.outputs):
            words += [] if file is None else [f"--{option}", file]
        self.words = [*map(str, words), *map(str, wanted.get("options", ()))]
        self.command = [find(wanted.get("meldsim")), *self.words]

    def _output(self, wanted: Union[bool, Path], name: str) -> Optional[str]:
        if isinstance(wanted, bool):
            return str(self.scratch.folder / name) if wanted else None
        return os.fspath(wanted)

    def start(self, progress: bool = False) -> Child:
        return Child(self.command if progress else [*self.command, "--quiet"], progress)

    def finish(self, done: Done) -> Run:
        """The run, or the exception that says how it has ended."""
        out = done.out.decode("utf-8", "replace")
        # The summary comes last and is indented, so nothing in it is such a line.
        at = max(out.rfind("\n{\n") + 1, 0)
        summary = out[at:].startswith("{\n")
        # Users have not seen the names of temporary files.
        said = done.said.replace(f"{self.scratch.folder}{os.sep}", "")
        made = Run(self.scratch, self.command, self.outputs, json.loads(out[at:]) if summary else {}, (out[:at] if summary else out) + said)
        if done.interrupted:
            raise Interrupted(made, self.command)
        if done.code == 3:
            failures = self._failures()
            if failures == []:
                return made
            raised = error(3, said, self.command, made)
            if isinstance(raised, PropertyFailed):
                raised.failures = failures or []
            raise raised
        if done.code != 0:
            raise error(done.code, said, self.command, made)
        lines = [line for line in said.splitlines() if not PRINTED.match(line)]
        first = next((number for number, line in enumerate(lines) if line.startswith("warning")), None)
        if first is not None:
            warnings.warn("\n".join(lines[first:]), MeldWarning, stacklevel=3)
        return made

    def _failures(self) -> Optional[list[tuple[str, str]]]:
        """What was expected or was never to be, and what was found, without what the run has stopped for; None if nobody knows."""
        try:
            tree = xml.etree.ElementTree.parse(self.outputs.junit or "")
        except (OSError, xml.etree.ElementTree.ParseError):
            return None
        failed = [(case.get("name", ""), case.find("failure")) for case in tree.iter("testcase")]
        return [(name, found.get("message", "")) for name, found in failed if found is not None and not name.startswith("stop: ")]


__all__ = ["Call", "Run", "run"]
