#!/usr/bin/env python3
"""Draws three moments of a recorded shape change side by side, as shaded spheres seen from above at an angle.

    meldsim run examples/meld/shape_change.meld --record shape.vtkhdf
    docs/pictures/make_picture.py shape.vtkhdf docs/pictures/shape_change.png

Needs numpy and h5py; writes the PNG itself.
"""
import argparse
import struct
import zlib

from libraries import need

need("h5py", "numpy")

import h5py
import numpy as np

PANEL = (430, 400)          # Pixels of a panel, width and height.
LABEL = 30                  # Pixels below the panels, for their ticks.
SAMPLES = 3                 # Each pixel is the mean of this many squared.
TURN = np.radians(-40)      # Of the scene about the upright axis.
TILT = np.radians(24)       # Of the camera above the horizon.
LIGHT = np.array([0.10, -0.62, 0.78])   # Towards the light, in the turned scene: x right, y away, z up.
LIGHT /= np.linalg.norm(LIGHT)
PAPER = np.array([255.0, 255.0, 255.0])
SHADOW = np.array([196.0, 202.0, 212.0])
INK = np.array([88.0, 96.0, 108.0])
DOT = 2                     # Pixels of the finished picture to a dot of a letter.
# The letters of a label, five dots wide and seven high, a string a row.
LETTERS = {
    "0": "01110 10001 10011 10101 11001 10001 01110", "1": "00100 01100 00100 00100 00100 00100 01110",
    "2": "01110 10001 00001 00010 00100 01000 11111", "3": "11111 00010 00100 00010 00001 10001 01110",
    "4": "00010 00110 01010 10010 11111 00010 00010", "5": "11111 10000 11110 00001 00001 10001 01110",
    "6": "00110 01000 10000 11110 10001 10001 01110", "7": "11111 00001 00010 00100 01000 01000 01000",
    "8": "01110 10001 10001 01110 10001 10001 01110", "9": "01110 10001 10001 01111 00001 00010 01100",
    "t": "01000 01000 11100 01000 01000 01001 00110", "i": "00100 00000 01100 00100 00100 00100 01110",
    "c": "00000 00000 01110 10000 10000 10001 01110", "k": "10000 10000 10010 10100 11000 10100 10010",
    ",": "00000 00000 00000 00000 01100 00100 01000", " ": "00000 00000 00000 00000 00000 00000 00000",
}


def moment(recording, tick):
    """Positions, colours and tick of the recorded step nearest to a tick; of equals the latest."""
    data = recording["VTKHDF"]
    times = data["Steps/Values"][:]
    step = len(times) - 1 - int(np.argmin(np.abs(times[::-1] - tick)))
    points = data["NumberOfPoints"][data["Steps/PartOffsets"][step]]
    first = data["Steps/PointOffsets"][step]
    colour = data["Steps/PointDataOffsets/colour"][step]
    return (data["Points"][first:first + points].astype(float),
            data["PointData/colour"][colour:colour + points].astype(float),
            int(times[step]))


def occupancy(cells, margin):
    low = cells.min(axis=0) - margin
    grid = np.zeros(cells.max(axis=0) - low + margin + 1, dtype=bool)
    grid[tuple((cells - low).T)] = True
    return grid, low


def exposed(cells):
    """Which catoms have a free side."""
    grid, low = occupancy(cells, 1)
    at = cells - low
    free = np.zeros(len(cells), dtype=bool)
    for axis in range(3):
        for sign in (-1, 1):
            beside = at.copy()
            beside[:, axis] += sign
            free |= ~grid[tuple(beside.T)]
    return free


def openness(cells, which):
    """How much of the sky around each catom is free, 0 to 1: rays of a few cells in many directions."""
    grid, low = occupancy(cells, 8)
    at = cells[which] - low
    directions = [np.array(d, dtype=float) for d in np.ndindex(5, 5, 5)]
    directions = [(d - 2) / np.linalg.norm(d - 2) for d in directions if np.abs(d - 2).max() == 2 and d[2] >= 2]
    total = np.zeros(len(at))
    for direction in directions:
        reach = np.full(len(at), 1.0)
        for distance in range(7, 0, -1):
            there = at + np.rint(direction * distance).astype(int)
            reach[grid[tuple(there.T)]] = (distance - 1) / 7
        total += reach
    return total / len(directions)


