"""What `meldsim sweep` makes of a study: sweep_test.py --meldc PATH --meldsim PATH [unittest options]"""

import csv
import html
import html.parser
import json
import os
import pathlib
import re
import resource
import shlex
import signal
import socket
import sqlite3
import subprocess
import sys
import time
import xml.etree.ElementTree

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1]))
sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1] / "view"))

import frame  # noqa: E402
from frame import FOREVER, FRONT, main, square, words_of  # noqa: E402
from running import children  # noqa: E402
from websocket import Page  # noqa: E402

FINE, USAGE, FAILED = 0, 2, 3
# A front that does not go further than `reach`; and another program with the same predicates, which has no such constant.
FLOOD = "const reach = 100.\n" + FRONT.replace("dist(A, D).", "dist(A, D), D < reach.")
RING = """
seeds = 2

[world]
lattice = "graph"
graph = "ring({n})"

[set]
n = [10, 20]
reach = [3, 100]
"""
STUDY = 'program = "flood.meld"\n' + RING


class Case(frame.Case):
    FILES = {"flood.meld": FLOOD, "plain.meld": FRONT, "study.toml": STUDY, "square.toml": square(3)}

    def sweep(self, *options, code=FINE, study="study.toml"):
        return self.call("meldsim", "sweep", study, *options, code=code)

    def rows(self, *options, code=FINE, study="study.toml"):
        """The table, as its file of CSV has it, after a sweep."""
        self.sweep("--quiet", *options, code=code, study=study)
        with open(self.folder / study.replace(".toml", ".results") / "rows.csv", newline="") as file:
            return list(csv.DictReader(file))

    def made(self, study="study.toml", code=FINE):
        """How many runs a sweep makes now."""
        return int(self.sweep(study=study, code=code)[0].split(": ")[1].split()[0])


