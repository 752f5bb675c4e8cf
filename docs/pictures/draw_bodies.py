#!/usr/bin/env python3
"""Draws moments of a recording of bodies side by side into an SVG: spheres seen along an axis, coloured by number from first to
last unless the program coloured them, with what the program wrote and drew between them, and the world's ground and obstacles:
boxes and terrain by their edges, planes where they cut the plane of view in the middle of the bodies; all as they stand at the start.

    meldsim run examples/meld/ring.meld --record ring.vtkhdf
    docs/pictures/draw_bodies.py ring.vtkhdf docs/pictures/ring.svg --view xy --ticks 0 1000 1600 2218

Needs numpy and h5py.
"""
import argparse
import collections
import colorsys
import html
import itertools
import tomllib

from libraries import need

need("h5py", "numpy")

import h5py
import numpy as np

GREY = 176          # Of a catom that has no colour.
MARGIN = 0.7        # Diameters around the bodies of all moments.
LABEL = 0.9         # Diameters below each panel, for its tick.
WIDTH = 880         # Pixels of the picture.
BEYOND = 3          # Diameters around the bodies, as far as obstacles are shown.

Moment = collections.namedtuple("Moment", "tick points diameters colours labels lines")


def moment(recording, tick):
    """The recorded step nearest to a tick; a label a body, empty where there is none, and pairs of places for the lines."""
    data = recording["VTKHDF"]
    times = data["Steps/Values"][:]
    step = int(np.argmin(np.abs(times - tick)))
    count = data["NumberOfPoints"][data["Steps/PartOffsets"][step]]

    def rows(name):
        first = data[f"Steps/PointDataOffsets/{name}"][step]
        return data["PointData"][name][first:first + count]

    first = data["Steps/PointOffsets"][step]
    diameters = rows("diameter") if "diameter" in data["PointData"] else np.ones(count)
    labels, lines = [""] * count, []
    if "label" in data["PointData"]:
        table = recording["meld/texts/label"]
        everything, ends = table["text"][:].tobytes(), table["ends"][:]
        texts = [everything[begin:end].decode() for begin, end in zip([0, *ends], ends)] + [""]
        labels = [texts[number] for number in rows("label")]
    if "Lines" in data:
        begin, lines_there = data["Steps/ConnectivityIdOffsets"][step, 1], data["Lines/NumberOfCells"][data["Steps/PartOffsets"][step]]
        lines = data["Lines/Connectivity"][begin:begin + 2 * lines_there].reshape(-1, 2)
    return Moment(times[step], data["Points"][first:first + count].astype(float), diameters, rows("colour"), labels, lines)


def rotation(turned):
    """The matrix that turns about a vector, by its length in degrees."""
    angle = np.radians(np.linalg.norm(turned))
    x, y, z = np.array(turned, float) / (np.linalg.norm(turned) or 1)
    across = np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])
    return np.eye(3) + np.sin(angle) * across + (1 - np.cos(angle)) * across @ across


def obstacles(recording, ground):
    """Polygons and planes of the recorded world: arrays of corners in space, and (normal, offset). Of solids, boxes alone."""
    motion = tomllib.loads(recording["meld/world"].asstr()[()]).get("motion", {})
    ground = motion.get("ground") if ground is None else ground
    polygons, planes = [], [] if ground is None else [(np.array([0, 0, 1.0]), ground)]
    found = motion.get("obstacle", [])
    for one in found if isinstance(found, list) else [found]:
        centre = np.array(one.get("centre", [0, 0, 0]), float)
        if one.get("kind", "plane") == "plane":
            normal = np.array(one.get("normal", [0, 0, 1]), float)
            planes.append((normal / np.linalg.norm(normal), one.get("offset", 0) / np.linalg.norm(normal)))
        elif one["kind"] == "box":
            turned = rotation(one.get("turned", [0, 0, one.get("degrees", 0)]))
            corners = np.array(list(itertools.product((-0.5, 0.5), repeat=3))) * one.get("size", [1, 1, 1]) @ turned.T + centre
            polygons += [corners[face] for face in ([0, 1, 3, 2], [4, 5, 7, 6], [0, 1, 5, 4], [2, 3, 7, 6], [0, 2, 6, 4], [1, 3, 7, 5])]
        elif one["kind"] == "terrain":
            heights, cell = np.array(one["heights"], float), one.get("cell", 1)
            y, x = np.indices(heights.shape)
            points = np.stack([x * cell, y * cell, heights], axis=-1) + centre
            polygons += [points[[j, j, j + 1, j + 1], [i, i + 1, i + 1, i]]
                         for j, i in np.ndindex(heights.shape[0] - 1, heights.shape[1] - 1)]
    return polygons, planes


def shades(colours, by_number):
    """As "#rrggbb", bright and dark: the program's, or from blue to red by number."""
    if by_number:
        hues = 0.62 * (1 - np.arange(len(colours)) / max(1, len(colours) - 1))
        colours = np.array([[255 * part for part in colorsys.hsv_to_rgb(hue, 0.55, 0.95)] for hue in hues])
    return [tuple("#%02x%02x%02x" % tuple(int(part * share) for part in colour) for share in (1, 0.55)) for colour in colours]


