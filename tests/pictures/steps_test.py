"""meldsim shot and movie with --steps: pictures of the steps of a recording are those of its run, and no run is made for them.

    steps_test.py --meldc PATH --meldsim PATH [unittest options]
"""
import json
import pathlib
import shutil
import signal
import subprocess
import sys

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1]))

import h5py  # noqa: E402
import numpy as np  # noqa: E402

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1] / "state"))

import resume_test  # noqa: E402
from frame import FOREVER, FRONT, Case, main, square  # noqa: E402
from png import read_png  # noqa: E402

EXAMPLES = pathlib.Path(__file__).resolve().parents[2] / "examples" / "meld"
# In it catoms take colours, say how far they are, and draw lines.
DRAWN = FRONT + """
setColor2(A, D)           :- dist(A, D).
setLabel(A, int2str(D))   :- dist(A, D), D % 3 = 1.
drawLine(A, B)            :- dist(A, D), neighbor(A, B), dist(B, D + 1), D % 2 = 0.
"""
SPACE = 'lattice = "{}"\n[[body]]\nshape = "box({})"\n[record]\nevery = 3\n'
MOVED = """
lattice = "cubic"
[[body]]
shape = "box(6, 6, 6)"
[target]
shape = "move(box(12, 3, 6), 3, 0, 0)"
fit = "mass"
[facts]
given-seed = ["cell == (0, 0, 0)"]
[motion]
kind = "lattice"
capacity = 1
[record]
every = 10
"""
FALL = "setColor2(A, N) :- id(A, N).\n"
BODIES = """
[[body]]
positions = [[0, 0, 4], [0.2, 0.3, 6], [3, 1, 5], [-2, 2, 3]]
[motion]
kind = "bodies"
[[motion.obstacle]]
kind = "plane"
normal = [0, 0, 1]
offset = 0
[[motion.obstacle]]
kind = "box"
centre = [-4, 1, 1]
size = [1, 8, 2]
[[motion.catoms]]
where = "x > 1"
radius = 0.8
[record]
every = 20
"""
# A pendulum whose second part is torn off, a rail, and a ball; of balls, and of boxes.
JOINTS = """
[[body]]
positions = [[0, 0, 0], [1, 0, 0], [2, 0, 0], [0, 3, 0], [1, 3, 0], [0, -3, 0], [1, -3, 0]]
[motion]
kind = "bodies"
steps = 4
[[motion.catoms]]
where = "x == 0"
fixed = true
[[motion.joint]]
between = [0, 1]
axis = [0, 1, 0]
[[motion.joint]]
between = [1, 2]
anchor = [2, 0, 0]
axis = [0, 1, 0]
breaking_force = 20
[[motion.joint]]
kind = "slider"
between = [3, 4]
axis = [0.6, 0, -0.8]
[[motion.joint]]
kind = "ball"
between = [5, 6]
[record]
every = 20
"""
BOXES = '[[motion.catoms]]\nwhere = "id != 4"\nshape = "box"\nedges = [1, 0.6, 0.4]\n'
# The first of three amoebots has two cells in every second step.
STEP = """expand(A, 1) :- id(A, 0), not expanded(A).
contract(A, "head") :- expanded(A).
setColor2(A, N) :- id(A, N).
"""
AMOEBOTS = """lattice = "hex"
[[body]]
cells = [[0, 0], [4, 0], [4, 1]]
[motion]
kind = "amoebot"
[record]
every = 1
"""
SMALL = ("--size", "160x120", "--quiet")
TINY = ("--size", "64x48", "--samples", "1")