def lit(cells, which, turned_to_scene):
    """How much of the light reaches each catom: a ray through the cells towards the light, and four beside it."""
    light = LIGHT @ turned_to_scene.T
    grid, low = occupancy(cells, 2)
    at = (cells[which] - low).astype(float)
    result = np.zeros(len(at))
    shape = np.array(grid.shape)
    for offset in ((0, 0, 0), (0.3, 0, 0.1), (-0.3, 0, 0.1), (0, 0.3, 0.1), (0, -0.3, 0.1)):
        free = np.ones(len(at), dtype=bool)
        for distance in np.arange(1.5, shape.max() * 1.8, 0.6):
            there = np.rint(at + light * distance + np.array(offset)).astype(int)
            inside = ((there >= 0) & (there < shape)).all(axis=1)
            if not inside.any():
                break
            clipped = np.clip(there, 0, shape - 1)
            free &= ~(inside & grid[tuple(clipped.T)])
        result += free
    return result / 5


def blur(image, radius):
    for axis in (0, 1):
        for _ in range(3):
            before, after = np.repeat(image.take([0], axis), radius + 1, axis), np.repeat(image.take([-1], axis), radius, axis)
            padded = np.concatenate([before, image, after], axis)
            summed = np.cumsum(padded, axis=axis)
            size = image.shape[axis]
            window = 2 * radius + 1
            image = (summed.take(range(window, window + size), axis) - summed.take(range(size), axis)) / window
    return image


class View:
    """From the scene to pixels: orthographic."""

    def __init__(self, scale, middle, floor):
        self.scale, self.middle, self.floor = scale, middle, floor  # middle: the pixel of the scene's origin.
        c, s = np.cos(TURN), np.sin(TURN)
        self.turn = np.array([[c, -s, 0], [s, c, 0], [0, 0, 1]])

    def project(self, turned):
        """Pixel x, pixel y, depth (greater is nearer)."""
        x = turned[:, 0]
        up = turned[:, 2] * np.cos(TILT) + turned[:, 1] * np.sin(TILT)
        near = turned[:, 2] * np.sin(TILT) - turned[:, 1] * np.cos(TILT)
        return self.middle[0] + x * self.scale, self.middle[1] - up * self.scale, near * self.scale


def sprite(radius):
    """Of a sphere: offsets of its pixels, how near they are, their normals in the turned scene, and how much of each is covered."""
    n = int(np.ceil(radius)) + 1
    y, x = np.mgrid[-n:n + 1, -n:n + 1]
    distance = np.hypot(x, y) / radius
    inside = distance <= 1
    x, y = x[inside], y[inside]
    near = np.sqrt(np.maximum(0, 1 - (x ** 2 + y ** 2) / radius ** 2))
    right, up = x / radius, -y / radius
    away = -near * np.cos(TILT) + up * np.sin(TILT)
    height = near * np.sin(TILT) + up * np.cos(TILT)
    return x, y, near * radius, np.stack([right, away, height], axis=1)


def darken_floor(image, points, view):
    """The shadow on the floor, and the darkness below what stands on it."""
    height, width, _ = image.shape
    turned = points[exposed(np.rint(points).astype(int))] @ view.turn.T
    above = (turned[:, 2] - view.floor) / LIGHT[2]
    x, y, _ = view.project(turned - LIGHT * above[:, None])
    shade = np.zeros((height, width))
    r = view.scale * 0.8
    for px, py in zip(x, y):
        rows = slice(max(0, int(py - r * np.sin(TILT))), max(0, int(py + r * np.sin(TILT)) + 1))
        shade[rows, max(0, int(px - r)):max(0, int(px + r) + 1)] = 1
    shade = blur(shade, int(view.scale * 0.9))[..., None]
    image *= 1 - shade * (1 - SHADOW / PAPER)


def draw(image, points, colours, view):
    height, width, _ = image.shape
    cells = np.rint(points).astype(int)
    which = exposed(cells)
    turned = points @ view.turn.T
    sky, sun = openness(cells, which), lit(cells, which, view.turn.T)
    x, y, near, normals = sprite(view.scale * 0.56)
    diffuse = np.maximum(0, normals @ LIGHT)
    half = LIGHT + np.array([0, -np.cos(TILT), np.sin(TILT)])
    shine = np.maximum(0, normals @ (half / np.linalg.norm(half))) ** 30
    dome = 0.5 + 0.5 * normals[:, 2]
    colours = colours[which]
    depth = np.full((height, width), -np.inf)
    px, py, pd = view.project(turned[which])
    for i, (cx, cy, cd) in enumerate(zip(px, py, pd)):
        xs, ys = x + int(round(cx)), y + int(round(cy))
        ok = (xs >= 0) & (xs < width) & (ys >= 0) & (ys < height)
        xs, ys = xs[ok], ys[ok]
        front = depth[ys, xs] < cd + near[ok]
        xs, ys = xs[front], ys[front]
        pick = np.flatnonzero(ok)[front]
        depth[ys, xs] = cd + near[pick]
        strength = (0.24 + 0.56 * sky[i]) * (0.5 + 0.5 * dome[pick]) + 0.70 * (0.12 + 0.88 * sun[i]) * diffuse[pick]
        image[ys, xs] = colours[i] * strength[:, None] + 60 * (sun[i] * shine[pick])[:, None]


