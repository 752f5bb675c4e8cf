"""What `meldsim about` says of runs, and that the command it prints makes them again: about_test.py --meldc PATH --meldsim PATH
[unittest options]"""

import csv
import json
import pathlib
import re
import shutil
import subprocess
import sys

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1]))

import frame  # noqa: E402
from frame import FOREVER, main, square  # noqa: E402

USAGE, FAILED, REFUSED = 2, 3, 6
PROGRAM = """
const reach = 100.
type source(node).
type dist(node, min int).
dist(A, 0)     :- source(A).
dist(B, D + 1) :- neighbor(A, B), dist(A, D), D < reach.
"""
WORLD = square(6) + """
[facts]
source = "id == 0"
[record]
every = 4
predicates = ["dist"]
[faults]
kill = 0.01
until = 20
"""
STUDY = 'program = "p.meld"\nworlds = ["w.toml"]\nseeds = [7]\n[set]\nreach = [3, 100]\n'


class Case(frame.Case):
    FILES = {"p.meld": PROGRAM, "w.toml": WORLD, "study.toml": STUDY}

    def about(self, *run, **options):
        return json.loads(self.call("meldsim", "about", *run, "--json", **options)[0])

    def again(self, about, *more, cwd=None):
        """Runs the command that it prints; the digest of the last tick."""
        self.assertEqual(about["again"][0], "meldsim")
        words = [*about["again"][1:], *more]
        out, _ = self.call("meldsim", *words, **({"cwd": cwd} if cwd else {}))
        return [line for line in out.splitlines() if line.startswith("tick ")][-1].split()[-1]


class Recordings(Case):
    OPTIONS = ("--set", "reach=5", "--seed", "3", "--limit", "facts=50")

    def record(self, *options):
        out, _ = self.call("meldsim", "run", "p.meld", "--world", "w.toml", "--record", "run.vtkhdf", "--digest", "digests", "--json",
                           *self.OPTIONS, *options)
        return json.loads(out), self.read("digests").decode().split()[-1]

    def test_it_is_made_again(self):
        summary, digest = self.record()
        about = self.about("run.vtkhdf")
        self.assertEqual((about["kind"], about["digest"], about["seed"], about["set"], about["limits"]),
                         ("recording", digest, 3, ["reach=5"], ["facts=50"]))
        self.assertEqual(about["again"], ["meldsim", "replay", "run.vtkhdf"])
        self.assertIn("the same", self.call("meldsim", *about["again"][1:])[0])
        self.assertEqual(self.again(about, "--digest", "-", "--quiet"), digest)
        # Also without the files that it was made of.
        for name in ("p.meld", "w.toml"):
            (self.folder / name).unlink()
        self.assertEqual(self.again(about, "--digest", "-", "--quiet"), digest)
        counts = about["counts"]
        self.assertEqual({name: counts[name] for name in summary if name in counts and name != "refused_actions"},
                         {name: value for name, value in summary.items() if name in counts and name != "refused_actions"})
        self.assertEqual(counts["messages"], summary["exported_changes"] + summary["linear_messages"])
        self.assertEqual(about["tick"], summary["ticks"])
        self.assertEqual(about["typed"][1:6], ["run", "p.meld", "--world", "w.toml", "--record"])

    def test_the_same_on_any_number_of_processes(self):
        said = []
        for options in ((), ("--threads", 2), ("-n", 2), ("-n", 4)):
            self.record(*options)
            about = self.about("run.vtkhdf")
            said.append({key: value for key, value in about.items() if key != "typed"})
        for other in said[1:]:
            self.assertEqual(other, said[0])

    def test_versions(self):
        self.record()
        versions = self.about("run.vtkhdf")["made_by"]
        self.assertEqual(versions["claymeld"], self.call("meldsim", "--version")[0].split()[1])
        self.assertRegex(versions["compiler"], r"^Clang \d+\.")
        self.assertRegex(versions["mpi"], r"\d+\.\d+")
        self.assertGreater(versions["module_abi"], 0)

    def test_what_it_does_not_contain(self):
        self.record()
        text = self.call("meldsim", "about", "run.vtkhdf")[0]
        self.assertIn("this recording does not contain\n  - the ticks between its steps: it has ", text)
        self.assertIn("facts of other predicates than dist", text)
        self.assertIn("\nagain       meldsim replay run.vtkhdf\n", text)
        self.assertNotIn("counts: ", text)

    def test_a_run_that_was_killed(self):
        self.write("forever.meld", PROGRAM + FOREVER)
        child = self.begin("meldsim", "run", "forever.meld", "--world", "w.toml", "--record", "run.vtkhdf", "--quiet",
                           stderr=subprocess.DEVNULL)
        self.wait_for(lambda: (self.folder / "run.vtkhdf").exists() and (self.folder / "run.vtkhdf").stat().st_size > 20000, child)
        child.kill()
        child.wait()
        about = self.about("run.vtkhdf")
        self.assertIsNone(about["counts"])
        self.assertTrue(any(each.startswith("counts: its run did not come to its end") for each in about["lacks"]), about["lacks"])
        self.assertRegex(about["digest"], "^[0-9a-f]{32}$")

    def test_latex(self):
        self.record()
        text = self.call("meldsim", "about", "run.vtkhdf", "--latex")[0]
        for sign in "#$%&_":
            self.assertFalse(re.search(rf"(?<!\\)\{sign}", re.sub(r"(?m)^%.*$| & ", "", text)), (sign, text))
        self.assertEqual(text.count("{"), text.count("}"))
        self.assertIn("\\begin{tabular}{lr}\nticks & ", text)
        self.assertIn("\\texttt{meldsim replay run.vtkhdf}", text)
        if shutil.which("pdflatex"):
            self.write("page.tex", "\\documentclass{article}\\usepackage{textcomp}\\begin{document}" + text + "\\end{document}")
            self.call("pdflatex", "-interaction=nonstopmode", "page.tex")


