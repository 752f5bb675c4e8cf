"""Worlds that are graphs: programs find on them what networkx finds, on any number of processes.

    graphs_test.py --meldc PATH --meldsim PATH [unittest options]
"""
import json
import pathlib
import re
import resource
import sys

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1]))

import networkx as nx  # noqa: E402

from frame import Case, main  # noqa: E402

HOPS = """type source(node).
type dist(node, min int D).
dist(A, 0) :- source(A).
dist(B, D + 1) :- neighbor(A, B), dist(A, D).
"""
LENGTHS = """type source(node).
type link(node, node, int).
type dist(node, min int D).
dist(A, 0) :- source(A).
dist(B, D + W) :- neighbor(A, B), link(A, B, W), dist(A, D).
"""


def world(source, more=""):
    return f'lattice = "graph"\n{source}\n{more}'


class Graphs(Case):
    def facts(self, program, toml, predicate, *options, processes=(1, 2, 4)):
        """The facts of a predicate as tuples of numbers; the same, and the same digests, for each number of processes."""
        self.write("p.meld", program)
        self.write("w.toml", toml)
        seen = []
        for n in processes:
            self.call("meldsim", "run", "p.meld", "--world", "w.toml", "-n", n, "--quiet", "--facts-out", "f", "--digest", "d", *options)
            seen.append((self.read("f"), self.read("d")))
            self.assertEqual(seen[-1], seen[0], f"{n} processes")
        found = re.findall(rf"^{predicate}\(([^)]*)\)", seen[0][0].decode(), re.M)
        return {tuple(int(word.strip().lstrip("@")) for word in each.split(",")) for each in found}

    def expect_hops(self, graph, toml, sources, **how):
        expected = nx.multi_source_dijkstra_path_length(graph, sources, weight=None)
        self.assertEqual(self.facts(HOPS, toml, "dist", **how), set(expected.items()))

    def test_hops_are_those_of_networkx(self):
        for graph in (nx.gnp_random_graph(150, 0.02, seed=3), nx.barabasi_albert_graph(200, 3, seed=1), nx.star_graph(60)):
            nx.write_edgelist(graph, self.folder / "e.txt", data=False)
            # Nodes without links are not in the file.
            graph = graph.edge_subgraph(graph.edges)
            toml = world('links = "e.txt"', '[facts]\nsource = ["id == 0", "id == 7"]\n')
            self.expect_hops(graph, toml, [0, 7])

    def test_lengths_are_those_of_networkx(self):
        graph = nx.gnp_random_graph(80, 0.06, seed=5, directed=True)
        for number, (a, b) in enumerate(sorted(graph.edges)):
            graph[a][b]["weight"] = number * 7 % 23 + 1
        nx.write_weighted_edgelist(graph, self.folder / "e.csv", delimiter=",")
        facts = '[facts]\nsource = "id == 0"\n'
        found = self.facts(LENGTHS, world('links = "e.csv"\ndirected = true', facts), "dist")
        self.assertEqual(found, set(nx.single_source_dijkstra_path_length(graph, 0).items()))
        # Without directions the weights of the two differ.
        self.write("w.toml", world('links = "e.csv"', facts))
        self.refused("meldsim", "run", "p.meld", "--world", "w.toml", code=2, says="with another weight")

    def test_killed_nodes_and_facts_that_come_and_go(self):
        graph = nx.barabasi_albert_graph(120, 2, seed=8)
        nx.write_edgelist(graph, self.folder / "e.txt", data=False)
        events = """[facts]
source = "id == 11"
[[event]]
tick = 9
kill = [0, 1, 2, 50]
[[event]]
tick = 20
take = { source = "id == 11" }
give = { source = "id == 90" }
[[event]]
tick = 21
kill = "id % 13 == 5"
"""
        graph.remove_nodes_from([0, 1, 2, 50, *range(5, 120, 13)])
        self.assertGreater(nx.number_connected_components(graph), 1)
        self.expect_hops(graph, world('links = "e.txt"', events), [90])

    def test_generated_graphs_run(self):
        for text, graph in (("ring(50)", nx.cycle_graph(50)), ("hypercube(6)", nx.hypercube_graph(6)),
                            ("complete(30)", nx.complete_graph(30)), ("grid(7, 9)", nx.grid_2d_graph(7, 9)),
                            ("torus(5, 6)", nx.grid_2d_graph(5, 6, periodic=True))):
            far = max(nx.single_source_shortest_path_length(graph, next(iter(graph))).values())
            found = self.facts(HOPS, world(f'graph = "{text}"', '[facts]\nsource = "id == 0"\n'), "dist", processes=(1, 3))
            self.assertEqual(len(found), len(graph))
            self.assertEqual(max(d for _, d in found), far, text)

    def test_linear_facts_go_over_any_number_of_links(self):
        program = """type linear ping(node, node From).
type linear pong(node, node From).
type heard(node, node From).
type linear go(node).
go(@0).
go(A) -o { B | !neighbor(A, B) | ping(B, A) }.
ping(B, A), neighbor(B, A) -o pong(A, B).
pong(A, B) -o !heard(A, B).
"""
        toml = world('graph = "star(41)"')
        self.assertEqual(self.facts(program, toml, "heard"), {(0, n) for n in range(1, 41)})

    def test_columns_of_nodes_and_links_are_facts(self):
        program = """type link(node, node, float, string).
type level(node, int).
type name(node, string).
type out(node, string, float, string).
out(A, N, L * W, M) :- name(A, N), level(A, X), link(A, B, W, M), L = float(X).
type sum(node, sum int).
sum(A, L) :- level(A, L).
sum(A, L) :- neighbor(A, B), level(B, L).
"""
        self.write("e.csv", "from,to,length,road\noak,elm,0.5,A1\nelm,ash,2,B2\n")
        self.write("n.csv", "tree,level\nash,30\nelm,20\noak,10\n")
        toml = world('links = "e.csv"\nnodes = "n.csv"')
        self.assertEqual(self.facts(program, toml, "sum", processes=(1, 2)), {(0, 30), (1, 60), (2, 50)})
        text = self.read("f").decode()
        self.assertIn('out(@1, "elm", 40.0, "B2")', text)
        self.assertIn('out(@0, "oak", 5.0, "A1")', text)
        self.write("p.meld", "type link(node, node, float, string, int).\ntype p(node).\np(A) :- link(A, _, _, _, _).\n")
        self.refused("meldsim", "run", "p.meld", "--world", "w.toml", code=2, says="the links of the graph have 2 columns")
        self.write("p.meld", "type link(node, node, int).\ntype p(node).\np(A) :- link(A, _, _).\n")
        self.refused("meldsim", "run", "p.meld", "--world", "w.toml", code=2, says="takes the column length of the graph")

    def test_links_may_stand_in_the_world(self):
        toml = world("links = [[0, 1], [1, 2], [2, 0], [4, 5]]", '[facts]\nsource = "id == 1"\n')
        self.assertEqual(self.facts(HOPS, toml, "dist"), {(0, 1), (1, 0), (2, 1)})
        everywhere, toml = "type seen(node, int).\nseen(A, 1) :- id(A, _).\n", toml.split("[facts]")[0]
        self.assertEqual(len(self.facts(everywhere, toml, "seen")), 5)
        self.assertEqual(len(self.facts(everywhere, toml.replace("links", "nodes = 8\nlinks", 1), "seen")), 8)
        self.assertEqual(self.facts(everywhere, world("nodes = [7, 0, 3]\nlinks = [[7, 0]]"), "seen"), {(0, 1), (3, 1), (7, 1)})
        self.assertEqual(self.facts(everywhere, world("nodes = [4]\nlinks = []"), "seen"), {(4, 1)})
        for wrong, said in (("nodes = [0, 1]\nlinks = [[0, 5]]", "does not list node 5"),
                            ("nodes = [0, 0]\nlinks = []", "node 0 is listed already"),
                            ("nodes = []\nlinks = []", "nodes are numbers"),
                            ('nodes = [0, "a"]\nlinks = []', "nodes are numbers"),
                            ("links = [[0, 1, 2]]", "pairs of numbers"), ('links = [["a", 1]]', "pairs of numbers"), ("links = 7", "pairs"),
                            ("nodes = 3\nlinks = [[0, 5]]", "the links name @5, and the nodes are @0 to @2. write nodes = 6"),
                            ("links = [[0, -1]]", "pairs of numbers")):
            self.write("w.toml", world(wrong))
            _, err = self.call("meldsim", "world", "w.toml", code=2)
            self.assertIn("w.toml:", err)
            self.assertIn(said, err)

    def test_a_program_that_lists_its_links_is_its_own_world(self):
        ring = "".join(f"edge(@{a}, @{(a + 5) % 12}).\n" for a in range(12))
        program = ("type route edge(node, node).\ntype dist(node, min int).\n" + ring +
                   "dist(@3, 0).\ndist(A, D + 1) :- edge(A, B), dist(B, D).\ndist(B, D + 1) :- edge(A, B), dist(A, D).\n")
        self.write("p.meld", program)
        seen = []
        for n in (1, 2, 3):
            _, err = self.call("meldsim", "run", "p.meld", "-n", n, "--facts-out", "f", "--digest", "d", "--record", f"r{n}.vtkhdf")
            self.assertIn("p.meld:10: @7 and @0 do not touch in the default world, so this run takes place in the graph", err)
            seen.append((self.read("f"), self.read("d")))
        self.assertEqual(seen[1:], seen[:-1])
        graph = nx.Graph([(a, (a + 5) % 12) for a in range(12)])
        found = dict(re.findall(r"^dist\(@(\d+), (\d+)\)", seen[0][0].decode(), re.M))
        self.assertEqual({int(a): int(d) for a, d in found.items()}, nx.single_source_shortest_path_length(graph, 3))
        out, _ = self.call("meldsim", "replay", "r2.vtkhdf")
        self.assertIn("same", out)
        # Catoms that touch stay in the cube if the program needs it, and a world that is chosen counts.
        near = "type route edge(node, node).\ntype p(node).\nedge(@0, @1).\np(A) :- edge(A, _).\n"
        for more, catoms in (("", 2), ("p(A) :- neighborCount(A, 6).\n", 1000), ("p(A) :- vacant(A, 0).\n", 1000)):
            self.write("near.meld", near + more)
            out, _ = self.call("meldsim", "run", "near.meld", "--json", "--quiet")
            self.assertEqual(json.loads(out)["catoms"], catoms)
        self.write("cube.toml", 'lattice = "cubic"\n[[body]]\nshape = "box(5, 5, 5)"\n')
        _, err = self.call("meldsim", "run", "p.meld", "--world", "cube.toml", code=2)
        self.assertIn("do not touch", err)

    def test_a_graph_that_is_written_is_the_same_when_it_is_read(self):
        """Its links and nodes as CSV: programs find on them what they find on the graph, however that came about."""
        program = """type source(node).
type link(node, node{0}).
type name(node, string).
type there(node{0}).
type near(node, float X, float Y, node).
type dist(node, min int).
source(A) :- id(A, N), N < 3.
dist(A, 0) :- source(A).
dist(B, D + 1) :- neighbor(A, B), dist(A, D).
near(A, X, Y, B) :- position(A, X, Y, _), neighbor(A, B).
there(B{1}) :- link(B, _{1}).
"""
        self.write("weights.csv", "from,to,weight,road\n0,7,3,A\n7,2,0.5,\"B, \"\"C\"\"\"\n9,2,7,#\n")
        self.write("words.csv", "oak,\"san \"\"f\"\"\"\nelm,oak\n\"a, b\",elm\noak,elm\n")
        self.write("nodes.csv", "node,x,y,level\n0,0.1,2,9\n2,1,1,8\n7,5,5,7\n9,9,9,6\n4,0,0,5\n")
        self.write("g.json", json.dumps(nx.node_link_data(nx.DiGraph([("a", "b"), ("b", "a"), ("c", "a")]))))
        columns = (", float, string", ", W, R")
        for source, directed, (types, variables) in (
                *((f'graph = "{graph}"', False, ("", "")) for graph in (
                    "line(7)", "ring(9)", "star(8)", "complete(6)", "grid(4, 3)", "torus(3, 3, 3)", "hypercube(4)", "tree(20, 3)",
                    "random(40, 0.05)", "regular(20, 3)", "geometric(30, 0.2)", "scale_free(40, 2)", "small_world(30, 4, 0.2)")),
                ("links = [[0, 1], [2, 1]]\nnodes = 5", False, ("", "")), ('links = "weights.csv"', False, columns),
                ('links = "weights.csv"\nnodes = "nodes.csv"', False, columns), ('links = "words.csv"', False, ("", "")),
                ('links = "weights.csv"', True, columns), ('links = "words.csv"', True, ("", "")), ('links = "g.json"', True, ("", ""))):
            with self.subTest(source, directed=directed):
                toml = world(source, "seed = 5\n" + ("directed = true\n" if directed else ""))
                self.write("p.meld", program.format(types, variables))
                self.write("w.toml", toml)
                out, _ = self.call("meldsim", "world", "w.toml", "--links", "links.out", "--nodes", "nodes.out")
                self.assertRegex(out, r"links\.out: \d+ links\nnodes\.out: \d+ nodes\n")
                self.write("back.toml", world('links = "links.out"\nnodes = "nodes.out"', "directed = true\n" if directed else ""))
                found = []
                for name in ("w.toml", "back.toml"):
                    self.call("meldsim", "run", "p.meld", "--world", name, "--quiet", "--facts-out", "f", "--digest", "d")
                    found.append((self.read("f"), self.read("d"), self.call("meldsim", "world", name)[0].split(": ")[1]))
                self.assertEqual(found[0], found[1])
                self.assertIn(b"near", found[0][0])
                # Links alone, where each node has one.
                self.assertEqual(self.call("meldsim", "world", "w.toml", "--links", "-")[0].encode(), self.read("links.out"))
        self.write("cells.toml", 'lattice = "square"\n[[body]]\nshape = "box(2, 2, 1)"\n')
        err = self.call("meldsim", "world", "cells.toml", "--links", "l.csv", code=2)[1]
        self.assertIn("--links: cells.toml has a lattice, whose catoms are linked where they touch", err)
        self.write("g.json", json.dumps(nx.node_link_data(nx.Graph([("a\nb", "c")]))))
        self.write("w.toml", world('links = "g.json"'))
        self.assertIn("'a' has a line break", self.call("meldsim", "world", "w.toml", "--nodes", "n.csv", code=2)[1])
        self.assertFalse((self.folder / "n.csv").exists())

    def test_values_that_grow_along_a_graph_without_a_circle(self):
        """acyclic = true: no warning that they may grow for ever, and a graph that has a circle is refused."""
        longest = ("type source(node).\ntype link(node, node).\ntype way(node, int).\ntype last(node, max int).\n"
                   "way(A, 0) :- source(A).\nway(B, D + 1) :- neighbor(A, B), link(A, B), way(A, D).\nlast(A, D) :- way(A, D).\n")
        self.write("dag.csv", "from,to\n0,1\n1,2\n0,2\n3,2\n")
        self.write("circle.csv", "a,b\nb,c\nc,d\nd,b\n")
        directed, source = 'links = "dag.csv"\ndirected = true\n', '[facts]\nsource = "id == 0"\n'
        self.write("p.meld", longest)
        for toml, warned in ((directed, True), (directed + "acyclic = false\n", True), (directed + "acyclic = true\n", False)):
            self.write("w.toml", world(toml, source))
            _, err = self.call("meldsim", "run", "p.meld", "--world", "w.toml", "--quiet", "--facts-out", "f", "-n", 2)
            self.assertEqual("W0604" in err, warned, err)
            self.assertIn(b"last(@2, 2).", self.read("f"))
        self.write("w.toml", world('links = "circle.csv"\ndirected = true\nacyclic = true', source))
        self.refused("meldsim", "world", "w.toml", code=2, says=[
            'w.toml:4:11: acyclic = true, and these links lead in a circle: "b" -> "c" -> "d" -> "b". take one of them out'])
        for toml, says in (('links = "dag.csv"\nacyclic = true', "lead there and back. add directed = true"),
                           ('graph = "line(4)"\nacyclic = true', "acyclic goes with links, and this graph is generated"),
                           ('links = "dag.csv"\ndirected = true\nacyclic = 3', "acyclic")):
            self.write("w.toml", world(toml))
            self.refused("meldsim", "world", "w.toml", code=2, says=says)
        # Only what follows links in one direction ends with them.
        declared = "type source(node).\ntype link(node, node).\ntype p(node, int).\ntype q(node, int).\np(A, 0) :- source(A).\n"
        for rules, warned in (("p(B, D + 1) :- neighbor(A, B), link(B, A), p(A, D).\n", False),
                              ("p(C, D + 1) :- neighbor(A, B), link(A, B), q(A, D), neighbor(B, C), link(B, C).\nq(A, D) :- p(A, D).\n",
                               False),
                              ("p(B, D + 1) :- neighbor(A, B), p(A, D).\n", True),
                              ("p(A, D + 1) :- p(A, D).\n", True),
                              ("p(B, D + 1) :- neighbor(A, B), link(A, B), p(A, D).\n"
                               "p(B, D + 1) :- neighbor(A, B), link(B, A), p(A, D).\n", True),
                              ("p(B, D + 1) :- neighbor(A, B), link(A, B), q(A, D).\nq(A, D + 1) :- p(A, D).\np(A, D) :- q(A, D).\n", True),
                              ("link(@0, @1).\np(B, D + 1) :- neighbor(A, B), link(A, B), p(A, D).\n", True)):
            self.write("q.meld", declared + rules)
            with self.subTest(rules):
                _, err = self.call("meldc", "check", "q.meld", "--graph", "--acyclic")
                self.assertEqual("W0604" in err, warned, err)
                self.assertIn("W0604", self.call("meldc", "check", "q.meld", "--graph")[1])

    def test_numbers_with_gaps_stay(self):
        self.write("e.txt", "10 700\n700 3000000\n")
        found = self.facts(HOPS, world('links = "e.txt"', '[facts]\nsource = "id == 10"\n'), "dist")
        self.assertEqual(found, {(10, 0), (700, 1), (3000000, 2)})

    def test_what_makes_no_sense_is_refused(self):
        for text, says in (('graph = "ring(9)"\nlinks = "e.csv"', "w.toml:3:9: this world has both graph and links"),
                           ("", "w.toml:1:11: this world has neither graph nor links. write graph ="),
                           ('graph = "rign(9)"', "w.toml:2:9: there is no graph 'rign'. did you mean 'ring'?"),
                           ('graph = "ring(9)"\nheld = 1', "a graph has no held"),
                           ('graph = "ring(9)"\n[[body]]\nshape = "box(1,1,1)"', "a graph has no body"),
                           ('graph = "ring(9)"\n[motion]\nkind = "lattice"', "nodes of a graph do not move. take [motion] out"),
                           ('graph = "ring(9)"\ndirected = true', "directed goes with links"),
                           ('links = "no.csv"', "no.csv")):
            self.write("w.toml", world(text))
            self.refused("meldsim", "world", "w.toml", code=2, says=says)
        self.write("w.toml", 'lattice = "square"\ngraph = "ring(9)"\n[[body]]\nshape = "box(1,1,1)"\n')
        self.refused("meldsim", "world", "w.toml", code=2, says="w.toml:2:9: graph belongs to a graph, and this world has cells")

    def test_files_that_mean_harm_are_refused(self):
        deep = "[" * 100_000 + "]" * 100_000
        for name, text, says in (
                ("g.json", '{"nodes": [{"id": 18446744073709551615}, {"id": 0}], "links": []}', "18446744073709551615, is too large"),
                ("g.json", '{"nodes": [{"id": 9223372036854775807}], "links": []}', "9223372036854775807, is too large"),
                ("g.json", f'{{"nodes": [{{"id": {deep}}}], "links": []}}', "nested more than 100 levels deep"),
                ("g.json", f'{{"nodes": [{{"id": 1}}], "links": [{{"source": 1, "target": {deep}}}]}}', "nested more than 100"),
                ("g.json", json.dumps({"nodes": [{"id": 0, "x": float("nan")}], "links": []}),
                 'g.json:1:27: "x" is NaN, which is no number of JSON'),
                ("g.json", json.dumps({"nodes": [{"id": 0, "x": float("-inf")}]}), "allow_nan=False"),
                ("g.csv", "0,1\n9223372036854775807,2\n", "9223372036854775807 is too large")):
            self.write(name, text)
            self.write("w.toml", world(f'links = "{name}"'))
            self.refused("meldsim", "world", "w.toml", code=2, says=says)
        self.write("a.json", '{"nodes": [{"id": 9223372036854775806}, {"id": [0, [1]]}], "links": []}')
        self.write("w.toml", world('links = "a.json"'))
        self.call("meldsim", "world", "w.toml")

    def test_a_graph_that_does_not_fit_is_refused_before_it_is_made(self):
        self.write("a.mtx", "%%MatrixMarket matrix coordinate pattern general\n1000000000 1000000000 0\n")
        for text, says in (('graph = "complete(60000)"', "complete(60000): 60 k nodes and about 1.8 G links take 26.8 GiB to make"),
                           ('graph = "regular(200k, 100)"', "about 10 M links"),
                           ('graph = "line(1G)"', "line(1G): 1 G nodes"),
                           ('links = [[0, 1]]\nnodes = "1G"', "meldsim: w.toml:2:9: 1 G nodes"),
                           ('links = "a.mtx"', "a.mtx: 1 G nodes")):
            for limit, kept, says_limit in (("", 1 << 32, "left by ulimit -d"), ('memory = "300MiB"', None, "allowed by [limits] memory")):
                self.write("w.toml", world(text, f"[limits]\n{limit}\n"))
                if kept and "regular" in text:
                    continue
                less = {"preexec_fn": lambda: resource.setrlimit(resource.RLIMIT_DATA, (kept, kept))} if kept else {}
                self.refused("meldsim", "world", "w.toml", code=4, says=[says, says_limit], **less)

    def test_nodes_that_make_ever_more_end_the_run_while_there_is_memory(self):
        self.write("p.meld", "type linear grow(node).\ngrow(@0).\ngrow(A) -o exists X, Y. (grow(X), grow(Y)).\n")
        self.write("w.toml", world('graph = "ring(6)"', '[limits]\nmemory = "200MiB"\n'))
        for n in ("1", "2"):
            # Should it fail, the machine is to go on.
            self.refused("meldsim", "run", "p.meld", "--world", "w.toml", "--quiet", "-n", n, code=4, says=" catoms came in tick ",
                         lines=None, preexec_fn=lambda: resource.setrlimit(resource.RLIMIT_DATA, (2 << 30, 2 << 30)))
        # A burst is none of that, and neither are nodes of which few come in a tick.
        self.write("p.meld", "type linear go(node, int).\ngo(@0, 3000).\ngo(A, N), N > 0 -o exists X. (go(A, N - 1), go(X, 0)).\n")
        self.write("w.toml", world('graph = "ring(6)"', '[limits]\nmemory = "80MiB"\n'))
        self.call("meldsim", "run", "p.meld", "--world", "w.toml", "--quiet")

    def test_programs_that_cannot_run_on_a_graph_are_refused(self):
        for program, says in (("type p(node, int).\np(A, P) :- vacant(A, P).\n", "the nodes of a graph have no cells"),
                              ("type p(node, sum int [<- neighbor]).\ntype q(node, int).\nq(A, 1) :- id(A, _).\n"
                               "p(B, X) :- neighbor(A, B), q(A, X).\n", "and node 0 has 40")):
            self.write("p.meld", program)
            self.write("w.toml", world('graph = "star(41)"'))
            self.refused("meldsim", "run", "p.meld", "--world", "w.toml", "--quiet", code=2, says=says)

    def test_a_world_is_described(self):
        self.write("w.toml", world('graph = "star(5)"'))
        out, _ = self.call("meldsim", "world", "w.toml")
        self.assertIn("w.toml: graph, 5 nodes, 4 links, degrees 1 to 4, 1.60 on average, 1 component\n", out)

    def test_a_recording_can_be_read(self):
        toml = world('graph = "grid(6, 5)"', '[facts]\nsource = "id == 0"\n[record]\nevery = 1\npredicates = ["dist"]\n')
        self.facts(HOPS, toml, "dist", "--record", "r.vtkhdf", processes=(1, 2))
        out, _ = self.call("meldsim", "shot", "r.vtkhdf", "-o", "r.png", "--colour", "dist(A, D)", "--size", "200x200")
        self.assertIn("30 of 30 catoms", out)

    def test_a_run_goes_on_from_a_checkpoint_on_other_processes(self):
        graph = nx.barabasi_albert_graph(150, 2, seed=4)
        nx.write_edgelist(graph, self.folder / "e.txt", data=False)
        events = '[facts]\nsource = "id == 3"\n[[event]]\ntick = 3\nkill = [0, 1]\n[[event]]\ntick = 6\nkill = [2, 9]\n'
        toml = world('links = "e.txt"', events)
        self.facts(HOPS, toml, "dist", processes=(1,))
        whole = self.read("d")
        facts = self.read("f")
        for n, m in ((1, 3), (2, 1), (2, 2)):
            self.call("meldsim", "run", "p.meld", "--world", "w.toml", "--quiet", "-n", n, "--ticks", "4", "--checkpoint", f"c{n}{m}",
                      "--digest", f"d{n}{m}", "--facts-out", "g")
            self.assertNotEqual(self.read("g"), facts)
            self.call("meldsim", "resume", f"c{n}{m}", "--quiet", "-n", m, "--ticks", "1000000")
            self.assertEqual(self.read("g"), facts, (n, m))
            self.assertEqual(self.read(f"d{n}{m}"), whole, (n, m))

    def test_a_seed_on_the_command_line_makes_another_graph(self):
        toml = world('graph = "random(60, 0.1)"', '[facts]\nsource = "id == 0"\n')
        first = self.facts(HOPS, toml, "dist", processes=(1,))
        self.assertEqual(self.facts(HOPS, toml, "dist", "--seed", "1", processes=(1, 2)), first)
        other = self.facts(HOPS, toml, "dist", "--seed", "5", processes=(1, 2))
        self.assertNotEqual(other, first)
        self.assertEqual(self.facts(HOPS, "seed = 5\n" + toml, "dist", processes=(1,)), other)

    def test_messages_that_take_time_reach_any_number_of_neighbours(self):
        graph = nx.barabasi_albert_graph(80, 3, seed=2)
        nx.write_edgelist(graph, self.folder / "e.txt", data=False)
        network = '[network]\nkind = "latency"\nmost = 5\n'
        self.expect_hops(graph, world('links = "e.txt"', '[facts]\nsource = "id == 17"\n' + network), [17])


if __name__ == "__main__":
    main("meldc", "meldsim")
