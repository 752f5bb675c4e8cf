"""Checks that no Python of the repository has names that nothing defines or nobody uses: names.py ROOT [STORE]. The cure stands in what
flake8 prints. STORE: a file that remembers what was found tidy."""

import pathlib
import subprocess
import sys

from seen import Seen

FOLDERS = ("cmake", "docs", "editors", "examples", "packaging", "physics", "python", "scripts", "tests")
# Recipes take their words from a package manager that is not there.
RECIPES = "packaging/spack"


def main():
    root = pathlib.Path(sys.argv[1]).resolve()
    files = [path.relative_to(root).as_posix() for folder in FOLDERS for path in sorted((root / folder).rglob("*.py"))]
    files = [file for file in files if not file.startswith(RECIPES) and "node_modules" not in file]
    check = [sys.executable, "-m", "flake8", "--isolated", "--select=F"]
    version = subprocess.run([*check, "--version"], capture_output=True, text=True, check=True).stdout
    seen = Seen(pathlib.Path(sys.argv[2]) if len(sys.argv) > 2 else None, version + str(check))
    files = seen.unseen(root, files)
    if not files:
        return 0
    code = subprocess.run([*check, *files], cwd=root).returncode
    if code == 0:
        seen.remember()
    return code


if __name__ == "__main__":
    sys.exit(main())
