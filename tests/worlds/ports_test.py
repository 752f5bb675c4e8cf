"""Ports of other robots: their numbers in programs, on any number of processes, in actions, and in runs that go on or are made again.

    ports_test.py --meldc PATH --meldsim PATH [unittest options]
"""
import pathlib
import re
import sys

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1]))

from frame import OPEN_MPI, Case, main  # noqa: E402

# For each robot its lattice, and of each number the port of the lattice that leads the same way: written down once more, from
# VisibleSim's and the Blinky Blocks' own sources.
ROBOTS = {"blinky": ("cubic", [5, 2, 0, 1, 3, 4]), "blinky-visiblesim": ("cubic", [5, 2, 0, 3, 1, 4]),
          "smartblocks": ("square", [1, 0, 3, 2]), "catoms2d": ("hex", [0, 1, 2, 3, 4, 5]),
          "catoms3d": ("fcc", [0, 1, 4, 5, 6, 7, 2, 3, 10, 11, 8, 9])}
SEES = """type sees(node, node, int).
type free(node, int).
type aim(node, int).
sees(A, B, P) :- neighbor(A, B, P).
free(A, P) :- vacant(A, P).
aim(A, P) :- target(A, P).
"""


def world(lattice, more=""):
    size = "3,3,1" if lattice in ("square", "hex") else "2,3,3"
    return f'lattice = "{lattice}"\n{more}[[body]]\nshape = "box({size})"\n[target]\nshape = "box(9,1,9)"\n'


