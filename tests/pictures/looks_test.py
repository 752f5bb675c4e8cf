"""Pictures of balls are what they should be, and the comparison notices when they are not.

    looks_test.py --meldc PATH --meldsim PATH [unittest options]
"""
import pathlib
import sys

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1]))

import numpy as np  # noqa: E402

from frame import Case, main  # noqa: E402
from judge import judge, viridis  # noqa: E402
from png import read_png  # noqa: E402
from stairs import COLOURS, FILES, PLACES  # noqa: E402


class Looks(Case):
    FILES = FILES

    def shot(self, *options, target="stairs.meld"):
        self.call("meldsim", "shot", target, "-o", "a.png", "--size", "320x260", "--angle", "0", "--bare", "--colour", "value(A, N)",
                  "--quiet", *options)
        return read_png(self.read("a.png"))

    def test_a_picture_is_as_it_should_be(self):
        self.assertEqual(judge(self.shot(), PLACES, COLOURS), [])
        for azimuth, elevation in ((20, 60), (130, -10)):
            pixels = self.shot("--azimuth", azimuth, "--elevation", elevation)
            self.assertEqual(judge(pixels, PLACES, COLOURS, azimuth, elevation), [])

    def test_another_map_is_noticed(self):
        for name in ("magma", "cividis", "coolwarm"):
            self.assertGreater(len(judge(self.shot("--map", name), PLACES, COLOURS)), 5, name)

    def test_a_catom_that_is_missing_is_noticed(self):
        # In the middle of others, so that the picture is as large as before.
        for missing in (7, 11):
            x, y, z = (int(c) for c in PLACES[missing])
            pixels = self.shot("--hide", f"cell(A, {x}, {y}, {z})")
            self.assertNotEqual(judge(pixels, PLACES, COLOURS), [], missing)

    def test_axes_that_are_swapped_are_noticed(self):
        pixels = self.shot()
        for order in ((1, 0, 2), (0, 2, 1), (2, 1, 0)):
            self.assertNotEqual(judge(pixels, PLACES[:, order], COLOURS), [], order)

    def test_a_mirrored_camera_is_noticed(self):
        pixels = self.shot()
        self.assertNotEqual(judge(pixels[:, ::-1], PLACES, COLOURS), [])
        self.assertNotEqual(judge(pixels[::-1], PLACES, COLOURS), [])
        self.assertNotEqual(judge(pixels, PLACES, COLOURS, azimuth=60), [])

    def test_one_wrong_colour_is_noticed(self):
        pixels = self.shot()
        for ball in range(0, len(PLACES), 4):
            colours = COLOURS.copy()
            colours[ball] = viridis([1 - ball / len(PLACES)])[0]
            if np.abs(colours[ball] - COLOURS[ball]).max() > 60:
                self.assertEqual(len(judge(pixels, PLACES, colours)), 1, ball)


if __name__ == "__main__":
    main("meldc", "meldsim")
