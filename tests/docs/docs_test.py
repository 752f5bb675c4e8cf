"""Runs every fenced block of README.md and of the pages in docs/, and follows the links between them.

    docs_test.py --bin build/bin [--update] [FILE.md ...] [--without FILE.md ...]

Each page has a scratch folder with a copy of examples/, in which its blocks run one after another:

    meld                    checked by meldc; `fail E0301`: must be refused with that code; `warn W0604`: must have that warning;
                            `graph`: it is for worlds that are graphs
    toml                    a world, checked by meldsim; `part`: lines of one, given a body and a lattice; `fail`: must be refused;
                            `exit=4`: with this code
    console                 `$ command` lines (more lines after a `\\`), then what they print; `exit=1`: how the last one ends;
                            `measured`: shown as really printed, but the summary's times and sizes may differ
    sh                      run as a whole; must end well
    python                  run by Debian's Python, which finds the package in python/
    cpp                     its syntax is checked, with the repository's headers
    text, none              not run

`file=NAME` on a block also saves it in the scratch folder. `norun` exempts a block. A comment `<!-- with ... -->` right before
a meld block holds declarations that it needs and the page does not show. In expected output, `...` on a line stands for any text,
and alone on a line for any lines. --update writes docs/errors.md and docs/functions.md anew.
"""
import argparse
import concurrent.futures
import os
import pathlib
import re
import shutil
import subprocess
import sys
import tempfile

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1]))

from frame import OPEN_MPI  # noqa: E402

ROOT = pathlib.Path(__file__).resolve().parents[2]
PYTHON = "/usr/bin/python3"
LANGUAGES = {"meld", "toml", "console", "sh", "python", "cpp", "text", ""}
SECONDS = 120  # For one command.


class Block:
    def __init__(self, page, line, info, text, preamble):
        words = info.split()
        self.place = f"{page.relative_to(ROOT)}:{line}"
        self.language = words[0] if words else ""
        self.flags = words[1:]
        self.text = text
        self.preamble = preamble

    def value(self, name):
        for flag in self.flags:
            if flag.startswith(name + "="):
                return flag[len(name) + 1:]
        return None

    def after(self, name):
        """The word after a flag: `fail E0301`."""
        if name not in self.flags:
            return None
        at = self.flags.index(name) + 1
        return self.flags[at] if at < len(self.flags) else ""


def blocks_of(page):
    found, preamble, lines = [], "", page.read_text().splitlines()
    at = 0
    while at < len(lines):
        line = lines[at]
        if line.startswith("<!-- with"):
            start = at
            while "-->" not in lines[at]:
                at += 1
            preamble = "\n".join(lines[start:at + 1]).removeprefix("<!-- with").removesuffix("-->").strip() + "\n"
        elif line.startswith("```"):
            start, info = at, line[3:].strip()
            at += 1
            while lines[at] != "```":
                at += 1
            found.append(Block(page, start + 1, info, "\n".join(lines[start + 1:at]) + "\n", preamble))
            preamble = ""
        at += 1
    return found


def matches(expected, real):
    """Whether real output is the expected one, with its wildcards."""
    pattern = ""
    for line in expected.rstrip("\n").splitlines():
        if line.strip() == "...":
            pattern += r"(?:.*\n)*?"
        else:
            pattern += ".*?".join(re.escape(piece) for piece in line.rstrip().split("...")) + r"[ \t]*\n"
    real = real.rstrip("\n")
    return re.fullmatch(pattern, real + "\n" if real else "") is not None


def unmeasured(expected):
    """Printed measurements as wildcards: whatever follows the names below in a summary differs from run to run."""
    return re.sub(r"^(  (?:memory|time) +).*$", r"\1...", expected, flags=re.MULTILINE)


def without_progress(real):
    """A run that takes long says how far it is, which one of the pages' does only where the machine has other work."""
    return re.sub(r"^tick [\d,]+ of [\d,]+, .* awake of .*\n", "", real, flags=re.MULTILINE)


