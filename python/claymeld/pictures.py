"""Pictures, films and pages of a run, which meldsim makes; notebooks show them."""

from __future__ import annotations

import base64
import html
import os
import pathlib
import shutil
from typing import Any, Mapping, Optional

from .data.scratch import Scratch
from .tool.calls import Path, call, has
from .tool.errors import MeldsimError, ToolNotFound

# A larger page would make a notebook slow; then a picture stands for it.
MOST_PAGE_BYTES = 16 << 20
INLINE_SIZE = (800, 450)


class Picture:
    """A PNG picture; notebooks show it.

    Attributes
    ----------
    png : bytes
    """

    def __init__(self, png: bytes) -> None:
        self.png = png

    @property
    def size(self) -> tuple[int, int]:
        """Width and height, in pixels."""
        return int.from_bytes(self.png[16:20], "big"), int.from_bytes(self.png[20:24], "big")

    def save(self, path: Path) -> None:
        pathlib.Path(path).write_bytes(self.png)

    def _repr_png_(self) -> bytes:
        return self.png

    def __repr__(self) -> str:
        return f"<Picture of {self.size[0]} x {self.size[1]} pixels>"


class Movie:
    """A film in a file; notebooks show it."""

    TYPES = {".mp4": "video/mp4", ".webm": "video/webm", ".mkv": "video/x-matroska"}

    def __init__(self, path: Path) -> None:
        self.path = os.fspath(path)

    def _repr_html_(self) -> str:
        data = base64.b64encode(pathlib.Path(self.path).read_bytes()).decode()
        suffix = pathlib.Path(self.path).suffix.lower()
        if suffix in self.TYPES:
            return f'<video controls loop style="max-width: 100%" src="data:{self.TYPES[suffix]};base64,{data}"></video>'
        return f'<img style="max-width: 100%" src="data:image/{suffix[1:]};base64,{data}">'

    def __repr__(self) -> str:
        return f"<Movie {self.path}>"


class Page:
    """A page in a file, which shows a run without a server; notebooks show it."""

    def __init__(self, path: Path, height: int = 520, scratch: Optional[Scratch] = None) -> None:
        self.path, self.height = os.fspath(path), height
        self._scratch = scratch  # A temporary file lasts as long as this.

    def save(self, path: Path) -> None:
        shutil.copyfile(self.path, path)

    def _repr_html_(self) -> str:
        return inline(pathlib.Path(self.path).read_text(encoding="utf-8"), self.height)

    def __repr__(self) -> str:
        return f"<Page {self.path}>"


def words_of(options: Mapping[str, Any]) -> list[str]:
    """Options of a command, from arguments in Python: "_" for "-", True for an option without a value, None and False for none; a pair of
    pixels for a size, one of numbers for a range."""
    words = []
    for name, value in options.items():
        option = "--" + name.replace("_", "-")
        if value is None or value is False:
            continue
        if value is True:
            words.append(option)
            continue
        if isinstance(value, (tuple, list)):
            value = {"size": "x", "range": ":"}.get(name, ",").join(map(str, value))
        # What begins with a hyphen is a value here.
        words.append(f"{option}={value}" if str(value).startswith("-") else option)
        if not str(value).startswith("-"):
            words.append(str(value))
    return words


def shot(target: str, ticks: str, options: Mapping[str, Any], meldsim: Optional[Path]) -> Picture:
    scratch = Scratch()
    path = scratch.folder / "picture.png"
    call(["shot", target, "-o", str(path), "--tick", ticks, "--quiet", *words_of(options)], meldsim=meldsim)
    return Picture(path.read_bytes())


def movie(target: str, path: Path, options: Mapping[str, Any], meldsim: Optional[Path]) -> Movie:
    if not has("movie", meldsim=meldsim):
        raise ToolNotFound("this meldsim has no command movie: it makes no films. Take pictures of several ticks with shot()")
    call(["movie", target, "-o", os.fspath(path), "--quiet", *words_of(options)], meldsim=meldsim)
    return Movie(path)


def share(target: str, path: Path, options: Mapping[str, Any], meldsim: Optional[Path]) -> Page:
    if not has("view", "--share", meldsim):
        raise ToolNotFound("this meldsim has no `view --share`: it writes no pages. Take pictures with shot()")
    call(["view", target, "--share", os.fspath(path), *words_of(options)], meldsim=meldsim)
    return Page(path)


def view(target: str, height: int, options: Mapping[str, Any], meldsim: Optional[Path]) -> Page:
    scratch = Scratch()
    path = scratch.folder / "page.html"
    share(target, path, {"limit": MOST_PAGE_BYTES >> 20, **options}, meldsim)
    return Page(path, height, scratch)


def inline(page: str, height: int) -> str:
    """A page within a page."""
    return (f'<iframe srcdoc="{html.escape(page)}" sandbox="allow-scripts allow-forms" style="width: 100%; height: {height}px; border: 0" '
            'title="A run of Claymeld"></iframe>')


def display(target: str, meldsim: Optional[Path]) -> dict[str, Any]:
    """What a notebook shows of a recording: the page if this meldsim writes pages, and if it is not too large; otherwise a picture of its
    end. Nothing if meldsim is not there or cannot make the run again: then the text has to do."""
    scratch = Scratch()
    try:
        if has("view", "--share", meldsim):
            page = scratch.folder / "page.html"
            share(target, page, {}, meldsim)
            if page.stat().st_size <= MOST_PAGE_BYTES:
                return {"text/html": Page(page)._repr_html_()}
        return {"image/png": base64.b64encode(shot(target, "end", {"size": INLINE_SIZE}, meldsim).png).decode()}
    except (MeldsimError, OSError):
        return {}
