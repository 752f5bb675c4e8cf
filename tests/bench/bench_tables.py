#!/usr/bin/env python3
"""Tables of facts at one catom: linear rules that keep, replace and fold facts, and views that join them and close them.

Usage: bench_tables.py BIN_DIR [--short] [--souffle]

Each task runs at three sizes, each ten times the last, so that a cost that grows faster than the table shows. A figure is the CPU time of
the run without its start, the least of three, and its memory at the peak. Beside the closure stands Souffle with --souffle, if it is in
PATH: compiled, on one thread, with the time that its profile gives. With --short only the first size runs.
"""
import json
import pathlib
import random
import re
import shutil
import subprocess
import sys
import tempfile

WORLD = 'lattice = "square"\n[[body]]\ncells = [[0, 0]]\n'

MAKE = """type linear make(node, int).
const rows = {rows}.
make(@0, rows).
"""
KEEP = MAKE + """type linear route(node, int Cost, int To).
make(A, N), N > 0 -o route(A, (N * 7919) % 1000003, N % 100), make(A, N - 1).
route(A, D, T), route(A, E, T), D < E -o route(A, D, T).
"""
REPLACE = MAKE + """type linear offer(node, int To, int Cost).
type linear best(node, int To, int Cost).
type linear begin(node, int).
make(A, N), N > 0 -o offer(A, N % 1000, (N * 7919) % 1000003), make(A, N - 1).
make(A, 0) -o begin(A, 0).
begin(A, T), T < 1000 -o best(A, T, 2000000), begin(A, T + 1).
best(A, T, D), offer(A, T, E), E < D -o best(A, T, E).
best(A, T, D), offer(A, T, _) -o best(A, T, D).
"""
FOLD = MAKE + """type linear item(node, int, int Kind).
type linear total(node, int Kind, int Sum).
type linear begin(node, int).
make(A, N), N > 0 -o item(A, (N * 7919) % 1000003, N % 100), make(A, N - 1).
make(A, 0) -o begin(A, 0).
begin(A, K), K < 100 -o total(A, K, 0), begin(A, K + 1).
total(A, K, S), item(A, V, K) -o total(A, K, S + V).
"""
# On a later argument: every pair of links to the same place.
JOIN = """type link(node, int From, int To).
type meet(node, int, int).
meet(A, X, Y) :- link(A, X, P), link(A, Y, P), X < Y.
"""
CLOSURE = """type link(node, int From, int To).
type path(node, int, int).
path(A, X, Y) :- link(A, X, Y).
path(A, X, Z) :- path(A, X, Y), link(A, Y, Z).
"""
SOUFFLE = """.decl link(x: number, y: number)
.input link(IO=file, filename="link.csv", delimiter=",")
.decl path(x: number, y: number)
path(x, y) :- link(x, y).
path(x, z) :- path(x, y), link(y, z).
.printsize path
"""
TASKS = {
    "keep the least of each group": (KEEP, 8000, None),
    "replace by a better one": (REPLACE, 8000, None),
    "fold each group": (FOLD, 8000, None),
    "join on the second argument": (JOIN, 8000, lambda n: n // 4),
    # Links for each node as in a random graph whose largest part has a tenth to a half of all pairs.
    "closure": (CLOSURE, 180, lambda n: n * 5 // 9),
}


def links(count, nodes):
    numbers = random.Random(3)
    return sorted({(numbers.randrange(nodes), numbers.randrange(nodes)) for _ in range(count)})


def measure(bin_dir, folder, program, runs):
    source = folder / "tables.meld"
    source.write_text(program)
    (folder / "world.toml").write_text(WORLD)
    module = folder / "tables.so"
    subprocess.run([bin_dir / "meldc", "compile", source, "-o", module, "--quiet"], check=True, stderr=subprocess.DEVNULL)
    command = [bin_dir / "meldsim", "run", module, "--world", folder / "world.toml", "--json", "--quiet"]
    summaries = [json.loads(subprocess.run(command, check=True, capture_output=True, text=True).stdout) for _ in range(runs)]
    return min(s["cpu_seconds"] for s in summaries), max(s["peak_bytes"] for s in summaries)


def souffle(folder, pairs):
    (folder / "link.csv").write_text("".join(f"{a},{b}\n" for a, b in pairs))
    (folder / "path.dl").write_text(SOUFFLE)
    subprocess.run(["souffle", "-o", folder / "path", folder / "path.dl"], check=True)
    times = []
    for _ in range(3):
        said = subprocess.run(["/usr/bin/time", "-f", "%U", folder / "path", "-j1", "-F", folder], check=True, capture_output=True,
                              text=True)
        times.append(float(re.findall(r"[\d.]+", said.stderr)[-1]))
    return min(times)


def main():
    arguments = [a for a in sys.argv[1:] if not a.startswith("--")]
    if len(arguments) != 1:
        sys.exit(__doc__)
    bin_dir = pathlib.Path(arguments[0]).resolve()
    short, beside = "--short" in sys.argv, "--souffle" in sys.argv
    if beside and shutil.which("souffle") is None:
        sys.exit("bench_tables.py: --souffle needs the command souffle (https://souffle-lang.github.io), and it is not in PATH")
    print(f"{'task':34}{'rows':>10}{'CPU s':>10}{'MiB':>8}" + (f"{'souffle':>10}" if beside else ""))
    for name, (program, rows, nodes) in TASKS.items():
        for size in [rows] if short else [rows, 10 * rows, 100 * rows] if nodes is None else [rows, 10 * rows]:
            with tempfile.TemporaryDirectory() as folder:
                folder = pathlib.Path(folder)
                pairs = links(size, nodes(size)) if nodes else []
                text = program.format(rows=size) if not pairs else program + "".join(f"link(@0, {a}, {b}).\n" for a, b in pairs)
                cpu, memory = measure(bin_dir, folder, text, 1 if short else 3)
                line = f"{name:34}{len(pairs) or size:>10,}{cpu:>10.4f}{memory / 2**20:>8.0f}"
                if beside and program is CLOSURE:
                    line += f"{souffle(folder, pairs):>10.3f}"
                print(line, flush=True)


if __name__ == "__main__":
    main()
