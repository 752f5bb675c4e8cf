"""Nodes of a graph that rules make: births_test.py --meldc PATH --meldsim PATH [unittest options]

A node begins with the facts that its maker gives it, has a number of its own, and fails, is saved, shown and asked like any other, on any
number of processes.
"""
import json
import pathlib
import re
import sys

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1]))

from frame import CAMPAIGN, Case, main  # noqa: E402

# Each node with a list takes its first element, and gives what is less and what is greater to two nodes that it makes.
SORT = """type linear sort(node, list int).
type linear split(node, int Pivot, list int Rest, list int Low, list int High).
type linear up(node, list int).
type linear waits(node, int Pivot, node Low, node High).
type linear answer(node, node From, list int).
type route parent(node, node).
type first(node).
type sorted(node, list int).
first(@0).
sort(A, []) -o up(A, []).
sort(A, [X | R]) -o split(A, X, R, [], []).
split(A, P, [X | R], L, H), X < P -o split(A, P, R, [X | L], H).
split(A, P, [X | R], L, H), X >= P -o split(A, P, R, L, [X | H]).
split(A, P, [], L, H) -o exists B, C. (waits(A, P, B, C), parent(B, A), sort(B, L), parent(C, A), sort(C, H)).
up(A, L), parent(A, B) -o answer(B, A, L).
up(A, L), first(A) -o sorted(A, L).
waits(A, P, B, C), answer(A, B, L), answer(A, C, H) -o up(A, L ++ [P | H]).
"""
# Nodes make others for a while; they write to their makers, who answer; digests depend on all of it.
FAMILY = """type linear grow(node, int).
type linear hello(node, node From, int).
type linear undelivered-hello(node, node To, node From, int).
type linear well(node, int).
type maker(node, node).
type child(node, node, int).
type heard(node, node, int).
type lost(node, node).
type old(node, int).
type near(node, node).
grow(A, 5) -o grow(A, 4), grow(A, 4).
grow(A, N), N > 0, N < 5 -o
    exists B, C. (maker(B, A), grow(B, N - 1)@+2, maker(C, A), grow(C, N - 2), child(A, B, N), child(A, C, N)),
    grow(A, N - 2)@+3.
grow(A, N), N <= 0, maker(A, B) -o hello(B, A, N).
hello(A, B, N) -o heard(A, B, N), well(B, N).
undelivered-hello(A, B, _, _) -o lost(A, B).
well(A, N) -o old(A, N).
near(B, A) :- neighbor(A, B), child(A, _, _).
"""
WORLD = 'lattice = "graph"\ngraph = "random(12, 0.2)"\nseed = 4\n[facts]\ngrow = [{ where = "id % 3 == 0", args = [5] }]\n'
FAULTS = "[faults]\nkill = 0.01\nhang = 0.004\nrestart = 0.02\ncut = 0.02\nheal = 0.1\nuntil = 25\n"
CONDITIONS = {
    "ideal": "",
    "faults": FAULTS,
    "latency": '[network]\nkind = "latency"\nmost = 4\n' + FAULTS,
    "lossy": '[network]\nkind = "lossy"\nloss = 0.3\nretry = 2\ntries = 4\n[[network.region]]\nwhere = "id < 9"\nleast = 3\n',
    "detected": "[network]\ndetect = 3\n" + FAULTS,
    "turns": '[clock]\nkind = "priority"\n' + FAULTS,
    "pauses": '[clock]\nkind = "random"\nrate = 0.4\nmost = 5\n' + FAULTS,
}


