"""Recordings of many catoms, of which few change in most steps: changes_test.py --meldc PATH --meldsim PATH [unittest options]

Their steps hold changes alone. However they came about and whoever reads them, they are what recordings with whole steps are.
"""

import os
import pathlib
import sys

import h5py

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1]))

import resume_test  # noqa: E402
from frame import Case, main  # noqa: E402

import claymeld  # noqa: E402

# A front with colours, labels and lines, a token, and for a while more news than a quarter of all.
PROGRAM = """
type source(node).
type dist(node, min int D).
type linear token(node).
type lit(node).
type all(node).
dist(A, 0)          :- source(A).
dist(B, D + 1)      :- neighbor(A, B), dist(A, D).
token(@0).
token(A), neighbor(A, B), B > A -o token(B), drawLine(A, B).
lit(A)              :- all(A).
setColor2(A, D)     :- dist(A, D), D % 7 = 0.
setLabel(A, "near") :- dist(A, 3).
"""
WORLD = """lattice = "cubic"
[[body]]
shape = "box(42, 42, 40)"
[facts]
source = "id == 0"
[[event]]
tick = 20
give = { all = "id % 3 == 0" }
[record]
every = 1
predicates = ["dist", "token", "lit"]
"""
TICKS = 60
RUN = ("run", "p.meld", "--world", "w.toml", "--quiet", "--record", "r.vtkhdf")
DAMAGED = 6


def ticks_of(table):
    return [int(tick) for tick in table["Values"][: table.attrs["NSteps"]]]


