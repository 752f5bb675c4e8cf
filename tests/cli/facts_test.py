"""Facts as tables: `--facts-out` with a folder of CSV files or an HDF5 file, and recordings; what Python makes of them.

    facts_test.py --meldsim PATH [unittest options]
"""
import json
import os
import pathlib
import re
import signal
import subprocess
import sys

import h5py
import pandas

import claymeld

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1]))

import frame  # noqa: E402
from frame import FOREVER, main, no_file_above  # noqa: E402

WORLD = 'lattice = "cubic"\n[[body]]\nshape = "box(5, 4, 3)"\n'
# Every type; names that are missing, double or reserved; a string with all that must be escaped; a predicate with two arities.
EVERYTHING = r"""
type dist(node, min int Hops, node Via).
type all(node, int, float X, float X, vec3 Force, bool Ok, string tick).
type lists(node, list int Ints, set string Names, :(int, float) Pair, list list float Reals).
type many(node, int facts, node arg2).
type here(node).
type here(node, int).
type never(node, string).
dist(@0, 0, @0).
dist(B, D + 1, A) :- neighbor(A, B), dist(A, D, _).
all(A, I, 0.1 * int2float(I), 1.0e-300, vec3(int2float(I), 2.5, 0.0 - 1.0e300), I % 2 = 0, "a,\"b\" \\n\n\t\x01\xff é " ++ int2str(I)) :-
    id(A, I).
all(A, 9223372036854775807, 0.0, 0.0, vec3(0.0, 0.0, 0.0), true, "") :- id(A, 3).
lists(A, [I, 0 - I], list2set(["NA", int2str(I)]), :(I, 0.5), [[0.1, 2.0], []]) :- id(A, I), I < 5.
many(A, I, B) :- neighbor(A, B), id(A, I).
here(A) :- id(A, I), I < 3.
here(A, I * I) :- id(A, I).
never(A, "x") :- id(A, 0 - 1).
"""
ONE = "type p(node, int Count).\np(A, N) :- neighborCount(A, N).\n"


class Case(frame.Case):
    FILES = {"w.toml": WORLD, "all.meld": EVERYTHING, "one.meld": ONE}

    def runs(self, program, *arguments, **options):
        return self.call("meldsim", "run", program, "--world", "w.toml", "--quiet", *arguments, **options)

    def refuses(self, program, *arguments, says, code=2, **options):
        return self.refused("meldsim", "run", program, "--world", "w.toml", *arguments, says=says, code=code, **options)


