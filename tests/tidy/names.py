"""Checks that no Python of the repository has names that nothing defines or nobody uses: names.py ROOT. The cure stands in what flake8
prints."""

import pathlib
import subprocess
import sys

FOLDERS = ("cmake", "docs", "editors", "examples", "packaging", "physics", "python", "scripts", "tests")
# Recipes take their words from a package manager that is not there.
RECIPES = "packaging/spack"


def main():
    root = pathlib.Path(sys.argv[1]).resolve()
    files = [path.relative_to(root).as_posix() for folder in FOLDERS for path in sorted((root / folder).rglob("*.py"))]
    files = [file for file in files if not file.startswith(RECIPES) and "node_modules" not in file]
    return subprocess.run([sys.executable, "-m", "flake8", "--isolated", "--select=F", *files], cwd=root).returncode


if __name__ == "__main__":
    sys.exit(main())
