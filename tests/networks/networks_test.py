"""Networks that take time and clocks that pause: networks_test.py --meldc PATH --meldsim PATH [unittest options]

Where a message always takes one tick, a run is that of the ideal network, tick by tick. Under all other conditions views end as they would
there, and nothing depends on the number of processes.
"""
import json
import pathlib
import random
import sys

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1]))

from frame import CAMPAIGN, Case, main, one_in  # noqa: E402

EXAMPLES = pathlib.Path(__file__).resolve().parents[2] / "examples" / "meld"
GRADIENT = """type source(node).
type dist(node, min int).
dist(A, 0) :- source(A).
dist(B, D + 1) :- neighbor(A, B), dist(A, D).
"""
WORLD = """lattice = "{lattice}"
seed = {seed}
[[body]]
shape = "box({size})"
[facts]
source = ["id == 3", "id == 40"]
[[event]]
tick = 25
take = {{ source = "id == 40" }}
[[event]]
tick = 31
kill = ["id == 17", "id % 11 == 5"]
[[event]]
tick = 60
give = {{ source = "id == 7" }}
"""
ONE = '[network]\nkind = "latency"\n'
CONDITIONS = [
    '[network]\nkind = "latency"\nleast = 2\nmost = 6\n',
    '[network]\nkind = "lossy"\nloss = 0.2\nretry = 3\ntries = 30\n',
    '[clock]\nkind = "random"\nrate = 0.3\nmost = 7\n',
    '[clock]\nkind = "drift"\nmost = 5\n',
    '[clock]\nkind = "priority"\n',
    '[clock]\nkind = "sequential"\n',
    '[network]\nkind = "latency"\nmost = 3\n[[network.region]]\nwhere = "x > 0"\nleast = 5\nmost = 9\n[clock]\nkind = "drift"\nmost = 3\n',
]
TRICKLE = """type linear todo(node, int).
type linear heard(node, int).
todo(@0, 300).
todo(A, N), !neighbor(A, B), N > 0 -o heard(B, N), todo(A, N - 1)@+1.
"""


# Two facts that neighbours read, one of them with a list, and one that follows from both.
WAYS = """type source(node).
type way(node, min int, list node).
type top(node, max int).
type both(node, sum int).
way(A, 0, [A]) :- source(A).
way(B, D + 1, [B | W]) :- neighbor(A, B), way(A, D, W), D < 9.
top(A, 7) :- source(A).
top(B, X - 1) :- neighbor(A, B), top(A, X), X > 0.
both(B, X) :- neighbor(A, B), way(A, _, _), top(A, X).
"""
# With a linear fact, each link has a mailbox of its own.
UNSHARED = "type linear never(node, int).\nnever(A, N), N > 0 -o never(A, N - 1).\n"
TROUBLE = """[[event]]
tick = 6
cut = "id % 3 == 0"
[[event]]
tick = 8
jam = { where = "id % 2 == 0", ticks = 4 }
[[event]]
tick = 9
heal = "all"
[[event]]
tick = 13
restart = "id % 5 == 1"
[[event]]
tick = 27
hang = "id == 9"
[[event]]
tick = 34
restart = "id == 9"
[faults]
cut = 0.004
heal = 0.05
restart = 0.002
until = 50
"""