class Tables(Case):
    def expected(self):
        """By table, the rows that the facts as text have."""
        self.runs("all.meld", "--facts-out", "all.facts")
        rows = {}
        for line in (self.folder / "all.facts").read_text().splitlines():
            name, arguments = re.fullmatch(r"(\w+)(\(.*\))\.", line).groups()
            cells = []
            for item in claymeld.value(arguments):
                # Of what is no number only a vec3 stands in columns of its own.
                cells += item if name == "all" and isinstance(item, tuple) else [item]
            rows.setdefault(f"here.{len(cells)}" if name == "here" else name, []).append(tuple(cells))
        return {**rows, "never": []}

    def test_frames_have_every_fact(self):
        expected = self.expected()
        self.assertGreater(len(expected["dist"]), 50)
        for path in ("tables/", "tables.h5", "tables.hdf5"):
            self.runs("all.meld", "--facts-out", path)
            frames = claymeld.facts(self.folder / path)
            self.assertEqual(set(frames), set(expected), path)
            for name, table in frames.items():
                self.assertEqual([tuple(row) for row in table.itertuples(index=False, name=None)], expected[name], (path, name))
            self.assertEqual(list(frames["dist"].columns), ["catom", "Hops", "Via"])
            self.assertEqual(list(frames["many"].columns), ["catom", "arg1", "arg2"])
            columns = {name: str(dtype) for name, dtype in frames["all"].dtypes.items()}
            self.assertEqual(columns, {"catom": "int64", "arg1": "int64", "arg2": "float64", "arg3": "float64", "Force.x": "float64",
                                       "Force.y": "float64", "Force.z": "float64", "Ok": "bool", "arg6": "object"})
            pandas.testing.assert_frame_equal(claymeld.facts(self.folder / path, "dist"), frames["dist"])
            with self.assertRaisesRegex(KeyError, "no table 'distance'; it has .*dist"):
                claymeld.facts(self.folder / path, "distance")

    def test_bytes_do_not_depend_on_the_partition(self):
        for path in ("t/", "t.h5"):
            contents = []
            for processes, threads in ((1, 1), (1, 3), (2, 1), (3, 2)):
                self.runs("all.meld", "--facts-out", path, "-n", processes, "--threads", threads)
                written = self.folder / path
                contents.append([p.read_bytes() for p in sorted(written.iterdir())] if written.is_dir() else [written.read_bytes()])
            self.assertTrue(all(content == contents[0] for content in contents), path)

    def test_other_readers(self):
        """What is read without the package: pandas reads CSV, h5py HDF5."""
        self.runs("all.meld", "--facts-out", "t/")
        self.runs("all.meld", "--facts-out", "t.h5")
        dist = claymeld.facts(self.folder / "t.h5", "dist")
        pandas.testing.assert_frame_equal(pandas.read_csv(self.folder / "t/dist.csv"), dist)
        with h5py.File(self.folder / "t.h5") as file:
            pandas.testing.assert_frame_equal(pandas.DataFrame(file["dist"][:]), dist)
            self.assertEqual(list(file["all"].attrs["types"]), ["node", "int", *["float"] * 5, "bool", "string"])
        package = json.loads((self.folder / "t/datapackage.json").read_text())
        self.assertEqual([r["path"] for r in package["resources"]], sorted(n for n in self.files("t") if n.endswith(".csv")))
        for version, says in ((2, "version 2"), (None, "version none")):
            with h5py.File(self.folder / "t.h5", "r+") as file:
                if "version" in file.attrs:
                    del file.attrs["version"]
                if version is not None:
                    file.attrs["version"] = version
            self.assertRaisesRegex(claymeld.RecordingError, f"{says} of the format.* reads version 1", claymeld.facts, self.folder / "t.h5")
        # A fact is a line, whatever its strings hold.
        self.assertEqual(len((self.folder / "t/all.csv").read_bytes().split(b"\n")), len(claymeld.facts(self.folder / "t", "all")) + 2)

    def test_program_with_one_table(self):
        self.runs("one.meld", "--facts-out", "p.csv")
        self.runs("one.meld", "--facts-out", "t/")
        text = (self.folder / "p.csv").read_text()
        self.assertTrue(text.startswith("catom,Count\n0,3\n"), text[:40])
        self.assertEqual(text, (self.folder / "t/p.csv").read_text())
        with open(self.folder / "stream", "wb") as out:
            os.symlink("/dev/stdout", self.folder / "out.csv")
            self.runs("one.meld", "--facts-out", "out.csv", stdout=out)
        self.assertEqual((self.folder / "stream").read_text(), text)


class Recorded(Case):
    """Recordings have the same facts as the files of facts."""

    def record(self, *arguments, ticks=99, predicates=("dist", "all", "lists", "many", "here", "never")):
        names = ", ".join(f'"{name}"' for name in predicates)
        self.write("w.toml", f"{WORLD}[record]\npredicates = [{names}]\n")
        self.runs("all.meld", "--record", "r.vtkhdf", "--facts-out", "f.h5", "--ticks", ticks, *arguments)
        return claymeld.open(self.folder / "r.vtkhdf"), claymeld.facts(self.folder / "f.h5")

    def test_every_step_has_every_fact(self):
        recording, _ = self.record()
        self.assertGreater(len(recording), 5)
        for tick in recording.ticks:
            _, facts = self.record(ticks=tick)
            for name in recording.predicates:
                pandas.testing.assert_frame_equal(recording.facts(name, tick), facts[name], obj=f"{name} in tick {tick}")
            if tick == recording.ticks[-1]:
                every = recording.facts("many", "all")
                self.assertEqual(len(every), sum(len(recording.facts("many", each)) for each in recording.ticks))
                self.assertEqual(list(every.columns), ["tick", "catom", "arg1", "arg2"])

    def test_recordings_do_not_depend_on_the_partition(self):
        first, _ = self.record()
        frames = {name: first.facts(name, "all") for name in first.predicates}
        for arguments in (("-n", 2), ("-n", 3, "--threads", 2)):
            other, _ = self.record(*arguments)
            for name, table in frames.items():
                pandas.testing.assert_frame_equal(other.facts(name, "all"), table)

    def test_first_arguments_are_where_they_were(self):
        """The layout for predicates with one argument, as older readers know it."""
        recording, facts = self.record(predicates=("dist", "here", "here", "never"))
        with h5py.File(self.folder / "r.vtkhdf") as file:
            data, begin = file["VTKHDF/PointData"], file["VTKHDF/Steps/PointDataOffsets/dist"]
            self.assertEqual(data["dist"][begin[-1]:begin[-1] + 60].tolist(), facts["dist"]["Hops"].tolist())
            self.assertEqual(set(data["dist"][begin[0]:begin[0] + 60].tolist()), {-1})
            begin = file["VTKHDF/Steps/PointDataOffsets/here.1"][-1]
            self.assertEqual(data["here.1"][begin:begin + 60].tolist(), [1] * 3 + [0] * 57)


