"""Linear facts to nodes of a graph that no link leads to: far_test.py --meldc PATH --meldsim PATH [unittest options]

They take a shortest route that there is, a tick a link, or one hop, as [network] reach says; and whatever happens to links and nodes, they
arrive or are counted, on any number of processes and with a checkpoint on the way.
"""
import json
import pathlib
import re
import sys

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1]))

import networkx as nx  # noqa: E402

from frame import CAMPAIGN, Case, main  # noqa: E402

# Each node sends its number, and when, to a node that it knows by a fact.
LETTERS = """type linear letter(node, node, int).
type linear start(node).
type goal(node, node).
type got(node, node, int Sent, int Came).
start(A).
start(A), goal(A, B), tick(A, T) -o letter(B, A, T).
letter(B, A, S), tick(B, T) -o got(B, A, S, T).
"""
RETURNED = """type linear undelivered-letter(node, node To, node, int).
type back(node At, node To, node From).
undelivered-letter(A, B, F, S) -o back(A, B, F).
"""
# Every node keeps sending for a while, and says something of what arrives, so that digests depend on all of it.
TALK = """type linear todo(node, int).
type linear word(node, node, int).
type linear undelivered-word(node, node To, node, int).
type heard(node, node, int).
type back(node, node, int).
todo(A, 12).
type goal(node, int, node).
todo(A, N), goal(A, N, B) -o word(B, A, N), todo(A, N - 1)@+2.
word(B, A, N) -o heard(B, A, N).
undelivered-word(A, B, _, N) -o back(A, B, N).
"""
RANDOM = 'lattice = "graph"\ngraph = "random(40, 0.06)"\nseed = 4\n'
TROUBLE = """[[event]]
tick = 4
cut = "id % 7 == 2"
[[event]]
tick = 6
kill = [3, 17]
hang = 20
[[event]]
tick = 9
join = [[1, 39], [2, 25], [9, 30]]
[[event]]
tick = 15
heal = "all"
restart = [20, 5]
"""
FAULTS = "[faults]\nkill = 0.002\ncut = 0.02\nheal = 0.1\nrestart = 0.004\nuntil = 40\n"
CONDITIONS = {
    "ideal": "",
    "latency": '[network]\nkind = "latency"\nmost = 4\n',
    "lossy": '[network]\nkind = "lossy"\nloss = 0.3\nretry = 2\ntries = 4\n[[network.region]]\nwhere = "id < 9"\nleast = 3\n',
    "raw": '[network]\nkind = "raw"\nmost = 5\nloss = 0.1\nduplicate = 0.1\nreorder = true\n',
    "turns": '[clock]\nkind = "sequential"\n',
    "pauses": '[clock]\nkind = "random"\nrate = 0.4\nmost = 5\n',
}


def letters(nodes, more=""):
    return LETTERS + more + "".join(f"goal(@{i}, @{(i * 7 + 3) % nodes}).\n" for i in range(nodes))


def talk():
    return TALK + "".join(f"goal(@{i}, {n}, @{(i * n * 5 + 11) % 40}).\n" for i in range(40) for n in range(1, 13))


def with_reach(conditions, reach):
    if "[network]\n" in conditions:
        return conditions.replace("[network]\n", f'[network]\nreach = "{reach}"\n')
    return f'[network]\nreach = "{reach}"\n' + conditions


