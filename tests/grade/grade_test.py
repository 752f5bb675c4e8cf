"""What `meldsim grade` makes of submissions: grade_test.py --meldc PATH --meldsim PATH [unittest options]"""

import csv
import html.parser
import io
import json
import os
import pathlib
import signal
import sys
import unittest

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1]))

import frame  # noqa: E402
from frame import main, square  # noqa: E402

START = "type source(node).\ntype reached(node).\n"
FLOOD = START + "reached(A) :- source(A).\nreached(B) :- neighbor(A, B), reached(A).\n"
HALF = START + "reached(A) :- source(A).\n"
EXERCISE = """
title = "Flood <all>"

[limits]
seconds = 5
memory = "512MiB"
output = "4KiB"
ticks = 200

[expect]
spreads = "not (neighbor(A, B), reached(A), not reached(B))"

[[world]]
file = "shown.toml"

[[world]]
file = "small.toml"
points = 2
[world.expect]
count = "count : { reached(_) } = 4"
soon = { body = "count : { reached(_) } > 1", ticks = [3] }
"""
SOURCE = '[facts]\nsource = ["id == 0"]\n'
HIDDEN = '[[world]]\nfile = "secret_place.toml"\npoints = 3\n[world.never]\nsecret_check = "reached(A), id(A, 77)"\n'


class Case(frame.Case):
    FILES = {"ex/exercise.toml": EXERCISE, "ex/start.meld": START, "ex/shown.toml": square(3) + SOURCE,
             "ex/small.toml": square(2) + SOURCE, "ex/hidden/hidden.toml": HIDDEN, "ex/hidden/secret_place.toml": square(5) + SOURCE,
             "ex/solution/flood.meld": FLOOD, "ex/README.md": "# Flood\n"}

    def grade(self, *options, code=0, submissions="sub", **more):
        return self.call("meldsim", "grade", "ex", submissions, *options, code=code, **more)

    def grades(self, *options):
        """By student."""
        return {student["student"]: student for student in json.loads(self.grade("--json", *options)[0])["students"]}

    def outcomes(self, *options):
        return {name: [world["outcome"] for world in grade["worlds"]] for name, grade in self.grades(*options).items()}

    def page(self, student, name="index.html"):
        return (self.folder / "sub.grades/students" / student / name).read_text()

    def made(self, **more):
        return int(self.grade(**more)[0].split(" runs: ")[1].split()[0])


def linear(rules):
    return START + "type linear t(node, int N).\nt(A, 0).\n" + rules + "reached(A) :- source(A).\n"


# By name of the file: its text, how each world goes (None: it is not run), and what the table says of it.
HOSTILE = {
    "grows.meld": (linear("t(A, N) -o t(A, N + 1), t(A, N + 2).\n"), {"memory", "limit"}, ""),
    "never_ends.meld": (linear("t(A, N) -o t(A, N + 1)@+1.\n"), {"limit"}, ""),
    "spins.meld": (linear("t(A, N), N < 1000000000000 -o t(A, N + 1).\n"), {"time", "limit", "error"}, ""),
    "recursion.meld": (START + "fun f(int X) : int = f(X + 1) + 1.\nreached(A) :- source(A), f(1) > 0.\n", {"error", "crash"}, ""),
    "prints.meld": (linear('t(A, N), N < 150 -o print(A, "%s" % 1), t(A, N + 1)@+1.\n'), None, "it does not compile: prints.meld:"),
    "talks.meld": (linear('t(A, N), N < 150 -o write-string(A, "' + "x" * 90 + '"), t(A, N + 1)@+1.\n'), {"output"}, ""),
    "divides.meld": (linear("t(A, 0), source(A), id(A, X) -o t(A, 1 / X).\n"), {"error"}, ""),
    "syntax.meld": (START + "reached(A :- source(A).\n", None, "it does not compile: syntax.meld:3:"),
    "deep.meld": (START + "reached(A) :- source(A), " + "(" * 5000 + "1" + ")" * 5000 + " = 1.\n", None, "it does not compile: deep.meld:"),
    "bytes.meld": (b"\xff\xfe\x00 bad", None, "it does not compile: bytes.meld:1:1: error[E0105]"),
    "empty.meld": ("", {"error"}, ""),
    "large.meld": ("// " + "x" * 1200000 + "\n", None, "its text has more than"),
    "steals.meld": ('include "../../../ex/solution/flood.meld".\n', None, "is not part of the submission"),
    "steals_absolutely.meld": ("absolute", None, "is not part of the submission"),
    "self.meld": ('include "self.meld".\n' + FLOOD, {"fine"}, ""),
    "foreign.meld": (START + "extern int system(int).\nreached(A) :- source(A), system(1) = 0.\n", None, "it does not compile"),
    "notes.txt": ("hello", None, "it is not a .meld file"),
    "folder/a.meld": (FLOOD, None, "it has 2 programs, and none is called start.meld"),
    "folder/b.meld": (FLOOD, None, "it has 2 programs, and none is called start.meld"),
    "parts/start.meld": ('include "lib/rest.meld".\n' + START, {"fine"}, ""),
    "parts/lib/rest.meld": ("reached(A) :- source(A).\nreached(B) :- neighbor(A, B), reached(A).\n", {"fine"}, ""),
    "other_names.meld": ("type quelle(node).\ntype erreicht(node).\nerreicht(A) :- quelle(A).\n", {"error"}, ""),
    "good.meld": (FLOOD, {"fine"}, ""),
}