class Rows(Case):
    def test_the_product(self):
        rows = self.rows()
        found = [(row["n"], row["reach"], row["seed"]) for row in rows]
        self.assertEqual(found, [(n, reach, seed) for n in ("10", "20") for reach in ("3", "100") for seed in ("1", "2")])
        self.assertEqual([row["row"] for row in rows], [str(i) for i in range(1, 9)])
        self.assertEqual(len({row["key"] for row in rows}), 8)
        self.assertEqual({row["status"] for row in rows}, {"fine"})

    def test_a_row_is_the_run_of_its_command(self):
        for row in self.rows():
            command = shlex.split(self.sweep("--show", row["row"], "--print")[0].splitlines()[0])
            self.assertEqual(command[:2], ["meldsim", "run"])
            out, _ = self.call("meldsim", *command[1:], "--digest", "digests", "--json")
            self.assertEqual((self.folder / "digests").read_text().split()[-1], row["digest"])
            self.assertEqual(json.loads(out)["ticks"], int(row["ticks"]))

    def test_a_row_is_shown_in_the_viewer(self):
        """Forward and back, as it was, whatever it is expected to be."""
        self.write("study.toml", STUDY + '[expect]\nall = "count : { dist(A, _) } = @world"\n[measure]\nrounds = "ticks"\n')
        row = self.rows(code=FAILED)[4]
        viewer = self.begin("meldsim", "sweep", "study.toml", "--show", row["row"], "--no-open", stdout=subprocess.PIPE, text=True)
        self.assertRegex(viewer.stdout.readline(), "^row 5: expect all: ")
        link = re.fullmatch(r"flood\.meld is shown at (http://\S+)\n", viewer.stdout.readline())[1]
        with Page(link) as page:
            hello, _ = page.ask("hello")
            self.assertEqual((hello["program"], hello["catoms"], hello["tick"], hello["live"]), ("flood.meld", int(row["n"]), 0, True))
            self.assertEqual(page.ask("command", line="run")[0]["answer"]["tick"], int(row["rounds"]))
            found = page.ask("command", line="query dist(A, D)")[0]["answer"]["rows"]
            self.assertEqual(max(found_row[1] for found_row in found), int(row["reach"]))
            self.assertEqual(page.ask("command", line="to 1")[0]["tick"], 1)
        viewer.send_signal(signal.SIGINT)
        viewer.communicate(timeout=30)
        self.assertEqual(viewer.returncode, 130)
        out, _ = self.sweep("--show", 5, "--no-open", "--for", 0.2, "--quiet")
        self.assertRegex(out, r"^flood\.meld is shown at http://\S+\n$")
        for wrong in (["--print"], ["--no-open"], ["--for", 1]):
            self.assertIn("requires --show", self.sweep(*wrong, code=USAGE)[1])

    def test_threads_and_jobs_do_not_matter(self):
        self.write("two.toml", "threads = 2\n" + STUDY)
        digests = [[(row["key"], row["digest"], row["messages"]) for row in self.rows(*options, study=study)]
                   for study, options in (("study.toml", ["--jobs", 1]), ("two.toml", ["--jobs", 3]))]
        self.assertEqual(*digests)

    def test_variants_and_worlds(self):
        """A parameter multiplies only the rows that it concerns."""
        self.write("study.toml", """
            worlds = { small = "square.toml", ring = "ring.toml" }
            [program]
            limited = "flood.meld"
            plain = "plain.meld"
            [set]
            reach = [1, 2]
            n = [4, 6, 8]
            """)
        self.write("ring.toml", 'lattice = "graph"\ngraph = "ring({n})"\n')
        found = [(row["program"], row["world"], row["reach"], row["n"]) for row in self.rows()]
        self.assertEqual(found, [("limited", "small", r, "") for r in "12"] + [("limited", "ring", r, n) for r in "12" for n in "468"]
                         + [("plain", "small", "", "")] + [("plain", "ring", "", n) for n in "468"])

    def test_keys_of_the_world(self):
        self.write("study.toml", """
            program = "plain.meld"
            worlds = ["square.toml"]
            [set]
            network = [{ kind = "ideal" }, { kind = "latency", least = 3, most = 3 }]
            "limits.max_ticks" = 100
            """)
        ideal, slow = self.rows()
        self.assertLess(int(ideal["ticks"]), int(slow["ticks"]))
        self.assertIn("latency", slow["network"])

    def test_files_that_a_world_names(self):
        """They are found from the world that names them, and a change of one makes its rows anew."""
        (self.folder / "worlds").mkdir()
        self.write("worlds/listed.toml", 'lattice = "square"\n[[body]]\ncells = "cells.csv"\n')
        self.write("worlds/cells.csv", "0,0,0\n1,0,0\n")
        self.write("study.toml", 'program = "plain.meld"\nworlds = ["worlds/listed.toml"]\n[set]\n"limits.max_ticks" = [50, 60]\n'
                                 '[measure]\nsize = "catoms"\n')
        self.assertEqual([row["size"] for row in self.rows()], ["2", "2"])
        self.write("worlds/cells.csv", "0,0,0\n1,0,0\n2,0,0\n")
        self.assertEqual([row["size"] for row in self.rows()], ["3", "3"])

    def test_the_files(self):
        rows = self.rows()
        database = sqlite3.connect(self.folder / "study.results" / "rows.sqlite")
        self.addCleanup(database.close)
        names = [column[1] for column in database.execute("PRAGMA table_info(rows)")]
        self.assertEqual(names, list(rows[0]))
        stored = [{name: "" if cell is None else str(cell) for name, cell in zip(names, row)}
                  for row in database.execute("SELECT * FROM rows")]
        for one in (*rows, *stored):
            one["seconds"] = float(one["seconds"])
        self.assertEqual(stored, rows)
        self.assertEqual(database.execute("SELECT typeof(n), typeof(digest) FROM rows").fetchone(), ("integer", "text"))
        self.assertEqual(database.execute("SELECT value FROM study WHERE name = 'study'").fetchone(), (STUDY,))

    def test_the_table(self):
        self.write("study.toml", STUDY + '[measure]\nfar = "max D : { dist(A, D) }"\n')
        self.assertEqual([line.split() for line in self.sweep("--table")[0].splitlines()],
                         [["n", "reach", "runs", "failed", "far"], ["10", "3", "2", "0", "3"], ["10", "100", "2", "0", "5"],
                          ["20", "3", "2", "0", "3"], ["20", "100", "2", "0", "10"]])


