"""What instruments of bodies show, gyro, accelerometer and range, against mechanics and geometry, with errors and without.

    sensors_test.py --meldc PATH --meldsim PATH [unittest options]
"""
import math
import pathlib
import random
import re
import sys

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[2]))

from frame import main, square  # noqa: E402
from cases import SIZES, InstrumentCase, dot, rotated, to_ball  # noqa: E402

TURNS = """type turns(node, float, float, float).
type turns-too(node, vec3).
turns(A, X, Y, Z) :- gyro(A, X, Y, Z).
turns-too(A, V) :- gyro(A, V).
"""
PULLS = """type pulls(node, float, float, float).
type pulls-too(node, vec3).
pulls(A, X, Y, Z) :- accelerometer(A, X, Y, Z).
pulls-too(A, V) :- accelerometer(A, V).
"""
AHEAD = """type ahead(node, int, float).
type stands(node, float, float, float).
type turn(node, float, float, float, float).
ahead(A, I, M) :- range(A, I, M).
stands(A, X, Y, Z) :- position(A, X, Y, Z).
turn(A, W, X, Y, Z) :- orientation(A, W, X, Y, Z).
"""
BODIES = '[motion]\nkind = "bodies"\n'
DISC = 'lattice = "hex"\n[[body]]\nshape = "sphere(5.1)"\n'
OBSTACLE = "[[motion.obstacle]]\n"
PAIR = ('[[motion.compound]]\nname = "pair"\n[[motion.compound.part]]\nshape = "sphere"\n'
        '[[motion.compound.part]]\nshape = "sphere"\nat = [1.5, 0, 0]\n')
EXACT = "[motion.sense]\nposition = 0\norientation = 0\ngyro = 0\naccelerometer = 0\nrange = 0\n"
# They fly through each other's beams, and to other processes.
CROWD = AHEAD + TURNS + PULLS + """type action force(node, float, float, float) while.
type way(node, float, float).
way(A, X, Y) :- tick(A, T), position(A, PX, PY, _), S = if T % 50 < 25 then 6.0 else -6.0 end, X = S * PX + PY * 3.0, Y = S * PY - PX * 3.0.
force(A, X, Y, 0) :- way(A, X, Y).
"""