class Networks(Case):
    def digests(self, world, *options, program="p.meld", tick_by_tick=True):
        out, _ = self.call("meldsim", "run", program, "--world", world, "--digest", "-", "--digest-check", 2, "--quiet",
                           *options)
        lines = [line.split() for line in out.splitlines() if line.startswith("tick ")]
        self.assertTrue(lines)
        return lines if tick_by_tick else lines[-1][2]

    def test_one_tick_is_the_ideal_network(self):
        for program, ticks in (("gradient", 200), ("leader", 200), ("shape_change", 120), ("pagerank", 60)):
            path = EXAMPLES / f"{program}.meld"
            text = (EXAMPLES / f"{program}.toml").read_text()
            ideal = self.write(f"{program}.toml", text)
            one = self.write(f"{program}_one.toml", text + "\n" + ONE)
            with self.subTest(program):
                expected = self.digests(ideal, "--ticks", ticks, program=path)
                for processes in (1, 2):
                    self.assertEqual(self.digests(one, "--ticks", ticks, "-n", processes, program=path), expected)

    def test_views_end_as_in_the_ideal_network_on_any_number_of_processes(self):
        self.write("p.meld", GRADIENT)
        draw = random.Random(3)
        for number, conditions in enumerate(one_in(2, CONDITIONS)):
            shape = draw.choice([("square", "12, 9, 1"), ("cubic", "6, 5, 4"), ("fcc", "5, 5, 4"), ("hex", "10, 10, 1")])
            world = WORLD.format(lattice=shape[0], size=shape[1], seed=number)
            with self.subTest(conditions=conditions, lattice=shape[0]):
                ideal = self.digests(self.write("ideal.toml", world), tick_by_tick=False)
                name = self.write("apart.toml", world + conditions)
                alone = self.digests(name)
                self.assertEqual(alone[-1][2], ideal)
                for options in (("-n", 2), ("-n", 3, "--threads", 2)) if CAMPAIGN else (("-n", 3, "--threads", 2),):
                    self.assertEqual(self.digests(name, *options), alone)

    def facts_of_ticks(self, program, world, ticks, *options):
        out = []
        for tick in ticks:
            self.call("meldsim", "run", program, "--world", world, "--ticks", tick, "--facts-out", "f", "--quiet", *options)
            out.append(sorted(self.read("f").decode().splitlines()))
        return out

    def test_readers_who_share_what_they_know_know_the_same(self):
        self.write("p.meld", WAYS)
        self.write("unshared.meld", WAYS + UNSHARED)
        draw = random.Random(11)
        shapes = [("square", "12, 9, 1"), ("cubic", "6, 5, 4"), ("hex", "10, 10, 1")]
        for number, conditions in enumerate(one_in(2, [c for c in CONDITIONS if "priority" not in c and "sequential" not in c])):
            lattice, size = draw.choice(shapes)
            name = self.write("apart.toml", WORLD.format(lattice=lattice, size=size, seed=number) + TROUBLE + conditions)
            with self.subTest(conditions=conditions, lattice=lattice):
                ticks = (7, 10, 11, 16, 29, 200)
                expected = self.facts_of_ticks("unshared.meld", name, ticks)
                self.assertEqual(self.facts_of_ticks("p.meld", name, ticks), expected)
                self.assertEqual(self.facts_of_ticks("p.meld", name, ticks[1:3], "-n", 2), expected[1:3])
                whole = self.digests(name, "--ticks", 200)
                # A checkpoint in the middle of all this, and one more of the run that goes on from it.
                self.call("meldsim", "run", "p.meld", "--world", name, "--ticks", 10, "--checkpoint", f"s{number}", "--digest", "d.txt",
                          "--quiet", "-n", 1 + number % 2)
                for until in (12, 200):
                    self.call("meldsim", "resume", f"s{number}", "--ticks", until, "--quiet")
                digests = [line.split() for line in self.read("d.txt").decode().splitlines() if line.startswith("tick ")]
                self.assertEqual(digests, whole)

    def test_a_run_goes_on_with_what_was_under_way(self):
        self.write("p.meld", GRADIENT)
        world = WORLD.format(lattice="cubic", size="6, 5, 4", seed=5)
        for number, conditions in enumerate(one_in(3, CONDITIONS)):
            name = self.write("apart.toml", world + conditions)
            with self.subTest(conditions=conditions):
                whole = self.digests(name)
                for processes in (1, 2) if CAMPAIGN else (1 + number % 2,):
                    self.call("meldsim", "run", "p.meld", "--world", name, "--ticks", 28, "--checkpoint", f"c{number}{processes}",
                              "--checkpoint-every", 7, "--digest", "d.txt", "--quiet", "-n", processes)
                    self.call("meldsim", "resume", f"c{number}{processes}", "--ticks", 100000, "--quiet")
                    digests = [line.split() for line in self.read("d.txt").decode().splitlines() if line.startswith("tick ")]
                    self.assertEqual(digests, whole)

    def test_linear_facts_arrive_once_and_in_order_unless_the_network_is_raw(self):
        self.write("p.meld", TRICKLE)
        line = 'lattice = "square"\n[[body]]\nshape = "box(2, 1, 1)"\n'
        heard = {}
        for name, conditions in (("ideal", ""), ("latency", CONDITIONS[0]), ("lossy", CONDITIONS[1]),
                                 ("raw", '[network]\nkind = "raw"\nloss = 0.2\nduplicate = 0.1\nmost = 4\nreorder = true\n')):
            world = self.write(f"{name}.toml", line + conditions)
            for processes in (1, 2):
                out, _ = self.call("meldsim", "run", "p.meld", "--world", world, "--json", "--facts-out", "facts/", "--quiet", "-n",
                                   processes)
                summary = json.loads(out)
                facts = self.read("facts/heard.csv").decode().splitlines()[1:]
                heard.setdefault(name, []).append((sorted(facts), summary["dropped_messages"]))
            self.assertEqual(heard[name][0], heard[name][1])
        self.assertEqual(len(heard["ideal"][0][0]), 300)
        self.assertEqual(heard["latency"], heard["ideal"])
        self.assertEqual(heard["lossy"], heard["ideal"])
        out, err = self.call("meldsim", "run", "p.meld", "--world", "raw.toml")
        self.assertIn("dropped: lost on the way, or their target was not a neighbour", out)
        self.assertNotIn("was no longer a neighbour", err)
        raw, lost = heard["raw"][0]
        self.assertTrue(30 < lost < 100, lost)
        self.assertEqual(len(set(raw)), 300 - lost)
        self.assertTrue(5 < len(raw) - len(set(raw)) < 60)

    def test_a_link_over_which_nothing_comes_is_down_for_both(self):
        self.write("p.meld", GRADIENT + "type degree(node, int).\ndegree(A, N) :- neighborCount(A, N).\n")
        world = ('lattice = "square"\n[[body]]\nshape = "box(6, 1, 1)"\n[facts]\nsource = "id == 0"\n'
                 '[network]\nkind = "lossy"\nretry = 2\ntries = 4\n[[network.region]]\nwhere = "id == 3"\nloss = 1\n')
        self.write("w.toml", world)
        for processes in (1, 2, 3):
            self.call("meldsim", "run", "p.meld", "--world", "w.toml", "--facts-out", "facts/", "--quiet", "-n", processes)
            rows = {name: self.read(f"facts/{name}.csv").decode().splitlines()[1:] for name in ("degree", "dist")}
            # Nothing is ever sent between the last three, so nothing is lost there.
            self.assertEqual(len(rows["dist"]), 3)
            self.assertEqual(sorted(row.split(",")[-1] for row in rows["degree"]), ["1", "1", "1", "1", "2", "2"])

    def test_single_links_have_terms_of_their_own(self):
        # A line: from @0 to @1 a message takes 7 ticks, the other way 1; and @2 says nothing to @3 for long.
        self.write("links.csv", "from,to,least,most\n# measured\n0,1,7,7\n2,3,20,20\n")
        self.write("p.meld", GRADIENT + "type linear wait(node).\ntype came(node, int).\nwait(A).\n"
                   "wait(A), dist(A, _), tick(A, T) -o came(A, T).\n")
        for base in ('lattice = "square"\n[[body]]\nshape = "box(5, 1, 1)"\n', 'lattice = "graph"\ngraph = "line(5)"\n'):
            came = {}
            for source in (0, 4):
                self.write("w.toml", base + f'[facts]\nsource = "id == {source}"\n[network]\nkind = "latency"\nlinks = "links.csv"\n')
                for n in (1, 2, 3):
                    self.call("meldsim", "run", "p.meld", "--world", "w.toml", "--ticks", 60, "--facts-out", "f", "--quiet", "-n", n)
                    rows = [line for line in self.read("f").decode().splitlines() if line.startswith("came")]
                    self.assertEqual(came.setdefault(source, rows), rows)
            ticks = {s: [int(row.split(",")[1].strip(" ).")) for row in sorted(rows)] for s, rows in came.items()}
            self.assertEqual([b - a for a, b in zip(ticks[0], ticks[0][1:])], [7, 1, 20, 1])
            self.assertEqual([a - b for a, b in zip(ticks[4], ticks[4][1:])], [1, 1, 1, 1])
        # Terms that are not named are those of the network, and regions do not count.
        self.write("links.csv", "from to loss\n0 1 1\n")
        self.write("w.toml", base + '[facts]\nsource = "id == 0"\n[network]\nkind = "lossy"\ntries = 2\nlinks = "links.csv"\n'
                                    '[[network.region]]\nwhere = "all"\nloss = 0\n')
        for n in (1, 2):
            self.call("meldsim", "run", "p.meld", "--world", "w.toml", "--ticks", 40, "--facts-out", "f", "--quiet", "-n", n)
            self.assertEqual(len([line for line in self.read("f").decode().splitlines() if line.startswith("dist")]), 1)

    def test_a_bad_list_of_links_has_places_and_cures(self):
        self.write("p.meld", GRADIENT)
        world = 'lattice = "square"\n[[body]]\nshape = "box(3, 3, 1)"\n[network]\nkind = "lossy"\nlinks = "links.csv"\n'
        for text, said in (("", "begin with a line of names"), ("0,1,0.5\n", "links.csv:1:1: the first line does not name"),
                           ("from,to,los\n", "links.csv:1:9: links of this network have no term `los`. did you mean 'loss'"),
                           ("from,to,loss,loss\n", "links.csv:1:14: two columns"), ("from,to,loss\n0,1\n", "links.csv:2:1: here are 2"),
                           ("from,to,loss\n0,x,1\n", "links.csv:2:3: 'x' is no number of a catom"),
                           ("from,to,loss\n0,1,2\n", "links.csv:2:5: '2' is no probability"),
                           ("from,to,least\n0,1,0\n", "links.csv:2:5: '0' is no number of ticks"),
                           ("from,to,loss\n4,4,0\n", "links.csv:2:1: @4 has no link to itself"),
                           ("from,to,least,most\n0,1,5,2\n", "links.csv:2:1: most is 2, and least is 5"),
                           ("from,to,retry,tries\n0,1,500,500\n", "links.csv:2:1: a message may be under way for 249501 ticks"),
                           ("from,to,loss\n0,1,0\n1,0,0\n0,1,1\n", "links.csv:4:1: the link from @0 to @1 is in line 2 already"),
                           ("from,to,loss\n0,1,0\n1,9,0\n", "links.csv:3: there is no catom @9")):
            with self.subTest(text):
                self.write("links.csv", text)
                self.write("w.toml", world)
                _, err = self.call("meldsim", "run", "p.meld", "--world", "w.toml", code=2)
                self.assertIn(said, err)
        self.write("w.toml", world.replace('"lossy"', '"ideal"'))
        _, err = self.call("meldsim", "run", "p.meld", "--world", "w.toml", code=2)
        self.assertIn("`links` says nothing of what is ideal", err)
        self.write("w.toml", world.replace("links.csv", "none.csv"))
        _, err = self.call("meldsim", "run", "p.meld", "--world", "w.toml", code=2)
        self.assertIn("w.toml:6:", err)

    def test_mistakes_have_places_and_cures(self):
        self.write("p.meld", GRADIENT)
        base = 'lattice = "square"\n[[body]]\nshape = "box(3, 3, 1)"\n'
        for text, said in (
                ('[network]\nkind = "slow"\n', "latency"),
                ('[network]\nkind = "latency"\nleast = 5\nmost = 2\n', "most is 2, and least is 5"),
                ('[network]\nkind = "latency"\nloss = 0.1\n', "`loss` says nothing of what is latency"),
                ('[network]\nkind = "lossy"\nloss = 1.5\n', "loss"),
                ('[network]\nkind = "lossy"\nretry = 1000\ntries = 1000\n', "may be under way for"),
                ('[network]\nkind = "raw"\nloss = 0.1\n', "dist"),
                ('[network]\nkind = "latency"\n[[network.region]]\nmost = 3\n', "where"),
                ('[clock]\nkind = "random"\nrate = 0.5\n', "most"),
                ('[clock]\nkind = "drift"\nmost = 0\n', "most"),
                ('[clock]\nkind = "drift"\nmost = 3\nrate = 0.5\n', "rate"),
        ):
            with self.subTest(text):
                self.write("w.toml", base + text)
                _, err = self.call("meldsim", "run", "p.meld", "--world", "w.toml", code=2)
                self.assertIn(said, err)
                self.assertIn("w.toml", err)


if __name__ == "__main__":
    main("meldc", "meldsim")
