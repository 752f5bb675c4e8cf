"""Whether a picture shows some balls where they are and in their colours: what it should be is worked out here once more, as simply as
possible, and compared within tolerances.

Where in the picture the balls are, and how large, is measured from the edges of all of it: so it is seen from any distance.
"""
import numpy as np

# Of viridis, evenly spread: Stefan van der Walt and Nathaniel Smith, 2015.
VIRIDIS = np.array([(68, 1, 84), (71, 44, 122), (59, 81, 139), (44, 113, 142), (33, 144, 141), (39, 173, 129), (92, 200, 99),
                    (170, 220, 50), (253, 231, 37)], dtype=float)
# Seen at least so many pixels of a ball, it is judged by them; so large a part of them has to be right.
ENOUGH, RIGHT = 40, 0.75
# Light makes colours brighter or darker, and hardly another hue: as far apart as that are two of them that are the same.
SAME = 0.1


def viridis(part):
    """The colours of numbers from 0 to 1."""
    at = np.clip(np.asarray(part, dtype=float), 0, 1) * (len(VIRIDIS) - 1)
    low = np.minimum(at.astype(int), len(VIRIDIS) - 2)
    return VIRIDIS[low] + (at - low)[:, None] * (VIRIDIS[low + 1] - VIRIDIS[low])


def hue(colours):
    """Of light of this colour, the parts of red, green and blue; colours are as screens show them."""
    light = (np.asarray(colours, dtype=float) / 255) ** 2.2
    return light / np.maximum(light.sum(axis=-1, keepdims=True), 1e-3)


def judge(pixels, places, colours, azimuth=-60, elevation=25):
    """What is wrong with a picture of balls with diameter 1, seen with parallel rays before a white ground; empty: nothing."""
    pixels, places = pixels[:, :, :3].astype(float), np.asarray(places, dtype=float)
    turn, tilt = np.radians(azimuth), np.radians(elevation)
    right = np.array([-np.sin(turn), np.cos(turn), 0])
    ahead = -np.array([np.cos(turn) * np.cos(tilt), np.sin(turn) * np.cos(tilt), np.sin(tilt)])
    up = np.cross(right, ahead)
    across, high, depth = places @ right, places @ up, places @ ahead
    filled = (pixels < 250).any(axis=2)
    rows, columns = np.nonzero(filled.any(axis=1))[0], np.nonzero(filled.any(axis=0))[0]
    if len(rows) == 0:
        return ["the picture is empty"]
    scale = (columns[-1] + 1 - columns[0]) / (np.ptp(across) + 1)
    if abs((rows[-1] + 1 - rows[0]) / (np.ptp(high) + 1) / scale - 1) > 0.03:
        return ["it is not as wide and as high as it should be"]
    x, y = columns[0] + scale * (across - across.min() + 0.5), rows[0] + scale * (high.max() - high + 0.5)
    v, u = np.mgrid[:pixels.shape[0], :pixels.shape[1]] + 0.5
    nearest, owner = np.full(filled.shape, np.inf), np.full(filled.shape, -1)
    for ball in range(len(places)):
        apart = ((u - x[ball]) ** 2 + (v - y[ball]) ** 2) / scale ** 2
        front = np.where(apart <= 0.25, depth[ball] - np.sqrt(np.maximum(0.25 - apart, 0)), np.inf)
        owner[front < nearest] = ball
        nearest = np.minimum(nearest, front)
    wrong, hues = [], hue(pixels)
    for ball, wanted in enumerate(hue(colours)):
        mine = owner == ball
        if mine.sum() < ENOUGH:
            continue
        good = (np.abs(hues[mine] - wanted).max(axis=1) < SAME) & filled[mine]
        if good.mean() < RIGHT:
            wrong.append(f"ball {ball} has its colour in {good.mean():.0%} of its pixels")
    # Light that falls through between balls may show a little of what is behind.
    more = filled & (owner < 0)
    if more.sum() > 0.03 * filled.sum():
        wrong.append(f"{more.sum()} pixels are of no ball")
    return wrong
