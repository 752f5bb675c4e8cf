"""A temporary folder for files of a run."""

from __future__ import annotations

import pathlib
import shutil
import tempfile
import weakref


class Scratch:
    """A folder for files of a run, which goes when nobody holds this object any more."""

    def __init__(self) -> None:
        self.folder = pathlib.Path(tempfile.mkdtemp(prefix="claymeld-"))
        weakref.finalize(self, shutil.rmtree, self.folder, ignore_errors=True)

    def write(self, name: str, text: str) -> pathlib.Path:
        path = self.folder / name
        path.write_text(text, encoding="utf-8")
        return path
