"""Cures that messages print, tried: each program of cures.toml has an error, the test applies its cure as a reader would, and the program
must then compile and derive what was wanted.

    cures_test.py --meldc PATH --meldsim PATH
"""
import argparse
import fnmatch
import json
import pathlib
import re
import subprocess
import sys
import tempfile
import tomllib

from fixes_test import apply

HERE = pathlib.Path(__file__).resolve().parent
WORLD = 'lattice = "square"\n[[body]]\nshape = "box(3, 1, 1)"\n'
# Of several mistakes each has a cure of its own.
MAX_CURES = 4


def messages(meldc, path):
    done = subprocess.run([meldc, "check", "--json", path.name], cwd=path.parent, stdin=subprocess.DEVNULL, capture_output=True, timeout=60)
    return [m for m in json.loads(done.stdout) if m["severity"] == "error"]


def cured(text, message, row):
    """The program after the cure of one message."""
    if row.get("take", "fix") == "fix":
        if not message["fixes"]:
            raise AssertionError(f"it has no fix; its help is: {message['help']}")
        return apply(text.encode(), message["fixes"][0]["edits"]).decode()
    words = re.findall(r"`([^`]*)`", message["help"])
    if not words:
        raise AssertionError(f"its help shows nothing to write: {message['help']}")
    how, line = row["put"].rsplit(" ", 1)
    lines = text.split("\n")
    lines[int(line) - 1:int(line) - (how == "before")] = words
    return "\n".join(lines)


def try_row(row, options, folder):
    path = folder / "program.meld"
    text = row["program"].lstrip("\n")
    path.write_text(text)
    found = messages(options.meldc, path)
    if not found or found[0]["code"] != row["code"]:
        raise AssertionError(f"the first error is {found[0]['code'] if found else 'none'}")
    # A cure must cure at once; other errors of the program may need theirs.
    for _ in range(MAX_CURES):
        text = cured(text, found[0], row)
        path.write_text(text)
        before, found = found, messages(options.meldc, path)
        if len(found) >= len(before):
            raise AssertionError(f"after the cure there is still: {found[0]['code']} {found[0]['message']}\n{text}")
        if not found:
            break
    if "without" in row and row["without"] in text:
        raise AssertionError(f"the cured program still has {row['without']}\n{text}")
    done = subprocess.run([options.meldsim, "run", path.name, "--world", "row.toml", "--ticks", "200", "--quiet", "--facts-out", "-"],
                          cwd=folder, stdin=subprocess.DEVNULL, capture_output=True, text=True, timeout=120)
    facts = done.stdout.split("\n")
    if done.returncode != 0:
        raise AssertionError(f"the cured program ends with {done.returncode}: {done.stderr}\n{text}")
    for wanted in row["holds"]:
        if not any(fnmatch.fnmatchcase(fact, wanted) for fact in facts):
            raise AssertionError(f"the cured program does not derive {wanted}\n{text}{done.stdout}")
    for name in row.get("lacks", []):
        if any(fact.startswith(name + "(") for fact in facts):
            raise AssertionError(f"the cured program has facts of {name}\n{text}{done.stdout}")


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--meldc", required=True)
    parser.add_argument("--meldsim", required=True)
    options = parser.parse_args()
    rows = tomllib.loads((HERE / "cures.toml").read_text())["cure"]
    wrong = []
    with tempfile.TemporaryDirectory(prefix="meld-cures-") as name:
        folder = pathlib.Path(name)
        (folder / "row.toml").write_text(WORLD)
        for number, row in enumerate(rows):
            try:
                try_row(row, options, folder)
            except AssertionError as error:
                wrong.append(f"cure {number + 1}, {row['code']}:\n{row['program']}{error}\n")
    print("\n".join(wrong) or f"{len(rows)} cures")
    return 1 if wrong else 0


if __name__ == "__main__":
    sys.exit(main())