def behind(plane, middle, low, size, axes):
    """The part of the view that is full behind a plane, as corners: the view's rectangle, cut where the plane cuts it at a depth."""
    (across, up, (depth, _)), (normal, offset) = axes, plane
    corners = [np.array(low) + np.array(corner) * size for corner in ((0, 0), (1, 0), (1, 1), (0, 1))]
    outside = [normal[across] * a + normal[up] * b + normal[depth] * middle - offset for a, b in corners]
    kept = []
    for (one, here), (other, there) in zip(zip(corners, outside), zip(corners[1:] + corners[:1], outside[1:] + outside[:1])):
        if here <= 0:
            kept.append(one)
        if (here <= 0) != (there <= 0):
            kept.append(one + here / (here - there) * (other - one))
    return kept


def panel(moment, colours, scene, axes, low, size, offset, out):
    """Obstacles, then the spheres of a moment, the farthest first, then lines and labels."""
    across, up, depth = axes
    polygons, planes = scene

    def place(a, b):
        return f"{a - low[0] + offset[0]:.3f} {offset[1] - (b - low[1]):.3f}"

    def outline(corners, fill):
        out.append(f'<path d="M{"L".join(place(*corner) for corner in corners)}Z" fill="{fill}" stroke="#9aa3b0" stroke-width="0.04"/>')

    points = moment.points
    middle = (points[:, depth[0]].min() + points[:, depth[0]].max()) / 2
    for plane in planes:
        if len(corners := behind(plane, middle, low, size, axes)) > 2:
            outline(corners, "#eef0f3")
    for polygon in sorted(polygons, key=lambda polygon: (polygon[:, depth[0]] * depth[1]).mean()):
        outline(polygon[:, [across, up]], "#dfe3e9")
    for i in np.argsort(points[:, depth[0]] * depth[1], kind="stable"):
        x, y = place(points[i, across], points[i, up]).split()
        out.append(f'<circle cx="{x}" cy="{y}" r="{moment.diameters[i] / 2:.3f}" fill="url(#c{colours[i]})"/>')
    for one, other in moment.lines:
        out.append(f'<path d="M{place(*points[one, [across, up]])}L{place(*points[other, [across, up]])}" '
                   'stroke="#333" stroke-width="0.06"/>')
    for point, diameter, label in zip(points, moment.diameters, moment.labels):
        x, y = place(point[across], point[up] - diameter / 8).split()
        if label:
            out.append(f'<text x="{x}" y="{y}" font-size="{0.4 * diameter:.2f}" text-anchor="middle" '
                       f'font-family="sans-serif">{html.escape(label)}</text>')


def main():
    arguments = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    arguments.add_argument("recording")
    arguments.add_argument("picture")
    arguments.add_argument("--ticks", nargs="+", type=float, help="the moments; without it the first, the middle one, the last")
    arguments.add_argument("--view", choices=("xy", "xz"), default="xz", help="from above or from the front")
    arguments.add_argument("--columns", type=int, default=2)
    arguments.add_argument("--ground", type=float, help="its height; without it that of the recorded world")
    options = arguments.parse_args()
    with h5py.File(options.recording) as recording:
        last = recording["VTKHDF/Steps/Values"][-1]
        moments = [moment(recording, tick) for tick in options.ticks or (0, last / 2, last)]
        scene = obstacles(recording, options.ground)
    axes = (0, 1, (2, 1)) if options.view == "xy" else (0, 2, (1, -1))
    ends = np.concatenate([m.points[:, axes[:2]] + sign * m.diameters[:, None] / 2 for m in moments for sign in (-1, 1)])
    least, most = ends.min(axis=0), ends.max(axis=0)
    if scene[0]:
        corners = np.concatenate(scene[0])[:, axes[:2]]
        least, most = (np.minimum(least, np.maximum(corners.min(axis=0), least - BEYOND)),
                       np.maximum(most, np.minimum(corners.max(axis=0), most + BEYOND)))
    low, size = least - MARGIN, most - least + 2 * MARGIN
    by_number = all((m.colours == GREY).all() for m in moments)
    used = sorted({shade for m in moments for shade in shades(m.colours, by_number)})
    out = [f'<radialGradient id="c{i}" cx="0.36" cy="0.30" r="0.75"><stop offset="0" stop-color="#ffffff"/>'
           f'<stop offset="0.25" stop-color="{bright}"/><stop offset="1" stop-color="{dark}"/></radialGradient>'
           for i, (bright, dark) in enumerate(used)]
    columns = min(options.columns, len(moments))
    height = size[1] + LABEL
    for i, m in enumerate(moments):
        left, bottom = i % columns * size[0], i // columns * height + size[1]
        out.append(f'<clipPath id="p{i}"><rect x="{left + 0.1:.2f}" y="{bottom - size[1]:.2f}" width="{size[0] - 0.2:.2f}" '
                   f'height="{size[1]:.2f}"/></clipPath><g clip-path="url(#p{i})">')
        panel(m, [used.index(shade) for shade in shades(m.colours, by_number)], scene, axes, low, size, (left, bottom), out)
        out.append(f'</g><text x="{left + size[0] / 2:.2f}" y="{bottom + 0.5:.2f}" font-size="0.55" '
                   f'text-anchor="middle" font-family="sans-serif" fill="#555">tick {m.tick:.0f}</text>')
    full = (columns * size[0], -(-len(moments) // columns) * height)
    with open(options.picture, "w") as file:
        file.write(f'<svg xmlns="http://www.w3.org/2000/svg" width="{WIDTH}" height="{WIDTH * full[1] / full[0]:.0f}" '
                   f'viewBox="0 0 {full[0]:.2f} {full[1]:.2f}">\n'
                   '<rect width="100%" height="100%" fill="#ffffff"/>\n' + "\n".join(out) + "\n</svg>\n")


if __name__ == "__main__":
    main()
