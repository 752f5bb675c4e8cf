#!/usr/bin/env python3
"""`meldsim replay`: a recording carries all that it takes to make its run again, and what is not the same is named.

Usage: replay_test.py --meldc FILE --meldsim FILE [TEST ...]
"""
import argparse
import json
import os
import shutil
import subprocess
import sys
import tempfile
import unittest
from pathlib import Path

import h5py
import numpy

# Every piece comes from another file: an include, a library folder, cells, and what the command line says.
FILES = {
    "work/main.meld": """include "parts/spread.meld".
use "count".
const step = 1.
type base(node, int).
base(A, @arg1 + step) :- source(A).
""",
    "work/parts/spread.meld": """type source(node).
type dist(node, min int D).
dist(A, 0) :- source(A).
dist(B, D + 1) :- neighbor(A, B), dist(A, D).
type linear coin(node, int).
coin(A, 0).
coin(A, N), dist(A, _), N < 20 -o coin(A, N + randint(3)), toss(A, N).
type toss(node, int).
""",
    "library/count.meld": """type known(node, max int).
known(A, N) :- toss(A, N).
""",
    "work/worlds/here.toml": """lattice = "cubic"
seed = 5
[[body]]
cells = "cells.csv"
[facts]
source = "id == 0"
[record]
every = 3
predicates = ["dist", "known", "base"]
[[event]]
tick = 7
take = { source = "id == 0" }
give = { source = "id == 29" }
""",
    "work/worlds/cells.csv": "".join(f"{x},{y},0\n" for x in range(6) for y in range(5)),
}
EXTERN = {
    "main.meld": """extern int twice(int).
type n(node, int).
n(A, twice(I)) :- id(A, I).
""",
    "main.toml": "lattice = \"square\"\n[[body]]\nshape = \"box(3, 3, 1)\"\n[record]\npredicates = [\"n\"]\n",
    "twice.c": "#include <meld/extern.h>\nint64_t twice(int64_t x) { return 2 * x; }\n",
}


