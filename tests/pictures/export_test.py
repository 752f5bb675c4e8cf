"""meldsim export: the files are what other programs take them for, and hold what is shown.

    export_test.py --meldc PATH --meldsim PATH [unittest options]
"""
import csv
import io
import json
import math
import pathlib
import re
import struct
import sys

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1]))

import numpy as np  # noqa: E402

from frame import FRONT, Case, main, no_file_above  # noqa: E402

NAMED = FRONT + """
type name(node, string).
name(A, "far, \\"away\\"") :- dist(A, D), D > 3.
"""
DIST = ("--colour", "dist(A, D)")
YELLOW, PURPLE = (0xFD, 0xE7, 0x25), (0x44, 0x01, 0x54)
COMPONENTS = {5126: ("f4", 4), 5125: ("u4", 4), 5123: ("u2", 2)}
PARTS = {"SCALAR": 1, "VEC3": 3, "VEC4": 4}


def cube(lattice, side):
    return f'lattice = "{lattice}"\n[[body]]\nshape = "box({side}, {side}, {side})"\n'


def read_ply(data):
    """The rows of its vertices, by the letter of the format."""
    head, _, body = data.partition(b"end_header\n")
    lines = head.decode("ascii").splitlines()
    assert lines[:2] == ["ply", "format binary_little_endian 1.0"], lines
    types = {"float": "<f4", "double": "<f8", "uchar": "u1", "uint": "<u4"}
    fields, count = [], None
    for line in lines[2:]:
        words = line.split()
        if words[0] == "element":
            assert words[1] == "vertex" and count is None, line
            count = int(words[2])
        elif words[0] == "property":
            fields.append((words[2], types[words[1]]))
        else:
            assert words[0] == "comment", line
    rows = np.frombuffer(body, np.dtype(fields))
    assert len(rows) == count, "more or fewer rows than it says"
    return rows


def read_glb(data):
    """Its JSON, and what its accessors say, by their numbers."""
    magic, version, size = struct.unpack_from("<4sII", data)
    assert (magic, version, size) == (b"glTF", 2, len(data))
    text_size, kind = struct.unpack_from("<I4s", data, 12)
    assert kind == b"JSON" and text_size % 4 == 0
    about = json.loads(data[20:20 + text_size])
    size, kind = struct.unpack_from("<I4s", data, 20 + text_size)
    assert kind == b"BIN\0" and size % 4 == 0 and len(data) == 28 + text_size + size
    body, found = data[28 + text_size:], []
    assert about["asset"]["version"] == "2.0"
    for accessor in about.get("accessors", []):
        view = about["bufferViews"][accessor["bufferView"]]
        letter, width = COMPONENTS[accessor["componentType"]]
        parts = PARTS[accessor["type"]]
        assert view["byteOffset"] % width == 0 and view["byteLength"] == accessor["count"] * parts * width
        assert view["byteOffset"] + view["byteLength"] <= about["buffers"][view["buffer"]]["byteLength"] == len(body)
        found.append(np.frombuffer(body, "<" + letter, accessor["count"] * parts, view["byteOffset"]).reshape(-1, parts))
    return about, found


def read_xyz(text):
    """For each frame its tick and its rows, by names."""
    lines, at, frames = text.splitlines(), 0, []
    while at < len(lines):
        count = int(lines[at])
        about = dict(word.split("=", 1) for word in lines[at + 1].replace('"F F F"', "FFF").split())
        names = []
        fields = about["Properties"].split(":")
        for name, _, parts in zip(fields[::3], fields[1::3], fields[2::3]):
            names += [name] if parts == "1" else [f"{name}{i}" for i in range(int(parts))]
        rows = [line.split() for line in lines[at + 2:at + 2 + count]]
        assert len(rows) == count and all(len(row) == len(names) for row in rows)
        frames.append((int(about["tick"]), [dict(zip(names, row)) for row in rows]))
        at += 2 + count
    return frames


