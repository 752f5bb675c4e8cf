"""Runs file tests: Meld programs that say in comments how they are run and what comes out.

    // RUN: meldc check %s           The command; %s is the program. One line.
    // WORLD: lattice = "square"     Lines of the world, for `meldsim run`.
    // EXIT: 4                      How it ends, where that is neither 0 nor, for a file fail_..., 1.
    // PROCESSES: 1                  The world runs on one process only; what is repeated has other numbers of threads.
    // KEEP: text                    Only output lines that hold one of these texts are compared.
    // CHECK: ...                    The exact output, together at the end of the file.

`meldsim run` is repeated with other numbers of processes and threads, and all must write the same facts, which are the output; the
campaign, with CLAYMELD_TEST_SIZES=all, takes all of MODES for each file, and modules that are optimized as they are for users; otherwise
they are compiled without that, which takes a fifth of the time. A file whose name starts with fail_ must exit with 1, any other
with 0. MELD_AUTOUPDATE=1 rewrites the CHECK lines; review the difference like code. Programs run in a folder of their own, without their
CHECK lines, so that output names no path. Files in a folder named `parts` beside a test can be included by it.

    file_test.py --meldc PATH --meldsim PATH FILE_OR_FOLDER...
    file_test.py --kinds compiler/diagnostics/kinds.def FOLDER       Every kind of diagnostic has a test that shows it.
    file_test.py --constructs constructs.toml ROOT                   Every construct has a test of its use and one of its misuse.
    file_test.py --passes compiler/plan/plan.cpp FOLDER              Every pass of the planner has a test of what it leaves.
"""
import argparse
import difflib
import os
import pathlib
import re
import shlex
import subprocess
import sys
import tempfile
import tomllib
import zlib
from concurrent.futures import ThreadPoolExecutor

# Processes and threads of each run; all write the same facts. One of those after the first is enough for a file: a folder has files of
# each kind, and it takes ten times as long to start several processes as to run a file on one.
MODES = [(1, 1), (1, 2), (2, 2), (3, 1)]
CAMPAIGN = os.environ.get("CLAYMELD_TEST_SIZES") == "all"
SECONDS = 120


class Failure(Exception):
    pass


class Test:
    def __init__(self, path):
        self.path = path
        # Bytes that are not UTF-8 come through unchanged: they are what some tests are about.
        self.lines = path.read_text(encoding="utf-8", errors="surrogateescape").split("\n")
        self.program = [line for line in self.lines if not line.startswith("// CHECK:")]
        self.expected = [line[len("// CHECK:"):].removeprefix(" ") for line in self.lines if line.startswith("// CHECK:")]
        runs = self.values("RUN")
        if len(runs) != 1:
            raise Failure("needs one line `// RUN: command`")
        self.command = runs[0]
        first = next((i for i, line in enumerate(self.lines) if line.startswith("// CHECK:")), None)
        if first is not None and any(line and not line.startswith("// CHECK:") for line in self.lines[first:]):
            raise Failure("the CHECK lines must stand together at the end")

    def values(self, key):
        return [line[len(f"// {key}:"):].removeprefix(" ") for line in self.program if line.startswith(f"// {key}:")]

    def update(self, actual):
        kept = list(self.program)
        while kept and not kept[-1]:
            kept.pop()
        text = "\n".join(kept + [""] + [f"// CHECK: {line}".rstrip() for line in actual]) + "\n"
        self.path.write_text(text, encoding="utf-8", errors="surrogateescape")


def call(command, folder):
    try:
        done = subprocess.run(command, cwd=folder, stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, stderr=subprocess.STDOUT,
                              timeout=SECONDS)
    except subprocess.TimeoutExpired:
        raise Failure(f"not done after {SECONDS} s: {shlex.join(command)}")
    return done.returncode, done.stdout.decode(errors="surrogateescape")


def prepare(test, folder):
    program = folder / test.path.name
    program.write_text("\n".join(test.program), encoding="utf-8", errors="surrogateescape")
    if test.values("WORLD"):
        (folder / "world.toml").write_text("\n".join(test.values("WORLD")) + "\n")
    parts = test.path.parent / "parts"
    if parts.is_dir():
        (folder / "parts").symlink_to(parts.resolve())


def modes_of(test):
    if test.values("PROCESSES") == ["1"]:
        return [mode for mode in MODES if mode[0] == 1]
    return MODES if CAMPAIGN else [MODES[0], MODES[1 + zlib.crc32(test.path.name.encode()) % 3]]


def run_modes(command, folder, modes):
    """The output and facts of the first mode; a Failure where another differs."""
    first = None
    for processes, threads in modes:
        facts = folder / f"facts.{processes}.{threads}"
        more = ["--quiet", "-n", str(processes), "--threads", str(threads), "--facts-out", facts.name]
        if not CAMPAIGN and not any(word.startswith("-O") for word in command):
            more.append("-O0")
        if (folder / "world.toml").exists():
            more += ["--world", "world.toml"]
        code, output = call(command + more, folder)
        output += facts.read_text() if facts.exists() else ""
        if first is None:
            first = (code, output)
        elif first != (code, output):
            difference = difflib.unified_diff(first[1].split("\n"), output.split("\n"), "1 process, 1 thread",
                                              f"-n {processes} --threads {threads}", lineterm="")
            raise Failure(f"exit {first[0]} and {code}; the facts depend on processes or threads:\n" + "\n".join(difference))
    return first