class Figures(Case):
    TWO = """
        program = { a = "plain.meld", b = "flood.meld" }
        seeds = 6
        [world]
        lattice = "graph"
        graph = "ring({n})"
        [set]
        n = [10, 100, 200]
        [measure]
        far = "max D : { dist(A, D) }"
        """

    def test_the_fit(self):
        self.write("study.toml", STUDY.replace("reach = [3, 100]", "reach = [100]") + '[measure]\nsize = "catoms"\n')
        out = self.sweep("--plot", "size~n")[0]
        self.assertEqual(out, "size ~ n: exponent 1, 95% confidence 1 to 1\nplot: study.results/size-n.svg\n")
        root = xml.etree.ElementTree.parse(self.folder / "study.results" / "size-n.svg").getroot()
        self.assertTrue(root.tag.endswith("}svg"))
        # A point and a line for each n, an axis, a grid and letters.
        self.assertGreater(len(list(root.iter())), 20)
        # The band has two corners for each n, and no other.
        band = next(each.get("d") for each in root.iter() if "fill-opacity:0.2" in each.get("style", ""))
        corners = set(re.findall(r"[ML] (\S+) \S+", band))
        self.assertEqual(len(corners), 2, band)
        self.sweep("--plot", "size~n", "--image", "size.png")
        self.assertEqual(self.read("size.png")[:8], b"\x89PNG\r\n\x1a\n")

    def test_the_paired_test(self):
        self.write("study.toml", self.TWO)
        self.write("flood.meld", FLOOD.replace("= 100.", "= 4."))
        lines = self.sweep("--plot", "far~n")[0].splitlines()
        # 5 - 4, 50 - 4 and 100 - 4, six times each; all of one sign, so the chance is 2 / 2^18.
        self.assertEqual(lines[2], "far: a minus b in 18 pairs: median 46, signed-rank test p = 7.6e-06")

    def test_lines_for_some_columns_alone(self):
        """And a measure along the axis: here n and reach are pooled, as a front gets n / 2 far at most."""
        self.write("study.toml", self.TWO.replace("far =", 'size = "catoms"\nfar =').replace("[set]", "[set]\nreach = [100, 200]"))
        out = self.sweep("--plot", "far~size|program")[0].splitlines()
        self.assertEqual(out[:2], [f"far ~ size, {name}: exponent 1, 95% confidence 1 to 1" for name in "ab"])
        self.assertEqual(out[-1], "plot: study.results/far-size-program.svg")
        out = self.sweep("--plot", "far~size|program,reach")[0].splitlines()
        self.assertEqual([line.split(":")[0] for line in out[:3]],
                         ["far ~ size, a, -", "far ~ size, b, reach = 100", "far ~ size, b, reach = 200"])
        self.assertIn("no column 'wrold'. did you mean 'world'?", self.sweep("--plot", "far~size|wrold", code=USAGE)[1])

    def test_rows_that_failed(self):
        """They are in no median and in no plot, and that is said."""
        self.write("study.toml", STUDY.replace("seeds = 2", "seeds = [1, 2, 3, 4]") + """
            [measure]
            far = "max D : { dist(A, D) }"
            [expect]
            near = "max D : { dist(A, D) } < 10"
            """)
        rows = [line.split() for line in self.sweep("--table", code=FAILED)[0].splitlines()]
        self.assertEqual(rows[1:], [["10", "3", "4", "0", "3"], ["10", "100", "4", "0", "5"], ["20", "3", "4", "0", "3"],
                                    ["20", "100", "4", "4", "-"]])
        out = self.sweep("--plot", "far~n", code=FAILED)[0].splitlines()
        self.assertEqual(out[1:3], ["far ~ n, reach = 100: no exponent, since there are not three rows at two places",
                                    "far ~ n without 4 rows that failed"])

    def test_mistakes(self):
        for options, said in ((["--plot", "tikcs~n"], "the table has no column 'tikcs'. did you mean 'ticks'?"),
                              (["--plot", "ticks"], "Write --plot rounds~n"),
                              (["--plot", "ticks~status"], "no row that is fine has numbers in both columns"),
                              (["--plot", "ticks~n", "--image", "x.gif"], "neither .svg nor .png")):
            self.assertIn(said, self.sweep(*options, code=USAGE)[1])

    def test_the_report(self):
        self.write("study.toml", STUDY + '[expect]\nall = "count : { dist(A, _) } = @world"\n')
        self.sweep("--plot", "messages~n", code=FAILED)
        page = self.read("study.results/report.html").decode()
        html.parser.HTMLParser().feed(page)
        self.assertEqual((page.count("<svg"), page.count("<h3>Row ")), (1, 4))
        self.assertNotIn("<?xml", page)
        command = html.unescape(page.split("<h3>Row 1</h3>")[1].split("<pre>")[1].split("</pre>")[0])
        self.call("meldsim", *shlex.split(command)[1:], code=FAILED)
        for outside in ("http://", "https://", "<script"):
            self.assertNotIn(outside, re.sub(r'xmlns(:xlink)?="[^"]*"', "", page))

    def test_a_job_array(self):
        out = self.sweep("--slurm", 3)[0]
        self.assertEqual(out, "8 of 8 runs are missing. Start the tasks by: sbatch study.results/sweep.sbatch\n")
        self.assertIn("#SBATCH --array=1-3\n", self.read("study.results/sweep.sbatch").decode())
        # Tasks begin at the same time, in any folder.
        script = self.folder / "study.results" / "sweep.sbatch"
        tasks = [self.begin("bash", script, cwd="/", stdout=subprocess.PIPE, text=True) for _ in range(3)]
        made = [int(task.communicate(timeout=60)[0].split(": ")[1].split()[0]) for task in tasks]
        self.assertEqual((sum(made), [task.returncode for task in tasks]), (8, [0] * 3))
        self.assertEqual(len(self.rows()), 8)


