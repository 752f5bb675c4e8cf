"""meldsim shot: what is in a picture, and that it does not depend on how it is made.

    shot_test.py --meldc PATH --meldsim PATH [unittest options]
"""
import math
import pathlib
import sys

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1]))

import numpy as np  # noqa: E402

from frame import Case, main, square  # noqa: E402
from png import read_png  # noqa: E402

CORNER = """
type source(node).
type dist(node, min int).
type name(node, string).
source(A)      :- id(A, 0).
dist(A, 0)     :- source(A).
dist(B, D + 1) :- neighbor(A, B), dist(A, D).
name(A, "first")  :- dist(A, 0).
name(A, "others") :- dist(A, D), D > 0.
"""
PAINTED = """
setColor(A, 255, 0, 0, 0) :- id(A, 0).
setColor(A, 0, 0, 255, 0) :- id(A, 3).
"""
SMALL = ("--size", "160x120", "--quiet")
RED, BLUE, PURPLE, YELLOW, ORANGE = (255, 0, 0), (0, 0, 255), (0x44, 0x01, 0x54), (0xFD, 0xE7, 0x25), (0xE6, 0x9F, 0x00)


def close(pixels, colour, within=40):
    """Where the pixels have about this colour."""
    return np.abs(pixels[:, :, :3].astype(int) - colour).max(axis=2) <= within


def middle(mask):
    """The mean place, as parts of the width and the height."""
    ys, xs = np.nonzero(mask)
    return xs.mean() / mask.shape[1], ys.mean() / mask.shape[0]