class Exports(Case):
    FILES = {"front.meld": NAMED, "front.toml": cube("cubic", 3)}

    def export(self, name, *options, target="front.meld"):
        self.call("meldsim", "export", target, "-o", name, "--quiet", *options)
        return self.read(name)

    def test_points(self):
        rows = read_ply(self.export("a.ply", *DIST))
        self.assertEqual(len(rows), 27)
        self.assertEqual(rows["catom"].tolist(), sorted(rows["catom"].tolist()))
        first = rows[rows["value"] == 0][0]
        self.assertEqual((first["red"], first["green"], first["blue"]), PURPLE)
        # Distances count the steps along the axes.
        steps = sum(np.abs(rows[axis] - first[axis]) for axis in "xyz")
        self.assertTrue((rows["value"] == steps).all())
        self.assertTrue((rows["radius"] == 0.5).all())
        shown = read_ply(self.export("a.ply", "--only", "dist(A, D), D < 2"))
        self.assertEqual(len(shown), 4)
        self.assertNotIn("value", shown.dtype.names)
        self.assertEqual(len(read_ply(self.export("a.ply", "--hide", "dist(A, D)"))), 0)

    def test_tables(self):
        rows = list(csv.DictReader(io.StringIO(self.export("a.csv", "--tick", "2,0,end", *DIST).decode(), newline="")))
        self.assertEqual([int(row["tick"]) for row in rows], [0] * 27 + [2] * 27 + [8] * 27)
        self.assertEqual({row["value"] for row in rows if row["tick"] == "0"}, {""})
        # A colour means the same in all ticks: 1 of 6 is no longer the greatest.
        self.assertNotIn(YELLOW, {(int(row["red"]), int(row["green"]), int(row["blue"])) for row in rows if row["tick"] == "2"})
        self.assertIn(YELLOW, {(int(row["red"]), int(row["green"]), int(row["blue"])) for row in rows if row["tick"] == "8"})
        words = list(csv.DictReader(io.StringIO(self.export("a.csv", "--colour", "name(A, N)").decode(), newline="")))
        self.assertEqual({row["value"] for row in words}, {"", r'"far, \"away\""'})

    def test_atoms(self):
        frames = read_xyz(self.export("a.xyz", "--tick", "0,end", *DIST).decode())
        self.assertEqual([tick for tick, _ in frames], [0, 8])
        values = [float(row["value"]) for row in frames[1][1]]
        self.assertEqual(sorted(values)[-1], 6)
        self.assertNotIn("value", frames[0][1][0])
        self.assertEqual([int(row["id"]) for row in frames[1][1]], sorted(int(row["id"]) for row in frames[1][1]))
        self.assertTrue(all(0 <= float(row[f"color{i}"]) <= 1 for row in frames[1][1] for i in range(3)))

    def test_shapes(self):
        """What there is of bodies that are no spheres: a box that stands on its side, and a ball beside it."""
        self.write("box.meld", "type far(node).\nfar(A) :- position(A, X, _, _), X > 3.0.\n")
        self.write("box.toml", """[[body]]
positions = [[0, 0, 1], [5, 0, 0.5]]
[motion]
kind = "bodies"
ground = 0
[[motion.catoms]]
where = "id == 0"
shape = "box"
edges = [1, 2, 3]
rounding = 0.1
turned = [90, 0, 0]
""")
        half = 0.5 ** 0.5
        names = ["core_x", "core_y", "core_z", "rounding", "orientation_w", "orientation_x", "orientation_y", "orientation_z"]
        wanted = [0.4, 0.9, 1.4, 0.1, half, half, 0, 0]
        run = ("--tick", "0")
        data = self.export("a.csv", *run, target="box.meld").decode()
        rows = list(csv.DictReader(io.StringIO(data, newline="")))
        self.assertEqual(data.splitlines()[0], "tick,catom,x,y,z,diameter,red,green,blue,value," + ",".join(names))
        self.assertTrue(np.allclose([float(rows[0][name]) for name in names], wanted, atol=1e-6), rows[0])
        self.assertEqual([float(rows[1][name]) for name in names], [0, 0, 0, 0.5, 1, 0, 0, 0])
        points = read_ply(self.export("a.ply", *run, "--colour", "neighborCount(A, N)", target="box.meld"))
        self.assertTrue(np.allclose([points[name][0] for name in names], wanted, atol=1e-6))
        self.assertEqual([points[name][1] for name in ("x", "rounding", "orientation_w", "value")], [5, 0.5, 1, 0])
        (_, atoms), = read_xyz(self.export("a.xyz", *run, "--colour", "neighborCount(A, N)", target="box.meld").decode())
        shape, turn = ([f"{name}{i}" for i in range(count)] for name, count in (("aspherical_shape", 3), ("orientation", 4)))
        read = [float(atoms[0][name]) for name in (*shape, "rounding", *turn, "value")]
        self.assertTrue(np.allclose(read, [0.5, 1, 1.5, 0.1, half, 0, 0, half, 0], atol=1e-6), read)
        # The same of what was recorded; without a catom nobody knows, and of spheres alone there is none.
        self.call("meldsim", "run", "box.meld", "--ticks", 3, "--record", "box.vtkhdf", "--quiet")
        self.assertEqual(self.export("b.csv", *run, target="box.vtkhdf").decode(), data)
        self.assertNotIn("core", self.export("b.csv", *run, "--hide", "position(A, _, _, _)", target="box.meld").decode())
        # The columns are there from the first row on, wherever it is.
        late = self.export("b.csv", "--tick", "0,1", "--only", "tick(A, T), T > 0", target="box.meld").decode().splitlines()
        self.assertEqual((late[0], len(late)), (data.splitlines()[0], 3))
        self.write("box.toml", '[[body]]\npositions = [[0, 0, 1], [5, 0, 0.5]]\n[motion]\nkind = "bodies"\n')
        for end in ("csv", "xyz", "ply"):
            self.assertNotIn(b"rounding", self.export(f"c.{end}", *run, target="box.meld"))

    def check_solid(self, data):
        """It is a surface: each triangle looks outwards, as its corners' normals do."""
        about, (places, normals, colours, faces) = read_glb(data)
        primitive = about["meshes"][0]["primitives"][0]
        self.assertEqual(primitive["attributes"], {"POSITION": 0, "NORMAL": 1, "COLOR_0": 2})
        for end, of in (("min", places.min(axis=0)), ("max", places.max(axis=0))):
            self.assertEqual(np.array(about["accessors"][0][end], np.float32).tolist(), of.tolist())
        self.assertTrue(np.allclose(np.linalg.norm(normals, axis=1), 1, atol=1e-5))
        corners = places[faces.reshape(-1, 3)].astype(float)
        across = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
        self.assertTrue((np.einsum("ij,ij->i", across, normals[faces.reshape(-1, 3)[:, 0]]) > 0).all())
        self.assertTrue((colours[:, 3] == 65535).all())
        return places, faces.reshape(-1, 3), corners

    def test_solids(self):
        # 26 of 27 balls can be seen from outside; there are so few that they are round.
        places, faces, corners = self.check_solid(self.export("a.glb", *DIST))
        self.assertEqual((len(places), len(faces)), (26 * 162, 26 * 320))
        volume = np.einsum("ij,ij->", corners[:, 0], np.cross(corners[:, 1], corners[:, 2])) / 6
        self.assertAlmostEqual(volume / (26 * math.pi / 6), 1, delta=0.05)
        # Cubes have the faces of the whole, 9 on each side.
        places, faces, corners = self.check_solid(self.export("b.glb", "--form", "cube"))
        self.assertEqual(len(faces), 6 * 9 * 2)
        volume = np.einsum("ij,ij->", corners[:, 0], np.cross(corners[:, 1], corners[:, 2])) / 6
        self.assertAlmostEqual(volume, 27, places=3)
        # Of rounded ones the edges are round, and those that others surround are left out.
        places, faces, corners = self.check_solid(self.export("b.glb", "--form", "rounded"))
        self.assertEqual((len(places), len(faces)), (26 * 216, 26 * 300))
        inner, r = 1 - 2 * 0.13, 0.13
        volume = np.einsum("ij,ij->", corners[:, 0], np.cross(corners[:, 1], corners[:, 2])) / 6
        wanted = inner ** 3 + 6 * r * inner ** 2 + 3 * math.pi * r ** 2 * inner + 4 / 3 * math.pi * r ** 3
        self.assertAlmostEqual(volume / (26 * wanted), 1, delta=0.01)
        # Up is y there, and z before.
        self.write("tower.toml", 'lattice = "cubic"\n[[body]]\nshape = "box(1, 2, 5)"\n')
        places, _, _ = self.check_solid(self.export("c.glb", "--world", "tower.toml", "--form", "cube"))
        self.assertEqual((places.max(axis=0) - places.min(axis=0)).tolist(), [1, 5, 2])
        about, found = read_glb(self.export("d.glb", "--hide", "dist(A, D)"))
        self.assertEqual((found, about["scenes"]), ([], [{"name": "tick 8"}]))

    def test_only_what_others_surround_is_left_out(self):
        for lattice, inside in (("cubic", 3 ** 3), ("fcc", None)):
            with self.subTest(lattice):
                self.write("w.toml", cube(lattice, 5))
                rows = read_ply(self.export("a.ply", "--world", "w.toml", "--colour", "neighborCount(A, N)"))
                deep = int((rows["value"] == (6 if lattice == "cubic" else 12)).sum())
                self.assertGreater(deep, 0)
                if inside:
                    self.assertEqual(deep, inside)
                places, _, _ = self.check_solid(self.export("a.glb", "--world", "w.toml"))
                self.assertEqual(len(places), 162 * (len(rows) - deep))

    def test_flat_lattices_are_flat(self):
        for lattice, faces in (("square", 12), ("hex", 4)):
            self.write("w.toml", f'lattice = "{lattice}"\n[[body]]\nshape = "box(1, 1, 1)"\n')
            _, found, _ = self.check_solid(self.export("a.glb", "--world", "w.toml"))
            self.assertEqual(len(found), faces)

    def test_it_is_the_same_from_wherever_it_is_written(self):
        self.call("meldsim", "run", "front.meld", "--record", "run.vtkhdf", "--quiet")
        self.call("meldsim", "run", "front.meld", "--ticks", 2, "--checkpoint", "kept", "--quiet")
        for end in ("ply", "glb", "csv", "xyz"):
            wanted = self.export(f"a.{end}", *DIST)
            self.assertEqual(self.export(f"b.{end}", *DIST, "-n", 2), wanted, end)
        self.assertEqual(self.export("b.xyz", *DIST, target="run.vtkhdf"), wanted)
        self.assertEqual(self.export("b.xyz", *DIST, target="kept"), self.export("a.xyz", *DIST, "--tick", 2))

    def test_a_file_of_each_tick(self):
        for end in ("ply", "glb"):
            out, _ = self.call("meldsim", "export", "front.meld", "-o", f"s-TICK.{end}", "--tick", "0,2,end")
            self.assertEqual(out, f"s-TICK.{end}: 27 of 27 catoms, ticks 0, 2, 8\n")
            for tick in (0, 2, 8):
                self.assertEqual(self.read(f"s-{tick:06}.{end}"), self.export(f"b.{end}", "--tick", tick))
        # Folders keep their names.
        (self.folder / "TICKS").mkdir()
        self.assertEqual(self.export("TICKS/a.csv", "--tick", 2), self.export("b.csv", "--tick", 2))

    def test_mistakes(self):
        self.write("old.ply", "as it was")
        for says, code, name, *options in (("old.ply can hold one tick only", 2, "old.ply", "--tick", "0,1"),
                                           ("a.obj ends with none of .csv, .xyz, .ply and .glb", 2, "a.obj"),
                                           ("the run ends with tick 8, before tick 9", 2, "old.ply", "--tick", "9"),
                                           ("did you mean `dist`?", 2, "old.ply", "--colour", "dits(A, D)"),
                                           ("cannot write no/a.csv", 2, "no/a.csv")):
            with self.subTest(says):
                self.refused("meldsim", "export", "front.meld", "-o", name, "--quiet", *options, code=code, says=says, lines=None)
                self.assertEqual(self.read("old.ply"), b"as it was")
        self.refused("meldsim", "export", "front.meld", "-o", "old.ply", "--quiet", code=4, says="Raise the limit",
                     preexec_fn=no_file_above(512))
        self.assertEqual(self.read("old.ply"), b"as it was")
        out, _ = self.call("meldsim", "export", "front.meld", "-o", "a.csv", "--tick", "0,end")
        self.assertEqual(out, "a.csv: 27 of 27 catoms, ticks 0, 8\n")
        # A tick that is named twice is in it once, also as the end.
        for colour in ((), DIST):
            self.call("meldsim", "export", "front.meld", "-o", "b.csv", "--tick", "5,2,2,end,8", "--quiet", *colour)
            rows = list(csv.DictReader(io.StringIO(self.read("b.csv").decode(), newline="")))
            self.assertEqual([int(row["tick"]) for row in rows], [2] * 27 + [5] * 27 + [8] * 27)
        out, _ = self.call("meldsim", "export", "front.meld", "-o", "a.ply", "--only", "source(A)", "--json")
        self.assertEqual(json.loads(out), {"file": "a.ply", "ticks": [8], "catoms": 27, "shown": 1})

    def test_whole_numbers_are_exact(self):
        """Also those of more than 53 bits, which are not rounded to each other: in values, in colours, and in a page that is shared."""
        big = 2 ** 53
        for numbers in ([big + 1, big + 2, big], [2 ** 62, 2 ** 62 + 1], [-big - 1, 0, big + 1], [2 ** 24 + 1, 2 ** 24], [5, 2 ** 62,
            2 ** 62 + 1],
                        [big + i for i in range(12)]):
            with self.subTest(numbers):
                self.write("big.meld", "type v(node, int).\n" + "".join(f"v(@{i}, {n}).\n" for i, n in enumerate(numbers)))
                self.write("big.toml", 'lattice = "square"\n[[body]]\nshape = "box(4, 4, 1)"\n')
                run = ("big.meld", "--world", "big.toml", "--colour", "v(A, N)", "--quiet")
                self.call("meldsim", "export", *run, "-o", "big.csv")
                rows = [row for row in csv.DictReader(self.read("big.csv").decode().splitlines()) if row["value"]]
                self.assertEqual([int(row["value"]) for row in rows], numbers)
                colours = {(row["red"], row["green"], row["blue"]) for row in rows}
                self.assertEqual(len(colours), len(set(numbers)), "two values have one colour")
                self.call("meldsim", "export", *run, "-o", "big.xyz")
                for number in numbers:
                    self.assertIn(str(number), self.read("big.xyz").decode())
                _, err = self.call("meldsim", "export", *run, "-o", "big.ply")
                rounded = any(float(n) != n for n in numbers)
                self.assertEqual("numbers of a .ply file have 53 bits" in err, rounded, err)
                if not rounded:
                    values = read_ply(self.read("big.ply"))["value"]
                    self.assertEqual(sorted(int(v) for v in values if v == v), sorted(numbers))
                self.call("meldsim", "view", *run, "--share", "big.html")
                page = self.read("big.html").decode()
                head = json.loads(re.search(r'<script type="application/json" id="share">(.*?)</script>', page, re.S)[1])
                exact = [n for n in numbers if float(np.float32(n)) != n]
                given = re.findall("......", head["exact"])
                self.assertEqual(len(given), len(exact))
                self.assertEqual(len(set(given)), len(exact), "two values have one colour")
                legend = head["legend"]
                if len(numbers) <= 8:
                    self.assertEqual([int(name) for name, _ in legend["kinds"]], sorted(numbers))
                    self.assertEqual(len({colour for _, colour in legend["kinds"]}), len(numbers), "two values have one colour")
                else:
                    self.assertEqual((int(legend["scale"]["low"]), int(legend["scale"]["high"])), (min(numbers), max(numbers)))


if __name__ == "__main__":
    main("meldc", "meldsim")