class Steps(Case):
    FILES = {"front.meld": DRAWN, "front.toml": square(4) + "[record]\nevery = 3\n"}

    def record(self, program="front.meld", *options):
        self.call("meldsim", "run", program, "--record", "run.vtkhdf", "--quiet", *options)
        with h5py.File(self.folder / "run.vtkhdf") as recording:
            return recording["VTKHDF/Steps/Values"][:].astype(int).tolist()

    def same(self, tick, *options):
        pictures = []
        for steps in ((), ("--steps",)):
            self.call("meldsim", "shot", "run.vtkhdf", "-o", "a.png", "--tick", tick, *SMALL, *options, *steps)
            pictures.append(self.read("a.png"))
        self.assertEqual(*pictures, (tick, options))
        return read_png(pictures[0])

    def film(self, *options, folder="f"):
        shutil.rmtree(self.folder / folder, ignore_errors=True)
        out, _ = self.call("meldsim", "movie", "run.vtkhdf", "-o", f"{folder}/", *TINY, "--json", "--quiet", *options)
        return json.loads(out)["ticks"], [self.read(f"{folder}/{name}") for name in sorted(self.files(folder))]

    def damage(self, change):
        """A recording in which something else stands."""
        shutil.copy(self.folder / "run.vtkhdf", self.folder / "bad.vtkhdf")
        with h5py.File(self.folder / "bad.vtkhdf", "r+") as recording:
            change(recording)

    def test_pictures_are_those_of_the_run(self):
        for lattice, box in (("square", "5, 4, 1"), ("hex", "5, 4, 1"), ("cubic", "4, 3, 3"), ("fcc", "4, 3, 3")):
            self.write("w.toml", SPACE.format(lattice, box))
            ticks = self.record("front.meld", "--world", "w.toml")
            self.assertGreater(len(ticks), 2)
            for tick in (ticks[0], ticks[1], "end"):
                with self.subTest(lattice=lattice, tick=tick):
                    self.same(tick)
            with self.subTest(lattice=lattice):
                pixels = self.same(ticks[1], "--callout", "@0=the source", "--edges", "--ground", "--scale", "--title", "A front",
                                   "--zoom", 0.9)
                self.assertGreater((pixels < 100).any(axis=2).sum(), 100)
                self.same("0,3,end", "--columns", 2)
        for form in ("sphere", "cube", "rounded", "disc", "hexagon"):
            with self.subTest(form=form):
                self.same("end", "--form", form, "--catom-size", 0.7, "--azimuth", 20, "--elevation", 10, "--angle", 50)

    def test_so_are_those_of_catoms_that_move(self):
        self.write("moved.toml", MOVED)
        ticks = self.record(EXAMPLES / "shape_change.meld", "--world", "moved.toml")
        self.assertGreater(len(ticks), 3)
        seen = [self.same(tick, "--form", "rounded", "--ground") for tick in (0, ticks[2], ticks[-1])]
        self.assertTrue((seen[0] != seen[-1]).any())

    def test_so_are_those_of_amoebots_which_may_have_two_cells(self):
        self.write("step.meld", STEP)
        self.write("step.toml", AMOEBOTS)
        ticks = self.record("step.meld", "--ticks", 6)
        with h5py.File(self.folder / "run.vtkhdf") as recording:
            steps, tails = recording["VTKHDF/Steps"], recording["VTKHDF/PointData/tail_position"]
            far = [np.abs(tails[tail] - recording["VTKHDF/Points"][head]).max() for tail, head in
                   zip(steps["PointDataOffsets/tail_position"][:], steps["PointOffsets"][:])]
        self.assertEqual([one > 0.1 for one in far[:6]], [False, False, True, False, True, False])
        self.assertGreater(len(ticks), 4)
        # A bar, darker than all else, joins both cells.
        dark = [(self.same(tick).max(axis=2) < 90).sum() for tick in ticks[:5]]
        self.assertEqual([count > dark[0] + 50 for count in dark], [False, False, True, False, True], dark)

    def test_so_are_those_of_bodies(self):
        self.write("fall.meld", FALL)
        self.write("fall.toml", BODIES)
        ticks = self.record("fall.meld", "--ticks", 50)
        self.assertEqual(ticks, [0, 20, 40, 50])
        seen = [self.same(tick, "--scale") for tick in ticks]
        self.assertTrue((seen[0] != seen[-1]).any())

    def test_joints_are_as_in_the_run(self):
        for name, forms in (("balls", ""), ("boxes", BOXES)):
            self.write("fall.meld", FALL)
            self.write("fall.toml", JOINTS.replace("[[motion.joint]]", forms + "[[motion.joint]]", 1))
            ticks = self.record("fall.meld", "--ticks", 70)
            with h5py.File(self.folder / "run.vtkhdf") as recording:
                steps, joints = recording["VTKHDF/Steps"], recording["meld/joints"]
                self.assertEqual(steps["JointCount"][:].tolist(), [4] * len(ticks))
                fates = [joints["fate"][first:first + 4].tolist() for first in steps["JointOffsets/fate"][:]]
                self.assertEqual((fates[0], fates[-1]), ([0, 0, 0, 0], [0, 1, 0, 0]))
                # What stays is in the file once.
                for column in ("first", "second", "kind", "first_anchor", "second_anchor", "axis"):
                    self.assertEqual(len(set(steps[f"JointOffsets/{column}"][:].tolist())), 1, column)
                self.assertEqual("joint.orientation" in recording["VTKHDF/PointData"], name == "balls")
            for tick in ticks:
                with self.subTest(name=name, tick=tick):
                    self.same(tick, "--ground")
            # Without what the recording has of them, the picture is another one.
            self.damage(lambda recording: recording.__delitem__("meld/joints"))
            self.call("meldsim", "shot", "run.vtkhdf", "-o", "a.png", "--tick", 0, "--steps", *SMALL)
            self.call("meldsim", "shot", "bad.vtkhdf", "-o", "b.png", "--tick", 0, "--steps", *SMALL)
            self.assertNotEqual(self.read("a.png"), self.read("b.png"))
            for says, change in (("a joint is as none can be", lambda recording: recording["meld/joints/kind"].write_direct(
                                      np.full(recording["meld/joints/kind"].shape, 7))),
                                 ("its joints have no column 'axis'", lambda recording: recording.__delitem__("meld/joints/axis"))):
                self.damage(change)
                self.refused("meldsim", "shot", "bad.vtkhdf", "-o", "c.png", "--steps", "--quiet", code=6, says=says)
            self.call("meldsim", "export", "run.vtkhdf", "-o", "whole.vtkhdf", "--quiet")
            self.call("meldsim", "diff", "run.vtkhdf", "whole.vtkhdf")
            with h5py.File(self.folder / "run.vtkhdf") as run, h5py.File(self.folder / "whole.vtkhdf") as whole:
                for step in range(len(ticks)):
                    rows = [file["meld/joints/fate"][first:first + 4].tolist() for file in (run, whole)
                            for first in [file["VTKHDF/Steps/JointOffsets/fate"][step]]]
                    self.assertEqual(*rows)

    def test_a_recording_that_goes_on_keeps_its_joints(self):
        self.write("fall.meld", FALL)
        self.write("fall.toml", JOINTS)
        self.record("fall.meld", "--ticks", 70)
        wanted = resume_test.recorded(self.folder / "run.vtkhdf")
        # Before and after one has broken.
        for tick in (10, 60):
            self.record("fall.meld", "--ticks", tick, "--checkpoint", f"kept{tick}")
            self.call("meldsim", "resume", f"kept{tick}", "--ticks", 70, "--quiet")
            found = resume_test.recorded(self.folder / "run.vtkhdf")
            self.assertEqual([name for name in {*found, *wanted} if found.get(name) != wanted.get(name)], [])

    def test_a_film_has_the_recorded_ticks(self):
        ticks = self.record()
        self.assertEqual(ticks, [0, 3, 6, 8])
        for options in ((), ("--turn", 90, "--elevation", 30, "--hold", 0.1), ("--key", "0,-90,80", "--key", "8,0,20,1.5", "--ground")):
            with self.subTest(options=options):
                shown, frames = self.film("--steps", *options)
                self.assertEqual(shown, ticks)
                self.assertEqual((shown, frames), self.film("--every", 3, *options))
        for options, wanted in ((("--from", 3), [3, 6, 8]), (("--from", 2, "--to", 7), [3, 6]), (("--from", "end"), [8]),
                                (("--every", 4), [0, 6, 8]), (("--every", 100), [0, 8]), (("--seconds", 1, "--fps", 3), [0, 6, 8])):
            with self.subTest(options=options):
                shown, frames = self.film("--steps", *options)
                self.assertEqual(shown, wanted)
                self.assertEqual(len(frames), len(wanted))

    def test_no_run_is_made(self):
        self.record()

        def other_digest(recording):
            for name in ("StateDigestLow", "StateDigestHigh"):
                recording[f"VTKHDF/Steps/{name}"][:] = 1

        self.damage(other_digest)
        self.refused("meldsim", "shot", "bad.vtkhdf", "-o", "a.png", *SMALL, code=3, says="tick 0 is not as it was recorded")
        self.call("meldsim", "shot", "bad.vtkhdf", "-o", "a.png", "--steps", *SMALL)
        # Nor is it compiled.
        self.call("meldsim", "movie", "run.vtkhdf", "-o", "f/", "--steps", *TINY, "--quiet",
                  environment={"PATH": "/none", "TMPDIR": "/none"})

    def test_code_that_is_gone_is_not_needed(self):
        self.write("twice.c", "#include <stdint.h>\nint64_t twice(int64_t x) { return 2 * x; }\n")
        self.write("twice.meld", "extern int twice(int).\nsetColor2(A, twice(N)) :- neighborCount(A, N).\n")
        self.record("twice.meld", "--world", "front.toml", "--link", "twice.c")
        before = self.same("end")
        (self.folder / "twice.c").unlink()
        self.refused("meldsim", "shot", "run.vtkhdf", "-o", "a.png", *SMALL, code=2, says="twice.c")
        self.call("meldsim", "shot", "run.vtkhdf", "-o", "a.png", "--tick", "end", "--steps", *SMALL)
        self.assertTrue((read_png(self.read("a.png")) == before).all())

    def test_an_interrupted_film_ends_there(self):
        self.write("forever.meld", FOREVER)
        self.write("forever.toml", square(2))
        self.record("forever.meld", "--ticks", 3000)
        for name, code in ((signal.SIGINT, 130), (signal.SIGTERM, 143)):
            shutil.rmtree(self.folder / "f", ignore_errors=True)
            film = self.begin("meldsim", "movie", "run.vtkhdf", "-o", "f/", "--steps", *TINY, "--quiet", stderr=subprocess.PIPE,
                              start_new_session=True)
            self.wait_for(lambda: (self.folder / "f" / "00005.png").exists(), film)
            film.send_signal(name)
            _, said = film.communicate(timeout=30)
            self.assertEqual(film.returncode, code, said)
            frames = sorted(self.files("f"))
            self.assertIn(f"interrupted: f/ ends with frame {len(frames)} of 3001".encode(), said)
            read_png(self.read(f"f/{frames[-1]}"))

    def test_what_asks_for_facts_is_refused(self):
        self.record()
        for option, body in (("--colour", "dist(A, D)"), ("--only", "source(A)"), ("--hide", "source(A)"), ("--links", "neighbor(A, B)"),
                             ("--arrows", "neighbor(A, B)"), ("--labels", "dist(A, D)"), ("--callout", "source(A)")):
            for command in ("shot", "movie"):
                with self.subTest(option=option, command=command):
                    self.refused("meldsim", command, "run.vtkhdf", "-o", "a.png" if command == "shot" else "f/", "--steps", option, body,
                                 "--quiet", code=2,
                                 says=[f"{option}: `{body}` asks for facts", "Leave out --steps, and the run is made again"])
        self.assertEqual(self.files() & {"a.png", "f"}, set())

    def test_mistakes(self):
        self.record()
        for says, *options in (("tick 4 is not recorded in run.vtkhdf: the nearest are 3 and 6", "--tick", "4"),
                               ("tick 9 is not recorded in run.vtkhdf: the last is 8", "--tick", "0,9"),
                               ("-n: with --steps there is no run for several processes", "-n", "2"),
                               ("--seed has no place here: run.vtkhdf says itself what was run", "--seed", "3")):
            with self.subTest(options=options):
                self.refused("meldsim", "shot", "run.vtkhdf", "-o", "a.png", "--steps", "--quiet", *options, code=2, says=says)
        for says, *options in (("run.vtkhdf ends with tick 8, before tick 20", "--to", "20"),
                               ("no tick from 4 to 5 is recorded in run.vtkhdf", "--from", "4", "--to", "5")):
            with self.subTest(options=options):
                self.refused("meldsim", "movie", "run.vtkhdf", "-o", "f/", "--steps", "--quiet", *options, code=2, says=says)
        self.refused("meldsim", "shot", "front.meld", "-o", "a.png", "--steps", "--quiet", code=2,
                     says=["--steps: front.meld is not a recording", "Leave out --steps"])
        self.refused("meldsim", "shot", "none.vtkhdf", "-o", "a.png", "--steps", "--quiet", code=2, says="cannot read none.vtkhdf")
        self.write("ring.toml", 'lattice = "graph"\ngraph = "ring(6)"\n')
        self.call("meldsim", "run", "front.meld", "--world", "ring.toml", "--record", "ring.vtkhdf", "--quiet")
        self.refused("meldsim", "shot", "ring.vtkhdf", "-o", "a.png", "--steps", "--quiet", code=2,
                     says="the links of a graph are not recorded")
        self.assertNotIn("a.png", self.files())

    def test_damaged_recordings(self):
        self.record()
        whole = self.read("run.vtkhdf")

        def put(place, value):
            def change(recording):
                recording[place][...] = value
            return change

        def take_away(recording):
            del recording["VTKHDF/PointData/colour"]
            del recording["VTKHDF/Steps/PointDataOffsets/colour"]

        for says, change in (("the numbers of catoms are out of order", put("VTKHDF/PointData/id", 0)),
                             ("a catom is where none can be", put("VTKHDF/Points", np.nan)),
                             ("a catom has a label that is not there", put("VTKHDF/PointData/label", 99)),
                             ("a line goes to a catom that is not there", put("VTKHDF/Lines/Connectivity", 99)),
                             ("refers to rows of position that are not there", put("VTKHDF/Steps/PointOffsets", 1 << 40)),
                             ("it has no colours of catoms", take_away),
                             ("is a recording of version 9", lambda recording: recording["meld"].attrs.modify("version", 9))):
            with self.subTest(says):
                self.damage(change)
                for command, name in (("shot", "a.png"), ("movie", "f/")):
                    self.refused("meldsim", command, "bad.vtkhdf", "-o", name, "--steps", "--quiet", code=6, says=["bad.vtkhdf", says])
        for size in (100, 3000, len(whole) // 2):
            with self.subTest(size=size):
                self.write("bad.vtkhdf", whole[:size])
                self.refused("meldsim", "shot", "bad.vtkhdf", "-o", "a.png", "--steps", "--quiet", code=6, says="cannot read bad.vtkhdf")
        self.assertNotIn("a.png", self.files())


if __name__ == "__main__":
    main("meldc", "meldsim")
