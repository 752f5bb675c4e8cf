#!/usr/bin/env python3
"""Claymeld beside Ascent and Soufflé, which compile Datalog into Rust and C++, on one thread: closures, same generation, connected
components, and what variables of a program point to.

Usage: bench_ascent.py BIN_DIR ASCENT [SOUFFLE] [--short]

ASCENT is the program of tests/bench/ascent: `cargo build --release` in a copy of that folder makes target/release/tables. It needs the
crate ascent, which cargo fetches once. SOUFFLE is the program of tests/bench/souffle: `make -f tests/bench/souffle/Makefile` makes it in
another folder, with the command souffle and its headers. Without it only Ascent runs; this script fetches nothing. The runs of all take
turns, and each figure is the least of three: CPU seconds of the rules, without reading the facts, and for Claymeld the memory of the
process at its peak. The ratio is to the faster of the others. All must derive as many rows.
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
POINTS = """type new(node, int, int).
type assign(node, int, int).
type load(node, int, int, int).
type store(node, int, int, int).
type points(node, int, int).
type field(node, int, int, int).
points(A, V, O) :- new(A, V, O).
points(A, V, O) :- assign(A, V, W), points(A, W, O).
field(A, O, F, P) :- store(A, V, F, W), points(A, V, O), points(A, W, P).
points(A, V, P) :- load(A, V, W, F), points(A, W, O), field(A, O, F, P).
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


def program(variables):
    """Statements of a program by what they do; most are about variables that are near each other, as those of a function are."""
    numbers = random.Random(11)

    def near(v):
        return numbers.randrange(variables) if numbers.random() < 0.02 else max(0, min(variables - 1, v + numbers.randrange(-20, 21)))

    made = {"new": set(), "assign": set(), "load": set(), "store": set()}
    for _ in range(2 * variables):
        v, kind, name = numbers.randrange(variables), numbers.choices(list(made), (2, 6, 2, 1))[0], numbers.randrange(8)
        other = near(v)
        made[kind].add({"new": (v, v), "assign": (v, other), "load": (v, other, name), "store": (v, name, other)}[kind])
    return {kind: sorted(rows) for kind, rows in made.items()}


# By task: its name in the others, the program, what it derives, sizes, what makes the facts, the relation that pairs are in, and whether
# these are links of the world.
TASKS = {
    "closure over links": ("closure", OVER_LINKS, ["path"], (300, 1000), regular, "link", True),
    "closure at one catom": ("closure", CLOSURE, ["path"], (1000, 1260), lambda n: links(n * 9 // 5, n), "link", False),
    "same generation": ("same", SAME, ["same"], (600, 2000), tree, "parent", False),
    "connected components": ("components", COMPONENTS, ["label"], (10_000, 100_000), sparse, "link", True),
    "points to": ("points", POINTS, ["points", "field"], (2000, 8000), program, None, False),
}


def prepare(bin_dir, folder, rules, facts, nodes, of_world):
    listed = [(relation, row) for relation, rows in facts.items() for row in rows]
    text = rules if of_world else rules + "".join(f"{relation}(@0, {', '.join(map(str, row))}).\n" for relation, row in listed)
    source, world, module = folder / "tables.meld", folder / "world.toml", folder / "tables.so"
    source.write_text(text)
    pairs = ", ".join(f"[{row[0]}, {row[1]}]" for _, row in listed)
    world.write_text(f'lattice = "graph"\nnodes = {nodes}\nlinks = [{pairs}]\n' if of_world else WORLD)
    subprocess.run([bin_dir / "meldc", "compile", source, "-o", module, "--quiet"] + (["--graph"] if of_world else []), check=True,
                   stderr=subprocess.DEVNULL)
    both = listed + [(relation, row[::-1]) for relation, row in listed] if of_world else listed
    (folder / "facts.txt").write_text("".join(f"{relation} {' '.join(map(str, row))}\n" for relation, row in both))
    return [bin_dir / "meldsim", "run", module, "--world", world, "--quiet"]


def count(command, folder, predicates):
    """How many rows Claymeld derives."""
    facts = folder / "all.facts"
    subprocess.run(command + ["--facts-out", facts], check=True, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    with open(facts) as lines:
        return sum(line.startswith(tuple(p + "(" for p in predicates)) for line in lines)


def main():
    arguments = [a for a in sys.argv[1:] if not a.startswith("--")]
    if len(arguments) not in (2, 3):
        sys.exit(__doc__)
    bin_dir, *programs = (pathlib.Path(a).resolve() for a in arguments)
    others = dict(zip(("Ascent", "Souffle"), programs))
    for name, other in others.items():
        if not other.exists():
            sys.exit(f"bench_ascent.py: there is no {other}. " + (
                "Copy tests/bench/ascent, and run `cargo build --release` there, which fetches the crate ascent once" if name == "Ascent"
                else "Run `make -f tests/bench/souffle/Makefile` in a folder of its own, with the command souffle in PATH"))
    short = "--short" in sys.argv
    print(f"{'task':22}{'size':>8}{'rows':>11}{'Claymeld s':>12}{'MiB':>6}" + "".join(f"{name + ' s':>11}" for name in others)
          + f"{'ratio':>7}")
    for name, (task, rules, predicates, sizes, make, relation, of_world) in TASKS.items():
        for size in sizes[:1] if short else sizes:
            with tempfile.TemporaryDirectory() as temporary:
                folder = pathlib.Path(temporary)
                made = make(size)
                command = prepare(bin_dir, folder, rules, {relation: made} if relation else made, size, of_world)
                ours, theirs, memory, rows = [], {other: [] for other in others}, 0, {}
                for _ in range(1 if short else 3):
                    summary = json.loads(subprocess.run(command + ["--json"], check=True, capture_output=True, text=True).stdout)
                    ours.append(summary["cpu_seconds"])
                    memory = max(memory, summary["peak_bytes"])
                    for other, tool in others.items():
                        said = subprocess.run([tool, task, folder / "facts.txt"], check=True, capture_output=True, text=True).stdout.split()
                        theirs[other].append(float(said[0]))
                        rows[other] = int(said[1])
                derived = count(command, folder, predicates)
                for other, of_other in rows.items():
                    if derived != of_other:
                        sys.exit(f"bench_ascent.py: {name}: Claymeld derives {derived} rows, {other} {of_other}")
                print(f"{name:22}{size:>8,}{derived:>11,}{min(ours):>12.3f}{memory / 2**20:>6.0f}"
                      + "".join(f"{min(times):>11.3f}" for times in theirs.values())
                      + f"{min(ours) / min(min(times) for times in theirs.values()):>7.2f}", flush=True)


if __name__ == "__main__":
    main()
