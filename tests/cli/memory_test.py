"""The memory that a run is expected to take, against what it has taken at its peak.

    memory_test.py --meldsim PATH [unittest options]

The expected peak is a range. Where its ends are near each other it is an estimate, which must be right within 20 %; where facts decide, the
peak must lie in the range.
"""
import json
import pathlib
import subprocess
import sys

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1]))

from frame import TOOLS, Case, main  # noqa: E402

EXAMPLES = pathlib.Path(__file__).parents[2] / "examples" / "meld"
NEAR = 1.2
# No rule makes anything.
NOTHING = "type seen(node).\ntype lonely(node).\nlonely(A) :- seen(A).\n"
# All catoms have something to read in the same tick.
ALL_AT_ONCE = """type x(node, int).
type best(node, max int).
x(A, I) :- id(A, I).
best(A, V) :- x(A, V).
best(A, V) :- neighbor(A, B), x(B, V).
"""


def cube(side, more="", lattice="cubic"):
    return f'lattice = "{lattice}"\n[[body]]\nshape = "box({side}, {side}, {side})"\n{more}'


def bodies(side, spacing):
    return f'[[body]]\nshape = "box({side}, {side}, {side})"\n[motion]\nkind = "bodies"\nground = {-2 * side}\nspacing = {spacing}\n'


class Runs(Case):
    def run_it(self, program, world, *options):
        """Returns the expected range and the peak, in MiB."""
        self.write("p.meld", program)
        self.write("w.toml", world)
        return self.run_files("p.meld", "w.toml", *options)

    def run_files(self, program, world, *options):
        summary = json.loads(self.call("meldsim", "run", program, "--world", world, "--json", *options)[0])
        least, most = (bytes / 2**20 for bytes in summary["expected_peak_bytes"])
        peak = summary["peak_bytes"] / 2**20
        if peak == 0:
            self.skipTest("the system does not tell how much memory a process has had")
        self.assertGreater(least, 0)
        self.assertLessEqual(least, most)
        return least, most, peak

    def expect_estimate(self, program, world, *options):
        least, most, peak = self.run_it(program, world, *options)
        self.assertLessEqual(most, NEAR * least, "a range, and no estimate")
        self.assertLessEqual(least / NEAR, peak)
        self.assertLessEqual(peak, most * NEAR)

    def expect_range(self, program, world, *options):
        least, most, peak = self.run_it(program, world, *options)
        self.assertGreater(most, NEAR * least, "an estimate, and no range")
        self.assertLessEqual(least / NEAR, peak)
        self.assertLessEqual(peak, most * NEAR)
        return least, most, peak


class Estimates(Runs):
    def test_one_catom_needs_what_a_process_needs(self):
        for n in ("1", "2"):
            self.expect_estimate(NOTHING, cube(1), "-n", n)

    def test_catoms_and_cells(self):
        self.expect_estimate(NOTHING, cube(70))
        self.expect_estimate(NOTHING, cube(70), "-n", "2")

    def test_bricks_around_a_thin_shell(self):
        shell = '[[body]]\nshape = "minus(sphere(60), sphere(59))"\n[motion]\nkind = "lattice"\n'
        least, most, peak = self.run_it(NOTHING, shell, "--ticks", "2")
        self.assertLessEqual(least / NEAR, peak)
        self.assertLessEqual(peak, least * NEAR)

    def test_bodies_and_their_contacts(self):
        for n in ("1", "2"):
            self.expect_estimate(NOTHING, bodies(30, 1), "--ticks", "2", "-n", n)

    def test_connected_bodies(self):
        self.expect_estimate(NOTHING, bodies(30, 1) + "[[motion.catoms]]\nconnected = true\n", "--ticks", "2")

    def test_nodes_and_links_of_graphs(self):
        for graph in ("scale_free(60k, 8)", "ring(150k)", "complete(900)"):
            self.expect_estimate(NOTHING, f'lattice = "graph"\ngraph = "{graph}"\n')

    def test_an_example_as_it_is(self):
        for name in ("gradient", "leader", "rolling"):
            self.expect_estimate((EXAMPLES / f"{name}.meld").read_text(), (EXAMPLES / f"{name}.toml").read_text(), "--ticks", "30")

    def test_recordings_and_checkpoints(self):
        self.expect_estimate(NOTHING, cube(50), "--record", "r.vtkhdf", "--ticks", "2")
        self.expect_estimate(NOTHING, cube(50), "--checkpoint", "kept", "--ticks", "2")


