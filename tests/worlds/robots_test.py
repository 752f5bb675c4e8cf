"""Robots of several bodies that a world describes once and places many times: the same bits as written by hand, on any number of processes
and threads, and through checkpoints; what programs know of them; and worlds in which they cannot stand.

    robots_test.py --meldc PATH --meldsim PATH [unittest options]
"""
import pathlib
import re
import sys

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1]))

from frame import Case, main  # noqa: E402

# A hull with two wheels and a ball, all in metres.
WHEEL = 'shape = "cylinder"\nradius = 0.3\nheight = 0.1\nrounding = 0.049\nmass = 0.05\nturned = [90, 0, 0]\n'
PARTS = (("hull", "[0.25, 0, 0.45]", 'shape = "box"\nedges = [1.2, 0.7, 0.4]\nmass = 0.5\n'),
         ("left", "[0, 0.5, 0.3]", WHEEL),
         ("right", "[0, -0.5, 0.3]", WHEEL),
         ("ball", "[0.65, 0, 0.12]", "radius = 0.12\nmass = 0.02\n"))
JOINTS = (("hull", "left", "anchor = [0, 0.5, 0.3]\naxis = [0, 1, 0]\ntorque = 2\n"),
          ("hull", "right", "anchor = [0, -0.5, 0.3]\naxis = [0, 1, 0]\ntorque = 2\n"),
          ("hull", "ball", 'kind = "ball"\nanchor = [0.65, 0, 0.12]\n'))
MOTION = '[motion]\nkind = "bodies"\nground = 0\nsteps = 4\nfriction = 0.8\n'
ASSEMBLY = ('[[assembly]]\nname = "rover"\n' +
            "".join(f'[[assembly.part]]\nname = "{name}"\nat = {at}\n{keys}' for name, at, keys in PARTS) +
            "".join(f'[[assembly.joint]]\nbetween = ["{one}", "{other}"]\n{keys}' for one, other, keys in JOINTS))
NAMES = [name for name, _, _ in PARTS]


def by_hand():
    world = f"[[body]]\npositions = [{', '.join(at for _, at, _ in PARTS)}]\n{MOTION}"
    world += "".join(f'[[motion.catoms]]\nwhere = "id == {i}"\n{keys}' for i, (_, _, keys) in enumerate(PARTS))
    return world + "".join(f"[[motion.joint]]\nbetween = [{NAMES.index(one)}, {NAMES.index(other)}]\n{keys}" for one, other, keys in JOINTS)


def rovers(places):
    return f'[[body]]\nassembly = "rover"\n{places}\n'


DRIVE = """type along(node, float, float).
type rolls(node, node, float, float).
type lies(node, int).
motor(A, B, 3.0) :- id(A, I), I % 4 = 0, joint(A, B, _, _), id(B, J), neighbor(A, B), J % 4 = 1.
motor(A, B, 2.0) :- id(A, I), I % 4 = 0, joint(A, B, _, _), id(B, J), neighbor(A, B), J % 4 = 2.
along(A, X, Y) :- position(A, X, Y, _).
rolls(A, B, P, S) :- joint(A, B, P, S).
lies(A, O) :- contact(A, O).
"""
# Each hull drives the wheels of its own robot.
NAMED = """type part(node, node Part, string Name).
type robot(node, int Number).
type along(node, int Robot, float, float).
motor(A, B, 3.0) :- part(A, A, "hull"), part(A, B, "left").
motor(A, B, 2.0) :- part(A, A, "hull"), part(A, B, "right").
along(A, N, X, Y) :- part(A, A, "hull"), robot(A, N), position(A, X, Y, _).
"""
TURNED = "positions = [[0, 0, 0], [4, 0, 0], [0, 4, 0], [4, 4, 0], [8, 0, 0]]\n"
TURNED += "turned = [[0, 0, 0], [0, 0, 90], [0, 0, 180], [0, 0, -90], [0, 0, 30]]"
SIZES = [(1, 2), (2, 1), (3, 2), (4, 1)]