class Ports(Case):
    FILES = {"sees.meld": SEES}

    def facts(self, program, name, *options, code=0):
        out, _ = self.call("meldsim", "run", program, "--world", name, "--quiet", "--facts-out", "-", *options, code=code,
                           environment=OPEN_MPI)
        return out.splitlines()

    @staticmethod
    def renumbered(lines, own):
        """Facts of the lattice's ports as another robot has them."""
        return sorted(re.sub(r"(\d+)\)\.$", lambda found: f"{own.index(int(found[1]))}).", line) for line in lines)

    def test_every_robot_is_here(self):
        self.write("w.toml", world("cubic", 'ports = "nobody"\n'))
        said = self.call("meldsim", "world", "w.toml", code=2)[1]
        self.assertEqual(re.search(r"one of (.*)$", said)[1].split(", "), ["lattice", *ROBOTS])

    def test_ports_have_the_numbers_of_a_robot(self):
        for robot, (lattice, own) in ROBOTS.items():
            self.write("w.toml", world(lattice))
            self.write("r.toml", world(lattice, f'ports = "{robot}"\n'))
            wanted = self.renumbered(self.facts("sees.meld", "w.toml"), own)
            for name, options in (("r.toml", []), ("w.toml", ["--ports", robot]), ("r.toml", ["-n", 2]), ("r.toml", ["--by-links"])):
                self.assertEqual(sorted(self.facts("sees.meld", name, *options)), wanted, f"{robot} {name} {options}")
            self.assertEqual(self.facts("sees.meld", "r.toml", "--ports", "lattice"), self.facts("sees.meld", "w.toml"))

    def test_actions_go_where_the_robots_ports_lead(self):
        # Blinky's 4 is to the south, and what it slides along is below, at its 0.
        self.write("m.meld", "slide(A, 0, 4) :- tick(A, 1), cell(A, 0, 1, 1).\ntype at-cell(node, int, int, int).\n"
                   "at-cell(A, X, Y, Z) :- cell(A, X, Y, Z).\n")
        self.write("m.toml", "ports = \"blinky\"\n[body]\ncells = [[0,0,0],[0,1,0],[0,1,1]]\n[motion]\nkind = \"lattice\"\n")
        for options in ([], ["-n", 2]):
            cells = {line.partition(", ")[2] for line in self.facts("m.meld", "m.toml", "--ticks", 5, *options) if "at-cell" in line}
            self.assertEqual(cells, {"0, 0, 0).", "0, 1, 0).", "0, 0, 1)."})

    def test_ports_only_change_numbers(self):
        # Two ways around a pivot are of one length: which is taken does not depend on what ports are called.
        program = "moveAround(A, @{}, @{}) :- tick(A, 1), id(A, {}).\ntype at-cell(node, int, int, int).\n" \
                  "at-cell(A, X, Y, Z) :- cell(A, X, Y, Z).\n"
        for robot, (lattice, _) in ROBOTS.items():
            cells = "[[0,0],[1,0],[2,0]]" if lattice in ("square", "hex") else "[[0,0,0],[1,0,0],[2,0,0]]"
            body = f'lattice = "{lattice}"\n[body]\ncells = {cells}\n[motion]\nkind = "lattice"\n'
            self.write("around.meld", program.format(1, 2, 0))
            self.write("around.toml", body)
            plain = self.facts("around.meld", "around.toml", "--ticks", 3)
            self.assertEqual(plain, self.facts("around.meld", "around.toml", "--ticks", 3, "--ports", robot))

    def test_runs_that_go_on_and_are_made_again_keep_their_ports(self):
        self.write("w.toml", world("cubic"))
        run = ["run", "sees.meld", "--world", "w.toml", "--ports", "blinky", "--quiet", "--record", "r.vtkhdf", "--checkpoint", "c"]
        self.call("meldsim", *run, environment=OPEN_MPI)
        wanted = {line for line in self.facts("sees.meld", "w.toml", "--ports", "blinky") if line.startswith("sees(@0")}
        for target in ("r.vtkhdf", "c"):
            out = self.call("meldsim", "query", target, "sees(@0, B, P)", "--quiet", "--csv", environment=OPEN_MPI)[0]
            seen = [line.replace("@", "").split(",") for line in out.splitlines()[1:]]
            self.assertEqual({f"sees(@0, @{other}, {port})." for other, port in seen}, wanted, target)
        self.assertIn("the same", self.call("meldsim", "replay", "r.vtkhdf", environment=OPEN_MPI)[0])
        said = self.call("meldsim", "fork", "c", "--ports", "lattice", "--quiet", code=6, environment=OPEN_MPI)[1]
        self.assertIn("the ports had the numbers of 'blinky', and now those of 'lattice'", said)
        self.refused("meldsim", "query", "r.vtkhdf", "sees(A, B, P)", "--ports", "blinky", code=2, says="--ports has no place here",
                     lines=None)

    def test_a_program_of_another_robot_is_warned_of_where_its_world_does_not_say(self):
        self.write("top.meld", "const top = 5.\ntype end(node).\nend(A) :- vacant(A, top).\n")
        self.write("w.toml", world("cubic"))
        self.write("r.toml", world("cubic", 'ports = "blinky"\n'))
        self.write("f.toml", world("fcc"))
        self.write("plain.toml", world("cubic", 'ports = "lattice"\n'))

        def said(*options):
            return self.call("meldsim", "run", "top.meld", "--quiet", *options, environment=OPEN_MPI)[1]

        # On the fcc lattice 5 is one of the upper four.
        for options in (["--world", "r.toml"], ["--world", "w.toml", "--ports", "blinky"], ["--world", "f.toml"],
                        ["--world", "plain.toml"]):
            self.assertEqual(said(*options), "", options)
        for options in (["--world", "w.toml"], []):
            text = said(*options)
            self.assertIn("warning[W0409]: `top` is port 5, as on Blinky Blocks", text)
            self.assertIn('write ports = "blinky" (0 bottom, 1 north, 2 east, 3 west, 4 south, 5 top)', text)

    def test_wrong_robots_are_errors(self):
        self.write("w.toml", world("cubic"))
        for robot, says in (("blinki", "--ports: there is no robot 'blinki' whose ports are known. did you mean 'blinky'?"),
                            ("smartblocks", "--ports: ports = \"smartblocks\" numbers the sides of SmartBlocks, which stand on the ")):
            said = self.call("meldsim", "run", "sees.meld", "--world", "w.toml", "--ports", robot, code=2, environment=OPEN_MPI)[1]
            self.assertIn(says, said)


if __name__ == "__main__":
    main("meldc", "meldsim")