class Page:
    def __init__(self, page, bin_folder, scratch):
        self.page, self.scratch = page, scratch
        self.failures, self.count = [], 0
        tools = scratch.with_name(scratch.name + "-tools")
        tools.mkdir()
        (tools / "python3").symlink_to(PYTHON)
        shutil.copytree(ROOT / "examples", scratch / "examples")
        (scratch / "docs").symlink_to(ROOT / "docs")
        self.environment = dict(os.environ, PATH=f"{tools}:{bin_folder}:{os.environ['PATH']}", XDG_CACHE_HOME=str(scratch.parent / "cache"),
                                PYTHONPATH=str(ROOT / "python"), PYTHONDONTWRITEBYTECODE="1",
                                COLUMNS="100", LC_ALL="C.UTF-8", **OPEN_MPI)

    def call(self, command):
        done = subprocess.run(command, cwd=self.scratch, env=self.environment, stdin=subprocess.DEVNULL, stdout=subprocess.PIPE,
                              stderr=subprocess.STDOUT, timeout=SECONDS, shell=isinstance(command, str),
                              executable="/bin/bash" if isinstance(command, str) else None)
        return done.returncode, done.stdout.decode(errors="replace")

    def wrong(self, block, what, output=""):
        self.failures.append(f"{block.place}: {what}\n" + "".join(f"    {line}\n" for line in output.splitlines()))

    def run(self):
        for block in blocks_of(self.page):
            if block.language not in LANGUAGES:
                self.wrong(block, f"a block of an unknown language, {block.language}")
                continue
            if block.value("file"):
                (self.scratch / block.value("file")).write_text(block.preamble + block.text)
            if "norun" in block.flags or block.language in ("text", ""):
                continue
            self.count += 1
            try:
                getattr(self, block.language)(block)
            except subprocess.TimeoutExpired:
                self.wrong(block, f"took longer than {SECONDS} s")
        return self

    def meld(self, block):
        path = self.scratch / "block.meld"
        path.write_text(block.preamble + block.text)
        code, output = self.call(["meldc", "check", "block.meld", *(["--graph"] if "graph" in block.flags else [])])
        refused, warned = block.after("fail"), block.after("warn")
        if refused is not None:
            if code != 1 or f"error[{refused}]" not in output:
                self.wrong(block, f"is not refused with {refused} (exit code {code})", output)
        elif code != 0:
            self.wrong(block, f"does not compile (exit code {code})", output)
        elif warned is not None and f"[{warned}]" not in output:
            self.wrong(block, f"has no message {warned}", output)

    def toml(self, block):
        text = block.text
        if "part" in block.flags:
            if "lattice" not in text:
                text = 'lattice = "cubic"\n' + text
            if "[[body]]" not in text:
                text += '\n[[body]]\nshape = "box(10, 10, 10)"\n'
        (self.scratch / "block.toml").write_text(text)
        code, output = self.call(["meldsim", "world", "block.toml"])
        wanted = int(block.value("exit") or (2 if "fail" in block.flags else 0))
        if code != wanted:
            self.wrong(block, f"meldsim world ends with {code}, not {wanted}", output)

    def sh(self, block):
        code, output = self.call("set -e\n" + block.text)
        if code != 0:
            self.wrong(block, f"ends with exit code {code}", output)

    def console(self, block):
        commands = []
        for line in block.text.splitlines():
            if line.startswith("$ "):
                commands.append([line[2:], ""])
            elif commands and commands[-1][0].endswith("\\"):
                commands[-1][0] += "\n" + line
            elif commands:
                commands[-1][1] += line + "\n"
            else:
                self.wrong(block, "begins with no command")
        for i, (command, expected) in enumerate(commands):
            wanted = int(block.value("exit") or 0) if i + 1 == len(commands) else 0
            code, output = self.call(command)
            if code != wanted:
                self.wrong(block, f"`{command}` ends with exit code {code}, not {wanted}", output)
            elif not matches(unmeasured(expected) if "measured" in block.flags else expected, without_progress(output)):
                self.wrong(block, f"`{command}` prints something else:", output)

    def python(self, block):
        (self.scratch / "block.py").write_text(block.text)
        code, output = self.call([PYTHON, "block.py"])
        if code != 0:
            self.wrong(block, f"ends with exit code {code}", output)

    def cpp(self, block):
        path = self.scratch / "block.cpp"
        path.write_text(block.preamble + block.text)
        code, output = self.call(["g++", "-std=c++20", "-fsyntax-only", "-I", str(ROOT), "block.cpp"])
        if code != 0:
            self.wrong(block, "is no C++ that the compiler takes", output)


def anchors(page):
    """The anchors of a page's headings, as GitHub makes them."""
    headings = re.findall(r"^#+ (.*)$", page.read_text(), re.MULTILINE)
    return {re.sub(r"[^\w\- ]", "", heading.lower()).replace(" ", "-") for heading in headings}


def dead_links(page):
    text = re.sub(r"^```.*?^```$", "", page.read_text(), flags=re.MULTILINE | re.DOTALL)
    for link in re.findall(r"\]\(([^)\s]+)\)", text):
        path, _, anchor = link.partition("#")
        target = (page.parent / path).resolve() if path else page
        if "://" in link:
            continue
        if not target.exists():
            yield f"{page.relative_to(ROOT)}: a link to {path}, which does not exist\n"
        elif anchor and anchor not in anchors(target):
            yield f"{page.relative_to(ROOT)}: a link to {link}, where no such heading is\n"