class Measures(Case):
    def test_bodies_and_counts(self):
        self.write("study.toml", STUDY.replace("seeds = 2", "seeds = [7]") + """
            [measure]
            rounds = "ticks"
            far = "max D : { dist(A, D) }"
            of_three = "dist(@3, D)"
            of_far = "dist(@5, D)"
            is_source = "source(@0)"
            grown = { body = "count : { dist(A, _) }", ticks = [2, 4] }
            """)
        values = [(row["far"], row["of_three"], row["of_far"], row["is_source"], row["grown@2"], row["grown@4"]) for row in self.rows()]
        self.assertEqual(values, [("3", "3", "", "1", "3", "7"), ("5", "3", "5", "1", "3", "7"),
                                  ("3", "3", "", "1", "3", "7"), ("10", "3", "5", "1", "3", "7")])

    def test_demands(self):
        self.write("study.toml", STUDY + '[expect]\nall = "count : { dist(A, _) } = @world"\n[never]\nfar = "dist(A, D), D > 7"\n')
        rows = self.rows(code=FAILED)
        self.assertEqual([(row["status"], row["reason"][:10]) for row in rows[::2]],
                         [("failed", "expect all"), ("fine", ""), ("failed", "expect all"), ("failed", "never far:")])
        out, _ = self.sweep(code=FAILED)
        self.assertIn("6 failed\n  row 1: expect all: ", out)
        self.assertIn("# expect all: ", self.sweep("--show", 1, "--print")[0])

    def test_failures_are_rows(self):
        self.write("flood.meld", FLOOD + "type half(node, int).\nhalf(A, 12 / (reach - 3)) :- id(A, 0).\n")
        rows = self.rows(code=FAILED)
        self.assertEqual([row["status"] for row in rows[::2]], ["failed", "fine"] * 2)
        self.assertIn("divided by zero", rows[0]["reason"])
        self.assertEqual((rows[0]["ticks"], rows[0]["digest"]), ("", ""))

    def test_a_measure_that_is_many_values(self):
        self.write("study.toml", STUDY + '[measure]\nd = "dist(A, D)"\nrounds = "ticks"\n')
        rows = self.rows(code=FAILED)
        self.assertIn("a measure is one value. Aggregate them", rows[0]["reason"])
        self.assertEqual((rows[0]["d"], rows[0]["rounds"] != ""), ("", True))

    def test_a_time_limit(self):
        self.write("forever.meld", FOREVER)
        self.write("study.toml", 'program = "forever.meld"\ntimeout = 0.5\n')
        self.assertIn("time limit", self.rows(code=FAILED)[0]["reason"])
        self.write("study.toml", 'program = "forever.meld"\nticks = 5\n')
        self.assertEqual(self.rows()[0]["ticks"], "5")


