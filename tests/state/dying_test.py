"""Catoms that events end: dying_test.py --meldc PATH --meldsim PATH [unittest options]

Distances are those of a search through what is left, in every world in which catoms are on a lattice, on any number of processes.
"""
import collections
import json
import random
import re
import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))

from debug_test import GRADIENT, OWN, DebugTest  # noqa: E402
from frame import main, square  # noqa: E402

# Around each cell, by lattice: any cell that touches, whatever the order of ports.
AROUND = {"square": [(1, 0, 0), (0, 1, 0)], "cubic": [(1, 0, 0), (0, 1, 0), (0, 0, 1)]}
DIST = """type source(node).
type dist(node, min int).
type place(node, int, int, int).
type alone(node).
dist(A, 0) :- source(A).
dist(B, D + 1) :- neighbor(A, B), dist(A, D).
place(A, X, Y, Z) :- cell(A, X, Y, Z).
alone(A) :- neighborCount(A, 0).
"""
BODIES = """radius = 0.5
[[body]]
shape = "box(4, 4, 3)"
[motion]
kind = "bodies"
ground = -2
[facts]
source = "id == 0"
[[event]]
tick = 6
kill = ["z < -0.5", 40]
[[event]]
tick = 25
kill = 33
"""


def distances(cells, source, lattice):
    """By catom; cells by their numbers."""
    at = {cell: catom for catom, cell in cells.items()}
    found, queue = {source: 0}, collections.deque([source])
    while queue:
        catom = queue.popleft()
        for step in AROUND[lattice]:
            for sign in (1, -1):
                other = at.get(tuple(a + sign * b for a, b in zip(cells[catom], step)))
                if other is not None and other not in found:
                    found[other] = found[catom] + 1
                    queue.append(other)
    return found