class Checkpoints(Case):
    def test_it_is_made_again(self):
        (self.folder / "below").mkdir()
        self.write("events.toml", '[[event]]\ntick = 6\nkill = "x == 2"\n')
        out, _ = self.call("meldsim", "run", "../p.meld", "--world", "../w.toml", "--events", "../events.toml", "--set", "reach=9",
                           "--seed", "5", "--checkpoint", "points", "--checkpoint-every", "5ticks", "--json", "--watch", "dist(A, 9)",
                           cwd=self.folder / "below", code=FAILED)
        summary = json.loads(out)
        about = self.about("below/points")
        self.assertEqual((about["kind"], about["tick"], about["seed"], about["set"]), ("checkpoint", summary["ticks"], 5, ["reach=9"]))
        self.assertEqual(self.again(about), about["digest"])
        elsewhere = self.about("points", cwd=self.folder / "below")
        self.assertEqual(self.again(elsewhere, cwd=self.folder / "below"), about["digest"])
        self.assertEqual(about["counts"]["evaluations"], summary["evaluations"])
        self.assertEqual(about["counts"]["killed"], summary["killed"])
        self.assertIn("the text of its program and its world, and their files: only their hashes", about["lacks"])


class Rows(Case):
    def rows(self, code=0):
        self.call("meldsim", "sweep", "study.toml", "--quiet", code=code)
        with open(self.folder / "study.results" / "rows.csv", newline="") as file:
            return list(csv.DictReader(file))

    def test_they_are_made_again(self):
        for number, row in enumerate(self.rows(), 1):
            about = self.about(f"study.toml#{number}")
            self.assertEqual((about["kind"], about["digest"], about["seed"]), ("row", row["digest"], 7))
            self.assertEqual(about["set"], [f"reach={row['reach']}"])
            self.assertEqual(self.again(about), row["digest"])
            self.assertEqual(str(about["counts"]["messages"]), row["messages"])
            self.assertEqual(self.about("study.toml", "--row", number), about)
            self.assertIn("\\texttt{meldsim run p.meld", self.call("meldsim", "about", f"study.toml#{number}", "--latex")[0])

    def test_rows_without_a_result(self):
        about = self.about("study.toml#2")
        self.assertEqual((about["digest"], about["counts"]), (None, None))
        self.assertIn("nobody has made this row yet", about["lacks"][-1])
        self.write("p.meld", PROGRAM + "type half(node, int).\nhalf(A, 12 / (reach - 3)) :- id(A, 0).\n")
        self.rows(code=FAILED)
        about = self.about("study.toml#1")
        self.assertIn("divided by zero", about["lacks"][-1])
        self.assertIsNotNone(self.about("study.toml#2")["digest"])


class Mistakes(Case):
    def test_each_has_its_cure(self):
        self.call("meldsim", "run", "p.meld", "--world", "w.toml", "--digest", "digests", "--quiet")
        for run, said, code in (("nothing.vtkhdf", "cannot read nothing.vtkhdf", USAGE), ("p.meld", "Give a recording, a folder of", USAGE),
                                ("digests", "digests is a file of digests, which does not say of which run", USAGE),
                                ("study.toml", "study.toml is a study, and it has many runs. Give a row with --row", USAGE),
                                ("study.toml#9", "the study has no row '9'. Its rows are 1 to 2", USAGE),
                                ("w.toml#1", "there is no key 'lattice'", USAGE)):
            with self.subTest(run):
                self.assertIn(said, self.call("meldsim", "about", run, code=code)[1])
        self.write("broken.vtkhdf", b"\x89HDF\r\n\x1a\n" + bytes(500))
        self.call("meldsim", "about", "broken.vtkhdf", code=USAGE)


if __name__ == "__main__":
    main("meldc", "meldsim")
