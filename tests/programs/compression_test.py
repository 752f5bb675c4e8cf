"""Compression of amoebots (compression.meld) shows the phase change of its paper, on any number of processes: with a great bias the
perimeter shrinks towards that of a disc, without one it stays near that of the line at the start.

Usage: compression_test.py MELDSIM EXAMPLES
"""

import math
import pathlib
import re
import subprocess
import sys
import tempfile

from amoebots import step

AMOEBOTS = 30
TICKS = 400000


def run(meldsim, examples, world, bias, ticks, processes):
    """The facts at the end."""
    command = [meldsim, "run", f"{examples}/compression.meld", "--world", world, "--set", f"lambda={bias}", "--ticks", str(ticks),
               "-n", str(processes), "--quiet", "--facts-out", "-"]
    return subprocess.run(command, capture_output=True, text=True, timeout=280, check=True).stdout


def perimeter(facts):
    """Of a connected system without holes: the length of the walk around it, 3 n - e - 3 (Cannon et al., Section 2), by the cells of heads.
    The few amoebots that are expanded at the end make little difference."""
    cells = {tuple(map(int, found)) for found in re.findall(r"^stands\(@\d+, (-?\d+), (-?\d+)\)", facts, re.M)}
    assert len(cells) == AMOEBOTS, facts
    edges = sum(step(cell, d) in cells for cell in cells for d in range(3))
    return 3 * len(cells) - edges - 3


def main():
    meldsim, examples = sys.argv[1:]
    with tempfile.TemporaryDirectory() as folder:
        world = pathlib.Path(folder) / "line.toml"
        text = pathlib.Path(examples, "compression.toml").read_text()
        assert "box(100, 1, 1)" in text
        world.write_text(text.replace("box(100, 1, 1)", f"box({AMOEBOTS}, 1, 1)"))
        some = {run(meldsim, examples, world, 4.0, 4000, processes) for processes in (1, 2, 3)}
        assert len(some) == 1, "\n".join(some)
        by_bias = {bias: perimeter(run(meldsim, examples, world, bias, TICKS, 1)) for bias in (6.0, 1.0)}
    least, most = math.ceil(math.sqrt(12 * AMOEBOTS - 3)) - 3, 2 * AMOEBOTS - 2
    print(f"perimeters by bias: {by_bias}; that of a disc is {least}, that of a line {most}")
    assert by_bias[6.0] < 0.75 * most < 0.9 * most < by_bias[1.0], by_bias


if __name__ == "__main__":
    main()