class Hostile(Case):
    def test_each_costs_only_its_own_points(self):
        for name, (text, _, _) in HOSTILE.items():
            if text == "absolute":
                text = f'include "{self.folder}/ex/solution/flood.meld".\n'
            self.write(f"sub/{name}", text)
        os.mkfifo(self.folder / "sub/pipe.meld")
        (self.folder / "sub/link.meld").symlink_to(self.folder / "ex/solution/flood.meld")
        (self.folder / "sub/linked").mkdir()
        (self.folder / "sub/linked/start.meld").symlink_to(self.folder / "ex/solution/flood.meld")
        (self.folder / "sub/nothing").mkdir()
        self.write("sub/.hidden", "is no submission")
        grades = self.grades()
        remarks = {row["student"]: row["remark"] for row in csv.DictReader(io.StringIO(self.read("sub.grades/grades.csv").decode()))}
        for name, (_, outcomes, remark) in HOSTILE.items():
            student = name.split("/")[0].removesuffix(".meld")
            with self.subTest(student=student):
                found = {world["outcome"] for world in grades[student]["worlds"]}
                self.assertLessEqual(found, outcomes or {"-"}, grades[student])
                self.assertIn(remark, remarks[student])
        for student, remark in (("pipe", "it is a pipe"), ("link", "it is a link"), ("linked", "start.meld is a link"),
                                ("nothing", "it has no .meld file")):
            self.assertIn(remark, remarks[student])
            self.assertEqual(grades[student]["points"], 0)
        self.assertNotIn(".hidden", grades)
        # Nobody reads another's file, neither in the pages nor in the answers that are kept.
        self.assertNotIn("neighbor(A, B), reached(A).", self.page("steals") + self.page("steals_absolutely"))

    def test_unreadable(self):
        if os.geteuid() == 0:
            raise unittest.SkipTest("root reads everything")
        self.write("sub/closed.meld", FLOOD).chmod(0)
        self.write("sub/good.meld", FLOOD)
        grades = self.grades()
        self.assertIn("closed.meld cannot be read", grades["closed"]["problem"])
        self.assertEqual(grades["good"]["points"], 6)

    def test_the_order_does_not_matter(self):
        """Not even that of a folder, or how many run at a time."""
        self.write("sub/a.meld", FLOOD)
        self.write("sub/b.meld", HALF)
        first = self.grade("--json", "--jobs", 1, "-o", "one")[0]
        self.assertEqual(first, self.grade("--json", "--jobs", 4, "-o", "four")[0])

    def test_without_network(self):
        self.write("sub/a.meld", FLOOD)
        out, err = self.grade("--json")
        self.assertEqual(json.loads(out)["without_network"], "network" not in err)

    def test_one_file(self):
        self.write("sub/a.meld", FLOOD)
        out, _ = self.grade(submissions="sub/a.meld")
        self.assertIn("6/6", out)
        self.assertTrue((self.folder / "sub/a.grades/index.html").is_file())


class Reader(html.parser.HTMLParser):
    """The text of a page, and where its links lead."""

    def __init__(self, page):
        super().__init__()
        self.text, self.links, self.tags = "", [], []
        self.feed(page)

    def handle_data(self, data):
        self.text += data

    def handle_starttag(self, tag, attributes):
        self.tags.append(tag)
        self.links += [value for name, value in attributes if name in ("href", "src")]