def run(test, tools):
    with tempfile.TemporaryDirectory(prefix="meld-test-") as name:
        folder = pathlib.Path(name)
        prepare(test, folder)
        words = [word.replace("%s", test.path.name) for word in shlex.split(test.command)]
        if words[0] not in tools:
            raise Failure(f"RUN starts with meldc or meldsim, not {words[0]}")
        command = [tools[words[0]]] + words[1:]
        code, output = run_modes(command, folder, modes_of(test)) if words[:2] == ["meldsim", "run"] else call(command, folder)
        output = output.replace(str(folder) + "/", "")
    refused = test.path.name.startswith("fail_")
    wanted = int((test.values("EXIT") or [refused])[0])
    if (wanted != 0) != refused:
        raise Failure("a file starts with fail_ exactly if it ends with another code than 0")
    if code != wanted:
        raise Failure(f"exit {code}, and the file says {wanted}:\n{output}")
    lines = [line.rstrip() for line in output.split("\n")]
    keep = test.values("KEEP")
    lines = [line for line in lines if not keep or any(text in line for text in keep)]
    while lines and not lines[-1]:
        lines.pop()
    return lines


def check(path, tools, rewrite):
    """None, or what is wrong."""
    try:
        test = Test(path)
        actual = run(test, tools)
        if actual == test.expected:
            return None if actual else "prints nothing that is compared, so it cannot fail"
        if rewrite:
            test.update(actual)
            return None
        return "\n".join(difflib.unified_diff(test.expected, actual, "expected", "actual", lineterm=""))
    except Failure as failure:
        return str(failure)


def programs(places):
    for place in map(pathlib.Path, places):
        found = [place] if place.is_file() else sorted(p for p in place.rglob("*.meld") if p.parent.name != "parts")
        if not found:
            sys.exit(f"no tests in {place}")
        yield from found


def check_kinds(table, places):
    codes = dict(re.findall(r'^MELD_KIND\((\w+), "(\w+)"', pathlib.Path(table).read_text(), re.M))
    shown = set()
    for path in programs(places):
        shown.update(re.findall(r"^// CHECK: \w+\[(\w+)\]", path.read_text(errors="surrogateescape"), re.M))
    missing = [f"{kind} ({code})" for kind, code in codes.items() if code not in shown]
    for kind in missing:
        print(f"no file test shows {kind}")
    return 1 if missing or not codes else 0


def check_passes(table, folder):
    """A file NAME.meld for each pass in the table; it stops after a pass, its own or the first whose result can be printed."""
    names = re.findall(r'^    \{\.name = "(\w+)"', pathlib.Path(table).read_text(), re.M)
    missing = [name for name in names if "--after=" not in read_or_empty(folder / f"{name}.meld")]
    for name in missing:
        print(f"no file test {folder}/{name}.meld with --after")
    return 1 if missing or not names else 0


def read_or_empty(path):
    return path.read_text() if path.is_file() else ""


def check_constructs(table, root):
    """The files that constructs.toml names hold the constructs; all words of the prelude are among them."""
    constructs = tomllib.loads(pathlib.Path(table).read_text())["construct"]
    wrong = []
    for construct in constructs:
        for part in ("use", "misuse"):
            if part not in construct:
                continue
            path = root / construct[part]
            if not path.is_file():
                wrong.append(f"{construct['name']}: there is no {construct[part]}")
                continue
            lines = path.read_text(errors="replace").split("\n")
            if construct["text"] not in "\n".join(line for line in lines if not line.startswith("//")):
                wrong.append(f"{construct['name']}: {construct[part]} holds no {construct['text']}")
            refused = any(re.match(r"// CHECK: (error|meldsim: |meldc: )", line) for line in lines)
            if refused != (part == "misuse"):
                wrong.append(f"{construct['name']}: {construct[part]} is {'' if refused else 'not '}refused")
    words = set(re.findall(r"^type (?:\w+ )*([\w-]+)\(", (root / "stdlib/prelude.meld").read_text(), re.M))
    wrong += [f"no construct for {word} of the prelude" for word in sorted(words - {c["name"] for c in constructs})]
    print("\n".join(wrong) or f"{len(constructs)} constructs")
    return 1 if wrong or not words else 0


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--meldc")
    parser.add_argument("--meldsim")
    parser.add_argument("--kinds")
    parser.add_argument("--constructs")
    parser.add_argument("--passes")
    parser.add_argument("places", nargs="+")
    options = parser.parse_args()
    if options.kinds:
        return check_kinds(options.kinds, options.places)
    if options.constructs:
        return check_constructs(options.constructs, pathlib.Path(options.places[0]))
    if options.passes:
        return check_passes(options.passes, pathlib.Path(options.places[0]))
    tools = {"meldc": options.meldc, "meldsim": options.meldsim}
    rewrite = os.environ.get("MELD_AUTOUPDATE") == "1"
    files = list(programs(options.places))
    with ThreadPoolExecutor(max_workers=2) as pool:
        results = list(pool.map(lambda path: check(path, tools, rewrite), files))
    failed = [(path, result) for path, result in zip(files, results) if result is not None]
    for path, result in failed:
        print(f"FAILED {path}\n{result}\n".encode(errors="backslashreplace").decode())
    print(f"{len(files) - len(failed)} of {len(files)} file tests passed")
    return 1 if failed else 0


if __name__ == "__main__":
    sys.exit(main())
