"""Checks that all C++ of the repository is as the formatter writes it: formatted.py ROOT CLANG_FORMAT [STORE]. The cure: scripts/format.
STORE: a file that remembers what was found tidy."""

import pathlib
import subprocess
import sys

from seen import Seen

FOLDERS = ("compiler", "examples", "physics", "runtime", "tests")


def sources(root: pathlib.Path):
    for folder in FOLDERS:
        for path in sorted((root / folder).rglob("*")):
            if path.suffix in (".cpp", ".h"):
                yield path.relative_to(root).as_posix()


def main():
    root, clang_format = pathlib.Path(sys.argv[1]).resolve(), sys.argv[2]
    version = subprocess.run([clang_format, "--version"], capture_output=True, text=True, check=True).stdout
    seen = Seen(pathlib.Path(sys.argv[3]) if len(sys.argv) > 3 else None, version + (root / ".clang-format").read_text())
    files = seen.unseen(root, list(sources(root)))
    if not files:
        return 0
    checked = subprocess.run([clang_format, "--dry-run", "--Werror", "--ferror-limit=1", *files], cwd=root, capture_output=True, text=True)
    print(checked.stderr, end="")
    if checked.returncode != 0:
        print("scripts/format mends these files")
    else:
        seen.remember()
    return checked.returncode


if __name__ == "__main__":
    sys.exit(main())
