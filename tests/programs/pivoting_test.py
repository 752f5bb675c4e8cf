"""Pivoting squares gather (pivoting.meld), on any number of processes: with a great bias they have more contacts than without, they stay
connected, and each step that is seen is a move of the table.

Usage: pivoting_test.py MELDSIM EXAMPLES
"""

import itertools
import pathlib
import re
import subprocess
import sys
import tempfile

import moves
from lattice import components, touching

SQUARES, TICKS = 30, 30000
LOG = "type linear was(node, int, int, int).\ntick(A, T), cell(A, X, Y, _), T <= 400 -o was(A, T, X, Y).\n"


def run(meldsim, program, world, bias, ticks, processes):
    """The facts at the end."""
    command = [meldsim, "run", program, "--world", world, "--set", f"lambda={bias}", "--ticks", str(ticks), "-n", str(processes),
               "--quiet", "--facts-out", "-"]
    return subprocess.run(command, capture_output=True, text=True, timeout=280, check=True).stdout


def contacts(facts):
    """How many pairs touch; all of them hang together."""
    found = re.findall(r"^stands\(@(\d+), (-?\d+), (-?\d+)\)", facts, re.M)
    links = touching("square", {int(square): (int(x), int(y), 0) for square, x, y in found})
    assert len(links) == SQUARES and len(list(components(links))) == 1, facts
    return sum(map(len, links.values())) // 2


def look_at_steps(facts):
    """Each square moved by a move of the table, if at all: of those that went at once, none was in another's way."""
    ticks = {}
    for square, tick, x, y in re.findall(r"^was\(@(\d+), (\d+), (-?\d+), (-?\d+)\)", facts, re.M):
        ticks.setdefault(int(tick), {})[int(square)] = (int(x), int(y), 0)
    table, steps = moves.table("square", "pivoting"), 0
    for before, after in itertools.pairwise(ticks[tick] for tick in sorted(ticks)):
        model = moves.Moves("square", [table, table], before)
        for square, cell in before.items():
            if after[square] != cell:
                steps += 1
                assert moves.minus(after[square], cell) in model.possible(square), f"{before}\n{after}"
    return steps


def main():
    meldsim, examples = sys.argv[1:]
    with tempfile.TemporaryDirectory() as folder:
        world, program = pathlib.Path(folder) / "line.toml", pathlib.Path(folder) / "pivoting.meld"
        text = pathlib.Path(examples, "pivoting.toml").read_text()
        assert "box(60, 1, 1)" in text
        world.write_text(text.replace("box(60, 1, 1)", f"box({SQUARES}, 1, 1)"))
        program.write_text(pathlib.Path(examples, "pivoting.meld").read_text() + LOG)
        some = {run(meldsim, program, world, 2.0, 600, processes) for processes in (1, 2, 3)}
        assert len(some) == 1, "\n".join(some)
        steps = look_at_steps(some.pop())
        by_bias = {bias: contacts(run(meldsim, program, world, bias, TICKS, 1)) for bias in (8.0, 1.0)}
    print(f"{steps} steps; contacts by bias: {by_bias}; a line has {SQUARES - 1}")
    assert steps > 100 and by_bias[8.0] > 1.1 * by_bias[1.0], (steps, by_bias)


if __name__ == "__main__":
    main()