class Dying(DebugTest):
    def run_of(self, program, world, *options):
        """Facts, digests, and the summary."""
        out = self.call("meldsim", "run", program, "--world", world, "--json", "--facts-out", "f", "--digest", "d", *options)[0]
        return self.read("f").decode(), self.read("d"), json.loads(out)

    def test_distances_are_those_of_what_is_left(self):
        self.write("dist.meld", DIST)
        rng = random.Random(5)
        for lattice, shape in (("square", "box(17, 13, 1)"), ("cubic", "box(9, 10, 8)")):
            world = f'lattice = "{lattice}"\n[[body]]\nshape = "{shape}"\n[facts]\nsource = "id == 7"\n'
            count = {"square": 17 * 13, "cubic": 720}[lattice]
            places = self.run_of("dist.meld", self.write("w.toml", world))[0]
            cells = {int(a): (int(x), int(y), int(z)) for a, x, y, z in re.findall(r"place\(@(\d+), (-?\d+), (-?\d+), (-?\d+)\)", places)}
            self.assertEqual(len(cells), count)
            killed = set()
            for tick in (3, 12, 14, 40):  # While the wave goes out, and when it has come to rest.
                some = rng.sample([i for i in range(count) if i != 7], count // 7)
                low = rng.randrange(-6, 3)
                region = f"x >= {low} && x < {low + 2} && y > {low}"
                killed |= {*some, *(c for c, (x, y, _) in cells.items() if c != 7 and low <= x < low + 2 and y > low)}
                world += f'[[event]]\ntick = {tick}\nkill = [{", ".join(map(str, some))}, "id != 7 && {region}"]\n'
            self.write("w.toml", world)
            expected = distances({c: cell for c, cell in cells.items() if c not in killed}, 7, lattice)
            facts, digests, summary = self.run_of("dist.meld", "w.toml")
            self.assertEqual({int(a): int(d) for a, d in re.findall(r"dist\(@(\d+), (\d+)\)", facts)}, expected)
            self.assertEqual((summary["killed"], summary["catoms"]), (len(killed), count - len(killed)))
            for processes, threads in ((1, 2), (2, 1), (3, 1), (4, 1)):
                others = self.run_of("dist.meld", "w.toml", "-n", processes, "--threads", threads)
                self.assertEqual((others[0], others[1], others[2]["killed"]), (facts, digests, len(killed)), f"{lattice}, {processes}")

    def test_what_moves(self):
        """Units and proposals of catoms that are killed go with them, and a run is the same on any number of processes."""
        world = (OWN / "storm.toml").read_text()
        self.write("w.toml", world + '[[event]]\ntick = 4\nevery = 3\ntimes = 12\nkill = "x == 1 || y == -2 && x > 0"\n')
        runs = [self.run_of(OWN / "storm.meld", "w.toml", "-n", n, "--ticks", 60)[:2] for n in (1, 2, 3)]
        self.assertEqual(runs[0], runs[1])
        self.assertEqual(runs[0], runs[2])

    def test_bodies(self):
        """What stood on them falls, and touches what is below."""
        self.write("dist.meld", "".join(line for line in DIST.splitlines(True) if "place(" not in line))
        self.write("w.toml", BODIES)
        first = None
        for processes in (1, 2, 3):
            facts, digests, summary = self.run_of("dist.meld", "w.toml", "-n", processes, "--ticks", 120)
            self.assertEqual((summary["killed"], summary["catoms"]), (18, 30))
            self.assertNotIn("@40", facts)
            first = first or (facts, digests)
            self.assertEqual((facts, digests), first)
        self.call("meldsim", "run", "dist.meld", "--world", "w.toml", "--ticks", 15, "--quiet", "--checkpoint", "kept")
        self.call("meldsim", "resume", "kept", "--ticks", 120, "--quiet", "-n", 2)

    def test_a_run_goes_on_from_a_checkpoint(self):
        self.write("dist.meld", DIST)
        events = '[[event]]\ntick = 9\nkill = "x > 2"\n[[event]]\ntick = 15\nkill = 3\n'
        self.write("w.toml", square(12) + '[facts]\nsource = "id == 0"\n' + events)
        facts, digests, _ = self.run_of("dist.meld", "w.toml")
        for ticks in (8, 9, 12):
            kept = f"kept{ticks}"
            self.call("meldsim", "run", "dist.meld", "--world", "w.toml", "--ticks", ticks, "--quiet", "--digest", "g", "--facts-out", "h",
                      "--checkpoint", kept)
            self.call("meldsim", "resume", kept, "--ticks", 10000, "--quiet", "-n", 2)
            self.assertEqual((self.read("h").decode(), self.read("g")), (facts, digests))

    def test_by_hand(self):
        """The world with what was done makes the same run, on any number of processes."""
        commands = ["to 20", "kill @42", "step", "kill dist(A, D), D > 4, D < 8", "to 140", "where", "back 53", "where", "to 140", "where",
                    "save-events e.toml", "events", "query dist(A, D), D > 4"]
        first = None
        for processes in (1, 2, 3):
            answers = self.answers(commands, GRADIENT, "-n", processes)
            first = first or answers
            self.assertEqual(answers[:5] + answers[10:], first[:5] + first[10:])
            self.assertEqual(answers[5]["digest"], answers[9]["digest"])
            self.assertEqual(answers[7]["tick"], 21)
            events = answers[11]["events"]
            self.assertEqual([(e["tick"], e["kind"]) for e in events], [(21, "kill"), (22, "kill")])
            self.assertEqual(events[0]["catoms"], [42])
            self.assertGreater(len(events[1]["catoms"]), 20)
            self.assertEqual(answers[12]["count"], 0)
        self.write("w.toml", GRADIENT.with_suffix(".toml").read_text() + self.read("e.toml").decode())
        digests = self.run_of(GRADIENT, "w.toml", "--ticks", 140)[1].decode()
        self.assertIn(first[5]["digest"], digests.splitlines()[-1])

    def test_failures_by_hand(self):
        """Back and forth over them, too."""
        self.write("dist.meld", DIST)
        self.write("w.toml", square(8) + '[facts]\nsource = "id == 0"\n')
        commands = ["to 12", "cut @9", "hang @20", "step", "cut @3 @4", "step 3", "restart dist(A, D), D > 9", "to 18", "heal @9", "to 45",
                    "where", "back 20", "where", "to 45", "where", "save-events e.toml", "events"]
        for processes in (1, 2, 3):
            answers = self.answers(commands, "dist.meld", "--world", "w.toml", "--by-links", "--ticks", 60, "-n", processes)
            self.assertEqual(answers[10]["digest"], answers[14]["digest"])
            events = answers[16]["events"]
            self.assertEqual([(e["tick"], e["kind"]) for e in events],
                             [(13, "cut"), (13, "hang"), (14, "cut"), (17, "restart"), (19, "heal")])
            self.assertEqual([e["catoms"] for e in events][:3], [[9], [20], [3, 4]])
            self.write("both.toml", self.read("w.toml").decode() + self.read("e.toml").decode())
            digests = self.run_of("dist.meld", "both.toml", "--ticks", 45)[1].decode()
            self.assertIn(answers[10]["digest"], digests.splitlines()[-1])
        for command in ("cut @3", "hang @3"):
            self.assertIn("--by-links", self.session([command], "dist.meld", "--world", "w.toml", code=2)[1])
        self.assertIn("no catom @99", self.session(["heal @3 @99"], "dist.meld", "--world", "w.toml", "--by-links", code=2)[1])

    def test_failures_of_several_and_around_them_by_hand(self):
        self.write("dist.meld", DIST)
        self.write("w.toml", square(8) + '[facts]\nsource = "id == 0"\n[network]\nlongest_jam = 30\n')
        commands = ["to 12", "cut around cell(A, X, Y, _), X >= 2", "to 60", "query dist(A, D), cell(A, X, Y, _), X >= 2",
                    "heal around cell(A, X, Y, _), X >= 2", "to 80", "jam 12 @0", "jam 9 around @3 @4 @5", "kill @50 @51", "hang @9 @9 @8",
                    "to 130", "where", "back 40", "to 130", "where", "save-events e.toml", "events"]
        for processes in (1, 2):
            answers = self.answers(commands, "dist.meld", "--world", "w.toml", "--ticks", 200, "-n", processes)
            self.assertEqual(answers[3]["count"], 0)
            self.assertEqual(answers[11]["digest"], answers[14]["digest"])
            events = answers[16]["events"]
            self.assertEqual([(e["tick"], e["kind"], e.get("ticks")) for e in events],
                             [(13, "cut", None), (61, "heal", None), (81, "jam", 12), (81, "jam", 9), (81, "kill", None),
                              (81, "hang", None)])
            self.assertEqual([e["catoms"] for e in events[2:]], [[0], [3, 4, 5], [50, 51], [9, 8]])
            self.assertEqual(events[0]["catoms"], events[1]["catoms"])
            self.write("both.toml", self.read("w.toml").decode() + self.read("e.toml").decode())
            digests = self.run_of("dist.meld", "both.toml", "--ticks", 130)[1].decode()
            self.assertIn(answers[11]["digest"], digests.splitlines()[-1])
        for command, says in (("jam 31 @0", "late by more than 30 ticks"), ("jam @0", "'@0'"), ("jam 3", "the catom is missing"),
                              ("cut @1 @2 @3", "@3 is a third one"), ("cut around", "the catom is missing"),
                              ("kill @1 @99", "no catom @99"), ("cut around dist(A, 99)", "holds for no catom")):
            self.assertIn(says, self.session([command], "dist.meld", "--world", "w.toml", code=2)[1], command)
        self.write("w.toml", square(8))
        self.assertIn("[network] longest_jam", self.session(["jam 3 @0"], "dist.meld", "--world", "w.toml", "--by-links", code=2)[1])

    def test_history_of_what_went_with_its_catom(self):
        """No rule is named that has not fired, and no event that has taken nothing."""
        self.write("k.meld", "type linear token(node, int).\ntype linear done(node, int).\ntype base(node).\ntype view(node).\n"
                   "token(@2, 0).\ntoken(A, N), N > 4 -o done(A, N).\nview(A) :- base(A).\n")
        self.write("k.toml", 'lattice = "square"\n[[body]]\nshape = "box(5, 1, 1)"\n[facts]\nbase = "all"\n[[event]]\ntick = 6\nkill = 2\n')
        for processes in (1, 2):
            for fact in ("token(@2, _)", "base(@2)", "view(@2)"):
                out = self.call("meldsim", "history", "k.meld", fact, "-n", processes, "--quiet")[0]
                self.assertRegex(out, r"tick 6 +-\S+ *\S* +gone with its catom\n")
                self.assertNotRegex(out, "consumed|taken|no longer")

    def test_a_branch_after_the_events(self):
        """What has happened is not looked for again."""
        self.write("dist.meld", DIST)
        self.write("w.toml", square(6) + '[facts]\nsource = "id == 0"\n[[event]]\ntick = 3\nkill = ["x > 1", 4]\n')
        self.call("meldsim", "run", "dist.meld", "--world", "w.toml", "--ticks", 8, "--quiet", "--checkpoint", "kept")
        self.assertNotIn("nothing is killed", self.call("meldsim", "fork", "kept", "--ticks", 12, "--quiet")[1])

    def test_why_not_says_when_a_catom_went(self):
        self.write("dist.meld", DIST)
        self.write("w.toml", square(6) + '[facts]\nsource = "id == 0"\n[[event]]\ntick = 3\nkill = [7]\n'
                   '[[event]]\ntick = 5\nkill = "id == 9"\n')
        for catom, says in ((7, "there is no catom @7: it was killed in tick 3"),
                            (9, "there is no catom @9: it went in tick 5, in which an event killed a region"),
                            (99, "there is no catom @99")):
            for processes in (1, 2):
                out, _ = self.call("meldsim", "why-not", "dist.meld", f"dist(@{catom}, 2)", "--world", "w.toml", "--quiet", "-n", processes)
                self.assertIn(says, out)
                self.assertNotIn("@99: ", out)
        # From a checkpoint nobody knows what was before.
        self.call("meldsim", "run", "dist.meld", "--world", "w.toml", "--ticks", 8, "--quiet", "--checkpoint", "kept")
        out, _ = self.call("meldsim", "why-not", "kept", "dist(@7, 2)", "--quiet")
        self.assertIn("there is no catom @7", out)
        self.assertNotIn("@7: ", out)

    def test_what_is_wrong(self):
        self.write("dist.meld", DIST)
        for kill, says in (("true", "kill is true or false, not a region"), ('"x >"', "w.toml:6"), ("-1", "there is no catom @-1"),
                           ('[3, 1.5]', "w.toml:6:12: kill is"), ("[]", "this [[event]] does nothing")):
            self.write("w.toml", square(3) + f"[[event]]\ntick = 2\nkill = {kill}\n")
            err = self.call("meldsim", "run", "dist.meld", "--world", "w.toml", code=2)[1]
            self.assertIn(says, err)
        self.write("w.toml", square(3) + '[facts]\nsource = "all"\n[[event]]\ntick = 2\nkill = ["x > 9", 77]\n')
        err = self.call("meldsim", "run", "dist.meld", "--world", "w.toml", "--quiet", "-n", 2)[1]
        self.assertIn("`x > 9` matches no catom, so nothing is killed", err)
        self.assertIn("there is no catom @77, so nothing is killed", err)
        for command, says in (("kill @99", "there is no catom @99 in tick 0"), ("kill", "the catom is missing"),
                              ("kill 1 < 2", "no variable is a catom"), ("kill x == 0", "or a body, as in kill cell(A, X, Y, Z), X = 0"),
                              ("kill dist(A, 99)", "holds for no catom in tick 0")):
            out, err = self.session([command], "dist.meld", "--world", "w.toml", code=2)
            self.assertIn(says, err)
            self.assertEqual(out, "")


if __name__ == "__main__":
    main("meldc", "meldsim")