class Mistakes(Case):
    CASES = [
        ("seeds = 2", "sedes = 2", "study.toml:3:1: there is no key 'sedes'. did you mean 'seeds'?"),
        ("reach = ", "raech = ", "study.toml:11:9: [set] raech: the program has no such constant, and no world has {raech} in it. "
                                 "Did you mean 'reach'?"),
        ("reach = [3, 100]", '"netwrok.kind" = "ideal"', "study.toml:11:18: [set] netwrok.kind: worlds have no such section. did you mean"),
        ("[3, 100]", "[3, 3]", "study.toml:11:9: [set] reach lists 3 twice"),
        ("[3, 100]", "[]", "[set] reach has no values"),
        ("reach = [3", "seed = [3", "tables have another column of this name. Write seeds = N at the top"),
        ("ring({n})", "rong({n})", "study.toml:5:1: [world]: there is no graph 'rong'. did you mean 'ring'?"),
        ('program = "flood.meld"', "", "study.toml: the study names no program. Add program ="),
        ("seeds = 2", "seeds = ", "study.toml:3:9: "),
        ("seeds = 2", "seeds = [-1]", "study.toml:3:10: a seed is a whole number"),
        ("flood.meld", "fload.meld", "there is no file fload.meld"),
        ("[set]", '[measure]\nx = "tikcs"\n[set]', "[measure] x: a run has no count 'tikcs'. Did you mean 'ticks'?"),
        ("[set]", '[measure]\nx = "max D : { dits(A, D) }"\n[set]', "[measure] x: error[E0301]: there is no predicate `dits`"),
        ("[set]", '[measure]\nx = { body = "dist(@0, D)", ticks = 0 }\n[set]', "a tick is a whole number from 1 on"),
        ("[set]", '[expect]\nx = "dits(A, D)"\n[set]', "[expect] x: error[E0301]: there is no predicate `dits`"),
    ]

    def test_each_has_its_place_and_cure(self):
        for number, (old, new, said) in enumerate(self.CASES):
            with self.subTest(new):
                self.assertIn(old, STUDY)
                self.write("study.toml", STUDY.replace(old, new, 1))
                err = self.sweep("-o", f"{number}.results", code=USAGE)[1]
                self.assertIn(said, err)

    def test_a_row_that_is_not_there(self):
        for options in ([], ["--print"]):
            self.assertIn("Its rows are 1 to 8", self.sweep("--show", 9, *options, code=USAGE)[1])

    def test_a_size_that_is_none(self):
        self.assertIn("--memory: 'much' is not a size", self.sweep("--memory", "much", code=USAGE)[1])


