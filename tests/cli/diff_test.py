"""What `meldsim diff` finds: diff_test.py --meldc PATH --meldsim PATH [unittest options]

Each test makes two results of runs that differ in a place it knows, and expects that place.
"""

import json
import os
import pathlib
import random
import shutil
import sys

import h5py
import numpy

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1]))

import frame  # noqa: E402
from frame import TOOLS, main  # noqa: E402

# A fact a catom, several facts a catom, strings, floats, vectors, colours, labels and lines.
PROGRAM = """
type clock(node, int).
type top(node, max int N).
type near(node, node Who, float X).
type hot(node, int N, vec3 At).
type name(node, string).
clock(A, T) :- tick(A, T).
top(A, T) :- clock(A, T).
near(A, B, X) :- neighbor(A, B), at(B, X, _, _).
hot(A, I * T + ODD, vec3(float(T), 0.0, 1.0)) :- id(A, I), clock(A, T), I != 1.
name(A, "even") :- id(A, N), N % 2 = 0.
name(A, ODDS) :- id(A, N), N % 2 = 1, N > 1.
setColor(A, 1, 2, 3) :- hot(A, N, _), N > 5.
setLabel(A, "l" ++ int2str(T)) :- id(A, 0), clock(A, T).
drawLine(A, B) :- clock(A, 3), neighbor(A, B), id(A, 1).
"""
WORLD = 'lattice = "square"\n[[body]]\nshape = "box(4, 1, 1)"\n[record]\nevery = 1\npredicates = ["near", "hot", "name", "clock", "top"]\n'
DIFFER, USAGE, DAMAGED = 1, 2, 6


class Case(frame.Case):
    FILES = {"w.toml": WORLD}

    def program(self, name, odd="0", odds='"odd"'):
        self.write(name, PROGRAM.replace("ODDS", odds).replace("ODD", odd))

    def run_program(self, name, *options, ticks=6):
        self.call("meldsim", "run", name, "--world", "w.toml", "--ticks", ticks, "--quiet", *options)

    def diff(self, a, b, code):
        out, err = self.call("meldsim", "diff", a, b, code=code)
        self.assertEqual(bool(out), code == DIFFER, out)
        return out if code in (0, DIFFER) else err

    def json(self, a, b, code=DIFFER):
        found = json.loads(self.call("meldsim", "diff", a, b, "--json", code=code)[0])
        self.assertEqual(found["same"], code == 0)
        return found


class Digests(Case):
    def lines(self, *digests, first=1):
        return "".join(f"tick {i} {digest * 32}\n" for i, digest in enumerate(digests, first))

    def test_the_first_tick(self):
        self.write("a", self.lines(*"12345"))
        self.write("b", self.lines(*"12945"))
        self.assertEqual(self.diff("a", "b", DIFFER),
                         f"--- a\n+++ b\n@@ tick 3, after 2 that are the same @@\n- {'3' * 32}\n+ {'9' * 32}\n")
        found = self.json("a", "b")
        self.assertEqual((found["kind"], found["tick"], found["same_ticks"]), ("digests", 3, 2))
        self.assertEqual(found["differences"], [{"what": "digest", "a": ["3" * 32], "b": ["9" * 32]}])

    def test_the_same(self):
        self.write("a", self.lines(*"123"))
        self.write("b", self.lines(*"123"))
        self.assertEqual(self.diff("a", "b", 0), "")
        self.assertEqual(self.json("a", "b", 0)["same_ticks"], 3)

    def test_ticks_that_one_lacks(self):
        self.write("a", self.lines(*"1234"))
        self.write("b", self.lines(*"23", first=2))
        self.assertEqual(self.diff("a", "b", DIFFER), "--- a\n+++ b\n- only here: 2 ticks, 1 to 4\n")
        self.write("empty", "")
        self.assertIn("+ only here: 2 ticks, 2 to 3", self.diff("empty", "b", DIFFER))

    def test_no_digests(self):
        self.write("a", self.lines(*"12"))
        for wrong in ("tick 1\n", "tick 2 aa\ntick 1 bb\n", "tick x aa\n", "tick 1 aa\ntick 2 b"):
            self.write("b", wrong)
            self.assertIn("b:", self.diff("a", "b", USAGE))


