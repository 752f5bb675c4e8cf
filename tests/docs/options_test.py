"""Options of meldc and meldsim that pages and examples name are there, also in commands that no test runs: blocks that take too long or
need what is not here, and first lines of programs.

    options_test.py --bin build/bin
"""
import argparse
import functools
import pathlib
import re
import shlex
import subprocess
import sys

ROOT = pathlib.Path(__file__).resolve().parents[2]
TOOLS = ("meldc", "meldsim")
# Everything up to the end of a command of the shell.
PIECE = re.compile(r"[|;&]+(?=\s|$)")


def lines_of(path):
    """With their numbers, the lines that may be commands; those that go on after a backslash are one."""
    fenced, start, whole = path.suffix != ".md", 0, ""
    for number, line in enumerate(path.read_text().splitlines(), 1):
        if path.suffix == ".md" and line.startswith("```"):
            info = line[3:].split()
            # A block that shows how a mistake is reported ends with 2.
            fenced = not fenced and info[:1] in (["sh"], ["console"]) and "exit=2" not in info
            continue
        if path.suffix == ".meld":
            said = re.match(r"// (?:Run: +|     +)(meld(?:c|sim) .*)", line)
            line = said.group(1) if said else ""
        if not fenced or not line:
            continue
        start = start or number
        whole += line.removesuffix("\\")
        if not line.endswith("\\"):
            yield start, whole.removeprefix("$ ")
            start, whole = 0, ""


def commands_of(line):
    """The words of each call of a tool that a line makes."""
    try:
        words = shlex.split(PIECE.sub(" ; ", line), comments=True)
    except ValueError:  # Within a text of several lines.
        return
    at = 0
    while at < len(words):
        end = words.index(";", at) if ";" in words[at:] else len(words)
        call = words[at:end]
        for i, word in enumerate(call):
            if word.rpartition("/")[2] in TOOLS:
                yield [word.rpartition("/")[2], *call[i + 1:]]
                break
        at = end + 1


class Options:
    def __init__(self, folder):
        self.folder = folder

    @functools.cache
    def of(self, tool, command):
        said = subprocess.run([self.folder / tool, *command, "--help"], stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True)
        return set(re.findall(r"(?<![\w-])--?[A-Za-z][\w-]*", said.stdout)) if said.returncode == 0 else None

    def wrong(self, call):
        """What is wrong about a call; nothing."""
        tool, *rest = call
        if not rest or rest[0].startswith("-") or not re.fullmatch(r"[a-z-]+", rest[0]):
            return None
        there = self.of(tool, (rest[0],))
        if there is None:
            return f"{tool} has no command {rest[0]}"
        for word in rest[1:]:
            name = word.partition("=")[0]
            if re.fullmatch(r"--[a-z][a-z-]*", name) and name not in there:
                return f"{tool} {rest[0]} has no option {name}"
        return None


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--bin", required=True, type=pathlib.Path)
    options = Options(parser.parse_args().bin.resolve())
    pages = [ROOT / "README.md", *sorted((ROOT / "docs").rglob("*.md")), *sorted((ROOT / "examples").rglob("*.meld")),
             *sorted((ROOT / "examples").rglob("*.md"))]
    calls, failures = 0, []
    for page in pages:
        for number, line in lines_of(page):
            for call in commands_of(line):
                calls += 1
                if said := options.wrong(call):
                    failures.append(f"{page.relative_to(ROOT)}:{number}: {said}")
    print("\n".join(failures + [f"{calls} commands, {len(failures)} wrong"]))
    # Commands are found at all.
    sys.exit(1 if failures or calls < 500 else 0)


if __name__ == "__main__":
    main()
