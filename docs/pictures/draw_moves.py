#!/usr/bin/env python3
"""Draws the moves of flat lattices, as the table of the runtime has them: which cells must be full, and which empty.

    docs/pictures/draw_moves.py OUT.svg
"""

import math
import pathlib
import re
import sys

TABLE = pathlib.Path(__file__).parents[2] / "runtime" / "world" / "lattice" / "moves.def"
SIZE, CAPTION, COLUMNS = 120, 34, 6
# What is new in a table, from the smallest to the largest.
SHOWN = [("square", "sliding"), ("square", "pivoting"), ("square", "leapfrog"), ("square", "monkey"), ("hex", "rolling"),
         ("hex", "pivoting"), ("hex", "monkey")]


def cells(text):
    return [tuple(map(int, cell.split()))[:2] for cell in text.split(",") if cell.strip()]


def moves():
    """(table, lattice, by, full, empty) of each line, by the first table that has it."""
    for tables, lattices, by, full, empty in re.findall(
            r'^MELD_MOVE\("([^"]*)",\s*"([^"]*)",\s*"([^"]*)",\s*"([^"]*)",\s*"([^"]*)"', TABLE.read_text(), re.M):
        for lattice in lattices.split():
            if lattice in ("square", "hex"):
                yield tables.split()[0], lattice, cells(by)[0], cells(full), cells(empty)


def outline(lattice, cell):
    x, y = cell
    if lattice == "square":
        centre, corners = (x, y), [(0.5, 0.5), (-0.5, 0.5), (-0.5, -0.5), (0.5, -0.5)]
    else:
        centre = (x + y / 2, y * math.sqrt(3) / 2)
        corners = [(math.cos(math.radians(30 + 60 * k)) / math.sqrt(3), math.sin(math.radians(30 + 60 * k)) / math.sqrt(3))
                   for k in range(6)]
    return centre, [(centre[0] + a, centre[1] + b) for a, b in corners]


def draw(left, top, lattice, name, by, full, empty):
    known = [(0, 0), by, *full, *empty]
    places = [outline(lattice, cell)[0] for cell in known]
    low = [min(p[i] for p in places) for i in (0, 1)]
    high = [max(p[i] for p in places) for i in (0, 1)]
    scale = SIZE / 4.6
    at = lambda p: (left + SIZE / 2 + scale * (p[0] - (low[0] + high[0]) / 2), top + SIZE / 2 - scale * (p[1] - (low[1] + high[1]) / 2))

    def polygon(cell, style):
        points = " ".join(f"{x:.1f},{y:.1f}" for x, y in map(at, outline(lattice, cell)[1]))
        return f'<polygon points="{points}" {style}/>'

    lines = [polygon(cell, 'fill="#ffffff" stroke="#9aa5b1" stroke-dasharray="3 2"') for cell in [by, *empty]]
    lines += [polygon(cell, 'fill="#8796a8" stroke="#3d4852"') for cell in full]
    lines.append(polygon((0, 0), 'fill="#e0812f" stroke="#3d4852"'))
    (x, y), (u, v) = at(outline(lattice, (0, 0))[0]), at(outline(lattice, by)[0])
    lines.append(f'<line x1="{x:.1f}" y1="{y:.1f}" x2="{u:.1f}" y2="{v:.1f}" stroke="#1f2933" stroke-width="2" marker-end="url(#tip)"/>')
    lines.append(f'<text x="{left + SIZE / 2:.1f}" y="{top + SIZE + 14:.1f}">{name}</text>')
    return lines


def main():
    every, drawn = list(moves()), []
    for lattice, name in SHOWN:
        drawn += [(lattice, name, *rest) for table, where, *rest in every if (table, where) == (name, lattice)]
    rows = -(-len(drawn) // COLUMNS)
    width, height = COLUMNS * SIZE, rows * (SIZE + CAPTION)
    lines = [f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {width} {height}" width="{width}" height="{height}" '
             'font-family="sans-serif" font-size="13" text-anchor="middle" fill="#1f2933">',
             f'<rect width="{width}" height="{height}" fill="#ffffff"/>',
             '<defs><marker id="tip" markerWidth="7" markerHeight="6" refX="5" refY="3" orient="auto"><path d="M0,0 L6,3 L0,6 z"/>'
             "</marker></defs>"]
    for number, (lattice, name, by, full, empty) in enumerate(drawn):
        left, top = number % COLUMNS * SIZE, number // COLUMNS * (SIZE + CAPTION)
        lines += draw(left, top, lattice, f"{name}{' (hex)' if lattice == 'hex' else ''}", by, full, empty)
    pathlib.Path(sys.argv[1]).write_text("\n".join([*lines, "</svg>"]) + "\n")


if __name__ == "__main__":
    main()