class Pages(Case):
    def setUp(self):
        super().setUp()
        self.write("sub/half.meld", HALF)
        self.write("sub/fine.meld", FLOOD)
        self.write("sub/<script>&x.meld", HALF.replace("reached(A) :- source(A)", 'reached(A) :- source(A), "<b>" = "<b>"'))
        self.write("sub/broken.meld", START + "reached(<i>).\n")
        self.write("sub/far.meld", FLOOD + "reached(A) :- id(A, 77).\n")

    def test_a_student_sees_what_went_wrong(self):
        self.grade()
        page = Reader(self.page("half"))
        for text in ("0 of 6 points", "It must hold: not (neighbor(A, B), reached(A), not reached(B))", "it does not hold after tick ",
                     "reached(@3)  does not hold", "half.meld:3: reached(A) :- source(A).", "FAILS"):
            self.assertIn(text, page.text)
        self.assertEqual(page.links, ["shown.html", "small.html"])
        for link in page.links:
            self.assertIn("<canvas", self.page("half", link))
        broken = Reader(self.page("broken")).text
        self.assertIn("broken.meld:3:9", broken)

    def test_hidden_worlds_stay_hidden(self):
        self.grade("--json")
        folder = self.folder / "sub.grades"
        given = [path for path in folder.rglob("*") if path.is_file() and "kept" not in path.parts and "scratch" not in path.parts]
        self.assertTrue(given)
        for path in given:
            for secret in ("secret_check", "77)", "@24"):
                if path.parent.name != "far":  # This one has the number in its program.
                    self.assertNotIn(secret, path.read_text(), path)
        self.assertIn("secret_place (hidden): 0 of 3 points", Reader(self.page("half")).text)
        out, _ = self.grade("--json")
        self.assertNotIn("secret_check", out)

    def test_revealed(self):
        self.grade()
        self.grade("--reveal")
        page = Reader(self.page("half"))
        self.assertIn("secret_place.html", page.links)
        self.assertIn("reached(@1)  does not hold", page.text)
        # And hidden again: the page of the world goes.
        self.grade()
        self.assertFalse((self.folder / "sub.grades/students/half/secret_place.html").exists())

    def test_text_of_students_is_data(self):
        self.grade("--reveal")
        for page in (self.folder / "sub.grades").glob("**/index.html"):
            self.assertLessEqual(set(Reader(page.read_text()).tags),
                                 {"html", "head", "meta", "title", "style", "body", "h1", "h2", "h3", "p", "strong", "section", "pre",
                                  "code", "a", "table", "tr", "th", "td"}, page)
        names = os.listdir(self.folder / "sub.grades/students")
        self.assertTrue(all(name.replace("_", "").replace(".", "").replace("-", "").isalnum() for name in names), names)
        overview = Reader((self.folder / "sub.grades/index.html").read_text())
        self.assertIn("<script>&x", overview.text)
        for link in overview.links:
            self.assertTrue((self.folder / "sub.grades" / link).is_file(), link)

    def test_never(self):
        """What may never hold is explained by the facts that it rests on."""
        self.write("ex/exercise.toml", EXERCISE + '[world.never]\nbig = "reached(A), id(A, N), N > 2"\n')
        self.grade()
        page = Reader(self.page("fine")).text
        self.assertIn("It may never hold: reached(A), id(A, N), N > 2", page)
        self.assertIn("fine.meld:4: reached(B) :- neighbor(A, B), reached(A).", page)

    def test_table_and_csv(self):
        out, _ = self.grade()
        lines = out.splitlines()
        self.assertEqual(lines[0].split(), ["student", "points", "shown", "small", "secret_place"])
        self.assertEqual([line.split()[:2] for line in lines[1:6]],
                         [["<script>&x", "0/6"], ["broken", "0/6"], ["far", "6/6"], ["fine", "6/6"], ["half", "0/6"]])
        rows = list(csv.DictReader(io.StringIO(self.read("sub.grades/grades.csv").decode())))
        self.assertEqual([(row["student"], row["points"], row["of"]) for row in rows][-1], ("half", "0", "6"))
        self.assertTrue(rows[1]["remark"].startswith("it does not compile: broken.meld:3:9: error["))