class Facts(Case):
    FORMS = ("f.txt", "f.h5", "f/")

    def setUp(self):
        super().setUp()
        self.program("one.meld")
        self.program("two.meld", odd="(if I = 2 then 1 else 0 end)", odds='"O,\\"dd"')
        for name in ("one", "two"):
            for form in self.FORMS:
                self.run_program(f"{name}.meld", "--facts-out", f"{name}-{form}")

    def test_each_form(self):
        for form in self.FORMS:
            with self.subTest(form):
                self.assertEqual(self.diff("one-" + form, "one-" + form, 0), "")
                facts = {p["predicate"]: p for p in self.json("one-" + form, "two-" + form)["facts"]}
                self.assertEqual({name: (p["both"], p["only_a"], p["only_b"]) for name, p in facts.items()},
                                 {"clock": (4, 0, 0), "hot": (2, 1, 1), "name": (2, 1, 1), "near": (6, 0, 0), "top": (4, 0, 0)})
                text = self.diff("one-" + form, "two-" + form, DIFFER)
                self.assertIn("@@ name: 2 in both, 1 only in the first, 1 only in the second @@", text)
                self.assertNotIn("clock", text)
                hot = ["hot(@2, 12, vec3(6.0, 0.0, 1.0))."] if form == "f.txt" else ["2,12,6.0,0.0,1.0"]
                self.assertEqual(facts["hot"]["a"], hot)

    def test_csv_and_hdf5_are_one_kind(self):
        self.assertEqual(self.diff("one-f/", "one-f.h5", 0), "")
        self.assertEqual([p["predicate"] for p in self.json("one-f.h5", "two-f/")["facts"] if p["only_a"]], ["hot", "name"])
        self.assertIn("cannot be compared", self.diff("one-f/", "one-f.txt", USAGE))

    def test_examples(self):
        """A few in text, all as JSON."""
        self.write("a", "".join(f"p(@{i}, 1).\n" for i in range(10)))
        self.write("b", "p(@9, 1).\n")
        self.assertEqual(self.diff("a", "b", DIFFER), "--- a\n+++ b\n@@ p: 1 in both, 9 only in the first, 0 only in the second @@\n"
                         "- p(@0, 1).\n- p(@1, 1).\n- p(@2, 1).\n- ... and 6 more\n")
        self.assertEqual(self.json("a", "b")["facts"][0]["a"], [f"p(@{i}, 1)." for i in range(9)])

    def test_a_predicate_that_one_lacks(self):
        self.write("a", "p(@1).\nq(@1, \"a, (b\").\n")
        self.write("b", "q(@1, \"a, (b\").\n")
        self.assertEqual(self.diff("a", "b", DIFFER),
                         "--- a\n+++ b\n@@ p: 0 in both, 1 only in the first, 0 only in the second @@\n- p(@1).\n")

    def test_two_predicates_of_one_name(self):
        self.write("a", "p(@1, [1, 2]).\np(@0, 1, 2).\n")
        self.write("b", "p(@1, [1, 2]).\np(@0, 1, 3).\n")
        self.assertEqual([(p["predicate"], p["only_a"]) for p in self.json("a", "b")["facts"]], [("p.2", 0), ("p.3", 1)])

    def test_a_name_whose_facts_with_more_arguments_are_gone(self):
        self.write("a", "p(@1, [1, 2]).\np(@0, 1, 2).\n")
        self.write("b", "p(@1, [1, 2]).\n")
        for a, b, only in (("a", "b", (0, 1, 0)), ("b", "a", (0, 0, 1))):
            facts = self.json(a, b)["facts"]
            self.assertEqual([(p["predicate"], p["both"], p["only_a"], p["only_b"]) for p in facts], [("p.2", 1, 0, 0), ("p.3", *only)])

    def test_a_csv_file_is_a_table_of_any_name(self):
        for name, files in (("@0", ("a.csv", "b.csv", "one.h5")), ("@1", ("c.csv", "two.h5"))):
            self.write("p.meld", f"type p(node, int).\np(A, I) :- id(A, I), A != {name}.\n")
            for file in files:
                self.run_program("p.meld", "--facts-out", file)
        self.assertEqual(self.diff("a.csv", "b.csv", 0), "")
        self.assertEqual(self.diff("c.csv", "two.h5", 0), "")
        for a, b, name in (("a.csv", "c.csv", "a"), ("a.csv", "two.h5", "p"), ("one.h5", "c.csv", "p")):
            facts = self.json(a, b)["facts"]
            self.assertEqual([(p["predicate"], p["both"], p["only_a"], p["only_b"]) for p in facts], [(name, 2, 1, 1)])

    def test_floats_by_bits(self):
        self.write("a", "p(@1, 0.0).\n")
        self.write("b", "p(@1, -0.0).\n")
        self.diff("a", "b", DIFFER)
        for name, value in (("a.h5", 0.0), ("b.h5", -0.0)):
            shutil.copytree(self.folder / "one-f", self.folder / "x", dirs_exist_ok=True)
            shutil.copy(self.folder / "one-f.h5", self.folder / name)
            with h5py.File(self.folder / name, "r+") as file:
                rows = file["near"][:]
                rows["X"][0] = value
                file["near"][:] = rows
        self.assertEqual(self.json("a.h5", "b.h5")["facts"][3]["b"], ["0,1,-0.0"])

    def test_what_is_no_set_of_facts(self):
        self.write("a", "p(@1, 1).\n")
        for wrong, says in (("p(@1, 1).\nhello\n", "b:2: this is no fact"), ("p(@2).\np(@1).\n", "not in the order of catoms"),
                            ("p(@2).\nq(@1).\np(@3).\n", "not together"), ("hello\n", "nothing that meldsim can compare"),
                            ("p(@2, \"x).\n", "no fact")):
            self.write("b", wrong)
            self.assertIn(says, self.diff("a", "b", USAGE))
        self.write("c.csv", "catom,D\n1,2\n2\nx,3\n")
        self.assertIn("c.csv:4", self.diff("c.csv", "c.csv", USAGE))

    def test_tables_of_another_form(self):
        truth = h5py.enum_dtype({"FALSE": 0, "TRUE": 1}, numpy.int8)
        for form, kind, says in (("truth", [("catom", truth)], "no numbers"), ("text", [("catom", h5py.string_dtype())], "no numbers"),
                                 ("real", [("catom", float)], "no numbers"), ("short", [("catom", numpy.int32)], "not as we write it"),
                                 ("named", [("n", int)], "not that of the catoms"), ("version", [("catom", int)], "version 2")):
            with self.subTest(form):
                with h5py.File(self.folder / "b.h5", "w") as file:
                    file.attrs["format"], file.attrs["version"] = "claymeld facts", 2 if form == "version" else 1
                    file.create_dataset("p", (20,), numpy.dtype(kind))
                self.assertIn(says, self.diff("b.h5", "b.h5", DAMAGED))

    def test_memory_does_not_grow_with_the_files(self):
        with open(self.folder / "a", "w") as a, open(self.folder / "b", "w") as b:
            for i in range(400_000):
                a.write(f"p(@{i}, {i}, \"a text that takes some room in memory\").\n")
                if i != 399_998:
                    b.write(f"p(@{i}, {i}, \"a text that takes some room in memory\").\n")
        out, _ = self.call("bash", "-c", 'ulimit -d 20000; "$0" diff a b', TOOLS.meldsim, code=DIFFER)
        self.assertIn("399999 in both, 1 only in the first", out)