class Refusals(Case):
    def test_names_that_promise_something_else(self):
        self.refuses("all.meld", "--facts-out", "x.csv", says=["holds one table", "has 7: all, dist, here.1", "Write x/", "x.h5"])
        for name in ("x.parquet", "x.arrow", "x.feather", "x.tsv", "x.json"):
            self.refuses("one.meld", "--facts-out", name, says=["not written in the format of .", "Write x.h5", "x/"])
        (self.folder / "there").mkdir()
        self.refuses("one.meld", "--facts-out", "there", says=["it is a folder", "Write there/"])
        self.refuses("one.meld", "--facts-out", "no/such/", says=["cannot write no/such/: No such file"])
        self.refuses("one.meld", "--facts-out", "no/such.h5", says=["cannot write no/such.h5: No such file"])
        self.refuses("one.meld", "--facts-out", "w.toml/", says=["cannot write w.toml/"])
        os.mkfifo(self.folder / "fifo.h5")
        self.refuses("one.meld", "--facts-out", "fifo.h5", says=["HDF5 is no stream"])
        self.assertEqual(self.files(), {*self.FILES, "fifo.h5", "there"})

    def test_folders_of_others(self):
        self.runs("all.meld", "--facts-out", "t/")
        before = self.files("t")
        self.refuses("one.meld", "--facts-out", "t/", says=["none of this run, all.csv", "Remove it"])
        self.assertEqual(self.files("t"), before)
        (self.folder / "data").mkdir()
        self.write("data/datapackage.json", '{"name": "rainfall"}')
        self.refuses("one.meld", "--facts-out", "data/", says=["datapackage.json describes other data"])
        # A table of a user's may have the name of one of the run's.
        (self.folder / "mine").mkdir()
        self.write("mine/p.csv", "a user's")
        self.refuses("one.meld", "--facts-out", "mine/", says=["none of this run, p.csv"])
        self.assertEqual(self.files("mine"), {"p.csv"})
        for option in ("--digest", "--record"):
            self.refuses("one.meld", "--facts-out", "t/", option, "./t/x", says=[f"{option} and --facts-out both write into the folder t/"])
        # Files of other kinds may stay.
        (self.folder / "data/datapackage.json").unlink()
        self.write("data/notes.txt", "a user's")
        self.runs("one.meld", "--facts-out", "data/")
        self.runs("one.meld", "--facts-out", "data/")
        self.assertEqual(self.files("data"), {"datapackage.json", "notes.txt", "p.csv"})

    def test_json_and_facts_on_one_stream(self):
        for path in ("-", "/dev/stdout", "/dev/fd/1", "/proc/self/fd/1"):
            self.refuses("one.meld", "--json", "--facts-out", path, says=["--facts-out and --json both write to standard output"])
        with open(self.folder / "both.txt", "wb") as out:
            self.refuses("one.meld", "--json", "--facts-out", "both.txt", stdout=out, says=["both write to standard output"])
        self.assertEqual((self.folder / "both.txt").read_bytes(), b"")

    def test_python_says_what_it_cannot_read(self):
        self.runs("one.meld", "--facts-out", "text")
        (self.folder / "folder").mkdir()
        with h5py.File(self.folder / "other.h5", "w"):
            pass
        for name, says in (("text", "neither"), ("folder", "datapackage.json is missing"), ("other.h5", "its format is None")):
            with self.assertRaisesRegex(ValueError, says):
                claymeld.facts(self.folder / name)
        for text in ("[1, 2", "1 2", "}", "hello", '"a'):
            with self.assertRaises(ValueError):
                claymeld.value(text)


