"""Changes that concern no neighbour: concerned_test.py --meldc PATH --meldsim PATH [unittest options]

A catom is not evaluated because a neighbour's value changes that offers it nothing better and has not been what its own rests on.
Facts and digests of all ticks are those of runs that evaluate it: of programs with linear facts, in a network that takes as long.
"""
import itertools
import json
import pathlib
import sys

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1]))

import networkx as nx  # noqa: E402

from frame import CAMPAIGN, Case, main  # noqa: E402

DISTANCE = ("type source(node).\ntype dist(node, min int).\ndist(A, 0) :- source(A).\n"
            "dist(B, D + 1) :- neighbor(A, B), dist(A, D).\n")
# It remembers whom the value came from.
PARENT = ("type source(node).\ntype dist(node, min int, node).\ndist(A, 0, A) :- source(A).\n"
          "dist(B, D + 1, A) :- neighbor(A, B), dist(A, D, _).\n")
PROGRAMS = {
    "distance": DISTANCE,
    "parent": PARENT,
    # With what comes along with the winner, a test, and a second rule that offers.
    "widest": "type source(node).\ntype wide(node, max int, int Far).\nwide(A, 40, 0) :- source(A).\n"
              "wide(B, W - 3, F + 1) :- neighbor(A, B), wide(A, W, F), W > 6.\n"
              "wide(B, W / 2, 0) :- neighbor(A, B), wide(A, W, F), F > 2.\n",
    # Two that share a record, of which one waits for the other to be there.
    "both": DISTANCE + "type least(node, min int).\nleast(A, N) :- id(A, N), dist(A, D), D > 1.\n"
                       "least(B, N) :- neighbor(A, B), least(A, N).\n",
    # A change that does not concern the distance concerns others.
    "others": DISTANCE + "type around(node, sum int).\naround(B, D) :- neighbor(A, B), dist(A, D).\n",
}
TROUBLE = """[facts]
source = "id % 100 == 7"
[[event]]
tick = 9
kill = [107, 30, 31]
cut = "id % 11 == 2"
[[event]]
tick = 14
restart = "id % 20 == 3"
kill = 207
[[event]]
tick = 60
heal = "all"
[[event]]
tick = 61
take = { source = "id == 7" }
[[event]]
tick = 150
give = { source = "id == 50" }
"""
BOX = 'lattice = "fcc"\nseed = 3\n[[body]]\nshape = "box(7, 7, 7)"\n'
WORLDS = {
    "graph": 'lattice = "graph"\ngraph = "geometric(300, 0.09)"\nseed = 3\n' + TROUBLE +
             "[[event]]\ntick = 60\njoin = [[1, 200], [90, 91]]\n",
    "lattice": BOX + TROUBLE,
}
SLOW = '[network]\nkind = "latency"\nleast = {}\nmost = {}\n'
# With it, each link has a mailbox, and a catom is evaluated for each message. There are no such facts.
EACH = "type linear spare(node).\ntype spent(node).\nspare(A) -o spent(A).\n"