class Recordings(Case):
    def record(self, program, name, *options, ticks=6):
        self.run_program(program, "--record", name, *options, ticks=ticks)

    def setUp(self):
        super().setUp()
        self.program("p.meld")
        self.record("p.meld", "a")

    def test_the_same_for_any_number_of_processes(self):
        self.record("p.meld", "b", "-n", "2")
        self.assertEqual(self.diff("a", "b", 0), "")
        self.assertEqual(self.json("a", "b", 0)["same_ticks"], 7)

    def test_the_least_catom_in_the_first_step(self):
        self.program("p.meld", odd="(if T > 2 && I > 1 then 1 else 0 end)")
        self.record("p.meld", "b")
        found = self.json("a", "b")
        self.assertEqual((found["tick"], found["same_ticks"], found["catom"], found["catoms"]), (3, 3, 2, 2))
        self.assertEqual(found["differences"],
                         [{"what": "hot", "a": ["hot(@2, 6, vec3(3, 0, 1))"], "b": ["hot(@2, 7, vec3(3, 0, 1))"]}])
        self.assertEqual([each["what"] for each in found["runs"]], ["the program, from line 10 on"])
        self.assertIn("@@ tick 3, after 3 that are the same; @2, the first of 2 catoms that differ: hot @@\n- hot(@2, 6",
                      self.diff("a", "b", DIFFER))

    def test_strings(self):
        self.program("p.meld", odds='"Odd"')
        self.record("p.meld", "b")
        self.assertEqual(self.json("a", "b")["differences"], [{"what": "name", "a": ['name(@3, "odd")'], "b": ['name(@3, "Odd")']}])

    def test_ticks_that_one_lacks(self):
        self.record("p.meld", "b", ticks=4)
        self.assertEqual(self.diff("a", "b", DIFFER), "--- a\n+++ b\n- only here: 2 ticks, 5 to 6\n")
        self.write("w.toml", WORLD.replace("every = 1", "every = 4"))
        self.record("p.meld", "c")
        found = self.json("a", "c")
        self.assertEqual((found["same_ticks"], found["ticks_only_a"]), (3, {"count": 4, "first": 1, "last": 5}))
        self.assertEqual([each["what"] for each in found["runs"]], ["the world, from line 5 on"])

    def test_what_is_recorded(self):
        self.write("w.toml", WORLD.replace(', "top"', "").replace('"near", ', ""))
        self.record("p.meld", "b")
        lone = {line for each in self.json("a", "b")["runs"] if each["what"] == "what is recorded" for line in each["a"]}
        self.assertLessEqual({"top", "top.facts", "the facts of near"}, lone)
        self.assertFalse([line for line in lone if "clock" in line or "hot" in line])

    def change(self, array, row, value):
        """The last step, otherwise."""
        shutil.copy(self.folder / "a", self.folder / "b")
        with h5py.File(self.folder / "b", "r+") as file:
            steps = file["VTKHDF/Steps"]
            if array.startswith("/meld/facts/"):
                offset = steps["FactOffsets" + array.removeprefix("/meld/facts")][-1]
            else:
                offset = steps["PointOffsets" if array.endswith("Points") else "PointDataOffsets/" + array.split("/")[-1]][-1]
            file[array][offset + row] = value

    def test_floats_by_bits(self):
        with h5py.File(self.folder / "a") as file:
            offset = file["VTKHDF/Steps/FactOffsets/near/X"][-1]
            at = int(numpy.flatnonzero(file["meld/facts/near/X"][offset:offset + 6] == 0)[0])
            who = int(file["meld/facts/near/catom"][file["VTKHDF/Steps/FactOffsets/near/catom"][-1] + at])
        self.change("/meld/facts/near/X", at, -0.0)
        found = self.json("a", "b")
        self.assertEqual((found["catom"], found["differences"][0]["what"]), (who, "near"))
        self.assertIn(", -0)", found["differences"][0]["b"][0])
        self.change("VTKHDF/Points", 2, [0, numpy.nan, 0])
        self.assertIn("nan", str(self.json("a", "b")["differences"]))
        # One that is none in the same way is the same.
        shutil.copy(self.folder / "b", self.folder / "c")
        self.diff("b", "c", 0)

    def test_each_array(self):
        for array, row, value, what in (("VTKHDF/Points", 1, [9, 9, 9], "position"), ("VTKHDF/PointData/colour", 3, [9, 9, 9], "colour"),
                                        ("VTKHDF/PointData/label", 0, -1, "label"), ("VTKHDF/PointData/top", 2, 77, "top"),
                                        ("/meld/facts/near/Who", 0, 3, "near")):
            with self.subTest(array):
                self.change(array, row, value)
                found = self.json("a", "b")
                self.assertIn(what, [each["what"] for each in found["differences"]])
                self.assertEqual(found["kind"], "recordings")

    def test_lines(self):
        with open(self.folder / "p.meld", "a") as file:
            file.write("drawLine(A, B) :- clock(A, 5), neighbor(A, B), id(A, 2), id(B, 3).\n")
        self.record("p.meld", "b")
        found = self.json("a", "b")
        self.assertEqual((found["catom"], found["differences"]), (2, [{"what": "line", "a": [], "b": ["to @3"]}]))

    def test_lines_are_compared_by_their_ends(self):
        """@9 comes before @10, but "to @9" after "to @10"."""
        self.write("w.toml", 'lattice = "square"\n[[body]]\nshape = "box(11, 1, 1)"\n')
        for name, ends in (("a", (9, 10)), ("b", (10,))):
            self.write("p.meld", "".join(f"drawLine(A, @{end}) :- id(A, 2).\n" for end in ends))
            self.record("p.meld", name)
        self.assertEqual(self.json("a", "b")["differences"], [{"what": "line", "a": ["to @9"], "b": []}])

    def test_a_recording_is_read_to_where_it_is_whole(self):
        """Every damage is told or changes nothing, and none is a crash."""
        whole = (self.folder / "a").read_bytes()
        generator = random.Random(3)
        for turn in range(25):
            data = bytearray(whole)
            if turn % 2:
                del data[generator.randrange(len(data)):]
            for _ in range(20 if not turn % 2 else 0):
                data[generator.randrange(len(data))] ^= 1 << generator.randrange(8)
            (self.folder / "b").write_bytes(data)
            done = self.run_tool("meldsim", "diff", "a", "b")
            self.assertIn(done.returncode, (0, DIFFER, USAGE, DAMAGED), (turn, done.stderr))

    def test_what_differs_and_is_not_recorded(self):
        shutil.copy(self.folder / "a", self.folder / "b")
        with h5py.File(self.folder / "b", "r+") as file:
            file["VTKHDF/Steps/StateDigestLow"][4] += 1
        found = self.json("a", "b")
        self.assertEqual((found["tick"], found["same_ticks"], [each["what"] for each in found["differences"]]), (4, 4, ["digest"]))
        self.assertIn("What differs is not recorded", self.diff("a", "b", DIFFER))

    def test_what_is_no_recording_of_this_form(self):
        """Each is refused, with no memory taken for what it claims."""
        def replaced(place, data, **options):
            def change(file):
                del file[place]
                file.create_dataset(place, data=data, **options)
            return change

        def attribute(place, name, value):
            return lambda file: file[place].attrs.create(name, value)

        def predicates(text):
            return replaced("meld/predicates", text, dtype=f"S{max(1, len(text))}")

        def endless(file):
            file["VTKHDF/Steps/Values"].resize(1 << 50, 0)
            file["VTKHDF/Steps"].attrs.create("NSteps", 1 << 50)

        def huge_part(file):
            file["VTKHDF/Lines/NumberOfCells"][0] = 1 << 62

        def unreadable(place):
            def change(file):
                del file[place]
                file[place] = h5py.SoftLink("/nowhere")
            return change

        steps = "VTKHDF/Steps"
        for name, change in (
                ("lines of bytes", replaced("VTKHDF/Lines/Connectivity", numpy.zeros(64, numpy.uint8))),
                ("lines of floats", replaced("VTKHDF/Lines/Connectivity", numpy.zeros(64, numpy.float32))),
                ("a huge part", huge_part), ("steps without end", endless),
                ("pairs of ticks", replaced(steps + "/Values", numpy.zeros((7, 16)))),
                ("ticks that are none", replaced(steps + "/Values", numpy.full(7, numpy.nan))),
                ("a text for a number", attribute(steps, "NSteps", "x")), ("no number", attribute(steps, "NSteps", numpy.nan)),
                ("another version", attribute("meld", "version", 3)), ("facts that cannot be read", unreadable("meld/facts")),
                ("arrays that cannot be read", unreadable("VTKHDF/PointData")), ("strings that cannot be read", unreadable("meld/texts")),
                ("no digests", lambda file: file.__delitem__(steps + "/StateDigestLow")),
                ("no predicates", lambda file: file.__delitem__("meld/predicates")), ("no JSON", predicates("[{")),
                ("no list", predicates('{"name": "p"}')), ("no name", predicates('[{"name": 1, "table": true, "arguments": []}]')),
                ("no types", predicates('[{"name": "p", "table": true, "arguments": [{"name": "N", "array": "p"}]}]'))):
            with self.subTest(name):
                shutil.copy(self.folder / "a", self.folder / "b")
                with h5py.File(self.folder / "b", "r+") as file:
                    change(file)
                for one, other in (("b", "b"), ("a", "b")):
                    self.assertRegex(self.diff(one, other, DAMAGED), "cannot read b: |b is a recording of version 3, ")

    def test_kinds(self):
        self.run_program("p.meld", "--digest", "d")
        self.assertIn("the first is a recording, the second is a file of digests", self.diff("a", "d", USAGE))
        self.assertIn("cannot read nowhere", self.diff("a", "nowhere", USAGE))
        os.mkfifo(self.folder / "pipe")
        self.assertIn("no regular file", self.diff("a", "pipe", USAGE))
        with h5py.File(self.folder / "other", "w") as file:
            file["x"] = 1
        self.assertIn("nothing that meldsim can compare", self.diff("a", "other", USAGE))