class Replay(unittest.TestCase):
    def setUp(self):
        temporary = tempfile.TemporaryDirectory()
        self.addCleanup(temporary.cleanup)
        self.folder = Path(temporary.name)

    def write(self, files):
        for name, text in files.items():
            path = self.folder / name
            path.parent.mkdir(parents=True, exist_ok=True)
            path.write_text(text)

    def call(self, *arguments, folder=""):
        return subprocess.run([str(OPTIONS.meldsim), *map(str, arguments)], capture_output=True, text=True, cwd=self.folder / folder)

    def fine(self, *arguments, folder=""):
        done = self.call(*arguments, folder=folder)
        self.assertEqual(done.returncode, 0, done.stderr + done.stdout)
        return done.stdout

    def refused(self, code, *arguments):
        done = self.call("replay", *arguments)
        self.assertEqual(done.returncode, code, done.stderr + done.stdout)
        return done.stderr

    def record(self):
        """The run in pieces; returns the options that say what it is. The recording is run.vtkhdf, and its last tick the run's."""
        self.write(FILES)
        what = ("main.meld", "--world", "worlds/here.toml", "-I", "../library", "--arg", "40", "--set", "step=2", "--seed", "11")
        self.fine("run", *what, "--quiet", "--ticks", 40, "--record", self.folder / "run.vtkhdf", "--digest", self.folder / "digest",
                  folder="work")
        return what

    def change(self, change):
        """Changes what the recording says of its run."""
        with h5py.File(self.folder / "run.vtkhdf", "r+") as file:
            text = change(file["meld/provenance"].asstr()[()])
            del file["meld/provenance"]
            file["meld/provenance"] = numpy.bytes_(text.encode())

    def test_nothing_else_is_needed(self):
        what = self.record()
        self.fine("run", *what, "--quiet", "--ticks", 14, "--facts-out", self.folder / "facts", folder="work")
        for name in ("work", "library"):
            shutil.rmtree(self.folder / name)
        left = set(os.listdir(tempfile.gettempdir()))
        for processes in (1, 2, 3):
            answer = json.loads(self.fine("replay", "run.vtkhdf", "--json", "-n", processes, "--digest", "again"))
            self.assertEqual((answer["same"], answer["ticks"]), (True, 19))
            self.assertGreater(answer["steps"], 6)
            self.assertEqual((self.folder / "again").read_text(), (self.folder / "digest").read_text())
            # The state in a tick that is not recorded.
            self.fine("replay", "run.vtkhdf", "--quiet", "--to", 14, "--facts-out", "then", "-n", processes, "--threads", 2)
            self.assertEqual((self.folder / "then").read_text(), (self.folder / "facts").read_text())
        self.assertIn("replayed 19 ticks: all", self.fine("replay", "run.vtkhdf"))
        self.assertEqual([name for name in set(os.listdir(tempfile.gettempdir())) - left if name.startswith("claymeld-replay")], [])

    def test_code_is_named_by_its_hash(self):
        self.write(EXTERN)
        self.fine("run", "main.meld", "--quiet", "--link", "twice.c", "--record", "run.vtkhdf")
        self.fine("replay", "run.vtkhdf", "--quiet")
        shutil.move(self.folder / "twice.c", self.folder / "kept.c")
        self.write({"twice.c": EXTERN["twice.c"].replace("2", "3")})
        for given in ((), ("--link", "twice.c")):
            self.assertRegex(self.refused(2, "run.vtkhdf", *given), r"was made with /.*/twice\.c, .*its hash, [0-9a-f]{16}.*with --link")
        self.fine("replay", "run.vtkhdf", "--quiet", "--link", "kept.c", "-n", 2)

    def test_the_first_difference_is_named(self):
        self.record()
        shutil.copy(self.folder / "run.vtkhdf", self.folder / "whole")
        # Another program: from the event in tick 7 on, catoms hear of another source.
        self.change(lambda text: text.replace("id == 29", "id == 28"))
        for processes in (1, 2):
            message = self.refused(3, "run.vtkhdf", "-n", processes)
            self.assertRegex(message, r"tick 9 is not as it was recorded: catom @\d+; .*dist: .* now, .* in run.vtkhdf")
            answer = json.loads(self.call("replay", "run.vtkhdf", "--json", "--quiet", "-n", processes).stdout)
            self.assertEqual((answer["same"], answer["tick"]), (False, 9))
            self.assertEqual(answer["differences"][-1]["what"], "dist")
        # Before it, only what the recording says of the world.
        self.assertIn("the run is not as it was recorded; the world", self.refused(3, "run.vtkhdf", "--to", 6))
        # The state is the same, and a column is not.
        shutil.copy(self.folder / "whole", self.folder / "run.vtkhdf")
        with h5py.File(self.folder / "run.vtkhdf", "r+") as file:
            file["VTKHDF/PointData/dist"][int(file["VTKHDF/Steps/PointDataOffsets/dist"][2]) + 4] += 1
        self.assertRegex(self.refused(3, "run.vtkhdf"),
                         r"tick 6 is not as it was recorded: catom @4; dist: .*, 4\) now, .*, 5\) in run.vtkhdf")
        # The columns are the same, and the state is not.
        shutil.copy(self.folder / "whole", self.folder / "run.vtkhdf")
        with h5py.File(self.folder / "run.vtkhdf", "r+") as file:
            file["VTKHDF/Steps/StateDigestLow"][4] += 1
        self.assertIn("tick 12 is not as it was recorded; what differs is not recorded", self.refused(3, "run.vtkhdf"))

    def test_what_cannot_be_replayed(self):
        self.record()
        self.assertIn("ends with tick 19, before tick 41", self.refused(2, "run.vtkhdf", "--to", 41))
        whole = (self.folder / "run.vtkhdf").read_bytes()
        for change, message in ((lambda text: text.replace('"version":"', '"version":"9'), "is of version 9"),
                                (lambda text: text[:100], "is damaged"),
                                (lambda text: text.replace("parts/spread.meld", "/tmp/spread.meld"), "cannot be placed"),
                                (lambda text: "", "does not say how its run is made again")):
            (self.folder / "run.vtkhdf").write_bytes(whole)
            self.change(change)
            for processes in (1, 2):
                self.assertIn(message, self.refused(6, "run.vtkhdf", "-n", processes))
        with h5py.File(self.folder / "foreign.h5", "w") as file:
            file["numbers"] = [1, 2, 3]
        self.assertIn("is no recording of meldsim", self.refused(6, "foreign.h5"))
        (self.folder / "short").write_bytes(whole[: len(whole) // 2])
        self.refused(6, "short")
        self.refused(2, "missing.vtkhdf")


def main():
    global OPTIONS
    parser = argparse.ArgumentParser()
    for tool in ("meldc", "meldsim"):
        parser.add_argument(f"--{tool}", required=True, type=Path)
    OPTIONS, rest = parser.parse_known_args()
    os.environ.update(OMPI_ALLOW_RUN_AS_ROOT="1", OMPI_ALLOW_RUN_AS_ROOT_CONFIRM="1", OMPI_MCA_rmaps_base_oversubscribe="1")
    unittest.main(argv=[sys.argv[0], *rest])


if __name__ == "__main__":
    main()
