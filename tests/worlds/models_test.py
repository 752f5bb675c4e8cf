"""Worlds from models: how many catoms a model has, and that all that reads it agrees.

    models_test.py --meldc PATH --meldsim PATH [unittest options]
"""
import io
import json
import math
import pathlib
import re
import struct
import sys

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1]))
sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1] / "pictures"))

import numpy as np  # noqa: E402

from frame import OPEN_MPI, Case, main  # noqa: E402
from png import read_png  # noqa: E402

FACES = ((0, 4, 6), (0, 6, 2), (1, 3, 7), (1, 7, 5), (0, 1, 5), (0, 5, 4), (2, 6, 7), (2, 7, 3), (0, 2, 3), (0, 3, 1), (4, 5, 7), (4, 7, 6))
COUNT = "type p(node, int).\np(A, N) :- neighborCount(A, N).\n"
CONFIGURATION = """<?xml version="1.0" standalone="no" ?>
<world gridSize="6,6,6">
  <camera target="1,1,1"/>
  <blockList color="0,255,0">
    <block position="0,0,0" color="255,0,0"/>
    <blocksLine line="2" plane="1" values="0110"/>
    <blockBox boxOrigin="3,3,3" boxSize="2,9,1"/>
  </blockList>
</world>
"""


GRIDLESS = CONFIGURATION.replace(' gridSize="6,6,6"', "")
TARGETED = """<!-- What it is,
 in two lines -->
<?xml version="1.0" standalone="no" ?>
<world gridSize="4,4,2" windowSize="800,600">
  <blockList blockSize="40,40,40" color="0,255,0">
    <block position="1,1,0" leader="true" master="true"/>
    <block position="2,1,0" leader="1" mobile="false"/>
    <block position="3,1,0" leader="false"/>
    <block position="3,2,1"/>
  </blockList>
  <capabilities><capability/></capabilities>
  <targetGrid>
    <targetLine plane="0" line=" 1" values="01100001"/>
    <targetLine plane="1" line="1" values="01110"/>
    <targetLine line="9" values="1"/>
  </targetGrid>
  <targetGrid/>
  <goal position="1,1,1"/>
</world>
"""


def obj(points, faces):
    return "".join(f"v {x} {y} {z}\n" for x, y, z in points) + "".join(f"f {a + 1} {b + 1} {c + 1}\n" for a, b, c in faces)


def box(x, y, z):
    """A box from the origin."""
    return obj([(x * (i & 1), y * (i >> 1 & 1), z * (i >> 2)) for i in range(8)], FACES)


def torus(large, small, rings, sides):
    """Its surface as quadrangles of two triangles, and the volume inside them."""
    points, faces = [], []
    for i in range(rings):
        for k in range(sides):
            a, b = 2 * math.pi * i / rings, 2 * math.pi * k / sides
            rho = large + small * math.cos(b)
            points.append((rho * math.cos(a), rho * math.sin(a), small * math.sin(b)))
            p, q, r, s = (j % rings * sides + m % sides for j, m in ((i, k), (i + 1, k), (i + 1, k + 1), (i, k + 1)))
            faces += [(p, q, r), (p, r, s)]
    return points, faces, sum(float(np.dot(points[a], np.cross(points[b], points[c]))) for a, b, c in faces) / 6


def stl(points, faces):
    out = io.BytesIO()
    out.write(b" " * 80 + struct.pack("<I", len(faces)))
    for face in faces:
        out.write(struct.pack("<12fH", 0, 0, 0, *(x for corner in face for x in points[corner]), 0))
    return out.getvalue()


def world(shape, lattice="cubic", more=""):
    return f'lattice = "{lattice}"\n[[body]]\nshape = "{shape}"\n{more}'


def npy(array):
    out = io.BytesIO()
    np.save(out, array)
    return out.getvalue()


