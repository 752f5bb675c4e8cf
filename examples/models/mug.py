#!/usr/bin/env python3
"""Writes the model of a mug, mug.obj: a wall and a bottom turned about the z axis, and a handle that grows into the wall."""
import math
import sys

AROUND = 48
# Radius and height of the outside from the middle of the bottom up, and back down the inside. Millimetres.
OUTLINE = [(0, 0), (36, 0), (40, 4), (41, 50), (42, 92), (40, 95), (37, 92), (36, 50), (35, 8), (0, 8)]


def turned():
    """The outline turned about the axis: its ends are single points."""
    points, faces = [(0, 0, OUTLINE[0][1])], []
    rings = OUTLINE[1:-1]
    for radius, height in rings:
        for k in range(AROUND):
            a = 2 * math.pi * k / AROUND
            points.append((radius * math.cos(a), radius * math.sin(a), height))
    points.append((0, 0, OUTLINE[-1][1]))

    def at(ring, k):
        return 1 + ring * AROUND + k % AROUND

    for k in range(AROUND):
        faces.append((0, at(0, k + 1), at(0, k)))
        for ring in range(len(rings) - 1):
            faces.append((at(ring, k), at(ring, k + 1), at(ring + 1, k + 1)))
            faces.append((at(ring, k), at(ring + 1, k + 1), at(ring + 1, k)))
        faces.append((len(points) - 1, at(len(rings) - 1, k), at(len(rings) - 1, k + 1)))
    return points, faces


def handle(sides=12, steps=24):
    """A bent tube whose two ends lie in the wall, closed by a point each."""
    points, faces = [], []
    for i in range(steps + 1):
        a = math.pi * (i / steps - 0.5)
        middle = (38.5 + 28 * math.cos(a), 0, 50 + 30 * math.sin(a))
        out = (math.cos(a), 0, math.sin(a))
        for k in range(sides):
            b = 2 * math.pi * k / sides
            across = [math.cos(b) * out[0], math.sin(b), math.cos(b) * out[2]]
            points.append(tuple(m + 5 * a for m, a in zip(middle, across)))
    for i in range(steps):
        for k in range(sides):
            p, q = i * sides + k, i * sides + (k + 1) % sides
            faces.append((p, p + sides, q + sides))
            faces.append((p, q + sides, q))
    for ring in (0, steps):
        middle = tuple(sum(points[ring * sides + k][axis] for k in range(sides)) / sides for axis in range(3))
        points.append(middle)
        for k in range(sides):
            p, q = ring * sides + k, ring * sides + (k + 1) % sides
            faces.append((len(points) - 1, p, q) if ring == 0 else (len(points) - 1, q, p))
    return points, faces


def write(out, name, part):
    points, faces = part
    print(f"# {name} in millimetres, from mug.py", file=out)
    for p in points:
        print("v", *(f"{x:.4g}" for x in p), file=out)
    for face in faces:
        print("f", *(corner + 1 for corner in face), file=out)


if __name__ == "__main__":
    for path, part in (("cup.obj", turned()), ("handle.obj", handle())):
        with open((sys.argv[1] if len(sys.argv) > 1 else ".") + "/" + path, "w", encoding="ascii") as file:
            write(file, "The " + path[:-4] + " of a mug", part)