class Robots(Case):
    def run_world(self, program, world, ticks, n=1, threads=1, *options):
        self.write("p.meld", program)
        self.write("w.toml", world)
        self.call("meldsim", "run", "p.meld", "--world", "w.toml", "--ticks", ticks, "-n", n, "--threads", threads, "--facts-out", "f",
                  "--digest", "d", "--quiet", *options, seconds=240)
        return self.read("f"), self.read("d")

    def facts(self, text, name):
        return [[word.strip() for word in line.split(",")] for line in re.findall(rf"^{name}\((.*)\)\.$", text.decode(), re.M)]

    def test_an_assembly_gives_the_bits_of_the_world_written_by_hand(self):
        whole = self.run_world(DRIVE, by_hand(), 150)
        self.assertEqual(self.run_world(DRIVE, ASSEMBLY + rovers("positions = [[0, 0, 0]]") + MOTION, 150), whole)
        self.assertGreater(float(self.facts(whole[0], "along")[0][1]), 1)

    def test_robots_are_alike_on_all_processes_and_threads_and_from_checkpoints(self):
        world = ASSEMBLY + rovers(TURNED) + MOTION
        whole = self.run_world(NAMED, world, 60)
        self.assertEqual(len(self.facts(whole[0], "along")), 5)
        for n, threads in SIZES:
            self.assertEqual(self.run_world(NAMED, world, 60, n, threads), whole, f"{n} processes of {threads} threads")
        self.expect_goes_on(40)

    def test_a_robot_that_is_turned_drives_the_other_way(self):
        along = {int(n): (float(x), float(y)) for _, n, x, y in
                 self.facts(self.run_world(NAMED, ASSEMBLY + rovers(TURNED) + MOTION, 120)[0], "along")}
        x, y = along[0]
        self.assertGreater(x, 0.8)
        for robot, (at, turn) in {1: ((4, 0), (-y, x)), 2: ((0, 4), (-x, -y)), 3: ((4, 4), (y, -x))}.items():
            for found, start, way in zip(along[robot], at, turn, strict=True):
                self.assertAlmostEqual(found, start + way, 1)

    def test_programs_know_the_parts_of_their_robot(self):
        program = "type part(node, node, string).\ntype robot(node, int).\ntype hull(node).\n"
        world = (rovers("positions = [[5, 0, 0], [9, 0, 0]]") + ASSEMBLY + '[[body]]\nshape = "move(box(2, 1, 1), 0, 30, 5)"\n' +
                 MOTION + '[facts]\nhull = "part == hull && robot == 1"\n')
        text, _ = self.run_world(program, world, 3)
        wanted = {(f"@{a}", f"@{2 + 4 * robot + i}", f'"{name}"')
                  for robot in range(2) for a in range(2 + 4 * robot, 6 + 4 * robot) for i, name in enumerate(NAMES)}
        self.assertEqual(set(map(tuple, self.facts(text, "part"))), wanted)
        self.assertEqual(self.facts(text, "robot"), [[f"@{a}", str((a - 2) // 4)] for a in range(2, 10)])
        self.assertEqual(self.facts(text, "hull"), [["@6"]])
        self.assertEqual(self.run_world(program, world, 3, 3)[0], text)

    def test_facts_of_other_types_are_those_of_the_program(self):
        program = 'type part(node, int).\ntype robot(node, string).\npart(A, 3) :- id(A, 0).\nrobot(A, "x") :- id(A, 1).\n'
        text, _ = self.run_world(program, ASSEMBLY + rovers("positions = [[0, 0, 0]]") + MOTION, 2)
        self.assertEqual(self.facts(text, "part"), [["@0", "3"]])
        self.assertEqual(self.facts(text, "robot"), [["@1", '"x"']])

    def test_events_strike_whole_robots(self):
        world = ASSEMBLY + rovers("positions = [[0, 0, 0], [9, 0, 0]]") + MOTION + '[[event]]\ntick = 2\nkill = "robot == 0"\n'
        text, _ = self.run_world("type robot(node, int).\n", world, 5)
        self.assertEqual(self.facts(text, "robot"), [[f"@{a}", "1"] for a in range(4, 8)])

    HELD = ('[[assembly]]\nname = "bar"\nconnections = [["a", "b"], ["c", "b"]]\n[[assembly.part]]\nname = "a"\n'
            '[[assembly.part]]\nname = "b"\nat = [1, 0, 0]\n[[assembly.part]]\nname = "c"\nat = [2, 0, 0]\n')
    PAIRS = "type pair(node, node).\npair(A, B) :- connected(A, B), A < B.\n"

    def test_parts_are_connected_within_their_robot_alone(self):
        # Both bars touch all along.
        world = self.HELD + '[[body]]\nassembly = "bar"\npositions = [[0, 0, 0.5], [0, 1, 0.5]]\n' + MOTION
        text, digest = self.run_world(self.PAIRS, world, 20)
        self.assertEqual(self.facts(text, "pair"), [["@0", "@1"], ["@1", "@2"], ["@3", "@4"], ["@4", "@5"]])
        for n, threads in SIZES:
            self.assertEqual(self.run_world(self.PAIRS, world, 20, n, threads), (text, digest))
        apart = world + '[[motion.catoms]]\nwhere = "robot == 1"\nconnected = false\n'
        self.assertEqual(self.facts(self.run_world(self.PAIRS, apart, 3)[0], "pair"), [["@0", "@1"], ["@1", "@2"]])

    def test_world_says_how_many_robots_there_are(self):
        self.write("w.toml", self.HELD + ASSEMBLY + rovers('shape = "box(5, 4, 1)"\nspacing = 3') +
                   '[[body]]\nassembly = "bar"\npositions = [[0, 0, 9]]\n' + MOTION)
        out, _ = self.call("meldsim", "world", "w.toml")
        self.assertIn("83 catoms", out)
        self.assertIn("robots: 1 bar of 3 bodies, 20 rover of 4 bodies\n", out)

    def refused(self, world):
        self.write("w.toml", world)
        process = self.run_tool("meldsim", "world", "w.toml")
        self.assertNotEqual(process.returncode, 0)
        return process.stderr

    def test_what_cannot_stand_is_an_error_with_its_place(self):
        self.assertIn("w.toml:46:1: robots 0 and 1 overlap: hull of the rover @0, and hull of the rover @4. Place them farther apart",
                      self.refused(ASSEMBLY + rovers("positions = [[0, 0, 0], [0.9, 0, 0]]") + MOTION))
        apart = self.HELD.replace("[2, 0, 0]", "[2.2, 0, 0]") + '[[body]]\nassembly = "bar"\npositions = [[0, 0, 0.5]]\n' + MOTION
        self.assertIn("w.toml:1:1: b and c are connected, and do not touch", self.refused(apart))
        into = self.HELD.replace('["c", "b"]', '["b", "a"]').replace("[2, 0, 0]", "[1.9, 0, 0]")
        self.assertIn("w.toml:1:1: b and c of a bar overlap, and have neither a joint nor a connection",
                      self.refused(into + '[[body]]\nassembly = "bar"\npositions = [[0, 0, 0.5]]\n' + MOTION))
        self.assertIn('w.toml:1:1: its parts are connected, and the world has the engine "ode"',
                      self.refused(self.HELD + '[[body]]\nassembly = "bar"\npositions = [[0, 0, 0.5]]\n' + MOTION + 'engine = "ode"\n'))

    def test_a_joint_or_a_connection_lets_parts_overlap(self):
        joint = '[[assembly.joint]]\nkind = "ball"\nbetween = ["b", "c"]\n'
        into = self.HELD.replace(', ["c", "b"]', "").replace("[2, 0, 0]", "[1.9, 0, 0]")
        for world in (into + joint, self.HELD.replace("[2, 0, 0]", "[1.9, 0, 0]")):
            self.write("w.toml", world + '[[body]]\nassembly = "bar"\npositions = [[0, 0, 0.5]]\n' + MOTION)
            self.call("meldsim", "world", "w.toml")


if __name__ == "__main__":
    main("meldc", "meldsim")
