"""Checks the repository against rules.py: tidy.py ROOT prints each problem as file:line: rule and exits with 1 if there are any."""

import pathlib
import sys

from references import SKIPPED, References
from rules import Layers, PrivateNames, Problem, check_file, check_table_of_folders

FOLDERS = ("cmake", "compiler", "docs/pictures", "docs/site", "editors", "examples", "packaging", "physics", "python", "runtime", "stdlib",
           "tests")
PAGES = ("README.md", "CHANGELOG.md", "docs", "editors")
SUFFIXES = (".h", ".cpp", ".def", ".l", ".y", ".yy", ".py", ".js", ".cmake", ".meld")
# Programs for the shell have no suffix.
SHELL = ("scripts", ".ci")
# A program that tests the scanner may contain any byte, and its expected output lines of any width.
FREE_TEXT = "tests/meld/"


def files_of(root: pathlib.Path):
    yield root / "CMakeLists.txt"
    for folder in FOLDERS:
        for path in sorted((root / folder).rglob("*")):
            if path.is_file() and (path.suffix in SUFFIXES or path.name == "CMakeLists.txt") and not SKIPPED & set(path.parts):
                yield path
    for folder in SHELL:
        yield from sorted(path for path in (root / folder).iterdir() if path.is_file())


def check_repository(root: pathlib.Path):
    layers = Layers((root / "CMakeLists.txt").read_text())
    yield from layers.problems_of_order("CMakeLists.txt")
    yield from check_table_of_folders((root / "docs/reference/design.md").read_text(), layers)
    references = References.of(root)
    private = PrivateNames()
    for path in sorted(references.texts):
        if path.endswith(".md") and path.startswith(PAGES):
            yield from references.problems(path, references.text(path).split("\n"))
    for file in files_of(root):
        path = file.relative_to(root).as_posix()
        if path.startswith(FREE_TEXT) and file.suffix == ".meld":
            continue
        try:
            text = file.read_bytes().decode("utf-8")
        except UnicodeDecodeError as error:
            yield Problem(path, 1, f"not UTF-8 ({error.reason})")
            continue
        yield from check_file(path, text, layers)
        if path.endswith(".cpp") and (layer := layers.layer_of(path)):
            yield from private.problems(path, text, layer)
        if not path.startswith("tests/tidy/"):
            yield from references.problems(path, text.split("\n"))


def main():
    problems = list(check_repository(pathlib.Path(sys.argv[1]).resolve()))
    for problem in problems:
        print(problem)
    if problems:
        print(f"{len(problems)} problems; docs of the rules: tests/tidy/rules.py and references.py")
    return 1 if problems else 0


if __name__ == "__main__":
    sys.exit(main())