class Shots(Case):
    FILES = {"corner.meld": CORNER, "painted.meld": PAINTED, "corner.toml": square(4), "painted.toml": square(2)}

    def shot(self, target, *options, name="a.png", size=SMALL):
        self.call("meldsim", "shot", target, "-o", name, *size, *options)
        return read_png(self.read(name))

    def test_catoms_are_where_they_are(self):
        pixels = self.shot("corner.meld", "--colour", "dist(A, D)", "--bare")
        self.assertEqual(pixels.shape, (120, 160, 3))
        # From above: the first catom is at the lower left, the last at the upper right.
        x, y = middle(close(pixels, PURPLE, 20))
        self.assertTrue(x < 0.4 and y > 0.6, (x, y))
        x, y = middle(close(pixels, YELLOW))
        self.assertTrue(x > 0.6 and y < 0.4, (x, y))
        # From below left and right are exchanged.
        x, y = middle(close(self.shot("corner.meld", "--colour", "dist(A, D)", "--bare", "--elevation", "-90"), YELLOW, 90))
        self.assertGreater(y, 0.6)

    def test_catoms_have_the_colours_they_gave_themselves(self):
        pixels = self.shot("painted.meld", "--bare")
        self.assertGreater(close(pixels, RED).sum(), 300)
        self.assertGreater(close(pixels, BLUE).sum(), 300)
        # Those that have no value are grey.
        self.assertEqual(close(self.shot("painted.meld", "--bare", "--colour", "id(A, N), N = 1"), RED).sum(), 0)

    def test_bodies_stand_before_obstacles(self):
        self.write("fall.meld", "type fast(node, float, float, float).\nfast(A, X, Y, Z) :- velocity(A, X, Y, Z).\n")
        world = '[[body]]\npositions = [[0, 0, 3], [0, 2, 3]]\n[motion]\nkind = "bodies"\n'
        box = '[[motion.obstacle]]\nkind = "box"\ncentre = [-4, 1, 3]\nsize = [1, 20, 20]\n'

        def seen(text, *options):
            self.write("fall.toml", text)
            return self.shot("fall.meld", "--bare", "--azimuth", 0, "--elevation", 0, "--tick", 12, *options).astype(int)

        # Behind the balls is a wall, and without it nothing.
        self.assertGreater((seen(world) == 255).all(axis=2).mean(), 0.3)
        wall = seen(world + box)
        self.assertEqual((wall == 255).all(axis=2).sum(), 0)
        red, blue = wall[5, 5, 0], wall[5, 5, 2]
        self.assertTrue(150 < red < 215 and 5 < red - blue < 25, wall[5, 5])
        # They fall, and arrows say so, by three numbers as by a vec3.
        arrows = seen(world, "--arrows", "fast(A, X, Y, Z)")
        self.assertGreater((arrows.max(axis=2) < 70).sum(), 50)
        self.assertTrue((arrows == seen(world, "--arrows", "fast(A, X, Y, Z), V = vec3(X, Y, Z)")).all())
        self.refused("meldsim", "shot", "fall.meld", "-o", "b.png", "--arrows", "fast(A, X, Y, _)", "--quiet", "--tick", 1, code=2,
                     says="no variable is another catom, a vec3 or the first of three numbers", lines=None)

    def test_only_and_hide(self):
        whole = (self.shot("corner.meld", "--bare", "--zoom", "0.5") < 250).any(axis=2).sum()
        some = (self.shot("corner.meld", "--bare", "--zoom", "0.5", "--hide", "dist(A, D), D > 2") < 250).any(axis=2).sum()
        # It is as large as fits, so fewer catoms are larger.
        self.assertLess(some, 0.9 * whole)
        self.call("meldsim", "shot", "corner.meld", "-o", "b.png", *SMALL, "--only", "dist(A, D), D < 0", "--json")
        self.assertGreater((self.shot("corner.meld", "--bare", "--only", "dist(A, D), D < 0") == 255).mean(), 0.999)
        out, _ = self.call("meldsim", "shot", "corner.meld", "-o", "b.png", "--size", "160x120", "--only", "source(A)")
        self.assertEqual(out, "b.png: 160 x 120 pixels, 1 of 16 catoms, tick 8\n")

    def test_members_words_and_numbers_have_legends(self):
        self.assertGreater(close(self.shot("corner.meld", "--colour", "source(A)"), ORANGE).sum(), 100)
        for body in ("name(A, N)", "dist(A, D)", "dist(A, D), F = int2float(D) / 3.0", "dist(A, D), neighbor(A, B)", "dist(A, D), L = [D]"):
            with self.subTest(body=body):
                self.assertTrue((self.shot("corner.meld", "--colour", body) != self.shot("corner.meld", "--colour", body, "--bare")).any())

    def test_range_and_map(self):
        wide = self.shot("corner.meld", "--colour", "dist(A, D)", "--range", "-10:100", "--bare")
        self.assertEqual(close(wide, YELLOW).sum(), 0)
        grey = self.shot("corner.meld", "--colour", "dist(A, D)", "--map", "grey", "--bare").astype(int)
        self.assertLess((grey.max(axis=2) - grey.min(axis=2)).max(), 3)

    def test_lines_arrows_and_labels_are_seen(self):
        plain = self.shot("corner.meld")
        downhill = "dist(A, D), neighbor(A, B), dist(B, D - 1)"
        for option, value in (("--links", downhill), ("--arrows", downhill), ("--arrows", "source(A), V = vec3(1.0, 1.0, 0.0)"),
                              ("--labels", "name(A, N)"), ("--title", "A gradient"), ("--scale", None), ("--ground", None),
                              ("--form", "sphere"), ("--catom-size", "0.5"), ("--background", "#203040")):
            with self.subTest(option=option):
                seen = self.shot("corner.meld", option, *([] if value is None else [value]))
                self.assertGreater((seen != plain).any(axis=2).sum(), 20)

    def test_rounded_cubes_have_round_edges(self):
        self.write("one.toml", square(1))
        view = ("--world", "one.toml", "--bare", "--background", "transparent")
        cube, rounded = [self.shot("painted.meld", *view, "--form", form, size=("--size", "300x300", "--quiet"))[:, :, 3] / 255
                         for form in ("cube", "rounded")]
        # It is a square without its four corners.
        for pixels, lacks in ((cube, 0), (rounded, (4 - math.pi) * 0.13 ** 2)):
            across, down = pixels.max(axis=0).sum(), pixels.max(axis=1).sum()
            self.assertAlmostEqual(pixels.sum() / (across * down), 1 - lacks, delta=0.002)
        # Its light changes little by little.
        pixels = self.shot("painted.meld", "--world", "one.toml", "--bare", "--form", "rounded", "--elevation", "0", "--azimuth", "-80",
                           size=("--size", "300x300", "--quiet"))
        across = pixels[150, :, 0].astype(int)
        inside = across[np.nonzero(across < 255)[0]][4:-4]
        self.assertGreater(inside.max() - inside.min(), 8)
        self.assertLess(np.abs(np.diff(inside)).max(), 25)

    def test_edges_are_where_one_catom_ends(self):
        plain, edges = (self.shot("corner.meld", "--bare", "--form", "cube", *options, size=("--size", "400x400", "--quiet")).astype(int)
                        .sum(axis=2) for options in ((), ("--edges",)))
        ys, xs = np.nonzero(plain < 700)
        left, side, top = xs.min(), xs.max() + 1 - xs.min(), ys.min()
        for along, first in ((edges[int(top + 0.375 * side)], left), (edges[:, int(left + 0.375 * side)], top)):
            dark = np.flatnonzero(along < 450)
            runs = [run.mean() for run in np.split(dark, np.flatnonzero(np.diff(dark) > 1) + 1)]
            self.assertEqual(len(runs), 5, runs)
            for number, at in enumerate(runs):
                self.assertLess(abs(at - first - number * side / 4), 3, runs)
        # Nothing else is changed.
        middle_of_one = np.s_[int(top + 0.3 * side):int(top + 0.45 * side), int(left + 0.3 * side):int(left + 0.45 * side)]
        self.assertLess(np.abs(edges - plain)[middle_of_one].max(), 12)

    def test_callouts_stand_beside_the_picture(self):
        size = ("--size", "640x480", "--quiet")
        pixels = self.shot("corner.meld", "--bare", "--callout", "@0=the source", "--callout", 'dist(A, 6), T = "far away"', size=size)
        dark = pixels.astype(int).sum(axis=2) < 300
        catoms = (pixels < 250).any(axis=2) & ~dark
        columns = np.flatnonzero(catoms.sum(axis=0) > 100)
        left, right = columns.min(), columns.max()
        rows = np.flatnonzero(catoms.sum(axis=1) > 100)
        # The first is at the lower left, and its label beside it; the last at the upper right.
        for number, column, row in ((0, np.s_[:left - 4], 7), (15, np.s_[right + 4:], 1)):
            height = rows.min() + row * (rows.max() - rows.min()) / 8
            ys, _ = np.nonzero(dark[:, column])
            self.assertLess(abs(np.median(ys) - height), 4)
            # The line ends with a dot in the middle of the catom.
            x = int(left + (8 - row) * (right - left) / 8)
            self.assertGreater(dark[int(height) - 3:int(height) + 4, x - 3:x + 4].sum(), 12, number)
        self.assertGreater(left, 60)
        # As many as there are, none over another.
        pixels = self.shot("corner.meld", "--bare", "--callout", "dist(A, D)", size=size)
        ink = (pixels.astype(int).sum(axis=2) < 450)[:, :np.flatnonzero((pixels < 250).any(axis=2).sum(axis=0) > 100).min() - 2]
        words = np.flatnonzero(ink[:, :40].any(axis=1))
        self.assertEqual(1 + (np.diff(words) > 1).sum(), 8)

    def test_several_ticks_stand_side_by_side(self):
        self.call("meldsim", "shot", "corner.meld", "-o", "a.png", "--tick", "0,2,end", "--size", "300x100", "--columns", "3", "--colour",
                  "dist(A, D)", "--quiet")
        pixels = read_png(self.read("a.png"))
        coloured = [close(pixels[:, 100 * i:100 * (i + 1)], PURPLE, 12).sum() for i in range(2)]
        self.assertEqual(coloured[0], 0)
        self.assertGreater(coloured[1], 0)
        out, _ = self.call("meldsim", "shot", "corner.meld", "-o", "a.png", "--tick", "0,2,end", "--size", "300x100", "--json")
        self.assertEqual(out, '{"file":"a.png","width":300,"height":100,"ticks":[0,2,8],"catoms":16,"shown":16}\n')

    def test_it_is_the_same_from_wherever_it_is_taken(self):
        options = ("--colour", "dist(A, D)", "--labels", "name(A, N)", "--ground", "--elevation", "40", "--form", "rounded", "--edges",
                   "--callout", "@3", "--callout", "source(A)")
        self.shot("corner.meld", *options)
        wanted = self.read("a.png")
        for processes in (2, 3):
            self.shot("corner.meld", *options, "-n", processes, name="b.png")
            self.assertEqual(self.read("b.png"), wanted)
        self.call("meldsim", "run", "corner.meld", "--record", "run.vtkhdf", "--checkpoint", "kept", "--quiet")
        for target in ("run.vtkhdf", "kept"):
            for processes in (1, 2):
                self.shot(target, *options, "-n", processes, name="b.png")
                self.assertEqual(self.read("b.png"), wanted, target)
        with (self.folder / "c.png").open("wb") as out:
            self.call("meldsim", "shot", "corner.meld", "-o", "-", *SMALL, *options, stdout=out)
        self.assertEqual(self.read("c.png"), wanted)

    def test_colours_before_a_checkpoint_are_kept_where_the_run_was_recorded(self):
        self.call("meldsim", "run", "painted.meld", "--record", "run.vtkhdf", "--checkpoint", "kept", "--quiet")
        self.assertGreater(close(self.shot("kept", "--bare"), RED).sum(), 300)
        self.call("meldsim", "run", "corner.meld", "--ticks", 4, "--checkpoint", "plain", "--quiet")
        self.shot("plain", "--tick", "8,5,end", "--colour", "dist(A, D)")
        wanted = self.read("a.png")
        self.shot("corner.meld", "--tick", "8,5,4", "--colour", "dist(A, D)")
        self.assertEqual(self.read("a.png"), wanted)

    def test_background(self):
        pixels = self.shot("corner.meld", "--background", "transparent", "--bare")
        self.assertEqual(pixels.shape, (120, 160, 4))
        self.assertEqual(pixels[0, 0].tolist(), [0, 0, 0, 0])
        self.assertEqual(self.shot("corner.meld", "--background", "#102030")[0, 0].tolist(), [0x10, 0x20, 0x30])

    def test_bodies_in_space(self):
        self.write("free.toml", '[motion]\nkind = "bodies"\n[[body]]\npositions = [[0,0,3],[0,0,1.5],[2,0,0.5]]\n')
        self.write("free.meld", "type p(node, float).\np(A, Z) :- position(A, _, _, Z).\n")
        pixels = self.shot("free.meld", "--world", "free.toml", "--tick", "1", "--colour", "position(A, X, Y, Z)", "--scale", "--ground")
        self.assertGreater(close(pixels, YELLOW, 60).sum(), 20)

    def test_mistakes(self):
        for says, *options in (("did you mean `dist`?", "--colour", "dits(A, D)"),
                               ("--colour: no variable is a catom in `D = 3`", "--colour", "D = 3"),
                               ("--links: no variable is another catom, a vec3 or the first of three numbers in `dist(A, D)`",
                                "--links", "dist(A, D)"),
                               ("--labels: no variable is a value in `source(A)`", "--labels", "source(A)"),
                               ("--size: '10' is no size of a picture", "--size", "10"),
                               ("--range: '3:1' is no range", "--range", "3:1"),
                               ("--map: there is no 'jet'. There are viridis", "--map", "jet"),
                               ("--form: 'ball' is none", "--form", "ball"),
                               ("--callout: '@x' is no callout", "--callout", "@x"),
                               ("--callout: there is no catom @16", "--callout", "@16=none"),
                               ("--callout: error[E0301]: there is no predicate `dits`", "--callout", "dits(A, D)"),
                               ("160 x 90 pixels have room for 4 callouts, not for 16", "--callout", "dist(A, D)", "--size", "160x90"),
                               ("--tick: 'x' is no tick", "--tick", "x"),
                               ("the run ends with tick 8, before tick 99", "--tick", "99"),
                               ("--background: 'pink' is no colour", "--background", "pink"),
                               ("--elevation: 91 is not", "--elevation", "91"),
                               ("has no room for 9 frames", "--tick", "0,1,2,3,4,5,6,7,8", "--size", "16x16")):
            for processes in (1, 2):
                with self.subTest(options=options, processes=processes):
                    self.write("old.png", "as it was")
                    self.refused("meldsim", "shot", "corner.meld", "-o", "old.png", "--quiet", *options, "-n", processes, code=2, says=says,
                                 lines=None)
                    self.assertEqual(self.read("old.png"), b"as it was")
        self.refused("meldsim", "shot", "corner.meld", "-o", "/dev/full", *SMALL, code=4, says="cannot write /dev/full")
        self.refused("meldsim", "shot", "corner.meld", "-o", "no/where.png", *SMALL, code=2, says="cannot write no/where.png")
        self.refused("meldsim", "shot", "corner.meld", "-o", "a.jpg", *SMALL, code=2, says="a.jpg: a picture is a .png file")

    def test_what_it_is_made_from_stays(self):
        self.call("meldsim", "run", "corner.meld", "--record", "run", "--quiet")
        for name in ("run.png", "run.csv"):
            self.write(name, self.read("run"))
        self.write("w.png", self.read("corner.toml"))
        before = {name: self.read(name) for name in self.files()}
        for words in (("shot", "run.png", "-o", "./run.png"), ("shot", "corner.meld", "--world", "w.png", "-o", "w.png"),
                      ("export", "run.csv", "-o", "run.csv"), ("movie", "run.png", "-o", "run.png"), ("world", "w.png", "--shot", "w.png"),
                      ("view", "corner.meld", "--share", "corner.meld"), ("view", "run.png", "--share", "run.png")):
            with self.subTest(words=words):
                err = self.call("meldsim", *words, code=2)[1]
                self.assertTrue("are the same file" in err or words[0] == "movie", err)
                self.assertEqual({name: self.read(name) for name in self.files()}, before)

    def test_a_damaged_recording_is_said_to_be_one(self):
        self.call("meldsim", "run", "corner.meld", "--record", "run.vtkhdf", "--quiet")
        self.write("cut.vtkhdf", self.read("run.vtkhdf")[:20000])
        for words in (("shot", "cut.vtkhdf", "-o", "a.png"), ("query", "cut.vtkhdf", "dist(A, D)")):
            err = self.call("meldsim", *words, code=6)[1]
            self.assertNotIn("UTF-8", err)


if __name__ == "__main__":
    main("meldc", "meldsim")