class Sensors(InstrumentCase):
    def test_a_gyro_turns_with_its_body(self):
        # About the own x axis, which points elsewhere: it is turned by 90 degrees about z.
        toml = ('[[body]]\npositions = [[0, 0, 0], [9, 0, 0]]\n[motion]\nkind = "bodies"\ngravity = [0, 0, 0]\nsleep_ticks = 0\n' + EXACT +
                '[[motion.catoms]]\nwhere = "id == 0"\nturned = [0, 0, 90]\nspin = [0, 3, 0]\n'
                '[[motion.catoms]]\nwhere = "id == 1"\nshape = "box"\nedges = [1, 2, 1]\nturned = [90, 0, 0]\nspin = [0, 0, 2]\n')
        facts = self.run_sizes(TURNS, toml, 30)
        turns = {int(a): v for a, *v in facts["turns"]}
        self.expect_close(turns[0], (3, 0, 0))
        # About its long axis, y.
        self.expect_close(turns[1], (0, 2, 0), 3)
        self.assertEqual(sorted(facts["turns"]), sorted(facts["turns-too"]))

    def test_an_accelerometer_shows_what_holds_its_body(self):
        toml = ('[[body]]\npositions = [[0, 0, 0.5], [9, 0, 0.5], [0, 0, 900], [20, 0, 5]]\n' + BODIES + 'ground = 0\n' + EXACT +
                '[[motion.catoms]]\nwhere = "id == 1"\nturned = [90, 0, 0]\n'
                '[[motion.catoms]]\nwhere = "id == 3"\nfixed = true\nturned = [0, 90, 0]\n')
        for ticks in (100, 400):
            facts = self.run_sizes(PULLS, toml, ticks, SIZES if ticks == 100 else [(1, 1)])
            pulls = {int(a): v for a, *v in facts["pulls"]}
            self.expect_close(pulls[0], (0, 0, 9.81), 2)
            self.expect_close(pulls[1], (0, 9.81, 0), 2)
            # In free fall nothing does.
            self.expect_close(pulls[2], (0, 0, 0), 2)
            self.expect_close(pulls[3], (-9.81, 0, 0), 4)
            self.assertEqual(sorted(facts["pulls"]), sorted(facts["pulls-too"]))

    def test_a_thrust_is_felt_along_the_own_axes(self):
        program = PULLS + "type action force(node, float, float, float) while.\nforce(A, 6, 0, 0) :- id(A, 0).\n"
        toml = ('[[body]]\npositions = [[0, 0, 0]]\n[motion]\nkind = "bodies"\ngravity = [0, 0, 0]\nmass = 2\n' + EXACT +
                '[[motion.catoms]]\nwhere = "id == 0"\nturned = [0, 0, 90]\n')
        facts = self.run_sizes(program, toml, 9, [(1, 1)])
        self.expect_close(facts["pulls"][0][1:], (0, -3, 0), 4)

    def test_changes_below_the_threshold_are_not_seen(self):
        program = "type saw(node, count int).\n" + TURNS
        toml = ('[[body]]\npositions = [[0, 0, 0]]\n[motion]\nkind = "bodies"\ngravity = [0, 0, 0]\nangular_damping = 0.5\n'
                '[motion.sense]\ngyro = LEAST\n[[motion.catoms]]\nwhere = "id == 0"\nspin = [0, 0, 2]\n')
        self.write("p.meld", program)
        seen = {}
        for least in ("0", "0.1"):
            self.write("w.toml", toml.replace("LEAST", least))
            out, _ = self.call("meldsim", "run", "p.meld", "--world", "w.toml", "--ticks", 240, "--json")
            seen[least] = int(re.search(r'"evaluations": (\d+)', out)[1])
        # Half of the speed goes in a second or so: some eight tenths of a rad/s in the end.
        self.assertGreaterEqual(seen["0"], 239)
        self.assertIn(seen["0.1"], range(5, 14))

    BEAMS = ((1, 0, 0), (0, 1, 0), (-1, -2, 0), (0, 0, -1), (1, 1, 1))

    def sensors(self, reach, more="", beams=BEAMS):
        return f"[[motion.sensor]]\ndirections = {[list(beam) for beam in beams]}\nreach = {reach}\n{more}"

    def expect_ranges(self, facts, reach, walls, radius=0.5):
        """From the surface of a ball to the next ball, or one of the planes, each a normal and an offset."""
        places = {int(a): at for a, *at in facts["stands"]}
        turns = {int(a): q for a, *q in facts["turn"]}
        found = {(int(a), int(i)): metres for a, i, metres in facts.get("ahead", [])}
        wanted = {}
        for a, at in places.items():
            for i, beam in enumerate(self.BEAMS):
                way = rotated(turns[a], beam)
                way = [x / math.hypot(*way) for x in way]
                start = [x + radius * y for x, y in zip(at, way)]
                far = [to_ball(start, way, other, radius) for b, other in places.items() if b != a]
                for normal, offset in walls:
                    above, along = dot(normal, start) - offset, dot(normal, way)
                    far.append(0 if above <= 0 else above / -along if along < 0 else None)
                near = [metres for metres in far if metres is not None and metres <= reach]
                if near:
                    wanted[a, i] = min(near)
        self.assertEqual(set(found), set(wanted))
        for key, metres in wanted.items():
            self.assertAlmostEqual(found[key], metres, 6, f"{key}")
        return found

    def test_ranges_are_those_of_geometry(self):
        drawn = random.Random(3)
        groups = "".join(f'[[motion.catoms]]\nwhere = "id == {i}"\nturned = {[drawn.uniform(-180, 180) for _ in range(3)]}\n'
                         for i in range(91))
        toml = (DISC + BODIES + 'spacing = 2.5\nground = -0.75\ngravity = [0, 0, 0]\n'
                'steps = 4\n' + EXACT + self.sensors(7) + groups + '[[motion.obstacle]]\nnormal = [-1, 0, 0]\noffset = -15\n')
        for ticks in (1, 20, 45):
            facts = self.run_sizes(CROWD, toml, ticks)
            found = self.expect_ranges(facts, 7, [((0, 0, 1), -0.75), ((-1, 0, 0), -15)])
            self.assertGreater(len(found), 150)

    def test_shapes_and_all_obstacles_are_met(self):
        self.write("wall.obj", "v 2 -1 -1\nv 2 1 -1\nv 2 1 2\nv 2 -1 2\nf 1 2 3\nf 1 3 4\n")
        for thing, metres in ((OBSTACLE + 'kind = "box"\ncentre = [3, 0, 0]\nsize = [1, 1, 1]', 2),
                              (OBSTACLE + 'kind = "box"\ncentre = [3, 0, 0]\nsize = [1, 1, 1]\ndegrees = 45', 2.5 - math.sqrt(0.5)),
                              (OBSTACLE + 'kind = "box"\ncentre = [3, 0, 0]\nsize = [1, 1, 1]\nturned = [0, 45, 0]', 2.5 - math.sqrt(0.5)),
                              (OBSTACLE + 'kind = "box"\ncentre = [3, 0, 0]\nsize = [1, 1, 1]\nrounding = 0.1\nturned = [0, 0, 45]',
                               2.4 - 0.4 * math.sqrt(2)),
                              (OBSTACLE + 'kind = "sphere"\ncentre = [4, 0, 0]\ndiameter = 3', 2),
                              (OBSTACLE + 'kind = "cylinder"\ncentre = [4, 0, 0]\ndiameter = 3\nheight = 5', 2),
                              (OBSTACLE + 'kind = "cylinder"\ncentre = [4, 0, 0]\ndiameter = 3\nheight = 5\nturned = [0, 90, 0]', 1),
                              (OBSTACLE + 'kind = "capsule"\ncentre = [4, 0, 0]\nlength = 5\nturned = [0, -90, 0]', 1),
                              # A row of two balls, whose first one the origin is at.
                              (OBSTACLE + 'kind = "pair"\ncentre = [4, 0, 0]\nturned = [0, 0, 180]\n' + PAIR, 1.5),
                              (OBSTACLE + 'kind = "terrain"\ncentre = [1, -4, -1]\ncell = 4\nheights = [[0, 2], [0, 2], [0, 2]]', 2.5),
                              (OBSTACLE + 'kind = "mesh"\nshape = "mesh(\'wall.obj\', scale = 1)"', 1.5),
                              ('[[motion.catoms]]\nwhere = "id == 1"\nshape = "cube"', 2),
                              ('[[motion.catoms]]\nwhere = "id == 1"\nshape = "cylinder"\nheight = 3', 2),
                              ('[[motion.catoms]]\nwhere = "id == 1"\nshape = "cylinder"\nheight = 3\nturned = [0, 90, 0]', 1),
                              ('[[motion.catoms]]\nwhere = "id == 1"\nshape = "capsule"\nlength = 4\nturned = [0, 90, 0]', 0.5),
                              ('[[motion.catoms]]\nwhere = "id == 1"\nradius = 0.25', 2.25)):
            with self.subTest(thing=thing):
                other = "obstacle" not in thing
                toml = (f'[[body]]\npositions = [[0, 0, 0], [3, {0 if other else 50}, 0]]\n[motion]\nkind = "bodies"\ngravity = [0, 0, 0]\n'
                        + EXACT + self.sensors(5, beams=[(1, 0, 0), (0, 0, 1)]) + thing + "\n")
                facts = self.run_sizes(AHEAD, toml, 2, [(1, 1), (2, 1)])
                mine = [(i, far) for a, i, far in facts["ahead"] if a == 0]
                self.assertEqual([i for i, _ in mine], [0])
                self.assertAlmostEqual(mine[0][1], metres, 6)
        # In metres, whatever the diameter, and from the surface of a long body.
        toml = ('radius = 0.01\n[[body]]\npositions = [[0, 0, 0], [5, 0, 0]]\n[motion]\nkind = "bodies"\ngravity = [0, 0, 0]\n' + EXACT +
                self.sensors(5, beams=[(1, 0, 0)]) + '[[motion.catoms]]\nwhere = "id == 0"\nshape = "box"\nedges = [3, 1, 1]\n')
        facts = self.run_sizes(AHEAD, toml, 2, [(1, 1)])
        self.assertAlmostEqual(dict((int(a), far) for a, _, far in facts["ahead"])[0], 3 * 0.02, 6)

    NOISE = "[motion.noise]\ngyro = 0.5\naccelerometer = 2\n"

    def test_errors_have_the_spread_that_the_world_says(self):
        toml = (square(32) + BODIES + 'spacing = 3\n' + EXACT + self.NOISE + self.sensors(4, "noise = 0.1\n", beams=[(1, 0, 0)]) +
                '[[motion.catoms]]\nfixed = true\n')
        facts = self.run_sizes(AHEAD + TURNS + PULLS, toml, 3)
        self.expect_normal([x for _, *v in facts["turns"] for x in v], 0.5, 700)
        self.expect_normal([x - g for _, *v in facts["pulls"] for x, g in zip(v, (0, 0, 9.81))], 2, 700)
        self.expect_normal([far - 2 for *_, far in facts["ahead"]], 0.1, 700)
        # What rests shows the same again; another seed shows something else.
        again = self.run_sizes(AHEAD + TURNS + PULLS, toml, 9, [(2, 2)])
        self.assertEqual(facts, again)
        other = self.run_sizes(AHEAD + TURNS + PULLS, "seed = 5\n" + toml, 3, [(1, 1)])
        for name in ("turns", "pulls", "ahead"):
            self.assertFalse(set(other[name]) & set(facts[name]))

    def test_errors_are_drawn_anew_while_a_body_is_awake(self):
        # They spin for ever at one speed.
        toml = (square(16) + BODIES + 'spacing = 3\ngravity = [0, 0, 0]\n' + EXACT + self.NOISE + '[[motion.catoms]]\nspin = [0, 0, 2]\n')
        one, other = (self.run_sizes(TURNS, toml, ticks, [(1, 1), (2, 1)])["turns"] for ticks in (50, 51))
        self.expect_normal([x - w for _, *v in one for x, w in zip(v, (0, 0, 2))], 0.5, 700)
        self.assertFalse(set(one) & set(other))

    def test_a_run_with_errors_comes_to_rest(self):
        toml = ('[[body]]\npositions = [[0, 0, 0.7], [3, 0, 0.6]]\n[motion]\nkind = "bodies"\nground = 0\n' + EXACT + self.NOISE +
                self.sensors(5, "noise = 0.1\n"))
        self.write("p.meld", AHEAD + TURNS + PULLS)
        self.write("w.toml", toml)
        out, _ = self.call("meldsim", "run", "p.meld", "--world", "w.toml", "--ticks", 5000, "--json")
        self.assertIn('"ended": "quiet"', out)

    def test_a_run_goes_on_from_a_checkpoint(self):
        self.write("p.meld", CROWD)
        self.write("w.toml", DISC + BODIES + 'spacing = 2\nground = -0.6\nsteps = 4\n' + self.NOISE + self.sensors(5, "noise = 0.1\n") +
                   "[links]\nrange = 4.0\nsight = true\n[[event]]\ntick = 15\nkill = 'id % 9 == 4'\n")
        self.expect_goes_on(50)

    def test_facts_are_explained_and_recorded(self):
        self.write("p.meld", AHEAD)
        self.write("w.toml", '[[body]]\npositions = [[0, 0, 0], [3, 0, 0]]\n[motion]\nkind = "bodies"\ngravity = [0, 0, 0]\n' +
                   self.sensors(5, beams=[(1, 0, 0)]))
        out, _ = self.call("meldsim", "why", "p.meld", "ahead(@0, 0, 2.0)", "--world", "w.toml", "--tick", 3)
        self.assertIn("range(@0, 0, 2.0)", out)
        out, _ = self.call("meldsim", "query", "p.meld", "range(A, I, M), M > 1.5", "--world", "w.toml", "--tick", 3)
        self.assertIn("2.0", out)
        self.call("meldsim", "run", "p.meld", "--world", "w.toml", "--ticks", 3, "--record", "r.vtkhdf", "--quiet")

    def test_errors_say_what_to_write(self):
        body = '[[body]]\npositions = [[0, 0, 0]]\n[motion]\nkind = "bodies"\n'
        for more, place, says in (("noise = 3\n", 5, "a table [motion.noise]"),
                                  ("[motion.noise]\ngiro = 1\n", 6, "giro"),
                                  ("[motion.noise]\ngyro = -1\n", 6, "gyro"),
                                  ("[motion.sense]\nrange = -1\n", 6, "range"),
                                  ("[[motion.sensor]]\n", 5, "no directions"),
                                  ("[[motion.sensor]]\ndirections = [[0, 0, 0]]\n", 6, "leads nowhere"),
                                  ("[[motion.sensor]]\ndirections = [[1, 0]]\n", 6, "directions"),
                                  ("[[motion.sensor]]\ndirections = [[1, 0, 0]]\nreach = 0\n", 7, "reach"),
                                  ("[[motion.sensor]]\ndirections = [[1, 0, 0]]\nnoise = -1\n", 7, "noise"),
                                  ("sensor = 3\n", 5, "is an integer, not tables [[motion.sensor]]")):
            with self.subTest(more=more):
                self.write("w.toml", body + more)
                said = self.call("meldsim", "world", "w.toml", code=2)[1]
                self.assertIn(says, said)
                self.assertIn(f"w.toml:{place}:", said)
        self.write("w.toml", body)
        self.write("p.meld", AHEAD)
        for n in (1, 2):
            said = self.call("meldsim", "run", "p.meld", "--world", "w.toml", "-n", n, "--quiet", code=2)[1]
            self.assertIn("the world has no sensors", said)
            self.assertIn("[[motion.sensor]]", said)


if __name__ == "__main__":
    main("meldc", "meldsim")
