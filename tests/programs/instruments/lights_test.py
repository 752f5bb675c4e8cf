"""What light sensors of bodies show, against geometry: lamps that stand somewhere and that catoms carry, shadows, dimming, and errors.

    lights_test.py --meldc PATH --meldsim PATH [unittest options]
"""
import math
import pathlib
import random
import sys

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[2]))

from frame import main, square  # noqa: E402
from cases import InstrumentCase, dot, minus, rotated, to_ball  # noqa: E402

LIT = """type lit(node, int, float).
type stands(node, float, float, float).
type turn(node, float, float, float, float).
lit(A, I, W) :- light(A, I, W).
stands(A, X, Y, Z) :- position(A, X, Y, Z).
turn(A, W, X, Y, Z) :- orientation(A, W, X, Y, Z).
"""
FREE = '[motion]\nkind = "bodies"\ngravity = [0, 0, 0]\n'
EXACT = "[motion.sense]\nposition = 0\norientation = 0\nlight = 0\n"
OBSTACLE = "[[motion.obstacle]]\n"
EYES = ((1, 0, 0), (0, 1, 0), (-1, -2, 0), (0, 0, -1), (1, 1, 1))
# They fly past each other and the lamps, to other processes; some that carry lamps dim them.
CROWD = LIT + """type action force(node, float, float, float) while.
type way(node, float, float).
type dims(node, float).
type linear waits(node).
way(A, X, Y) :- tick(A, T), position(A, PX, PY, _), S = if T % 50 < 25 then 6.0 else -6.0 end, X = S * PX + PY * 3.0, Y = S * PY - PX * 3.0.
force(A, X, Y, 0) :- way(A, X, Y).
waits(A), tick(A, 12) -o lamp(A, 0.25), lamp(A, 0.125).
waits(A) :- id(A, N), N % 13 == 5.
"""


def sensors(eyes=EYES, more=""):
    return f'[[motion.sensor]]\nkind = "light"\ndirections = {[list(eye) for eye in eyes]}\n{more}'