LONG = START + """
type linear asleep(node).
type near(node).
type linear wave(node, int Hops).   // A remark.
const most = 3.
fun next(int X) : int = X + 1.

asleep(A).
asleep(A), source(A) -o wave(A, 0).
wave(A, H), asleep(A) -o reached(A), { B | neighbor(A, B) | wave(B, next(H)) }.
wave(_, H), H <= most -o 1.
near(A) :- reached(A), neighbor(A, B), reached(B).
"""
# Each changed from LONG in one way: whether it still counts as the same.
CHANGES = {
    "variables": (LONG.replace("A", "Here").replace("H)", "Far)").replace("H <=", "Far <=").replace("(_, H", "(_, Far"), True),
    "names": (LONG.replace("asleep", "dozing").replace("wave", "front").replace("next", "more").replace("most", "limit"), True),
    "swapped_names": (LONG.replace("asleep", "xx").replace("wave", "asleep").replace("xx", "wave"), True),
    "comments": (LONG.replace("// A remark.", "// Another.") + "// And one at the end.\n", True),
    "layout": (LONG.replace("\n", "\n  ").replace(", ", " ,\n"), True),
    "order_of_rules": (START + "\n".join(reversed(LONG[len(START):].strip().split("\n"))), True),
    "order_in_bodies": (LONG.replace("wave(A, H), asleep(A) -o", "asleep(A), wave(A, H) -o"), True),
    "order_at_the_end": (LONG.replace("neighbor(A, B), reached(B).", "reached(B), neighbor(A, B)."), True),
    "names_of_arguments": (LONG.replace("int Hops", "int Far"), True),
    "a_number": (LONG.replace("most = 3", "most = 4"), False),
    "a_rule_more": (LONG + "reached(A) :- source(A).\n", False),
    "another_variable": (LONG.replace("wave(B, next(H)) }", "wave(A, next(H)) }"), False),
    "another_operator": (LONG.replace("H <= most", "H < most"), False),
    "order_of_arguments": (LONG.replace("reached(A), neighbor(A, B)", "reached(A), neighbor(B, A)"), False),
    "a_name_of_the_exercise": (LONG.replace("source(A)", "reached(A)"), False),
}


class Copies(Case):
    def test_only_names_comments_order_and_layout(self):
        self.write("sub/0long.meld", LONG)
        for name, (text, _) in CHANGES.items():
            self.write(f"sub/{name}.meld", text)
        grades = self.grades()
        for name, (_, same) in CHANGES.items():
            with self.subTest(change=name):
                self.assertFalse(grades[name]["messages"], grades[name])
                self.assertEqual("0long" in grades[name]["same_as"], same, grades[name]["same_as"])

    def test_the_solution_and_the_start(self):
        for name, text in (("a", FLOOD), ("b", FLOOD.replace("A", "X")), ("c", START), ("d", "// Mine.\n" + START), ("e", HALF)):
            self.write(f"sub/{name}.meld", text)
        grades = self.grades()
        self.assertEqual([grade["same_as"] for grade in grades.values()], [["b"], ["a"], [], [], []])
        self.assertEqual([grade["as_solution"] for grade in grades.values()], [True, True, False, False, False])
        self.assertEqual([grade["as_start"] for grade in grades.values()], [False, False, True, True, False])
        out, _ = self.grade()
        self.assertIn("a: the same program as b, and as the solution\n", out)
        # Students do not learn of each other.
        self.assertNotIn("same", self.page("a"))

    def test_programs_with_mistakes_are_no_copies(self):
        self.write("sub/a.meld", "reached(.\n")
        self.write("sub/b.meld", "reached(.\n")
        self.assertEqual([grade["same_as"] for grade in self.grades().values()], [[], []])