class Births(Case):
    def run_in(self, world, *options, program="p.meld"):
        self.write("w.toml", world)
        out, _ = self.call("meldsim", "run", program, "--world", "w.toml", "--json", "--quiet", "--facts-out", "facts", *options)
        return json.loads(out), self.read("facts").decode()

    def test_nodes_that_are_made_sort_a_list(self):
        numbers = [37 * i % 101 for i in range(1, 60)]
        self.write("p.meld", SORT + f"sort(@0, [{', '.join(map(str, numbers))}]).\n")
        seen = set()
        for n in (1, 2, 3, 4):
            found, facts = self.run_in('lattice = "graph"\nlinks = []\nnodes = 1\n', "-n", n)
            self.assertIn(f"sorted(@0, [{', '.join(map(str, sorted(numbers)))}]).", facts)
            # Each element has its node, and each node that has none.
            self.assertEqual((found["nodes_made"], found["catoms"]), (2 * len(numbers), 1 + 2 * len(numbers)))
            self.assertEqual((found["dropped_messages"], found["lost_linear_facts"]), (0, 0))
            seen.add(facts)
        self.assertEqual(len(seen), 1)

    def test_a_program_that_makes_nodes_needs_no_world(self):
        self.write("p.meld", SORT + "sort(@0, [3, 1, 2]).\n")
        out, err = self.call("meldsim", "run", "p.meld", "--quiet", "--facts-out", "-")
        self.assertIn("sorted(@0, [1, 2, 3]).", out)
        self.assertIn("its rules make nodes", err)

    def test_numbers_follow_from_the_program(self):
        # In a graph of n nodes, those that node i makes in the first tick are b + i, b + n + i, ...
        self.write("p.meld", "type linear go(node, int).\ntype made(node, node, int).\ntype begun(node, int).\n"
                             "go(A, N), N > 0 -o exists B. (made(A, B, N), begun(B, N)), go(A, N - 1).\n")
        for n in (1, 3):
            _, facts = self.run_in('lattice = "graph"\ngraph = "line(4)"\n[facts]\ngo = [{ where = "id >= 0", args = [3] }]\n', "-n", n)
            made = {(int(a), int(b)): int(k) for a, b, k in re.findall(r"made\(@(\d+), @(\d+), (\d+)\)", facts)}
            self.assertEqual(made, {(i, 4 + 4 * j + i): 3 - j for i in range(4) for j in range(3)})
            begun = {int(b): int(k) for b, k in re.findall(r"begun\(@(\d+), (\d+)\)", facts)}
            self.assertEqual(begun, {b: k for (_, b), k in made.items()})

    def test_on_any_number_of_processes_and_with_a_checkpoint(self):
        self.write("p.meld", FAMILY)
        for name, conditions in CONDITIONS.items():
            world = WORLD + conditions
            seen = []
            for n in (1, 2, 3, 4) if CAMPAIGN else (1, 3):
                found, facts = self.run_in(world, "--digest", "d", "--digest-check", 1, "-n", n, "--threads", 1 + n % 2, "--ticks", 60)
                seen.append((facts, self.read("d"), *(found[key] for key in (
                    "nodes_made", "killed", "restarted", "far_facts", "far_messages", "dropped_messages", "lost_linear_facts"))))
                with self.subTest(name, processes=n):
                    self.assertEqual(seen[-1], seen[0])
            self.assertGreater(seen[0][2], 30)
            self.assertIn("old(", seen[0][0])
            for stop, n in ((2, 1), (9, 3)) if CAMPAIGN else ((9, 3),):
                with self.subTest(name, stop=stop):
                    folder = f"c-{name}-{stop}"
                    self.call("meldsim", "run", "p.meld", "--world", "w.toml", "--ticks", stop, "--checkpoint", folder, "--digest", "d",
                              "--facts-out", "again", "--quiet", "-n", n)
                    self.call("meldsim", "resume", folder, "--ticks", 60, "--quiet", "-n", 4 - n)
                    self.assertEqual(self.read("d"), seen[0][1])
                    self.assertEqual(self.read("again").decode(), seen[0][0])

    def test_a_node_that_was_made_can_be_killed_joined_and_hang(self):
        self.write("p.meld", "type linear go(node).\ntype linear note(node, node).\ntype mine(node, node).\ntype beside(node, node).\n"
                             "type linear letter(node, node).\ntype linear undelivered-letter(node, node, node).\ntype back(node, node).\n"
                             "go(@0).\ngo(A) -o exists B. (mine(A, B), mine(B, A), note(A, B)@+8).\n"
                             "note(A, B) -o letter(B, A).\nletter(A, B), mine(A, B) -o mine(A, A).\n"
                             "undelivered-letter(A, B, _) -o back(A, B).\nbeside(A, B) :- neighbor(A, B).\n")
        world = 'lattice = "graph"\ngraph = "line(3)"\n'
        for n in (1, 2, 3):
            _, facts = self.run_in(world + "[[event]]\ntick = 4\njoin = [[2, 3]]\n", "-n", n)
            self.assertIn("beside(@3, @2).", facts)
            self.assertIn("beside(@2, @3).", facts)
            found, facts = self.run_in(world + "[[event]]\ntick = 4\nkill = 3\n", "-n", n)
            self.assertEqual((found["killed"], found["catoms"], found["nodes_made"]), (1, 3, 1))
            self.assertIn("back(@0, @3).", facts)
            self.assertNotIn("mine(@3", facts)
            found, facts = self.run_in(world + "[[event]]\ntick = 4\nrestart = 3\n", "-n", n)
            self.assertNotIn("mine(@3", facts)

    def test_they_are_recorded_shown_and_asked(self):
        self.write("p.meld", SORT + "sort(@0, [3, 1, 2]).\n")
        self.write("w.toml", 'lattice = "graph"\nlinks = []\nnodes = 1\n')
        self.call("meldsim", "run", "p.meld", "--world", "w.toml", "--quiet", "--record", "r.h5", "--ticks", 40, "--checkpoint", "c")
        out, _ = self.call("meldsim", "query", "c", "parent(A, B)")
        self.assertEqual(len([line for line in out.splitlines() if "@" in line]), 6)
        out, _ = self.call("meldsim", "why", "c", "parent(@1, @0)")
        self.assertIn("parent(@1, @0)", out)
        out, _ = self.call("meldsim", "shot", "p.meld", "--world", "w.toml", "-o", "p.png", "--size", "200x200")
        self.assertIn("7 of 7 catoms", out)

    def test_what_no_fact_begins_is_no_node(self):
        self.write("p.meld", "type linear go(node).\ntype linear letter(node, node).\ntype key(node, node).\n"
                             "go(@0).\ngo(A) -o exists B. (key(A, B)), exists C. (letter(C, A)).\n"
                             "letter(A, B) -o key(A, B).\n")
        found, facts = self.run_in('lattice = "graph"\ngraph = "line(2)"\n')
        self.assertEqual(found["nodes_made"], 1)
        self.assertIn("key(@2, @0).", facts)

    def test_mistakes_have_cures(self):
        self.write("p.meld", SORT + "sort(@0, [3, 1, 2]).\n")
        self.write("w.toml", 'lattice = "square"\n[[body]]\nshape = "box(3, 3, 1)"\n')
        _, err = self.call("meldsim", "run", "p.meld", "--world", "w.toml", code=1)
        self.assertIn("E0502", err)
        self.assertIn('lattice = "graph"', err)
        self.write("p.meld", "type linear go(node).\ngo(@0).\ngo(A) -o exists B. (setColor(B, 1, 2, 3)).\n")
        _, err = self.call("meldc", "check", "--no-graph", "p.meld", code=1)
        self.assertIn("E0502", err)


if __name__ == "__main__":
    main("meldc", "meldsim")