class Far(Case):
    def run_in(self, world, *options, program="p.meld"):
        self.write("w.toml", world)
        out, _ = self.call("meldsim", "run", program, "--world", "w.toml", "--json", "--quiet", "--facts-out", "facts", *options)
        return json.loads(out), self.read("facts").decode()

    def letters(self, facts):
        return {(int(a), int(b)): int(came) - int(sent)
                for b, a, sent, came in re.findall(r"got\(@(\d+), @(\d+), (\d+), (\d+)\)", facts)}

    def test_they_take_shortest_routes_a_tick_a_link(self):
        for number, graph in enumerate((nx.cycle_graph(31), nx.barabasi_albert_graph(50, 2, seed=3), nx.balanced_tree(2, 4))):
            n = len(graph)
            nx.write_edgelist(graph, self.folder / "e.txt", data=False)
            self.write("p.meld", letters(n))
            far = dict(nx.all_pairs_shortest_path_length(graph))
            expected = {(i, (i * 7 + 3) % n): far[i][(i * 7 + 3) % n] for i in graph}
            for reach in ("links", "any"):
                found, facts = self.run_in(f'lattice = "graph"\nlinks = "e.txt"\n[network]\nreach = "{reach}"\n', "--ticks", 60, "-n",
                                           1 + number)
                want = {pair: d if reach == "links" else min(d, 1) for pair, d in expected.items()}
                self.assertEqual(self.letters(facts), want)
                self.assertEqual((found["far_facts"], found["far_messages"], found["dropped_messages"]), (n, sum(want.values()), 0))
                self.assertEqual(found["linear_messages"], sum(want.values()))

    def test_without_a_route_they_come_back_or_are_dropped(self):
        parts = nx.disjoint_union(nx.cycle_graph(9), nx.path_graph(7))
        nx.write_edgelist(parts, self.folder / "e.txt", data=False)
        world = 'lattice = "graph"\nlinks = "e.txt"\n'
        apart = {(i, (i * 7 + 3) % 16) for i in range(16) if (i < 9) != ((i * 7 + 3) % 16 < 9)}
        self.assertTrue(apart)
        for n in (1, 2, 3):
            self.write("p.meld", letters(16))
            found, facts = self.run_in(world, "--ticks", 30, "-n", n)
            self.assertEqual(found["dropped_messages"], len(apart))
            self.assertEqual(len(self.letters(facts)), 16 - len(apart))
            self.write("p.meld", letters(16, RETURNED))
            found, facts = self.run_in(world, "--ticks", 30, "-n", n)
            self.assertEqual(found["dropped_messages"], 0)
            self.assertEqual({(int(a), int(b)) for a, b in re.findall(r"back\(@(\d+), @(\d+),", facts)}, apart)
            # One hop goes anywhere but to nodes that are not there.
            found, facts = self.run_in(world + '[network]\nreach = "any"\n[[event]]\ntick = 1\nkill = 3\n', "--ticks", 30, "-n", n)
            gone = {(i, 3) for i in range(16) if i != 3 and (i * 7 + 3) % 16 == 3}
            self.assertEqual(len(self.letters(facts)), 15 - len(gone))
            self.assertEqual(found["dropped_messages"] + len(re.findall(r"back\(", facts)), len(gone))

    def test_they_find_another_way_when_links_go(self):
        # A ring that is cut behind the letter, before it, and closed by a new link.
        self.write("p.meld", "type linear letter(node, int).\ntype got(node, int).\n"
                             "type linear go(node).\ngo(@0).\ngo(A) -o letter(@5, 1).\nletter(A, 1), tick(A, T) -o got(A, T).\n")
        ring = 'lattice = "graph"\ngraph = "ring(12)"\n'
        def came(events):
            said = {self.run_in(ring + events, "--ticks", 40, "-n", n)[1] for n in (1, 2, 3)}
            self.assertEqual(len(said), 1)
            return int(re.search(r"got\(@5, (\d+)\)", said.pop())[1])
        whole = came("")
        self.assertEqual(came("[[event]]\ntick = 3\ncut = [[0, 1]]\n"), whole)
        # It is at @3 when it learns of the cut, and goes all the way back: ten links instead of two.
        self.assertEqual(came("[[event]]\ntick = 3\ncut = [[3, 4]]\n"), whole + 8)
        self.assertEqual(came("[[event]]\ntick = 2\njoin = [[1, 5]]\n"), whole - 3)

    def test_on_any_number_of_processes_and_with_a_checkpoint(self):
        self.write("p.meld", talk())
        for name, conditions in CONDITIONS.items():
            for reach in ("links", "any"):
                world = RANDOM + with_reach(conditions, reach) + (TROUBLE if name != "pauses" else FAULTS)
                seen = []
                for n in (1, 2, 3, 4) if CAMPAIGN else (1, 3):
                    found, facts = self.run_in(world, "--digest", "d", "--digest-check", 1, "-n", n, "--threads", 1 + n % 2)
                    seen.append((facts, self.read("d"), found["far_facts"], found["far_messages"], found["dropped_messages"]))
                    with self.subTest(name, reach=reach, processes=n):
                        self.assertEqual(seen[-1], seen[0])
                self.assertIn("heard(", seen[0][0])
                for stop, n in ((5, 1), (9, 2), (17, 3)) if CAMPAIGN else ((9, 3),):
                    with self.subTest(name, reach=reach, stop=stop):
                        folder = f"c-{name}-{reach}-{stop}"
                        self.call("meldsim", "run", "p.meld", "--world", "w.toml", "--ticks", stop, "--checkpoint", folder, "--digest", "d",
                                  "--facts-out", "again", "--quiet", "-n", n)
                        self.call("meldsim", "resume", folder, "--ticks", 100000, "--quiet", "-n", 4 - n)
                        self.assertEqual(self.read("d"), seen[0][1])
                        self.assertEqual(self.read("again").decode(), seen[0][0])

    def test_every_word_is_heard_comes_back_or_is_counted(self):
        self.write("p.meld", talk())
        for name in ("ideal", "latency", "lossy"):
            for reach in ("links", "any"):
                world = RANDOM + with_reach(CONDITIONS[name], reach) + "[[event]]\ntick = 7\nkill = 'id > 35'\n"
                found, facts = self.run_in(world, "-n", 2)
                said = 36 * 12 + 4 * 3
                here = len(re.findall(r"heard\(|back\(", facts))
                # What the four had heard went with them.
                self.assertLessEqual(here + found["dropped_messages"] + found["lost_linear_facts"], said)
                self.assertGreaterEqual(here + found["dropped_messages"] + found["lost_linear_facts"], said - 4 * 12)

    def test_a_program_that_lists_its_links_needs_no_world(self):
        self.write("p.meld", "type route edge(node, node).\ntype linear go(node).\ntype linear letter(node, node).\ntype got(node, node).\n"
                             "edge(@0, @700). edge(@700, @9). edge(@9, @3).\ngo(@0).\n"
                             "go(A) -o letter(@3, A).\nletter(A, B) -o got(A, B).\n")
        out, err = self.call("meldsim", "run", "p.meld", "--quiet", "--facts-out", "-")
        self.assertIn("got(@3, @0).", out)
        # It needs no links either, if it reads none of the world.
        post = ("type linear go(node).\ntype linear letter(node).\ntype got(node).\ngo(@0).\ngo(A) -o letter(@3).\n"
                "letter(A) -o got(A).\n")
        self.write("q.meld", post)
        out, err = self.call("meldsim", "run", "q.meld", "--quiet", "--facts-out", "-")
        self.assertEqual(out, "got(@3).\n")
        self.assertIn("the graph of @0, @3 and", err)
        # One that reads the links of the cube is in the cube.
        self.write("q.meld", post + "type near(node, node).\nnear(A, B) :- neighbor(A, B).\n")
        _, err = self.call("meldsim", "run", "q.meld", code=1)
        self.assertIn("E0502", err)
        self.assertIn('lattice = "graph"', err)

    def test_questions_can_be_asked(self):
        self.write("p.meld", letters(12))
        self.write("w.toml", 'lattice = "graph"\ngraph = "ring(12)"\n')
        self.call("meldsim", "run", "p.meld", "--world", "w.toml", "--ticks", 9, "--quiet", "--checkpoint", "c")
        out, _ = self.call("meldsim", "query", "c", "got(A, B, _, T)")
        self.assertEqual(len([line for line in out.splitlines() if "@" in line]), 12)
        # All that is sent crosses the same tick in one hop.
        self.write("w.toml", 'lattice = "graph"\ngraph = "ring(12)"\n[network]\nreach = "any"\n')
        for n in (1, 2):
            out, _ = self.call("meldsim", "messages", "p.meld", "--world", "w.toml", "--tick", 1, "--quiet", "-n", n)
            self.assertIn("tick 1: 12 messages", out)
            self.assertIn("@1 -> @10", out)

    def test_mistakes_have_cures(self):
        self.write("p.meld", talk())
        square = 'lattice = "square"\n[[body]]\nshape = "box(3, 3, 1)"\n'
        for world, said in ((square + '[network]\nreach = "any"\n', 'write lattice = "graph"'),
                            (RANDOM + '[network]\nreach = "all"\n', "any"),
                            (RANDOM + "[network]\nreech = 'any'\n", "did you mean 'reach'")):
            self.write("w.toml", world)
            _, err = self.call("meldsim", "world", "w.toml", code=2)
            self.assertIn(said, err)
        self.write("w.toml", square)
        _, err = self.call("meldsim", "run", "p.meld", "--world", "w.toml", code=1)
        self.assertIn("E0502", err)
        # A module knows what it was made for.
        self.call("meldc", "compile", "p.meld", "--graph", "-o", "p.so", "--quiet")
        _, err = self.call("meldsim", "run", "p.so", "--world", "w.toml", code=2)
        self.assertIn("compile --no-graph", err)
        self.write("v.meld", "type p(node, node).\ntype q(node).\np(@0, @5).\nq(B) :- p(A, B).\n")
        _, err = self.call("meldc", "check", "--no-graph", "v.meld", code=1)
        self.assertIn("--graph", err)
        _, err = self.call("meldc", "check", "v.meld")
        self.assertIn("N0906", err)


if __name__ == "__main__":
    main("meldc", "meldsim")