class Going(Case):
    def test_only_what_is_new_is_made(self):
        self.assertEqual([self.made(), self.made()], [8, 0])
        for old, new, made in (("seeds = 2", "seeds = 3", 4), ("reach = [3, 100]", "reach = [3, 100, 50]", 6),
                               ("n = [10, 20]", "n = [10]", 0)):
            study = (self.folder / "study.toml").read_text()
            self.write("study.toml", study.replace(old, new))
            self.assertEqual(self.made(), made, new)
        self.write("study.toml", (self.folder / "study.toml").read_text() + '[measure]\nfar = "max D : { dist(A, D) }"\n')
        self.assertEqual([self.made(), self.made()], [9, 0])
        # Without it nothing is to be done; a program that says something else is another one.
        self.write("study.toml", (self.folder / "study.toml").read_text().replace("far = ", "# "))
        self.assertEqual(self.made(), 0)
        self.write("flood.meld", FLOOD.replace("D + 1", "D + 2"))
        self.assertEqual(self.made(), 9)

    def test_as_is(self):
        self.assertIn("8 missing", self.sweep("--as-is")[0])
        self.assertEqual(len(self.rows("--as-is")), 0)

    def test_failures_again(self):
        self.write("study.toml", STUDY + '[expect]\nall = "count : { dist(A, _) } = @world"\n')
        self.rows(code=FAILED)
        self.assertEqual(self.made(code=FAILED), 0)
        self.assertIn("4 made now, 4 there before", self.sweep("--again", code=FAILED)[0])

    def long_study(self):
        """Rows of some 50 ms each."""
        self.write("forever.meld", FOREVER)
        self.write("study.toml", 'program = "forever.meld"\nseeds = 40\nticks = 3000\nworlds = ["square.toml"]\n')

    def start(self, *options):
        child = subprocess.Popen(words_of("meldsim", "sweep", "study.toml", *options), cwd=self.folder, stdout=subprocess.PIPE,
                                 stderr=subprocess.PIPE, text=True)
        self.addCleanup(child.stdout.close)
        self.addCleanup(child.stderr.close)
        self.addCleanup(child.wait)
        self.addCleanup(child.kill)
        return child

    def wait_for_rows(self, count):
        """Until so many are in the journals."""
        end = time.monotonic() + 60
        while time.monotonic() < end:
            lines = sum(path.read_text().count("\n") for path in self.folder.glob("study.results/journals/*"))
            if lines >= count:
                return
            time.sleep(0.01)
        self.fail("there are no rows")

    def test_interrupted(self):
        for signal_number, code in ((signal.SIGINT, 130), (signal.SIGTERM, 143)):
            with self.subTest(signal_number):
                self.setUp()
                self.long_study()
                child = self.start("--jobs", "2")
                self.wait_for_rows(3)
                child.send_signal(signal_number)
                out, err = child.communicate(timeout=30)
                self.assertEqual(child.returncode, code, err)
                self.assertIn("the same command goes on with the", err)
                out = self.sweep()[0]
                self.assertNotIn(" 40 made now", out)
                self.assertIn("40 runs: ", out)
                self.assertEqual(len(self.rows()), 40)

    def test_killed(self):
        """What it had claimed is taken over, and a line that it did not finish counts for nothing."""
        self.long_study()
        child = self.start("--jobs", "2")
        self.wait_for_rows(3)
        child.kill()
        child.communicate()
        journal = next(self.folder.glob("study.results/journals/*"))
        journal.write_text(journal.read_text() + '{"key": "half a li')
        whole = self.rows()
        self.assertEqual(len(whole), 40)
        self.assertEqual(list(self.folder.glob("study.results/claims/*")), [])

    def test_claims_of_nobody(self):
        """What names no process that lives holds up nothing, whatever it is."""
        self.long_study()
        self.rows()
        results = self.folder / "study.results"
        keys = [json.loads(line)["key"] for path in (results / "journals").glob("*") for line in path.read_text().splitlines()]
        gone = subprocess.Popen(["true"])
        gone.wait()
        for key, owner in zip(keys, ("", f"{socket.gethostname()}-{gone.pid}", "nobody-1", "no name")):
            (results / "claims" / key).symlink_to(owner) if owner else (results / "claims" / key).touch()
        for path in (results / "journals").glob("*"):
            path.unlink()
        self.assertEqual(len(self.rows()), 40)
        self.assertEqual(list((results / "claims").iterdir()), [])

    def test_two_at_once(self):
        """They share the rows, and both end with all of them."""
        self.long_study()
        ends = [child.communicate(timeout=60) for child in [self.start("--jobs", "1"), self.start("--jobs", "1")]]
        made = [int(out.split(": ")[1].split()[0]) for out, _ in ends]
        self.assertEqual(sum(made), 40, ends)
        self.assertTrue(all(made), made)
        self.assertEqual(len(self.rows()), 40)