class Concerned(Case):
    def run_in(self, program, world, *options):
        self.write("p.meld", program)
        self.write("w.toml", world)
        out, _ = self.call("meldsim", "run", "p.meld", "--world", "w.toml", "--json", "--quiet", "--facts-out", "facts", "--digest", "d",
                           *options)
        return json.loads(out), self.read("facts").decode(), self.read("d")

    def test_a_search_in_breadth_evaluates_each_node_once(self):
        world = 'lattice = "graph"\ngraph = "small_world(500, 6, 0.1)"\n[facts]\nsource = "id == 0"\n'
        found, facts, _ = self.run_in(DISTANCE, world)
        self.assertEqual(found["evaluations"], 500)
        # The last values still go to their neighbours, in one more tick.
        depth = max(int(line.split(", ")[1].rstrip(").")) for line in facts.splitlines() if line.startswith("dist("))
        self.assertEqual(found["ticks"], depth + 2)

    def test_other_readers_are_evaluated_for_every_change(self):
        world = 'lattice = "graph"\ngraph = "small_world(500, 6, 0.1)"\n[facts]\nsource = "id == 0"\n'
        self.assertGreater(self.run_in(PROGRAMS["others"], world)[0]["evaluations"], 1000)

    def test_a_wave_through_a_lattice_evaluates_each_catom_once(self):
        for program in (DISTANCE, PARENT):
            found, facts, _ = self.run_in(program, BOX + '[facts]\nsource = "id == 0"\n')
            self.assertEqual(found["evaluations"], found["catoms"])
            depth = max(int(line.split(", ")[1].rstrip(").")) for line in facts.splitlines() if line.startswith("dist("))
            self.assertEqual(found["ticks"], depth + 2)

    def test_all_ticks_are_as_if_every_neighbour_were_evaluated(self):
        runs = [(1, 1), (1, 2), (2, 1), (3, 2), (4, 1)] if CAMPAIGN else [(1, 2), (3, 1)]
        for (name, program), (place, world) in itertools.product(PROGRAMS.items(), WORLDS.items()):
            told = self.run_in(program + EACH, world + SLOW.format(1, 1), "--ticks", 400)
            seen = set()
            for n, threads in runs:
                with self.subTest(name, world=place, processes=n, threads=threads):
                    found, facts, digests = self.run_in(program, world, "-n", n, "--threads", threads, "--ticks", 400)
                    self.assertEqual(facts, told[1])
                    self.assertEqual(digests, told[2])
                    seen.add((found["evaluations"], found["derivations"]))
            self.assertEqual(len(seen), 1)
            self.assertLessEqual(seen.pop()[0], told[0]["evaluations"])
            with self.subTest(name, world=place, checkpoint=True):
                self.run_in(program, world, "-n", 2, "--ticks", 62, "--checkpoint", f"c-{name}-{place}")
                self.call("meldsim", "resume", f"c-{name}-{place}", "--ticks", 400, "--quiet", "-n", 1)
                self.assertEqual(self.read("d"), told[2])

    def test_all_ticks_of_a_network_are_as_if_every_message_were_followed_by_an_evaluation(self):
        runs = [(1, 1), (1, 2), (2, 1), (3, 2), (4, 1)] if CAMPAIGN else [(1, 2), (3, 1)]
        delays = [(1, 1), (1, 4)] if CAMPAIGN else [(1, 4)]
        for (name, program), (place, world), (least, most) in itertools.product(PROGRAMS.items(), WORLDS.items(), delays):
            told = self.run_in(program + EACH, world + SLOW.format(least, most), "--ticks", 400)
            seen = set()
            for n, threads in runs:
                with self.subTest(name, world=place, most=most, processes=n, threads=threads):
                    found, facts, digests = self.run_in(program, world + SLOW.format(least, most), "-n", n, "--threads", threads,
                                                        "--ticks", 400)
                    self.assertEqual(facts, told[1])
                    self.assertEqual(digests, told[2])
                    seen.add((found["evaluations"], found["derivations"]))
            self.assertEqual(len(seen), 1)
            self.assertLessEqual(seen.pop()[0], told[0]["evaluations"] / (2 if name == "distance" else 1))
            with self.subTest(name, world=place, most=most, checkpoint=True):
                self.run_in(program, world + SLOW.format(least, most), "-n", 2, "--ticks", 62, "--checkpoint", f"s-{name}-{place}-{most}")
                self.call("meldsim", "resume", f"s-{name}-{place}-{most}", "--ticks", 400, "--quiet", "-n", 1)
                self.assertEqual(self.read("d"), told[2])

    def test_an_offer_without_a_value_is_found(self):
        # Worse than what the other node has, but an error wherever it is derived and remains.
        self.write("p.meld", "type start(node, int).\ntype least(node, min int).\nleast(A, N) :- start(A, N).\n"
                             "least(B, 3000000000 * N) :- neighbor(A, B), least(A, N).\n")
        world = 'lattice = "graph"\ngraph = "line(5)"\n[facts]\nstart = [{ where = "id == 2", args = [1] }]\n'
        seen = set()
        for more, options in (("", ()), ("", ("-n", 2)), (SLOW.format(1, 1), ())):
            self.write("w.toml", world + more)
            _, err = self.call("meldsim", "run", "p.meld", "--world", "w.toml", "--quiet", "--digest", "d", *options, code=1)
            seen.add((err.partition("meldsim: ")[2], self.read("d")))
        self.assertEqual(len(seen), 1)
        self.assertIn("a number became too large", seen.pop()[0])

    def test_components_are_those_of_networkx(self):
        graph = nx.random_geometric_graph(400, 0.05, seed=2)
        self.write("edges.csv", "".join(f"{a},{b}\n" for a, b in graph.edges))
        self.write("nodes.csv", "node\n" + "".join(f"{a}\n" for a in graph.nodes))
        program = "type label(node, min int).\nlabel(A, N) :- id(A, N).\nlabel(B, N) :- neighbor(A, B), label(A, N).\n"
        _, facts, _ = self.run_in(program, 'lattice = "graph"\nlinks = "edges.csv"\nnodes = "nodes.csv"\n')
        least = {node: min(part) for part in nx.connected_components(graph) for node in part}
        self.assertEqual(sorted(line for line in facts.splitlines() if line.startswith("label(")),
                         sorted(f"label(@{node}, {value})." for node, value in least.items()))


if __name__ == "__main__":
    main("meldc", "meldsim")