def errors_page(bin_folder):
    """docs/errors.md, from the table of kinds and `meldc explain`."""
    table = (ROOT / "compiler/diagnostics/kinds.def").read_text()
    codes = re.findall(r'^MELD_KIND\(\w+, "(\w+)"', table, re.MULTILINE)
    out = ["# Messages", "", "<!-- Written by tests/docs/docs_test.py --update. -->", "",
           "This page lists all messages of `meldc`. `meldc explain CODE` explains a message, with an example and a cure:", "",
           "```console", "$ meldc explain E0304 | head -n 1", "E0304: a type mismatch (TypeMismatch)", "```", "",
           "Codes that begin with E are errors, W warnings, N notes; only errors stop the compilation.", "",
           "| code | title | what it means |", "|---|---|---|"]
    for code in codes:
        text = subprocess.run([bin_folder / "meldc", "explain", code], capture_output=True, text=True, check=True).stdout
        head, body = text.split("\n", 1)
        title = head.removeprefix(f"{code}: ").rsplit(" (", 1)[0]
        paragraph = " ".join(body.strip().split("\n\n")[0].split())
        sentence = re.split(r"(?<=[.])\s+(?=[A-Z])", paragraph)[0].replace("|", "\\|").replace("*", "\\*")
        out.append(f"| {code} | {title} | {sentence} |")
    return "\n".join(out) + "\n"


def functions_page():
    """docs/functions.md, from the table of the library."""
    table = (ROOT / "compiler/check/program/library.def").read_text()
    out = ["# Functions", "", "<!-- Written by tests/docs/docs_test.py --update. -->", "",
           "This page lists the functions that every program can call. "
           "Here `sqrt` and `float` give the distance of a catom from a cell:", "",
           "```meld", "type away(node, float).", "away(A, sqrt(float(X * X + Y * Y))) :- cell(A, X, Y, _).", "```", "",
           "A function of the program hides a library function of the same name.", "",
           "`T` is any type, `N` is `int` or `float`, `S` a struct of floats.",
           "A function without a value for an argument, such as an element past the end, stops the run with a message."]
    # An entry may go on in the next line.
    entry = re.compile(r'^MELD_(SECTION|OPERATOR|\w*FUNCTION)\("([^"]*)"(?:, "([^"]*)")?.*?(?:"([^"]*)")?\)$', re.MULTILINE | re.DOTALL)
    for kind, name, signature, text in entry.findall(table):
        if kind == "SECTION" and not name:
            break
        if kind == "SECTION":
            out += ["", f"## {name}", "", "| function | type | returns |", "|---|---|---|"]
        else:
            out.append(f"| `{name}` | `{signature}` | {text} |")
    return "\n".join(out) + "\n"


GENERATED = {"errors.md": lambda bin_folder: errors_page(bin_folder), "functions.md": lambda bin_folder: functions_page()}


def main():
    arguments = argparse.ArgumentParser()
    arguments.add_argument("--bin", required=True, type=pathlib.Path)
    arguments.add_argument("--update", action="store_true")
    arguments.add_argument("--without", nargs="*", default=[], type=pathlib.Path, help="pages that are not run")
    arguments.add_argument("pages", nargs="*", type=pathlib.Path)
    options = arguments.parse_args()
    bin_folder = options.bin.resolve()
    if options.update:
        for name, text in GENERATED.items():
            (ROOT / "docs" / name).write_text(text(bin_folder))
    pages = [page.resolve() for page in options.pages] or [ROOT / "README.md", *sorted((ROOT / "docs").rglob("*.md"))]
    pages = [page for page in pages if page not in {left_out.resolve() for left_out in options.without}]
    # The longest first, so that none is left alone at the end.
    pages.sort(key=lambda page: -page.stat().st_size)
    failures = []
    for name, text in GENERATED.items():
        if not options.pages and (ROOT / "docs" / name).read_text() != text(bin_folder):
            failures.append(f"docs/{name} is not what its table says; write it anew with tests/docs/docs_test.py --update\n")
    for page in pages:
        failures += dead_links(page)
    with tempfile.TemporaryDirectory() as folder:
        jobs = []
        with concurrent.futures.ThreadPoolExecutor(2) as pool:
            for page in pages:
                scratch = pathlib.Path(folder) / "-".join(page.relative_to(ROOT).parts)
                scratch.mkdir()
                jobs.append(pool.submit(Page(page, bin_folder, scratch).run))
        for job in jobs:
            failures += job.result().failures
        count = sum(job.result().count for job in jobs)
    print("\n".join(failures), end="")
    print(f"{count} blocks on {len(pages)} pages: {len(failures) or 'no'} failures")
    return 1 if failures else 0


if __name__ == "__main__":
    sys.exit(main())
