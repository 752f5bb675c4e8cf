"""`meldsim replay`: a recording carries all that it takes to make its run again, and what is not the same is named.

    replay_test.py --meldc PATH --meldsim PATH [unittest options]
"""
import json
import os
import pathlib
import pty
import shutil
import signal
import subprocess
import sys
import time
import unittest.mock

import h5py
import numpy

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1]))

from frame import Case, main  # noqa: E402

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


class Replay(Case):
    def replay(self, *arguments, code=0):
        return self.call("meldsim", "replay", *arguments, code=code)[0]

    def refuses(self, *arguments, code, says):
        return self.refused("meldsim", "replay", *arguments, code=code, says=says)

    def write_all(self, files):
        for name, text in files.items():
            self.write(name, text)

    def record(self):
        """The run in pieces; returns the options that say what it is. The recording is run.vtkhdf, and its last tick the run's."""
        self.write_all(FILES)
        what = ("main.meld", "--world", "worlds/here.toml", "-I", "../library", "--arg", "40", "--set", "step=2", "--seed", "11")
        self.call("meldsim", "run", *what, "--quiet", "--ticks", 40, "--record", self.folder / "run.vtkhdf",
                  "--digest", self.folder / "digest", cwd=self.folder / "work")
        return what

    def change(self, change):
        """Changes what the recording says of its run."""
        with h5py.File(self.folder / "run.vtkhdf", "r+") as file:
            text = change(file["meld/provenance"].asstr()[()])
            del file["meld/provenance"]
            file["meld/provenance"] = numpy.bytes_(text.encode())

    def test_nothing_else_is_needed(self):
        what = self.record()
        self.call("meldsim", "run", *what, "--quiet", "--ticks", 14, "--facts-out", self.folder / "facts", cwd=self.folder / "work")
        for name in ("work", "library"):
            shutil.rmtree(self.folder / name)
        (self.folder / "passing").mkdir()
        self.enterContext(unittest.mock.patch.dict(os.environ, TMPDIR=str(self.folder / "passing")))
        for processes in (1, 2, 3):
            answer = json.loads(self.replay("run.vtkhdf", "--json", "-n", processes, "--digest", "again"))
            self.assertEqual((answer["same"], answer["ticks"]), (True, 19))
            self.assertGreater(answer["steps"], 6)
            self.assertEqual(self.read("again"), self.read("digest"))
            # The state in a tick that is not recorded.
            self.replay("run.vtkhdf", "--quiet", "--to", 14, "--facts-out", "then", "-n", processes, "--threads", 2)
            self.assertEqual(self.read("then"), self.read("facts"))
        self.assertIn("replayed 19 ticks: all", self.replay("run.vtkhdf"))
        self.assertEqual([name for name in self.files("passing") if name.startswith("claymeld-replay")], [])

    def test_a_run_that_was_counted(self):
        """It is the same run whether it is counted or not."""
        what = self.record()
        self.call("meldsim", "run", *what, "--quiet", "--ticks", 9, "--stats", "--record", self.folder / "run.vtkhdf",
                  cwd=self.folder / "work")
        self.assertIn("the same", self.replay("run.vtkhdf"))

    def test_the_graph_of_the_links_of_the_program(self):
        """There facts reach any node, which no file says."""
        self.write("own.meld", "type route edge(node, node).\ntype linear letter(node, node).\ntype got(node, node).\n"
                               "edge(@0, @1). edge(@1, @2). edge(@2, @3).\nletter(@0, @3).\nletter(A, B) -o got(B, A).\n")
        for text in (None, "[limits]\nmax_ticks = 50\n", '[network]\nkind = "latency"\nmost = 2\n'):
            if text is not None:
                self.write("some.toml", text)
            self.call("meldsim", "run", "own.meld", *(("--world", "some.toml") if text else ()), "--quiet", "--record", "run.vtkhdf")
            self.assertIn("the same", self.replay("run.vtkhdf"))

    def test_code_is_named_by_its_hash(self):
        self.write_all(EXTERN)
        self.call("meldsim", "run", "main.meld", "--quiet", "--link", "twice.c", "--record", "run.vtkhdf")
        self.replay("run.vtkhdf", "--quiet")
        shutil.move(self.folder / "twice.c", self.folder / "kept.c")
        self.write("twice.c", EXTERN["twice.c"].replace("2", "3"))
        for given in ((), ("--link", "twice.c")):
            message = self.refuses("run.vtkhdf", *given, code=2, says="was made with")
            self.assertRegex(message, r"was made with /.*/twice\.c, .*its hash, [0-9a-f]{16}.*with --link")
        self.replay("run.vtkhdf", "--quiet", "--link", "kept.c", "-n", 2)

    def test_the_first_difference_is_named(self):
        self.record()
        shutil.copy(self.folder / "run.vtkhdf", self.folder / "whole")
        # Another program: from the event in tick 7 on, catoms hear of another source.
        self.change(lambda text: text.replace("id == 29", "id == 28"))
        for processes in (1, 2):
            message = self.refuses("run.vtkhdf", "-n", processes, code=3, says="is not as it was recorded")
            self.assertRegex(message, r"tick 9 is not as it was recorded: catom @\d+; .*dist: .* now, .* in run.vtkhdf")
            answer = json.loads(self.replay("run.vtkhdf", "--json", "--quiet", "-n", processes, code=3))
            self.assertEqual((answer["same"], answer["tick"]), (False, 9))
            self.assertEqual(answer["differences"][-1]["what"], "dist")
        # Before it, only what the recording says of the world.
        self.refuses("run.vtkhdf", "--to", 6, code=3, says="the run is not as it was recorded; the world")
        # The state is the same, and a column is not.
        shutil.copy(self.folder / "whole", self.folder / "run.vtkhdf")
        with h5py.File(self.folder / "run.vtkhdf", "r+") as file:
            file["VTKHDF/PointData/dist"][int(file["VTKHDF/Steps/PointDataOffsets/dist"][2]) + 4] += 1
        self.assertRegex(self.refuses("run.vtkhdf", code=3, says="is not as it was recorded"),
                         r"tick 6 is not as it was recorded: catom @4; dist: .*, 4\) now, .*, 5\) in run.vtkhdf")
        # The columns are the same, and the state is not.
        shutil.copy(self.folder / "whole", self.folder / "run.vtkhdf")
        with h5py.File(self.folder / "run.vtkhdf", "r+") as file:
            file["VTKHDF/Steps/StateDigestLow"][4] += 1
        self.refuses("run.vtkhdf", code=3, says="tick 12 is not as it was recorded; what differs is not recorded")

    def test_a_run_that_ends_early_is_another(self):
        """Also where no recorded step is left that could differ."""
        self.write_all({"ends.meld": "extern int ends(int).\ntype clock(node, int).\nclock(A, T) :- tick(A, T).\n"
                                 "stop-program(A) :- clock(A, T), ends(T) > 0.\n",
                    "ends.c": "#include <meld/extern.h>\n#include <unistd.h>\n"
                              "int64_t ends(int64_t tick) { return tick >= 30 && access(\"now\", F_OK) == 0; }\n",
                    "ends.toml": "lattice = \"square\"\n[[body]]\nshape = \"box(3, 3, 1)\"\n[record]\nevery = 50\n"})
        self.call("meldsim", "run", "ends.meld", "--quiet", "--link", "ends.c", "--ticks", 100, "--record", "run.vtkhdf")
        self.assertIn("replayed 100 ticks: all 3 recorded steps are the same", self.replay("run.vtkhdf"))
        self.assertIn("replayed 20 ticks: the only recorded step is the same", self.replay("run.vtkhdf", "--to", 20))
        self.write_all({"now": ""})
        for processes in (1, 2):
            self.refuses("run.vtkhdf", "-n", processes, code=3,
                         says="is not as it was recorded; the last tick: 30 now, at least 100 in run.vtkhdf")
        answer = json.loads(self.replay("run.vtkhdf", "--json", "--quiet", "--to", 40, code=3))
        self.assertEqual((answer["same"], answer["tick"]), (False, 30))
        self.assertEqual(answer["differences"], [{"what": "the last tick", "recorded": ["at least 40"], "now": ["30"]}])

    def test_a_module_that_was_compiled_beforehand(self):
        """It carries its sources, but not where they were found, nor what was linked into it."""
        self.write_all({"program/main.meld": "include \"deep/n.meld\".\nuse \"count\".\nextern int twice(int).\n"
                                         "n(A, twice(I)) :- id(A, I).\nknown(A, N) :- n(A, N).\n",
                    "one/deep/n.meld": "include \"own.meld\".\ntype n(node, int).\n", "one/deep/own.meld": "type own(node).\n",
                    "two/count.meld": "type known(node, max int).\n", "code/twice.c": EXTERN["twice.c"], "main.toml": EXTERN["main.toml"]})
        self.call("meldc", "compile", "program/main.meld", "-I", "one", "-I", "two", "--link", "code/twice.c", "-o", "main.so")
        self.call("meldsim", "run", "main.so", "--world", "main.toml", "--quiet", "--record", "run.vtkhdf")
        for name in ("program", "one", "two"):
            shutil.rmtree(self.folder / name)
        self.assertIn("--link", self.call("meldsim", "replay", "run.vtkhdf", code=1)[1])
        for processes in (1, 2):
            self.replay("run.vtkhdf", "--link", "code/twice.c", "-n", processes)
        self.write_all({"thrice.c": EXTERN["twice.c"].replace("2", "3")})
        self.refuses("run.vtkhdf", "--link", "thrice.c", code=3,
                     says="tick 1 is not as it was recorded: catom @1; n: n(@1, 3) now, n(@1, 2) in run.vtkhdf")

    def test_the_recording_is_only_read(self):
        self.record()
        whole = self.read("run.vtkhdf")
        for option in ("--digest", "--facts-out"):
            self.refuses("run.vtkhdf", option, "./run.vtkhdf", code=2, says=f"the recording and {option} are the same file")
        self.assertEqual(self.read("run.vtkhdf"), whole)

    def test_quiet_on_a_terminal(self):
        self.record()
        for options, silent in ((("--quiet",), True), ((), False)):
            terminal, end = pty.openpty()
            with open(terminal, "rb", buffering=0) as shown:
                self.call("meldsim", "replay", "run.vtkhdf", *options, stdout=subprocess.DEVNULL, stderr=end)
                os.write(end, b"the end")
                os.close(end)
                text = b""
                while not text.endswith(b"the end"):
                    text += shown.read(4096)
                self.assertEqual(text == b"the end", silent, text)

    def test_an_interrupted_replay_leaves_nothing(self):
        self.write_all({"slow.meld": "include \"parts/clock.meld\".\nextern int slow(int).\ntype seen(node, int).\n"
                                 "seen(@0, slow(T)) :- clock(@0, T).\n",
                    "parts/clock.meld": "type clock(node, int).\nclock(A, T) :- tick(A, T).\n",
                    "slow.c": "#include <meld/extern.h>\n#include <unistd.h>\n"
                              "int64_t slow(int64_t tick) { if (access(\"now\", F_OK) == 0) usleep(tick < 6 ? 20000 : 9000000);"
                              " return tick; }\n",
                    "slow.toml": "lattice = \"square\"\n[[body]]\nshape = \"box(3, 3, 1)\"\n"})
        self.call("meldsim", "run", "slow.meld", "--quiet", "--link", "slow.c", "--ticks", 9, "--record", "run.vtkhdf")
        self.write_all({"now": ""})
        (self.folder / "tmp").mkdir()

        def left():
            return [path.name for path in (self.folder / "tmp").rglob("*") if not str(path).startswith(f"{self.folder}/tmp/ompi")]

        def interrupted(signals, until, *options):
            run = self.begin("meldsim", "replay", "run.vtkhdf", *options, environment={"TMPDIR": self.folder / "tmp"},
                             stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
            self.wait_for(lambda: until(left()), run)
            for each in signals:
                run.send_signal(each)
                time.sleep(0.1)
            out, err = run.communicate(timeout=60)
            self.assertEqual(left(), [], err)
            return run.returncode, out, err

        def began(names):
            return any(name.startswith("claymeld-replay") for name in names)

        def ticks(names, last=1):
            return (self.folder / "d").exists() and f"tick {last} " in (self.folder / "d").read_text()

        def in_a_long_tick(names):
            return ticks(names, 5)

        # Before it handles them; between two ticks; in a tick that takes longer than anybody waits.
        for processes, signals, until, ended in ((1, [signal.SIGTERM], began, 143), (1, [signal.SIGINT], ticks, 130),
                                                 (2, [signal.SIGINT], ticks, 130), (1, [signal.SIGINT], in_a_long_tick, 130),
                                                 (1, [signal.SIGTERM] * 2, in_a_long_tick, 143),
                                                 (2, [signal.SIGTERM] * 2, in_a_long_tick, 143)):
            with self.subTest(processes=processes, signals=signals, until=until.__name__):
                (self.folder / "d").unlink(missing_ok=True)
                code, out, err = interrupted(signals, until, "-n", processes, "--digest", "d", "--json")
                self.assertEqual((code, out), (ended, ""), err)
                if until == ticks:
                    self.assertRegex(err, r"^meldsim: interrupted after tick \d+\n$")

    def test_what_cannot_be_replayed(self):
        self.record()
        self.refuses("run.vtkhdf", "--to", 41, code=2, says="ends with tick 19, before tick 41")
        whole = self.read("run.vtkhdf")
        for change, message in ((lambda text: text.replace('"version":"', '"version":"9'), "is of version 9"),
                                (lambda text: text[:100], "is damaged"),
                                (lambda text: text.replace("parts/spread.meld", "/tmp/spread.meld"), "cannot be placed"),
                                (lambda text: "", "does not say how its run is made again")):
            self.write("run.vtkhdf", whole)
            self.change(change)
            for processes in (1, 2):
                self.refuses("run.vtkhdf", "-n", processes, code=6, says=message)
        with h5py.File(self.folder / "foreign.h5", "w") as file:
            file["numbers"] = [1, 2, 3]
        self.refuses("foreign.h5", code=6, says="is no recording of meldsim")
        self.write("short", whole[: len(whole) // 2])
        self.refuses("short", code=6, says="short")
        self.refuses("missing.vtkhdf", code=2, says="missing.vtkhdf")


if __name__ == "__main__":
    main("meldc", "meldsim")
