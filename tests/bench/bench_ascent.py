#!/usr/bin/env python3
"""Claymeld beside Ascent, a Datalog that is compiled into Rust, on one thread: closures, same generation and connected components.

Usage: bench_ascent.py BIN_DIR ASCENT [--short]

ASCENT is the program of tests/bench/ascent: `cargo build --release` in a copy of that folder makes target/release/tables. It needs the
crate ascent, which cargo fetches once; this script fetches nothing. The runs of both take turns, and each figure is the least of three: CPU
seconds of the rules, without reading the facts, and for Claymeld the memory of the process at its peak. Both must derive as many rows.
"""
import json
import pathlib
import random
import subprocess
import sys
import tempfile

from bench_tables import CLOSURE, WORLD, links

OVER_LINKS = """type route edge(node, node).
type path(node, node).
path(B, A) :- neighbor(A, B).
path(B, X) :- neighbor(A, B), path(A, X).
"""
SAME = """type parent(node, int Child, int Parent).
type same(node, int, int).
same(A, X, Y) :- parent(A, X, P), parent(A, Y, P), X <> Y.
same(A, X, Y) :- parent(A, X, P), same(A, P, Q), parent(A, Y, Q).
"""
COMPONENTS = """type label(node, min int).
label(A, N) :- id(A, N).
label(B, N) :- neighbor(A, B), label(A, N).
"""


def regular(nodes):
    """Three links at each node, as of a ring with chords."""
    order = list(range(nodes))
    random.Random(5).shuffle(order)
    pairs = {(i, (i + 1) % nodes) for i in range(nodes)} | {(order[i], order[i + 1]) for i in range(0, nodes - 1, 2)}
    return sorted({(min(a, b), max(a, b)) for a, b in pairs if a != b})


def tree(nodes):
    numbers = random.Random(7)
    return [(child, numbers.randrange(max(0, (child - 1) // 3 - 2), (child - 1) // 3 + 1)) for child in range(1, nodes)]


def sparse(nodes):
    """Parts of many sizes: 0.9 links at each node on average, and no node without a link."""
    numbers = random.Random(9)
    pairs = {(i, i + 1) for i in range(0, nodes - 1, 2)} | {(numbers.randrange(nodes), numbers.randrange(nodes)) for _ in range(nodes // 3)}
    return sorted({(min(a, b), max(a, b)) for a, b in pairs if a != b})


# By task: its name in Ascent, the program, the predicate that it derives, sizes, the pairs, and whether these are links of the world.
TASKS = {
    "closure over links": ("closure", OVER_LINKS, "path", (300, 1000), regular, True),
    "closure at one catom": ("closure", CLOSURE, "path", (1000, 1260), lambda n: links(n * 9 // 5, n), False),
    "same generation": ("same", SAME, "same", (600, 2000), tree, False),
    "connected components": ("components", COMPONENTS, "label", (10_000, 100_000), sparse, True),
}
FACT = {"closure": "link", "same": "parent"}


def prepare(bin_dir, folder, program, fact, nodes, pairs, of_world):
    text = program if of_world else program + "".join(f"{fact}(@0, {a}, {b}).\n" for a, b in pairs)
    source, world, module = folder / "tables.meld", folder / "world.toml", folder / "tables.so"
    source.write_text(text)
    listed = ", ".join(f"[{a}, {b}]" for a, b in pairs)
    world.write_text(f'lattice = "graph"\nnodes = {nodes}\nlinks = [{listed}]\n' if of_world else WORLD)
    subprocess.run([bin_dir / "meldc", "compile", source, "-o", module, "--quiet"] + (["--graph"] if of_world else []), check=True,
                   stderr=subprocess.DEVNULL)
    both = pairs + [(b, a) for a, b in pairs] if of_world else pairs
    (folder / "pairs.txt").write_text("".join(f"{a} {b}\n" for a, b in both))
    return [bin_dir / "meldsim", "run", module, "--world", world, "--quiet"]


def count(command, folder, predicate):
    """How many rows Claymeld derives."""
    facts = folder / "all.facts"
    subprocess.run(command + ["--facts-out", facts], check=True, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    with open(facts) as lines:
        return sum(line.startswith(predicate + "(") for line in lines)


def main():
    arguments = [a for a in sys.argv[1:] if not a.startswith("--")]
    if len(arguments) != 2:
        sys.exit(__doc__)
    bin_dir, ascent = pathlib.Path(arguments[0]).resolve(), pathlib.Path(arguments[1]).resolve()
    if not ascent.exists():
        sys.exit(f"bench_ascent.py: there is no {ascent}. Copy tests/bench/ascent, and run `cargo build --release` there, which fetches "
                 "the crate ascent once")
    short = "--short" in sys.argv
    print(f"{'task':24}{'nodes':>9}{'rows':>11}{'Claymeld s':>12}{'MiB':>7}{'Ascent s':>10}{'ratio':>7}")
    for name, (task, program, predicate, sizes, make, of_world) in TASKS.items():
        for nodes in sizes[:1] if short else sizes:
            with tempfile.TemporaryDirectory() as temporary:
                folder = pathlib.Path(temporary)
                command = prepare(bin_dir, folder, program, FACT.get(task), nodes, make(nodes), of_world)
                ours, theirs, memory, rows = [], [], 0, 0
                for _ in range(1 if short else 3):
                    summary = json.loads(subprocess.run(command + ["--json"], check=True, capture_output=True, text=True).stdout)
                    ours.append(summary["cpu_seconds"])
                    memory = max(memory, summary["peak_bytes"])
                    said = subprocess.run([ascent, task, folder / "pairs.txt"], check=True, capture_output=True, text=True).stdout.split()
                    theirs.append(float(said[0]))
                    rows = int(said[1])
                derived = count(command, folder, predicate)
                if derived != rows:
                    sys.exit(f"bench_ascent.py: {name}: Claymeld derives {derived} rows, Ascent {rows}")
                print(f"{name:24}{nodes:>9,}{rows:>11,}{min(ours):>12.3f}{memory / 2**20:>7.0f}{min(theirs):>10.3f}"
                      f"{min(ours) / min(theirs):>7.2f}", flush=True)


if __name__ == "__main__":
    main()