class Going(Case):
    def setUp(self):
        super().setUp()
        for i in range(4):
            self.write(f"sub/s{i}.meld", FLOOD + f"// {i}\n")

    def test_only_what_is_new_is_run(self):
        self.assertEqual(self.made(), 12)
        self.assertEqual(self.made(), 0)
        self.write("sub/s1.meld", HALF)
        self.assertEqual(self.made(), 3)
        self.write("ex/README.md", "# Another text\n")
        self.assertEqual(self.made(), 0)
        self.write("ex/shown.toml", square(4) + SOURCE)
        self.assertEqual(self.made(), 12)

    def test_interrupted(self):
        whole = self.grade("--json", "-o", "whole")[0]
        for signal_number, code in ((signal.SIGINT, 130), (signal.SIGTERM, 143)):
            folder = self.folder / f"cut{code}.grades"
            process = self.begin("meldsim", "grade", "ex", "sub", "--jobs", 1, "-o", folder, "--quiet")
            kept = folder / "kept"
            self.wait_for(lambda kept=kept: kept.is_dir() and len(list(kept.glob("*.json"))) >= 3, process)
            process.send_signal(signal_number)
            self.assertEqual(process.wait(timeout=20), code)
            out, _ = self.grade("-o", folder)
            self.assertNotIn(", 0 there before", out)
            self.assertEqual((folder / "grades.json").read_text(), whole)

    def test_killed(self):
        """Nothing that it has started outlives it, and what is kept is whole."""
        self.write("sub/s0.meld", linear("t(A, N), N < 1000000000000 -o t(A, N + 1).\n"))
        process = self.begin("meldsim", "grade", "ex", "sub", "--jobs", 2, "--quiet")
        kept = self.folder / "sub.grades/kept"
        self.wait_for(lambda: kept.is_dir() and len(list(kept.glob("*.json"))) >= 3, process)
        process.kill()
        process.wait()
        self.wait_for(lambda: not [pid for pid in os.listdir("/proc") if pid.isdigit() and self.works_here(pid)])
        self.grade(seconds=100)

    def works_here(self, pid):
        try:
            return os.readlink(f"/proc/{pid}/cwd").startswith(f"{self.folder}/sub.grades/scratch")
        except OSError:
            return False

    def test_again(self):
        self.write("sub/s0.meld", linear("t(A, N) -o t(A, N + 1), t(A, N + 2).\n"))
        self.grade()
        outcomes = self.outcomes()["s0"]
        self.assertEqual(self.made(), 0)
        out, _ = self.grade("--again")
        again = sum(outcome in ("memory", "time", "crash") for outcome in outcomes)
        self.assertIn(f": {again} made now", out)


# What is written to a file of the exercise, and what the message says.
MISTAKES = {
    "no hidden world": ("hidden/hidden.toml", "", "ex/hidden/hidden.toml: it lists no world"),
    "no exercise": ("exercise.toml", 'worlds = ["shown.toml"]\n', "ex/exercise.toml:1:"),
    "no file": ("exercise.toml", '[expect]\na = "reached(_)"\n[[world]]\nfile = "none.toml"\n', "ex/exercise.toml:4:8: "),
    "outside": ("exercise.toml", '[expect]\na = "reached(_)"\n[[world]]\nfile = "../w.toml"\n', "is not in the folder of the exercise"),
    "nothing expected": ("exercise.toml", '[[world]]\nfile = "shown.toml"\n', "nothing is expected in the world 'shown'"),
    "a wrong key": ("exercise.toml", EXERCISE.replace("ticks = 200", "tick = 200"), "ticks"),
    "a wrong kind": ("exercise.toml", EXERCISE.replace("points = 2", 'points = "two"'), "ex/exercise.toml:18:"),
    "twice": ("exercise.toml", EXERCISE + '[[world]]\nfile = "shown.toml"\n', "two worlds are called 'shown'"),
    "a hidden one with a shown name": ("hidden/hidden.toml", '[[world]]\nname = "shown"\nfile = "secret_place.toml"\n',
                                       "two worlds are called 'shown'"),
    "a name": ("exercise.toml", EXERCISE.replace('file = "small.toml"', 'file = "small.toml"\nname = "a/b"'),
               "'a/b' is not the name of a world"),
    "a world with a mistake": ("shown.toml", 'lattice = "squre"\n', "square"),
    "a program that is not there": ("exercise.toml", 'program = "begin.meld"\n' + EXERCISE, "there is no 'begin.meld'"),
    "not TOML": ("exercise.toml", "title = \n", "ex/exercise.toml:1:"),
    "an empty check": ("exercise.toml", EXERCISE.replace('"not (neighbor(A, B), reached(A), not reached(B))"', '""'), "says nothing"),
}


class Mistakes(Case):
    def test_of_exercises(self):
        self.write("sub/a.meld", FLOOD)
        self.write("w.toml", square(2))
        for name, (file, text, says) in MISTAKES.items():
            with self.subTest(mistake=name):
                before = self.read(f"ex/{file}")
                self.write(f"ex/{file}", text)
                try:
                    _, err = self.grade(code=2)
                    self.assertIn(says, err)
                finally:
                    self.write(f"ex/{file}", before)

    def test_of_commands(self):
        self.grade(code=2, submissions="nowhere")
        (self.folder / "sub").mkdir()
        _, err = self.grade(code=2)
        self.assertIn("sub is empty", err)
        _, err = self.call("meldsim", "grade", "nowhere", "sub", code=2)
        self.assertIn("nowhere is not a folder", err)


if __name__ == "__main__":
    main("meldc", "meldsim")