class Models(Case):
    FILES = {"brick.obj": box(25, 10, 5), "count.meld": COUNT}

    def count(self, text, code=0):
        self.write("w.toml", text)
        out, err = self.call("meldsim", "world", "w.toml", code=code)
        return int(re.search(r", (\d+) catoms", out)[1]), err

    def refuse(self, text, says, code=2):
        self.write("w.toml", text)
        self.refused("meldsim", "world", "w.toml", code=code, says=says)

    def test_a_box_has_as_many_cells_as_it_is_long(self):
        for shape, cells in (("mesh('brick.obj', 10)", 10 * 4 * 2), ("mesh('brick.obj', scale = 2)", 50 * 20 * 10),
                             ("rotate(mesh('brick.obj', size = 10), z, 90)", 80), ("move(mesh('brick.obj', scale = 1), 3, 4, 5)", 1250),
                             ("minus(mesh('brick.obj', 50), mesh('brick.obj', 10))", 10000 - 80),
                             ("shell(mesh('brick.obj', 50), 2)", self.count(world("shell(box(50, 20, 10), 2)"))[0])):
            self.assertEqual(self.count(world(shape))[0], cells, shape)
        # The plane z = 0 cuts it.
        self.assertEqual(self.count(world("mesh('brick.obj', 50)", "square"))[0], 50 * 20)

    def test_a_torus_has_its_volume(self):
        points, faces, volume = torus(10, 3, 120, 60)
        self.write("torus.stl", stl(points, faces))
        # Off the symmetry of the lattice the errors of cells near the surface mostly cancel.
        place = "move({}, 0.3, 0.17, 0.41)"
        self.assertAlmostEqual(self.count(world(place.format("mesh('torus.stl', scale = 2.5)")))[0] / (volume * 2.5 ** 3), 1, delta=0.01)
        # The flat sides are 0.01 inside the round ones.
        for lattice in ("cubic", "fcc"):
            for shape in ("{}", "shell({}, 2)"):
                cells, round_cells = (self.count(world(place.format(shape.format(solid)), lattice))[0]
                                      for solid in ("mesh('torus.stl', scale = 2.5)", "torus(25, 7.5)"))
                self.assertAlmostEqual(cells / round_cells, 1, delta=0.005)

    def test_processes_agree_on_body_and_target(self):
        points, faces, _ = torus(10, 3, 24, 12)
        self.write("torus.stl", stl(points, faces))
        more = "[target]\nshape = \"mesh('brick.obj', 30)\"\n[facts]\nmarked = \"inside(mesh('brick.obj', 8))\"\n"
        self.write("w.toml", world("rotate(mesh('torus.stl', size = 26), y, 20)", "fcc", more))
        self.write("p.meld", COUNT + "type marked(node).\ntype goal(node).\ngoal(A) :- target(A).\n")
        made = set()
        for processes in range(1, 5):
            self.call("meldsim", "run", "p.meld", "--world", "w.toml", "--quiet", "-n", processes, "--facts-out", "facts")
            made.add(self.read("facts"))
        self.assertEqual(len(made), 1)
        facts = made.pop().decode()
        self.assertTrue("goal(" in facts and "marked(" not in facts)

    def test_a_body_takes_the_shape_of_a_model(self):
        self.write("w.toml", world("box(10, 10, 10)", more="[target]\nshape = \"mesh('brick.obj', 1)\"\nfit = \"mass\"\n"))
        out = self.call("meldsim", "world", "w.toml")[0]
        self.assertRegex(out, r"target: scale\(mesh\('brick.obj', 1\), [0-9.]+\), 1000 cells of it")

    def test_a_recording_carries_the_model(self):
        self.write("w.toml", world("mesh('brick.obj', 10)"))
        self.call("meldsim", "run", "count.meld", "--world", "w.toml", "--quiet", "--record", "r.vtkhdf")
        (self.folder / "brick.obj").unlink()
        self.call("meldsim", "replay", "r.vtkhdf", "--quiet")

    def test_an_open_surface_is_decided_by_majority(self):
        points = [tuple(20.0 * (i >> axis & 1) for axis in range(3)) for i in range(8)]
        self.write("open.obj", obj(points, FACES[:-1]))
        cells, err = self.count(world("mesh('open.obj', scale = 1)"))
        self.assertEqual(cells, 8000)
        self.assertIn("the surface of open.obj is open: 3 of its 18 edges", err)

    def test_mistakes_are_named(self):
        extent = "'brick.obj' is 25 x 10 x 5 units, from (0, 0, 0) to (25, 10, 5); give either size"
        for text, says in ((world("mesh('none.obj', 3)"), "w.toml:3:15: there is no file none.obj"),
                           (world("mesh('brick.obj')"), extent),
                           (world("mesh('brick.obj', 3, 4)"), "give only one of size"),
                           (world("mesh(brick)"), "expected a file in quotes, as in mesh('part.stl', ...)"),
                           (world("mesh('brick.obj, 3)"), "a quote has no second one"),
                           (world("mesh('w.toml', 3)"), "w.toml is not a model that can be read, by the end of its name"),
                           (world("move(mesh('brick.obj', 1e-3), 0.5, 0)"), "no catom: the body is empty"),
                           (world("mesh('brick.obj', 1e8)"), "cells lie within 1048576")):
            self.refuse(text, says)
        self.write("cut.stl", stl(*torus(10, 3, 8, 6)[:2])[:700])
        self.refuse(world("mesh('cut.stl', 9)"),
            "cut.stl is cut off: it has 12 of the 96 triangles that it announces. copy or export it again")
        # Whatever the library says, it says of the user's file.
        for name, data in (("short.stl", b"nothing" * 20), ("head.stl", bytes(30)), ("text.stl", b"solid cut\n facet normal 0 0"),
                           ("cut.ply", b"ply\nformat ascii 1.0\nelement vertex 3\n"), ("cut.glb", b"glTF\2\0\0\0"), ("cut.gltf", b'{"a')):
            self.write(name, data)
            self.write("w.toml", world(f"mesh('{name}', 9)"))
            _, err = self.call("meldsim", "world", "w.toml", code=2)
            self.assertIn(name, err)
            self.assertNotIn("magic", err)
        self.write("mesh.obj", "v 0 0 0\n")
        self.write("zero.stl", b"")
        self.refuse(world("mesh('zero.stl', 9)"), "zero.stl is not a model")
        self.refuse(world("mesh('/dev/zero.stl', 9)"), "there is no file /dev/zero.stl")

    def test_files_that_a_model_names_are_not_read(self):
        self.write("data.bin", struct.pack("<9f", 0, 0, 0, 1, 0, 0, 0, 2, 0))
        scene = {"asset": {"version": "2.0"}, "scenes": [{"nodes": [0]}], "scene": 0, "nodes": [{"mesh": 0}],
                 "meshes": [{"primitives": [{"attributes": {"POSITION": 0}}]}], "bufferViews": [{"buffer": 0, "byteLength": 36}],
                 "accessors": [{"bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3", "min": [0, 0, 0], "max": [1, 2, 0]}],
                 "buffers": [{"byteLength": 36, "uri": "data.bin"}]}
        self.write("part.gltf", json.dumps(scene))
        self.refuse(world("mesh('part.gltf', 9)"), "part.gltf is not a model: ")

    def test_numpy_files_list_cells_and_positions(self):
        cells = np.array([[x, y, 3 * x] for x in range(4) for y in range(5)])
        self.write("w.toml", 'lattice = "cubic"\n[[body]]\ncells = "cells.npy"\n')
        for array in (cells, cells.astype("<u2"), cells.astype(">i4"), cells.astype("f4"), np.asfortranarray(cells.astype("i1"))):
            self.write("cells.npy", npy(array))
            out = self.call("meldsim", "world", "w.toml")[0]
            self.assertIn("20 catoms, within cells (0, 0, 0) to (3, 4, 9)", out)
        self.write("free.toml", '[[body]]\npositions = "points.npy"\n[motion]\nkind = "bodies"\n')
        self.write("points.npy", npy(np.array([[0, 0, 0.25, 0.5, 2], [1, 0, 0.5, 0.25, 1]])))
        self.assertIn("2 catoms", self.call("meldsim", "world", "free.toml")[0])
        for array, says in ((cells + 0.5, "in row 0, 0.5 is not a cell coordinate"), (cells[:, 0], "is not a table of rows and columns"),
                            (cells[:, :2], "in row 0, a cell of the cubic lattice has 3 coordinates, here are 2"),
                            (np.vstack([cells, cells[3:4]]), "cells.npy:20: cell (0, 3, 0) is listed twice, first in cells.npy:3"),
                            (cells.astype("c8"), "holds numbers of type <c8"), (cells.astype(bool), "holds numbers of type |b1")):
            self.write("cells.npy", npy(array))
            self.refused("meldsim", "world", "w.toml", code=2, says=says)
        self.write("cells.npy", "0,0,0\n1,0,0\n")
        self.refused("meldsim", "world", "w.toml", code=2, says="cells.npy has the name of a NumPy file, and is none", lines=None)
        self.write("z.toml", 'lattice = "cubic"\n[[body]]\ncells = "cells.npz"\n')
        np.savez(self.folder / "cells.npz", cells)
        self.refused("meldsim", "world", "z.toml", code=2, says="cells.npz is an archive of files", lines=None)
        self.write("cells.npy", npy(cells)[:-1])
        self.refused("meldsim", "world", "w.toml", code=2, says="cells.npy ends too early")

    def test_cells_are_kept_empty(self):
        for lattice, listed in (("cubic", "[[3, 0, 0], [0, 0, 0]]"), ("fcc", "[[3, 0, 1], [0, 0, 0]]"), ("hex", "[[3, 1], [0, 0]]"),
                                ("square", "[[3, 1], [0, 0]]")):
            whole = world("box(5, 5, 5)", lattice, f"[[body]]\ncells = {listed}\n")
            program = "type at-cell(node, int, int, int).\nat-cell(A, X, Y, Z) :- cell(A, X, Y, Z).\n"

            def cells(text):
                self.write("w.toml", text)
                self.write("cells.meld", program)
                out = self.call("meldsim", "query", "cells.meld", "--world", "w.toml", "at-cell(_, X, Y, Z)", "--quiet", "--csv")[0]
                return {tuple(map(int, line.split(","))) for line in out.splitlines()[1:]}

            before, third = cells(whole), (3, 1, 0) if lattice in ("hex", "square") else (3, 0, int(lattice == "fcc"))
            self.assertIn(third, before)
            after = cells(whole + f"[without]\ncells = {listed}\n")
            self.assertEqual(before - after, {third, (0, 0, 0)}, lattice)
            self.assertLess(after, before)
        # As a list of their own, too; and for a target that is as large as the body.
        self.write("holes.csv", "0,0,0\n1,0,0\n9,9,9\n")
        more = '[without]\ncells = "holes.csv"\n[target]\nshape = "box(9, 9, 9)"\nfit = "mass"\n[motion]\nkind = "lattice"\n'
        self.assertEqual(self.count(world("box(5, 5, 5)", more=more))[0], 123)
        cube = world("box(2, 1, 1)")
        for text, says in ((cube + "[without]\n", "[without] has no cells"), ("without = 3\n" + cube, "a table [without]"),
                           (cube + "[without]\ncells = [[0, 0, 0], [0, 0, 0]]\n", "cell (0, 0, 0) is listed twice"),
                           (cube + "[without]\ncells = [[0, 0, 0], [-1, 0, 0]]\n", "no catom: the body is empty"),
                           ('lattice = "graph"\ngraph = "ring(5)"\n[without]\ncells = []\n', "a graph has no without")):
            self.refuse(text, says)

    def test_configurations_of_visiblesim_become_worlds(self):
        self.write("c.xml", CONFIGURATION)
        out = self.call("meldsim", "world", "--import", "c.xml", "--lattice", "fcc", "-o", "made.toml")[0]
        self.assertEqual(out, "made.toml: 7 catoms of c.xml; left out: colours, the camera\n")
        cells = [eval(line.strip(" ,\n")) for line in self.read("made.toml").decode().splitlines() if line.startswith("    [")]
        self.assertEqual(sorted(cells), [[0, 0, 0], [1, 2, 1], [2, 2, 1], [3, 3, 3], [3, 4, 3], [4, 3, 3], [4, 4, 3]])
        self.assertIn("7 catoms", self.call("meldsim", "world", "made.toml")[0])
        # Rows of a hexagonal lattice lie along z and are shifted to and fro.
        blocks = "".join(f'<block position="{at}"/>' for at in ("3,0,0", "3,0,1", "2,0,2"))
        self.write("h.xml", f"<world><blockList>{blocks}</blockList></world>")
        self.call("meldsim", "world", "--import", "h.xml", "--lattice", "hex", "-o", "hex.toml")
        self.assertEqual(re.findall(r"\[(\d+, \d+, 0)\]", self.read("hex.toml").decode()), ["3, 0, 0", "3, 1, 0", "1, 2, 0"])
        # Everything else is named: what is beside the world, elements, attributes; marks can be facts.
        self.write("t.xml", TARGETED)
        out = self.call("meldsim", "world", "--import", "t.xml", "--lattice", "cubic", "-o", "t.toml")[0]
        self.assertEqual(out, "t.toml: 4 catoms of t.xml, and a target of 5 cells; left out: windowSize, blockSize, colours, leader, "
                              "master, mobile, <capabilities>, targets after the first, <goal>, 2 cells of the target outside of the "
                              "grid\n")
        text = self.read("t.toml").decode()
        self.assertIn('# leader = ["cell == (1, 1, 0)", "cell == (2, 1, 0)"]\n# master = ["cell == (1, 1, 0)"]\n', text)
        self.assertIn('ports = "blinky-visiblesim"\n', text)
        self.assertIn("target: 5 listed cells\n", self.call("meldsim", "world", "t.toml")[0])
        self.write("t.meld", "type in(node, int, int, int).\nin(A, X, Y, Z) :- target(A), cell(A, X, Y, Z).\n"
                   "type above(node).\nabove(A) :- target(A, 5).\n")
        for options in ([], ["-n", 2]):
            facts = self.call("meldsim", "run", "t.meld", "--world", "t.toml", "--quiet", "--facts-out", "-", *options,
                              environment=OPEN_MPI)[0]
            self.assertEqual(sorted(line.partition("(")[0] + line.partition(",")[2] for line in facts.splitlines()),
                             [*["above"] * 3, "in 1, 1, 0).", "in 2, 1, 0)."])
        # Newer configurations have targets of other kinds, and a root around the world.
        for target, says in (('<target format="csg"><csg content="cube(3)"/></target>', "a target of the format csg"),
                             ('<target format="grid"><cell position="0,0,0"/><mesh/></target>', "<mesh>")):
            self.write("n.xml", f'<!-- n.xml -->\n<?xml version="1.0"?>\n<vs><visuals/><world><blockList><block position="1,0,0"/>'
                                f'</blockList><targetList>{target}</targetList></world></vs>')
            out = self.call("meldsim", "world", "--import", "n.xml", "--lattice", "fcc", "-o", "n.toml")[0]
            self.assertTrue(out.endswith(f"; left out: {says}, <visuals>\n"), out)
            self.assertEqual("[target]" in self.read("n.toml").decode(), "grid" in target)
        for text, lattice, says in ((CONFIGURATION, "hex", "c.xml:6: a module is not in the plane of the hex lattice"),
                                    (CONFIGURATION, "", "not name its lattice. Write --lattice with one of square, hex, "),
                                    ("<world", "fcc", "c.xml:1: this is not XML"), ("<a/>", "fcc", "there is no world in it"),
                                    (CONFIGURATION.replace("0,0,0", "0,zero"), "fcc", 'c.xml:5: position = "0,zero" of a block'),
                                    (CONFIGURATION.replace("0,0,0", "1,2,1"), "fcc",
                                     "c.xml:6: a module at 1,2,1 stands where that of line 5 is. take one of the two out"),
                                    (CONFIGURATION.replace("0,0,0", "0,6,0"), "fcc", "c.xml:5: a module at 0,6,0 lies outside of "),
                                    (CONFIGURATION.replace("0,0,0", "-1,0,0"), "fcc", "c.xml:5: a module at -1,0,0 lies outside of "),
                                    ("<!-- c.xml\n -->\n\n" + CONFIGURATION.replace("0,0,0", "0,zero"), "fcc",
                                     'c.xml:8: position = "0,zero"'),
                                    ("<!-- <?xml ?>", "fcc", "c.xml:1: this is not XML"),
                                    (GRIDLESS.replace("0,0,0", "0,0,1048576"), "fcc", "is not a cell"),
                                    (GRIDLESS.replace('plane="1"', 'plane="2000000"'), "fcc",
                                     "c.xml:6: a module is too far out: coordinates lie between -1048576 and 1048575"),
                                    (CONFIGURATION.replace("block ", "csg "), "fcc", "VisibleSim computes from a csg are not imported")):
            self.write("c.xml", text)
            option = ["--lattice", lattice] if lattice else []
            self.refused("meldsim", "world", "--import", "c.xml", "-o", "none.toml", *option, code=2, says=says)
            self.assertNotIn("none.toml", self.files())

    def test_bodies_lie_on_a_model(self):
        bodies = '[[body]]\npositions = [[0, 0, 3.2], [4, 0.3, 3.1], [9, 0, 3]]\n[motion]\nkind = "bodies"\nsteps = 4\n'
        obstacle = '[[motion.obstacle]]\nkind = "mesh"\nshape = "{}"\n'
        model = "move(rotate(mesh('brick.obj', size = 12), z, 180), 0, 0, 1)"
        self.write("w.toml", bodies + 'lowest = -20\nlost = "remove"\n' + obstacle.format(model))
        self.write("p.meld", "type lies(node, float).\nlies(A, Z) :- position(A, _, _, Z), contact(A, 0).\n")
        out = self.call("meldsim", "run", "p.meld", "--world", "w.toml", "--ticks", 300, "--quiet", "--facts-out", "-")[0]
        heights = dict(re.findall(r"lies\(@(\d), ([0-9.]+)\)", out))
        # The top is 1.2 above the middle, which is at 1; catom 2 fell beside it.
        self.assertEqual(sorted(heights), ["0", "1"])
        for height in heights.values():
            self.assertAlmostEqual(float(height), 2.7, delta=0.05)
        self.write("w.toml", bodies + obstacle.format("box(1, 1, 1)"))
        self.refused("meldsim", "world", "w.toml", code=2, says="the shape box(1, 1, 1) of an obstacle is not one mesh")

    def test_a_picture_shows_the_start(self):
        self.write("w.toml", world("mesh('brick.obj', 10)"))
        out = self.call("meldsim", "world", "w.toml", "--shot", "w.png", "--size", "160x120", "--bare")[0]
        self.assertIn("w.png: 160 x 120 pixels", out)
        pixels = read_png(self.read("w.png"))
        dark = (np.asarray(pixels)[:, :, :3].max(axis=2) < 230).mean()
        self.assertGreater(dark, 0.1)
        self.assertLess(dark, 0.9)


if __name__ == "__main__":
    main("meldc", "meldsim")