class Whole(Case):
    """Files are replaced as a whole, and a run that fails leaves what was there."""

    def test_full_disk(self):
        self.write("w.toml", WORLD.replace("5, 4, 3", "40, 40, 3"))
        self.runs("one.meld")
        self.write("f.h5", "old")
        self.refuses("one.meld", "--quiet", "--facts-out", "f.h5", says=["cannot write f.h5: File too large"], code=4,
                     preexec_fn=no_file_above(4096))
        self.assertEqual((self.folder / "f.h5").read_text(), "old")
        self.runs("one.meld", "--facts-out", "t/", "--ticks", "0")
        before = (self.folder / "t/p.csv").read_bytes()
        self.refuses("one.meld", "--quiet", "--facts-out", "t/", says=["cannot write t/p.csv: File too large"], code=4,
                     preexec_fn=no_file_above(4096))
        self.assertEqual((self.folder / "t/p.csv").read_bytes(), before)
        self.refuses("one.meld", "--quiet", "--facts-out", "new/", says=["cannot write new/p.csv"], code=4, preexec_fn=no_file_above(4096))
        self.assertEqual(self.files(), {*self.FILES, "f.h5", "t", "t/datapackage.json", "t/p.csv"})

    def test_second_run_is_refused(self):
        self.write("ever.meld", FOREVER)
        for path, lock in (("t/", "t/.p.csv.claymeld-lock"), ("f.h5", ".f.h5.claymeld-lock")):
            first = self.begin("meldsim", "run", "ever.meld", "--world", "w.toml", "--quiet", "--facts-out", path,
                               stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
            self.wait_for(lambda: (self.folder / lock).exists() and (self.folder / lock).read_text() == f"{first.pid}\n")
            self.refuses("one.meld", "--facts-out", path, says=[f"process {first.pid}", "still runs"])
            first.send_signal(signal.SIGINT)
            self.assertEqual(first.wait(60), 130)
            self.assertEqual(len(claymeld.facts(self.folder / path, "p")), 60)

    def test_modes_and_links_stay(self):
        (self.folder / "there").mkdir()
        for name in ("f.h5", "t/"):
            self.runs("one.meld", "--facts-out", name)
        for name, file in (("f.h5", "f.h5"), ("t/", "t/p.csv")):
            os.chmod(self.folder / file, 0o640)
            self.runs("one.meld", "--facts-out", name)
            self.assertEqual(oct(os.stat(self.folder / file).st_mode & 0o777), oct(0o640))
        (self.folder / "link.h5").symlink_to("there/real.h5")
        self.runs("one.meld", "--facts-out", "link.h5", "--sync")
        self.assertTrue((self.folder / "link.h5").is_symlink())
        self.assertEqual((self.folder / "there/real.h5").read_bytes(), (self.folder / "f.h5").read_bytes())

    def test_failed_run_has_its_last_good_tick(self):
        self.write("ever.meld", FOREVER)
        self.write("w.toml", WORLD + "[limits]\nmax_ticks = 7\n")
        for path in ("t/", "f.h5", "f.csv"):
            self.runs("ever.meld", "--facts-out", path, code=4)
        self.assertEqual(len(set(claymeld.facts(self.folder / "t", "p")["arg1"])), 1)
        pandas.testing.assert_frame_equal(claymeld.facts(self.folder / "t", "p"), claymeld.facts(self.folder / "f.h5", "p"))
        self.assertEqual((self.folder / "t/p.csv").read_bytes(), (self.folder / "f.csv").read_bytes())
        # One that ends in the middle of a tick writes none.
        self.write("fails.meld", "type p(node, int).\np(A, 10 / (2 - T)) :- tick(A, T).\n")
        self.runs("fails.meld", "--strict", "--facts-out", "new/", code=1)
        self.assertFalse((self.folder / "new").exists())


if __name__ == "__main__":
    main("meldsim")
