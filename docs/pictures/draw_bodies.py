#!/usr/bin/python3
"""Draws moments of a recording of bodies side by side into an SVG: spheres seen along an axis, coloured by number from first to
last unless the program coloured them, with the ground if there is one.

    meldsim run examples/meld/ring.meld --record ring.vtkhdf
    docs/pictures/draw_bodies.py ring.vtkhdf docs/pictures/ring.svg --view xy --ticks 0 1000 1600 2218

Needs numpy and h5py.
"""
import argparse
import colorsys

import h5py
import numpy as np

GREY = 176          # Of a catom that has no colour.
MARGIN = 0.7        # Diameters around the bodies of all moments.
LABEL = 0.9         # Diameters below each panel, for its tick.
WIDTH = 880         # Pixels of the picture.


def moment(recording, tick):
    """Tick, positions, diameters and colours of the recorded step nearest to a tick."""
    data = recording["VTKHDF"]
    times = data["Steps/Values"][:]
    step = int(np.argmin(np.abs(times - tick)))
    count = data["NumberOfPoints"][data["Steps/PartOffsets"][step]]

    def rows(name):
        first = data[f"Steps/PointDataOffsets/{name}"][step]
        return data["PointData"][name][first:first + count]

    first = data["Steps/PointOffsets"][step]
    diameters = rows("diameter") if "diameter" in data["PointData"] else np.ones(count)
    return times[step], data["Points"][first:first + count].astype(float), diameters, rows("colour")


def shades(colours, by_number):
    """As "#rrggbb", bright and dark: the program's, or from blue to red by number."""
    if by_number:
        hues = 0.62 * (1 - np.arange(len(colours)) / max(1, len(colours) - 1))
        colours = np.array([[255 * part for part in colorsys.hsv_to_rgb(hue, 0.55, 0.95)] for hue in hues])
    return [tuple("#%02x%02x%02x" % tuple(int(part * share) for part in colour) for share in (1, 0.55)) for colour in colours]


def panel(points, diameters, colours, axes, low, offset, out):
    """The spheres of a moment, the farthest first."""
    across, up, depth = axes
    for i in np.argsort(points[:, depth[0]] * depth[1], kind="stable"):
        x, y = points[i, across] - low[0] + offset[0], offset[1] - (points[i, up] - low[1])
        out.append(f'<circle cx="{x:.3f}" cy="{y:.3f}" r="{diameters[i] / 2:.3f}" fill="url(#c{colours[i]})"/>')


def main():
    arguments = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    arguments.add_argument("recording")
    arguments.add_argument("picture")
    arguments.add_argument("--ticks", nargs="+", type=float, help="the moments; without it the first, the middle one, the last")
    arguments.add_argument("--view", choices=("xy", "xz"), default="xz", help="from above or from the front")
    arguments.add_argument("--columns", type=int, default=2)
    arguments.add_argument("--ground", type=float, help="its height, for a view from the front")
    options = arguments.parse_args()
    with h5py.File(options.recording) as recording:
        last = recording["VTKHDF/Steps/Values"][-1]
        moments = [moment(recording, tick) for tick in options.ticks or (0, last / 2, last)]
    axes = (0, 1, (2, 1)) if options.view == "xy" else (0, 2, (1, -1))
    ends = np.concatenate([np.concatenate([points[:, axes[:2]] - d[:, None] / 2, points[:, axes[:2]] + d[:, None] / 2]) for _, points, d, _ in moments])
    low, size = ends.min(axis=0) - MARGIN, np.ptp(ends, axis=0) + 2 * MARGIN
    by_number = all((colours == GREY).all() for _, _, _, colours in moments)
    used = sorted({shade for _, _, _, colours in moments for shade in shades(colours, by_number)})
    out = [f'<radialGradient id="c{i}" cx="0.36" cy="0.30" r="0.75"><stop offset="0" stop-color="#ffffff"/><stop offset="0.25" stop-color="{bright}"/>'
           f'<stop offset="1" stop-color="{dark}"/></radialGradient>' for i, (bright, dark) in enumerate(used)]
    columns = min(options.columns, len(moments))
    height = size[1] + LABEL
    for i, (tick, points, diameters, colours) in enumerate(moments):
        left, bottom = i % columns * size[0], i // columns * height + size[1]
        if options.ground is not None:
            y = bottom - (options.ground - low[1])
            out.append(f'<path d="M{left + 0.2:.2f} {y:.3f}H{left + size[0] - 0.2:.2f}" stroke="#9aa3b0" stroke-width="0.06"/>')
        panel(points, diameters, [used.index(shade) for shade in shades(colours, by_number)], axes, low, (left, bottom), out)
        out.append(f'<text x="{left + size[0] / 2:.2f}" y="{bottom + 0.3:.2f}" font-size="0.55" text-anchor="middle" font-family="sans-serif" fill="#555">tick {tick:.0f}</text>')
    full = (columns * size[0], -(-len(moments) // columns) * height)
    with open(options.picture, "w") as file:
        file.write(f'<svg xmlns="http://www.w3.org/2000/svg" width="{WIDTH}" height="{WIDTH * full[1] / full[0]:.0f}" viewBox="0 0 {full[0]:.2f} {full[1]:.2f}">\n'
                   '<rect width="100%" height="100%" fill="#ffffff"/>\n' + "\n".join(out) + "\n</svg>\n")


if __name__ == "__main__":
    main()