class Checkpoints(Case):
    def keep(self, program, folder, *options, ticks=6):
        self.run_program(program, "--checkpoint", folder, "--checkpoint-every", "2ticks", *options, ticks=ticks)

    def setUp(self):
        super().setUp()
        self.program("p.meld")
        self.keep("p.meld", "a")

    def test_the_same_for_any_number_of_processes(self):
        self.keep("p.meld", "b", "-n", "2")
        self.assertEqual(self.diff("a", "b", 0), "")

    def test_the_least_catom(self):
        self.program("q.meld", odd="(if I > 1 then 1 else 0 end)")
        self.keep("q.meld", "b", "-n", "2")
        found = self.json("a", "b")
        self.assertEqual((found["tick"], found["catom"], found["catoms"]), (6, 2, 2))
        self.assertEqual([each["what"] for each in found["runs"]], ["the program"])
        self.assertEqual(found["differences"], [{"what": "state", "a": ["hot(@2, 12, vec3(6.0, 0.0, 1.0))"],
                                                 "b": ["hot(@2, 13, vec3(6.0, 0.0, 1.0))"]}])

    def test_the_seed_and_places(self):
        self.keep("p.meld", "b", "--seed", "7")
        self.assertEqual(self.json("a", "b")["runs"], [{"what": "the seed", "a": ["1"], "b": ["7"]}])
        self.write("v.toml", WORLD.replace("box(4, 1, 1)", "move(box(4, 1, 1), 1, 0, 0)"))
        self.call("meldsim", "run", "p.meld", "--world", "v.toml", "--ticks", 6, "--quiet", "--checkpoint", "c")
        found = self.json("a", "c")
        self.assertEqual((found["catom"], found["runs"][0]["what"]), (0, "the world"))
        self.assertIn("in cell (", str(found["differences"][0]["a"]))

    def test_where_bodies_are(self):
        """Nothing but the position of one differs."""
        self.write("p.meld", "type high(node).\nhigh(A) :- position(A, _, _, Z), Z > 100.0.\n")
        for name, x, processes in (("b", 4.5, 1), ("c", 4.75, 2)):
            self.write(name + ".toml", f'[[body]]\npositions = [[0, 0, 9], [{x}, 0, 9], [8, 0, 9]]\n[motion]\nkind = "bodies"\n')
            self.call("meldsim", "run", "p.meld", "--world", name + ".toml", "--ticks", 6, "--quiet", "--checkpoint", name, "-n", processes)
        found = self.json("b", "c")
        self.assertEqual((found["catom"], found["catoms"]), (1, 1))
        (one,) = found["differences"]
        self.assertRegex(one["a"][0], r"^at \(4\.5, 0, 8\.")
        self.assertRegex(one["b"][0], r"^at \(4\.75, 0, 8\.")

    def test_the_newest_tick_that_both_have(self):
        """Folders have the last two."""
        self.keep("p.meld", "b", ticks=8)
        self.assertEqual(self.diff("a", "b", 0), "")
        self.keep("p.meld", "c", ticks=20)
        self.assertIn("@@ the tick @@\n- 6\n+ 20\n", self.diff("a", "c", DIFFER))

    def test_a_program_that_has_changed_since(self):
        self.program("q.meld", odd="1")
        self.keep("q.meld", "b")
        self.program("q.meld", odd="2")
        found = self.json("a", "b")
        self.assertIn("has changed since", found["remark"])
        self.assertEqual(found["differences"][0]["what"], "digest")

    def test_damage(self):
        self.program("q.meld", odd="1")
        self.keep("q.meld", "b")
        for share in (self.folder / "b").glob("6.*.share"):
            share.write_bytes(share.read_bytes()[:-1])
        self.assertIn("share", self.diff("a", "b", DAMAGED))
        for manifest in (self.folder / "b").glob("*.json"):
            manifest.write_text("{}\n")
        self.assertIn("manifest", self.diff("a", "b", DAMAGED))


if __name__ == "__main__":
    main("meldc", "meldsim")
