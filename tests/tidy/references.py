"""What comments and docs point to must be there: files, headings of pages, and functions named with their file."""

import pathlib
import re
from typing import Iterator

from rules import Problem

COMMENTS = {".h": "//", ".cpp": "//", ".def": "//", ".l": "//", ".y": "//", ".meld": "//",
            ".py": "#", ".cmake": "#", ".toml": "#", ".txt": "#"}
# The name of a file, not in <> and not behind a letter, an option or a wildcard.
FILE = re.compile(r"(?<![\w<*/.{}-])((?:[\w-]+/)*[\w-]+\.(?:md|h|cpp|def|py|cmake|meld|toml|l|y))\b(?![\w>*])")
# docs/design.md, "Ranks and quarantine"
HEADING = re.compile(r'\b([\w/]+\.md), "([^"]+)"')
# `compiler/plan/plan.cpp: make_plan()`
FUNCTION = re.compile(r"`([\w/.-]+): ([\w~:]+)\(\)`")
# What the reader is to put a name of their own for.
PLACEHOLDER = re.compile(r"(^|/)(file|name|world)\.\w+$|^[A-Z_]+[./]")
SKIPPED = {"__pycache__", "node_modules"}


class References:
    """The files of a repository, with their text."""

    def __init__(self, texts: dict):
        self.texts = texts
        self.endings = {"/".join(parts[start:]) for parts in (path.split("/") for path in texts) for start in range(len(parts))}

    @classmethod
    def of(cls, root: pathlib.Path):
        texts, folders = {}, [root]
        while folders:
            folder = folders.pop()
            for path in folder.iterdir():
                if path.name.startswith(".") or path.name in SKIPPED or (folder == root and path.name.startswith("build")):
                    continue
                if path.is_dir():
                    folders.append(path)
                else:
                    texts[path.relative_to(root).as_posix()] = path
        return cls(texts)

    def text(self, path: str) -> str:
        found = self.texts.get(path, "")
        return found if isinstance(found, str) else found.read_text(errors="replace")

    def problems(self, path: str, lines) -> Iterator[Problem]:
        for number, text in prose(path, lines):
            for name in FILE.findall(text):
                if name not in self.endings and not PLACEHOLDER.search(name):
                    yield Problem(path, number, f"points to {name}, which is not in this repository")
            for page, heading in HEADING.findall(text):
                if page in self.texts and not re.search(rf"^#+ {re.escape(heading)}$", self.text(page), re.MULTILINE):
                    yield Problem(path, number, f'points to "{heading}", which is no heading of {page}')
            for file, function in FUNCTION.findall(text):
                if not re.search(rf"(?<![\w]){re.escape(function)}\b", self.text(file)):
                    yield Problem(path, number, f"points to {function}(), which is not in {file}")


def prose(path: str, lines):
    """The numbered lines of a page outside its blocks of code, or the comments of a file."""
    suffix = pathlib.PurePosixPath(path).suffix
    if suffix == ".md":
        code = False
        for number, line in enumerate(lines, 1):
            if line.startswith("```"):
                code = not code
            elif not code and not line.startswith("    "):
                yield number, line
        return
    mark = COMMENTS.get(suffix)
    for number, line in enumerate(lines, 1):
        if mark == "#" and line.lstrip().startswith("#"):
            yield number, line
        elif mark == "//" and mark in line:
            comment = line[line.index(mark):]
            if line.count('"', 0, line.index(mark)) % 2 == 0:
                yield number, comment