class Examples(Runs):
    def test_each_takes_what_was_expected(self):
        part, parts = (int(n) for n in TOOLS.part.split("/"))
        # Those without a world are parts of programs.
        whole = [program for program in sorted(EXAMPLES.glob("*.meld")) if program.with_suffix(".toml").exists()]
        for program in whole[part - 1::parts]:
            world = program.with_suffix(".toml")
            with self.subTest(program.stem):
                least, most, peak = self.run_files(program, world, "--ticks", "100")
                self.assertLessEqual(least / NEAR, peak)
                self.assertLessEqual(peak, most * NEAR)


class Ranges(Runs):
    def test_what_changes_in_one_tick(self):
        least, most, quiet = self.expect_range((EXAMPLES / "gradient.meld").read_text(), cube(60), "--ticks", "2")
        self.assertLess(quiet, least * NEAR)
        least, most, busy = self.expect_range(ALL_AT_ONCE, cube(60))
        self.assertGreater(busy, most / NEAR)

    def test_networks_in_which_messages_take_time(self):
        """What is not under way takes no memory but its place in the table of links, however many catoms there are."""
        program = (EXAMPLES / "gradient.meld").read_text()
        conditions = '[facts]\nsource = "id == 0"\n[network]\nkind = "latency"\nmost = 4\n'
        further = []
        for side in (45, 90):
            peak = self.expect_range(program, cube(side, conditions))[2]
            self.write("ideal.toml", cube(side, conditions.partition("[network]")[0]))
            further.append((peak - self.run_files("p.meld", "ideal.toml")[2]) * 2**20 / side**3)
        # What is under way is about as much as the surface of a cube. While each link had a mailbox, 650.
        self.assertLess(further[1], min(260, further[0] * NEAR), further)
        self.expect_range(ALL_AT_ONCE, cube(40, "".join(conditions.partition("[network]")[1:])))

    def test_bodies_that_connect(self):
        self.expect_range("connect(A, B) :- neighbor(A, B).\n", bodies(30, 1), "--ticks", "4")

    def test_a_recursion_that_follows_each_firing(self):
        """Its sets are small, and there are hundreds of them, one after the other."""
        program = ("type linear go(node, int).\ntype link(node, int, int).\ntype path(node, int, int).\n"
                   "path(A, X, Y) :- link(A, X, Y).\npath(A, X, Z) :- link(A, X, Y), path(A, Y, Z).\n"
                   "go(@0, 0).\ngo(A, N), N < 420 -o link(A, N, N + 1), go(A, N + 1).\n")
        self.write("p.meld", program)
        self.write("w.toml", cube(1))
        summary = json.loads(self.call("meldsim", "run", "p.meld", "--world", "w.toml", "--json", "--quiet")[0])
        # While all of these sets stayed in scratch memory, 669 MiB.
        self.assertLess(summary["peak_bytes"] / 2**20, 250)

    def test_routes_to_nodes_that_no_link_leads_to(self):
        program = ("type linear go(node).\ntype goal(node, node).\ntype linear letter(node).\ntype got(node).\ngo(A).\n"
                   "go(A), goal(A, B) -o letter(B).\nletter(A) -o got(A).\n" +
                   "".join(f"goal(@{i}, @{(7 * i + 3) % 3000}).\n" for i in range(3000)))
        self.expect_range(program, 'lattice = "graph"\ngraph = "scale_free(3000, 3)"\n')

    def test_graphs_that_are_easy_and_hard_to_divide(self):
        for graph in ("complete(900)", "random(40k, 0.0005)"):
            self.expect_range(NOTHING, f'lattice = "graph"\ngraph = "{graph}"\n', "-n", "2")

    def test_limits_between_the_ends_and_below_them(self):
        program, world = (EXAMPLES / "gradient.meld").read_text(), cube(60)
        least, most, _ = self.run_it(program, world, "--ticks", "2")
        for limit, code, says in ((most * 1.1, 0, ""), ((least + most) / 2, 0, "warning: the run needs"),
                                  (least * 0.9, 4, "meldsim: the world needs")):
            self.write("w.toml", world + f"[limits]\nmemory = {round(limit * 2**20)}\n")
            _, err = self.call("meldsim", "run", "p.meld", "--world", "w.toml", "--ticks", "2", code=code, stdout=subprocess.DEVNULL)
            self.assertEqual(err.count("needs"), 1 if says else 0, err)
            self.assertIn(says, err)

    def test_rows_and_messages(self):
        diffusing = (EXAMPLES / "temperature.meld").read_text()
        facts = '[facts]\ntemperature = [{ where = "id >= 0", args = [0, 20.0] }]\n'
        self.expect_range(diffusing, cube(25, facts), "--ticks", "10")


if __name__ == "__main__":
    main("meldsim", part={"default": "1/1", "metavar": "K/N", "help": "of the examples: every Nth, beginning with the Kth"})
