"""The live page of the viewer in a cell of a notebook: `meldsim view` serves it as long as its object is there."""

from __future__ import annotations

import html
import json
import urllib.parse
import weakref
from typing import Any, Mapping, Optional, Sequence

from .data.scratch import Scratch
from .data.sources import World, literal, program_path, world_path
from .pictures import words_of
from .tool.calls import Child, Path, find, has
from .tool.errors import Interrupted, ToolNotFound, error

# What the page shows at first; its link says so.
LOOK = ("colour", "only", "hide", "links", "arrows", "labels", "map", "form")


class Live:
    """A run that is shown by a page with a server behind it; notebooks show the page.

    It ends with close(), at the end of a `with`, when nobody has it any more, and with this process. Notebooks have what their cells
    have shown, as `Out[3]`.

    Attributes
    ----------
    link : str
        Of the page, for a browser on this machine. Whoever has it can do all that you can do with the run.
    height : int
        Of the cell, in pixels.
    """

    def __init__(self, words: Sequence[Any], height: int, options: Mapping[str, Any], meldsim: Optional[Path], kept: Any = None) -> None:
        if not has("view", "--framed", meldsim):
            raise ToolNotFound("this meldsim has no `view --framed`: its live pages cannot be in a notebook. Use view() without live=True")
        look = {name: options[name] for name in LOOK if options.get(name) is not None}
        rest = {name: value for name, value in options.items() if name not in LOOK}
        command = [find(meldsim), "view", *map(str, words), "--json", "--no-open", "--framed", *words_of(rest)]
        self.height = height
        self._kept = kept  # Files that the server reads last as long as this.
        self._child = Child(command)
        try:
            line = self._child.first_line()
        except KeyboardInterrupt:
            self._child.interrupt()
            self._child.wait()
            raise Interrupted(command=command) from None
        if line is None:
            done = self._child.wait()
            raise error(done.code, done.said, command)
        self.link = json.loads(line)["link"] + ("#" + urllib.parse.urlencode(look, quote_via=urllib.parse.quote) if look else "")
        self._end = weakref.finalize(self, self._child.interrupt)

    def close(self) -> None:
        """Ends the server; the page then says that it has ended. Asked again it does nothing."""
        if self._end.detach() is not None:
            self._child.interrupt()
            self._child.wait()

    def __enter__(self) -> Live:
        return self

    def __exit__(self, *_: Any) -> None:
        self.close()

    def _repr_html_(self) -> str:
        return (f'<iframe src="{html.escape(self.link)}" style="width: 100%; height: {self.height}px; border: 0" '
                'title="A run of Claymeld, live"></iframe>')

    def __repr__(self) -> str:
        return f"<Live page at {self.link}>" if self._end.alive else "<Live page that has ended>"


def view(program: Path, world: World = None, *, ticks: Optional[int] = None, seed: Optional[int] = None, processes: int = 1,
         constants: Optional[Mapping[str, Any]] = None, height: int = 520, meldsim: Optional[Path] = None, **options: Any) -> Live:
    """A program as a live page in a notebook's cell: it is run there, forward and back, changed by hand, and asked.

    Parameters
    ----------
    program, world, ticks, seed, processes, constants, meldsim
        As for `run`.
    height : int
        Of the cell, in pixels.
    **options
        What is shown at first: colour, only, hide, links, arrows, labels, map, form; and options of `meldsim view`, such as tick=10.

    Returns
    -------
    Live

    Raises
    ------
    ProgramError, WorldError, LimitReached, MeldsimError
        By what is wrong.
    ToolNotFound
        This meldsim cannot show live pages in notebooks.
    """
    scratch = Scratch()
    path, folders = program_path(program, scratch)
    words: list[Any] = [path]
    for folder in folders:
        words += ["-I", folder]
    place = world_path(world, path, scratch, None, None)
    for name, value in (("world", place), ("ticks", ticks), ("seed", seed), ("processes", processes if processes != 1 else None)):
        if value is not None:
            words += [f"--{name}", value]
    for name, value in (constants or {}).items():
        words += ["--set", f"{name}={literal(value)}"]
    return Live(words, height, options, meldsim, scratch)


__all__ = ["Live", "view"]
