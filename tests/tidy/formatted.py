"""Checks that all C++ of the repository is as the formatter writes it: formatted.py ROOT CLANG_FORMAT. The cure: scripts/format."""

import pathlib
import subprocess
import sys

FOLDERS = ("compiler", "examples", "physics", "runtime", "tests")


def sources(root: pathlib.Path):
    for folder in FOLDERS:
        for path in sorted((root / folder).rglob("*")):
            if path.suffix in (".cpp", ".h"):
                yield path.relative_to(root).as_posix()


def main():
    root, clang_format = pathlib.Path(sys.argv[1]).resolve(), sys.argv[2]
    files = list(sources(root))
    checked = subprocess.run([clang_format, "--dry-run", "--Werror", "--ferror-limit=1", *files], cwd=root, capture_output=True, text=True)
    print(checked.stderr, end="")
    if checked.returncode != 0:
        print("scripts/format mends these files")
    return checked.returncode


if __name__ == "__main__":
    sys.exit(main())