class Lights(InstrumentCase):
    def expect_lit(self, facts, lamps, ground=None, radius=0.5, eyes=EYES):
        """`lamps`: place, power, reach, and who carries it or nothing. Balls of one radius, and the ground, throw shadows."""
        places = {int(a): at for a, *at in facts["stands"]}
        turns = {int(a): q for a, *q in facts["turn"]}
        found = {(int(a), int(i)): w for a, i, w in facts["lit"]}
        self.assertEqual(len(found), len(places) * len(eyes))
        shadows = 0
        for a, at in places.items():
            for i, eye in enumerate(eyes):
                axis = rotated(turns[a], eye)
                axis = [x / math.hypot(*axis) for x in axis]
                here = [x + radius * y for x, y in zip(at, axis)]
                wanted = 0
                for place, power, reach, carrier in lamps:
                    way = minus(places[carrier] if place is None else place, here)
                    far = math.hypot(*way)
                    if a == carrier or dot(way, axis) <= 0 or far > reach:
                        continue
                    ahead = [x / far for x in way]
                    met = [to_ball(here, ahead, other, radius) for b, other in places.items() if b not in (a, carrier)]
                    if any(m is not None and m <= far for m in met) or (ground is not None and here[2] <= ground):
                        shadows += 1
                        continue
                    wanted += power / (4 * math.pi * far * far) * dot(ahead, axis)
                self.assertAlmostEqual(found[a, i], wanted, delta=1e-5 * wanted + 1e-9, msg=f"{a}, {i}")
        return shadows

    def test_irradiance_is_that_of_geometry(self):
        drawn = random.Random(4)
        groups = "".join(f'[[motion.catoms]]\nwhere = "id == {i}"\nturned = {[drawn.uniform(-180, 180) for _ in range(3)]}\n'
                         for i in range(91))
        toml = ('lattice = "hex"\n[[body]]\nshape = "sphere(5.1)"\n' + FREE + 'spacing = 2.5\nsteps = 4\n' + EXACT + sensors() + groups +
                '[[motion.lamp]]\nposition = [30, -4, 9]\npower = 500\n'
                '[[motion.lamp]]\nposition = [-3, 2.4, 2]\npower = 70\nreach = 9\n'
                '[[motion.lamp]]\nwhere = "id % 13 == 5"\npower = 20\nshare = 0.5\nreach = 12\n')
        for ticks in (1, 20, 45):
            facts = self.run_sizes(CROWD, toml, ticks)
            share = 0.5 if ticks < 13 else 0.25
            lamps = [([30, -4, 9], 500, math.inf, None), ([-3, 2.4, 2], 70, 9, None)]
            lamps += [(None, 20 * share, 12, a) for a in range(91) if a % 13 == 5]
            self.assertGreater(self.expect_lit(facts, lamps), 50)

    def test_a_reach_beyond_all_bodies_changes_no_bit(self):
        # Lamps without a reach are looked at one after the other, others are found in a grid.
        toml = ('lattice = "hex"\n[[body]]\nshape = "sphere(4.1)"\n' + FREE + 'spacing = 2.5\nsteps = 4\n' + EXACT + sensors(EYES[:3]) +
                '[[motion.lamp]]\nposition = [30, -4, 9]\npower = 500\nREACH[[motion.lamp]]\nwhere = "id % 3 == 1"\npower = 20\nREACH')
        seen = [self.run_sizes(CROWD, toml.replace("REACH", reach), 20) for reach in ("", "reach = 900\n")]
        self.assertEqual(*seen)
        # A nearer one does change some.
        self.assertNotEqual(self.run_sizes(CROWD, toml.replace("REACH", "reach = 6\n"), 20, [(1, 1)]), seen[0])

    def test_all_bodies_and_obstacles_throw_shadows(self):
        self.write("wall.obj", "v 2 -1 -1\nv 2 1 -1\nv 2 1 2\nv 2 -1 2\nf 1 2 3\nf 1 3 4\n")
        free = 100 / (4 * math.pi * 5.5 ** 2)
        for thing, wanted in (('', free),
                              (OBSTACLE + 'kind = "box"\ncentre = [3, 0, 0]\nsize = [1, 1, 1]\n', 0),
                              (OBSTACLE + 'kind = "box"\ncentre = [3, 2, 0]\nsize = [1, 1, 1]\n', free),
                              (OBSTACLE + 'kind = "box"\ncentre = [6, 0, 0]\nsize = [1, 1, 1]\n', 0),
                              (OBSTACLE + 'kind = "box"\ncentre = [3, 0, 0.9]\nsize = [1, 1, 1]\n', free),
                              (OBSTACLE + 'kind = "box"\ncentre = [3, 0, 0.6]\nsize = [1, 1, 1]\nturned = [0, 45, 0]\n', 0),
                              (OBSTACLE + 'kind = "sphere"\ncentre = [3, 0, 0.9]\ndiameter = 2\n', 0),
                              (OBSTACLE + 'kind = "cylinder"\ncentre = [3, 0, 0.9]\n', free),
                              (OBSTACLE + 'kind = "cylinder"\ncentre = [3, 1, 0]\nheight = 3\nturned = [90, 0, 0]\n', 0),
                              (OBSTACLE + 'kind = "capsule"\ncentre = [3, 1, 0]\nlength = 3\nturned = [90, 0, 0]\n', 0),
                              (OBSTACLE + 'kind = "terrain"\ncentre = [1, -4, -1]\ncell = 4\nheights = [[0, 3], [0, 3], [0, 3]]\n', 0),
                              (OBSTACLE + 'kind = "mesh"\nshape = "mesh(\'wall.obj\', scale = 1)"\n', 0),
                              (OBSTACLE + 'normal = [-1, 0, 0]\noffset = -4\n', 0),
                              ('[[motion.catoms]]\nwhere = "id == 1"\nshape = "cube"\n', 0),
                              ('[[motion.catoms]]\nwhere = "id == 1"\nshape = "cylinder"\nheight = 3\n', 0),
                              ('[[motion.catoms]]\nwhere = "id == 1"\nshape = "capsule"\nlength = 4\nturned = [0, 90, 0]\n', 0),
                              ('[[motion.catoms]]\nwhere = "id == 1"\nradius = 0.25\n', 0)):
            with self.subTest(thing=thing):
                beside = "id == 1" in thing
                toml = (f"[[body]]\npositions = [[0, 0, 0], [3, {0 if beside else 50}, 0]]\n" + FREE + EXACT + sensors([(1, 0, 0)]) +
                        "[[motion.lamp]]\nposition = [6, 0, 0]\npower = 100\n" + thing)
                facts = self.run_sizes(LIT, toml, 2, [(1, 1), (2, 1)])
                self.assertAlmostEqual({int(a): w for a, _, w in facts["lit"]}[0], wanted, 5)

    def test_a_body_shades_itself(self):
        # An eye on the edge of a face looks past it; what is behind the face is in its shadow though it is ahead of the eye.
        eye = (1, 0.9, 0)
        for lamp, lit in (((5, 0, 0), True), ((0.2, 5, 0), False), ((0.55, 5, 0), True)):
            with self.subTest(lamp=lamp):
                toml = ('radius = 0.05\n[[body]]\npositions = [[0, 0, 0]]\n' + FREE + 'shape = "cube"\nrounding = 0\n' + EXACT +
                        sensors([eye]) + f"[[motion.lamp]]\nposition = {list(lamp)}\n")
                facts = self.run_sizes(LIT, toml, 1, [(1, 1)])
                here = [0.05, 0.045, 0]
                way = minus([0.1 * x for x in lamp], here)
                wanted = dot(way, eye) / math.hypot(*eye) / (4 * math.pi * math.hypot(*way) ** 3) if lit else 0
                self.assertAlmostEqual(facts["lit"][0][2], wanted, 4)

    def test_lamps_are_dimmed(self):
        program = LIT + ("type linear go(node, float).\ntype refused(node, int).\ngo(A, S) -o lamp(A, S).\n"
                         "failed(A, N) -o refused(A, N).\n")
        full = 10 / (4 * math.pi * 2.5 ** 2)
        for share, wanted in (("0.0", 0), ("0.25", 0.25), ("1.0", 1), ("7.5", 1), ("-2.0", 0)):
            for n in (1, 2):
                toml = ("[[body]]\npositions = [[0, 0, 0], [3, 0, 0]]\n" + FREE + EXACT + sensors([(1, 0, 0)]) +
                        '[[motion.lamp]]\nwhere = "id == 1"\npower = 10\n[facts]\n' +
                        f'go = [{{ where = "id == 1", args = [{share}] }}, {{ where = "id == 0", args = [1.0] }}]\n')
                facts = self.run_sizes(program, toml, 4, [(n, 1)])
                self.assertAlmostEqual({int(a): w for a, _, w in facts["lit"]}[0], wanted * full, 5)
                self.assertEqual(facts["refused"], [(0, 30)])

    def test_changes_below_the_threshold_are_not_seen(self):
        program = LIT + "type action force(node, float, float, float) while.\nforce(A, 1.0, 0.0, 0.0) :- id(A, 0), stands(A, _, _, _).\n"
        toml = ("[[body]]\npositions = [[0, 0, 0]]\n" + FREE + "[motion.sense]\nlight = LEAST\nposition = 100\norientation = 100\n" +
                sensors([(1, 0, 0)]) + "[[motion.lamp]]\nposition = [20, 0, 0]\npower = 9\n")
        seen = []
        for least in ("0", "0.2"):
            self.write("p.meld", program)
            self.write("w.toml", toml.replace("LEAST", least))
            out, _ = self.call("meldsim", "run", "p.meld", "--world", "w.toml", "--ticks", 600, "--json")
            seen.append(int(out.split('"evaluations": ')[1].split(",")[0]))
        # From 19.5 diameters to 16.4 the light grows by 1.41, which is between one and two steps of a fifth.
        self.assertGreater(seen[0], 500)
        self.assertLess(seen[1], 8)

    def test_errors_have_the_spread_that_the_world_says(self):
        toml = (square(32) + FREE + 'spacing = 3\n' + EXACT + sensors([(0, 0, 1)], "noise = 0.01\n") +
                "[[motion.lamp]]\nposition = [0, 0, 5000]\npower = 1e8\n[[motion.catoms]]\nfixed = true\n")
        facts = self.run_sizes(LIT, toml, 3)
        places = {int(a): at for a, *at in facts["stands"]}
        errors = []
        for a, _, lit in facts["lit"]:
            way = minus([0, 0, 5000], [*places[int(a)][:2], 0.5])
            errors.append(lit - 1e8 * way[2] / (4 * math.pi * math.hypot(*way) ** 3))
        self.expect_normal(errors, 0.01, 700)
        # What rests shows the same again; another seed shows something else.
        self.assertEqual(facts, self.run_sizes(LIT, toml, 9, [(2, 2)]))
        other = self.run_sizes(LIT, "seed = 5\n" + toml, 3, [(1, 1)])
        self.assertFalse(set(other["lit"]) & set(facts["lit"]))

    def test_a_run_goes_on_from_a_checkpoint(self):
        # Before and after lamps are dimmed, and one that carries a lamp is killed.
        self.write("p.meld", CROWD)
        self.write("w.toml", 'lattice = "hex"\n[[body]]\nshape = "sphere(5.1)"\n' + FREE + 'spacing = 2\nsteps = 4\n' +
                   sensors(more="noise = 0.1\n") + '[[motion.lamp]]\nwhere = "id % 13 == 5"\npower = 20\n'
                   "[[motion.lamp]]\nposition = [3, 4, 5]\n[[event]]\ntick = 15\nkill = 'id % 9 == 4'\n")
        self.expect_goes_on(50)

    def test_errors_say_what_to_write(self):
        body = '[[body]]\npositions = [[0, 0, 0]]\n[motion]\nkind = "bodies"\n'
        lamp = "[[motion.lamp]]\nposition = [0, 0, 3]\n"
        for more, place, says in (("[[motion.lamp]]\n", 5, "is nowhere"),
                                  (lamp + 'where = "id == 0"\n', 7, "a position and a region"),
                                  (lamp + "power = 0\n", 7, "power"),
                                  (lamp + "share = 1.5\n", 7, "share"),
                                  (lamp + "reach = -1\n", 7, "reach"),
                                  (lamp + "colour = 1\n", 7, "colour"),
                                  ("lamp = 3\n", 5, "is an integer, not tables [[motion.lamp]]"),
                                  ("[motion.sense]\nlight = -1\n", 6, "light"),
                                  ('[[motion.sensor]]\nkind = "sound"\n', 6, "sound"),
                                  ('[[motion.sensor]]\nkind = "light"\n', 5, "no directions"),
                                  ('[[motion.sensor]]\nkind = "light"\ndirections = [[1, 0, 0]]\nreach = 3\n', 8, "reach")):
            with self.subTest(more=more):
                self.write("w.toml", body + more)
                said = self.call("meldsim", "world", "w.toml", code=2)[1]
                self.assertIn(says, said)
                self.assertIn(f"w.toml:{place}:", said)
        self.write("p.meld", LIT)
        for more, says in (("", "the world has no light sensors"), ("[[motion.sensor]]\ndirections = [[1, 0, 0]]\n", "no light sensors")):
            self.write("w.toml", body + more)
            for n in (1, 2):
                self.assertIn(says, self.call("meldsim", "run", "p.meld", "--world", "w.toml", "-n", n, "--quiet", code=2)[1])
        # In a dark world everything is dark.
        self.write("w.toml", body + sensors([(1, 0, 0)]) + '[[motion.lamp]]\nwhere = "id == 7"\n')
        out, said = self.call("meldsim", "run", "p.meld", "--world", "w.toml", "--ticks", 3, "--quiet", "--facts-out", "-")
        self.assertIn("lit(@0, 0, 0.0).", out)
        self.assertIn("`id == 7` matches no catom", said)


if __name__ == "__main__":
    main("meldc", "meldsim")