class Memory(Case):
    """Rows of some 30 MB each."""
    SIDE, JOBS = 90, 3

    def setUp(self):
        super().setUp()
        self.write("study.toml", f'''program = "plain.meld"
            seeds = 6
            ticks = 100
            [world]
            lattice = "cubic"
            body = [{{ shape = "box({self.SIDE}, {self.SIDE}, {self.SIDE})" }}]
            ''')

    def own_bytes(self, process):
        """What a process has in memory and shares with no other; 0: it has ended."""
        try:
            text = pathlib.Path(f"/proc/{process}/status").read_text()
        except OSError:
            return 0
        found = re.search(r"RssAnon:\s+(\d+)", text)
        return 1024 * int(found[1]) if found else 0

    def watch(self, *options):
        """The most that runs have together during a sweep, and how many of them have much; and what the sweep says."""
        sweep = self.begin("meldsim", "sweep", "study.toml", "--jobs", self.JOBS, *options, stdout=subprocess.PIPE, text=True)
        most, together = 0, 0
        while sweep.poll() is None:
            base = self.own_bytes(sweep.pid)
            sizes = [max(0, self.own_bytes(child) - base) for child in children(sweep.pid)]
            most, together = max(most, sum(sizes)), max(together, sum(size > 8_000_000 for size in sizes))
            time.sleep(0.005)
        said = sweep.communicate(timeout=60)[0]
        self.assertEqual(sweep.returncode, 0)
        return most, together, said

    def test_a_row_waits_until_there_is_memory_for_it(self):
        most, together, said = self.watch("--memory", "10GB")
        self.assertGreater(together, 1)
        self.assertNotIn("waited for memory", said)
        digests = [row["digest"] for row in self.rows()]
        peak = max(int(row["memory"]) for row in self.rows())
        # The first is expected to need much, and the others what it has needed: room for one, and not for two.
        for path in (self.folder / "study.results" / "journals").glob("*"):
            path.unlink()
        limit = int(0.9 * most) if together == 2 else int(0.55 * most)
        limited, alone, said = self.watch("--memory", limit)
        self.assertRegex(said,
                         "[1-6] of them waited for memory, of which one was expected to take [0-9.]+ MiB: at most [12] ran at a time")
        self.assertLess(limited, max(limit, peak) * 1.05)
        self.assertLess(alone, self.JOBS)
        self.assertEqual([row["digest"] for row in self.rows()], digests)

    def test_one_always_runs(self):
        most, together, said = self.watch("--memory", 1)
        self.assertEqual(together, 1)
        self.assertIn("5 of them waited for memory", said)
        self.assertIn("at most 1 ran at a time", said)
        self.assertEqual([row["status"] for row in self.rows()], ["fine"] * 6)


class Costs(Case):
    def test_a_small_run(self):
        """Of the processors; the clock on the wall depends on what else runs."""
        self.write("study.toml", 'program = "plain.meld"\nworlds = ["square.toml"]\nseeds = 300\n')
        before = resource.getrusage(resource.RUSAGE_CHILDREN)
        rows = self.rows()
        after = resource.getrusage(resource.RUSAGE_CHILDREN)
        spent = (after.ru_utime - before.ru_utime) + (after.ru_stime - before.ru_stime) - sum(float(row["seconds"]) for row in rows)
        self.assertLess(spent / len(rows), 0.02 * (10 if os.environ.get("CLAYMELD_SANITIZED") else 1))


if __name__ == "__main__":
    main("meldc", "meldsim")