def write_label(image, text, middle, bottom):
    """Draws a line of text whose middle is at a pixel and whose last row of dots ends `bottom` pixels above the edge."""
    dots = np.hstack([np.array([[dot == "1" for dot in row + "0"] for row in LETTERS[letter].split()]) for letter in text])
    mask = np.kron(dots, np.ones((DOT, DOT), dtype=bool))
    top, left = image.shape[0] - bottom - mask.shape[0], middle - mask.shape[1] // 2
    image[top:top + mask.shape[0], left:left + mask.shape[1]][mask] = INK


def png(image, path):
    """Truecolour, each row with the filter that leaves the least behind."""
    height, width, _ = image.shape
    rows = image.reshape(height, width * 3).astype(np.int16)
    out = bytearray()
    above = np.zeros(width * 3, dtype=np.int16)
    for row in rows:
        left = np.concatenate([np.zeros(3, dtype=np.int16), row[:-3]])
        corner = np.concatenate([np.zeros(3, dtype=np.int16), above[:-3]])
        guess = left + above - corner
        a, b, c = np.abs(guess - left), np.abs(guess - above), np.abs(guess - corner)
        paeth = np.where((a <= b) & (a <= c), left, np.where(b <= c, above, corner))
        filtered = [row, row - left, row - above, row - (left + above) // 2, row - paeth]
        best = min(range(5), key=lambda f: np.abs(filtered[f].astype(np.uint8).astype(np.int8).astype(int)).sum())
        out.append(best)
        out += filtered[best].astype(np.uint8).tobytes()
        above = row
    def chunk(kind, data):
        return struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))
    with open(path, "wb") as file:
        file.write(b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", struct.pack(">IIBBBBB", width, height, 8, 2, 0, 0, 0)) +
                   chunk(b"IDAT", zlib.compress(bytes(out), 9)) + chunk(b"IEND", b""))


def main():
    arguments = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    arguments.add_argument("recording")
    arguments.add_argument("picture")
    arguments.add_argument("--ticks", nargs="+", type=float, help="the moments; without it the first, one on the way, the last")
    options = arguments.parse_args()
    with h5py.File(options.recording) as recording:
        last = recording["VTKHDF/Steps/Values"][-1]
        moments = [moment(recording, tick) for tick in options.ticks or (0, last * 0.18, last)]
    all_points = np.concatenate([points for points, _, _ in moments])
    plain = View(1, (0, 0), 0)
    x, y, _ = plain.project(all_points @ plain.turn.T)
    panel = np.array(PANEL) * SAMPLES
    scale = min(panel[0] / (x.max() - x.min() + 3), panel[1] / (y.max() - y.min() + 6))
    floor = all_points[:, 2].min() - 0.5
    image = np.tile(PAPER, (panel[1], panel[0] * len(moments), 1))
    views = [View(scale, (panel[0] * (i + 0.5) - (x.max() + x.min()) / 2 * scale, panel[1] / 2 - (y.max() + y.min()) / 2 * scale), floor)
             for i in range(len(moments))]
    for view, (points, _, _) in zip(views, moments):
        darken_floor(image, points, view)
    for view, (points, colours, _) in zip(views, moments):
        draw(image, points, colours, view)
    image = image.reshape(PANEL[1], SAMPLES, -1, SAMPLES, 3).mean(axis=(1, 3))
    image = np.concatenate([image, np.tile(PAPER, (LABEL, image.shape[1], 1))])
    for i, (_, _, tick) in enumerate(moments):
        write_label(image, f"tick {tick:,}", int(PANEL[0] * (i + 0.5)), 8)
    # A few bits less are not seen, and a third less to store.
    png(np.clip(np.rint(image / 4) * 4, 0, 255), options.picture)


if __name__ == "__main__":
    main()