class Changes(Case):
    FILES = {"p.meld": PROGRAM, "w.toml": WORLD}

    def check_same(self, found, wanted, but=()):
        """Names what differs: all of it would be megabytes."""
        names = [name for name in {*found, *wanted} if found.get(name) != wanted.get(name) and name not in but]
        self.assertFalse(names)

    def record(self, *options, ticks=TICKS):
        self.call("meldsim", *RUN, "--ticks", ticks, *options)
        return resume_test.recorded(self.folder / "r.vtkhdf")

    def test_any_number_of_processes_and_threads(self):
        wanted = self.record()
        with h5py.File(self.folder / "r.vtkhdf") as file:
            whole, changes = ticks_of(file["VTKHDF/Steps"]), ticks_of(file["meld/changes/Steps"])
        self.assertEqual(sorted(whole + changes), list(range(TICKS + 1)))
        # The first step, that in which many are lit, and those before which changes had become more than an array.
        self.assertIn(0, whole)
        self.assertIn(20, {*whole, *(tick - 1 for tick in whole)})
        self.assertLess(len(whole), 12)
        for processes, threads in ((1, 2), (2, 1), (3, 2)):
            with self.subTest(processes=processes, threads=threads):
                self.check_same(self.record("-n", processes, "--threads", threads), wanted)
        # And after a stop.
        self.call("meldsim", *RUN, "--ticks", 31, "--checkpoint", "kept")
        self.call("meldsim", "resume", "kept", "--quiet", "--ticks", TICKS, "-n", 2)
        self.check_same(resume_test.recorded(self.folder / "r.vtkhdf"), wanted)

    def test_a_copy_in_which_all_steps_are_whole(self):
        self.record()
        out, _ = self.call("meldsim", "export", "r.vtkhdf", "-o", "whole.vtkhdf")
        self.assertEqual(out, f"whole.vtkhdf: {TICKS + 1} steps, all of them whole\n")
        with h5py.File(self.folder / "whole.vtkhdf") as file:
            self.assertEqual(ticks_of(file["VTKHDF/Steps"]), list(range(TICKS + 1)))
            self.assertEqual(file["meld"].attrs["version"], 1)
            self.assertNotIn("changes", file["meld"])
        with h5py.File(self.folder / "r.vtkhdf") as file:
            self.assertEqual(file["meld"].attrs["version"], 2)
        # Every reader finds the same in both.
        self.assertEqual(self.call("meldsim", "diff", "r.vtkhdf", "whole.vtkhdf"), ("", ""))
        with claymeld.open(self.folder / "r.vtkhdf") as changes, claymeld.open(self.folder / "whole.vtkhdf") as whole:
            self.assertEqual(changes.ticks.tolist(), whole.ticks.tolist())
            for tick in (0, 1, 2, 19, 20, 21, 22, 40, TICKS):
                self.assertTrue(changes.frame(tick).equals(whole.frame(tick)), tick)
                for predicate in ("dist", "token", "lit"):
                    self.assertTrue(changes.facts(predicate, tick).equals(whole.facts(predicate, tick)), (predicate, tick))
        for name in ("r", "whole"):
            self.call("meldsim", "shot", f"{name}.vtkhdf", "--steps", "--tick", "17,41", "-o", f"{name}.png", "--size", "200x200",
                      "--quiet")
        self.assertEqual(self.read("r.png"), self.read("whole.png"))
        for name in ("r", "whole"):
            self.assertIn("all 61 recorded steps are the same", self.call("meldsim", "replay", f"{name}.vtkhdf")[0])
        out, _ = self.call("meldsim", "export", "whole.vtkhdf", "-o", "again.vtkhdf", "--json")
        self.assertEqual(out, f'{{"file":"again.vtkhdf","ticks":{list(range(TICKS + 1))}}}\n'.replace(", ", ","))
        # The sidecars name their files.
        copies = [resume_test.recorded(self.folder / f"{name}.vtkhdf") for name in ("again", "whole")]
        self.check_same(*copies, but=(".xdmf", ".lines.xdmf"))

    def test_what_cannot_be_copied(self):
        self.record(ticks=2)
        for command, code, says in (
            (("p.meld", "-o", "a.vtkhdf"), 2, ["p.meld is not a recording", "meldsim run --record"]),
            (("r.vtkhdf", "-o", "a.vtkhdf", "--tick", "1"), 2, ["--tick: a .vtkhdf file is a copy of the whole recording", "Leave it out"]),
            (("r.vtkhdf", "-o", "a.vtkhdf", "--only", "token(A)"), 2, ["--only: a .vtkhdf file is a copy"]),
            (("none.vtkhdf", "-o", "a.vtkhdf"), 2, ["none.vtkhdf"]),
        ):
            with self.subTest(command=command):
                self.refused("meldsim", "export", *command, code=code, says=says)
                self.assertFalse((self.folder / "a.vtkhdf").exists())

    def test_damaged_changes(self):
        self.record(ticks=8)
        whole = self.read("r.vtkhdf")
        place = "meld/changes"
        for name, damage in (
            ("a row that is not there", lambda file: file[f"{place}/PointData/dist/row"].__setitem__(0, 1 << 40)),
            ("a negative row", lambda file: file[f"{place}/PointData/dist/row"].__setitem__(0, -1)),
            ("too many", lambda file: file[f"{place}/Steps/PointDataChanges/dist"].__setitem__(3, [0, 1 << 60])),
            ("backwards", lambda file: file[f"{place}/Steps/PointDataChanges/dist"].__setitem__(3, [5, 2])),
            ("no values", lambda file: file[f"{place}/PointData/dist"].__delitem__("value")),
        ):
            with self.subTest(name):
                self.write("b.vtkhdf", whole)
                with h5py.File(self.folder / "b.vtkhdf", "r+") as file:
                    damage(file)
                out, err = self.call("meldsim", "export", "b.vtkhdf", "-o", "a.vtkhdf", code=DAMAGED)
                self.assertIn("cannot read b.vtkhdf: ", out + err)
                with claymeld.open(self.folder / "b.vtkhdf") as recording, self.assertRaises(claymeld.RecordingError):
                    for tick in recording.ticks.tolist():
                        recording.facts("dist", tick)


if __name__ == "__main__":
    os.environ["CLAYMELD_MELDSIM"] = sys.argv[sys.argv.index("--meldsim") + 1]
    main("meldc", "meldsim")
