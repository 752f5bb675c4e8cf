"""The exercises that come with Claymeld: a correct solution gets all points, and each wrong program fails where and as it should:
exercises_test.py --meldc PATH --meldsim PATH [unittest options]"""

import json
import pathlib
import shutil
import sys
import tomllib

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1]))

from frame import Case, main  # noqa: E402

EXERCISES = pathlib.Path(__file__).resolve().parents[2] / "examples/exercises"

# By exercise and wrong program: the worlds in which it fails, and what fails there: names of checks, or another outcome than "wrong".
WRONG = {
    "bipartite": {
        "for_good": {"opened": ["right"]},
        "nobody_is_told": {"triangles": ["one_answer"], "odd_ring": ["one_answer"]},
        "triangles_only": {"odd_ring": ["right"]},
    },
    "byzantine": {
        "any_one": {"contrary": ["alike", "as_ordered"]},
        "believes": {"lying_general": ["alike"], "tie": ["alike"]},
        "no_tie": {"tie": ["all_decide"]},
    },
    "flood": {
        "everywhere": {"islands": ["no_further"]},
        "few_hops": {"plate": ["spreads"], "line": ["spreads"]},
        "never_ends": {"plate": "limit", "ring": "limit", "line": "limit", "islands": "limit"},
    },
    "gradient": {
        "as_the_crow_flies": {"wall": ["a_link_nearer"]},
        "only_better": {"moves": ["only_they_have_0"]},
    },
    "independent_set": {
        "even_numbers": {"plate": ["two_neighbours"], "all_touch": ["two_neighbours"], "random": ["two_neighbours"]},
        "first_come": {"line": ["two_neighbours"], "plate": ["two_neighbours"], "random": ["two_neighbours"]},
        "one_round": {"line": ["maximal"], "plate": ["maximal"], "random": ["maximal"]},
    },
    "leader": {
        "few_hops": {"long": ["all_agree", "it_is_the_one"]},
        "greatest_nearby": {"mixed": ["one_is_elected", "it_is_the_one"]},
    },
    "mutual_exclusion": {
        "both_ways": {"ring": ["two_inside"], "tree": ["two_inside"], "slow": ["two_inside"]},
        "by_the_clock": {"ring": ["two_inside"], "tree": ["two_inside"], "slow": ["two_inside"]},
        "one_way": {"tree": ["all_have_entered"], "slow": ["all_have_entered"]},
    },
    "spanning_tree": {
        "all_nearer": {"plate": ["others_have_one"], "middle": ["others_have_one"]},
        "least_number": {"plate": ["depth_grows_by_one"], "middle": ["depth_grows_by_one"], "cut": ["depth_grows_by_one"]},
        "once": {"cut": ["parents_are_neighbours"]},
    },
    "sum": {
        "all_ways": {"plate": ["it_is_the_sum"]},
        "counts": {"plate": ["it_is_the_sum"], "changes": ["it_is_the_sum"]},
    },
    "termination": {
        "a_timer": {"slow_line": ["too_early"]},
        "first_echo": {"plate": ["the_root_knows"], "slow_line": ["too_early"]},
        "only_trees": {"plate": ["the_root_knows"]},
    },
}


class Exercises(Case):
    def grade(self, name):
        submissions = self.folder / "submissions"
        submissions.mkdir()
        for kind in ("solution", "wrong"):
            for program in sorted((EXERCISES / name / kind).glob("*.meld")):
                shutil.copy(program, submissions)
        out, _ = self.call("meldsim", "grade", EXERCISES / name, "submissions", "--reveal", "--json", seconds=110)
        return {student["student"]: student for student in json.loads(out)["students"]}

    def check(self, name):
        grades = self.grade(name)
        solutions = {path.stem for path in (EXERCISES / name / "solution").glob("*.meld")}
        for solution in solutions:
            with self.subTest(program=solution):
                self.assertEqual(grades[solution]["points"], grades[solution]["of"], grades[solution])
        found = {}
        for student, grade in grades.items():
            if student in solutions:
                continue
            self.assertEqual(grade["problem"], "", grade)
            self.assertTrue(any(world["hidden"] and world["points"] < world["of"] for world in grade["worlds"]), grade)
            found[student] = {
                world["world"]: [check["name"] for check in world["checks"] if not check["fine"]]
                if world["outcome"] == "wrong" else world["outcome"] for world in grade["worlds"] if world["outcome"] != "fine"
            }
        self.assertEqual(found, WRONG[name])

    def check_shape(self, name):
        """What every exercise has."""
        folder = EXERCISES / name
        self.assertTrue((folder / "README.md").is_file())
        self.assertGreaterEqual(len(tomllib.loads((folder / "exercise.toml").read_text())["world"]), 2)
        self.assertGreaterEqual(len(tomllib.loads((folder / "hidden/hidden.toml").read_text())["world"]), 2)
        self.assertGreaterEqual(len(list((folder / "wrong").glob("*.meld"))), 2)


def add(name):
    def test(self):
        self.check_shape(name)
        self.check(name)

    setattr(Exercises, f"test_{name}", test)


for exercise in WRONG:
    add(exercise)


class All(Case):
    def test_each_exercise_has_a_row(self):
        self.assertEqual({path.parent.name for path in EXERCISES.glob("*/exercise.toml")}, set(WRONG))


if __name__ == "__main__":
    main("meldc", "meldsim")
