"""Catoms and links that fail: failures_test.py --meldc PATH --meldsim PATH [unittest options]

When all has come to rest, views are those of a world that had always been as it is then; and nothing depends on the number of processes,
nor on a checkpoint in between.
"""
import json
import pathlib
import sys

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1]))

from frame import CAMPAIGN, Case, main, one_in  # noqa: E402

GRADIENT = """type source(node).
type dist(node, min int).
type degree(node, int).
dist(A, 0) :- source(A).
dist(B, D + 1) :- neighbor(A, B), dist(A, D).
degree(A, N) :- neighborCount(A, N).
"""
SQUARE = 'lattice = "square"\nseed = 4\n[[body]]\nshape = "box(12, 9, 1)"\n[facts]\nsource = ["id == 3", "x == 5 && y == 2"]\n'
RING = 'lattice = "graph"\ngraph = "ring(24)"\n[facts]\nsource = "id == 0"\n'
LATENCY = '[network]\nkind = "latency"\nleast = 2\nmost = 5\n'
PAUSES = '[clock]\nkind = "random"\nrate = 0.4\nmost = 4\n'
CUT = """[[event]]
tick = 20
cut = ["id % 7 == 2", {{ between = ["x < 0", "x >= 0"] }}, [{0}, {1}]]
hang = ["id == 10", 30]
[[event]]
tick = 33
restart = ["id == 10", "id % 17 == 4"]
kill = 50
{2}
[[event]]
tick = 90
heal = "{3}"
restart = 30
"""
PARTIAL = CUT.format(40, 41, "", "y < 1")
WHOLE = CUT.format(40, 41, "", "all")
JOIN = """[[event]]
tick = 15
cut = [[3, 4], [20, 21]]
join = [[2, 13], [0, 12], [5, 6]]
[[event]]
tick = 40
cut = "id == 12"
heal = [[20, 21]]
hang = 7
[[event]]
tick = 70
heal = "id == 12"
join = [[0, 12]]
restart = "id > 6"
"""
FAULTS = "[faults]\nkill = 1e-3\nhang = 4e-3\nrestart = 0.03\ncut = 0.004\nheal = 0.02\nfrom = 5\nuntil = 60\nwhere = \"id > 5\"\n"
SLOWLY = "[network]\ndetect = 7\n"
JAM = "[[event]]\ntick = 24\njam = { where = [\"x > 0\", [[0, 1], [1, 2]]], ticks = 9 }\n"
DOWN = '[network]\nkind = "lossy"\nretry = 1\ntries = 2\n[[network.region]]\nwhere = "id % 5 == 3"\nloss = 0.7\n'
TRICKLE = """type linear todo(node, int).
type linear heard(node, int).
todo(@0, 300).
todo(A, N), !neighbor(A, B), N > 0 -o todo(A, N - 1), heard(B, N).
"""
PAIR = 'lattice = "square"\n[[body]]\nshape = "box(2, 1, 1)"\n'


class Failures(Case):
    def setUp(self):
        super().setUp()
        self.write("p.meld", GRADIENT)

    def digests(self, world, *options):
        self.write("w.toml", world)
        out, _ = self.call("meldsim", "run", "p.meld", "--world", "w.toml", "--digest", "-", "--digest-check", 1, "--quiet", *options)
        return [line.split() for line in out.splitlines() if line.startswith("tick ")]

    def facts(self, world, *options, program="p.meld"):
        self.write("w.toml", world)
        out, _ = self.call("meldsim", "run", program, "--world", "w.toml", "--facts-out", "-", "--quiet", *options)
        return sorted(out.split("\n"))

    def summary(self, world, *options, program="p.meld"):
        self.write("w.toml", world)
        return json.loads(self.call("meldsim", "run", program, "--world", "w.toml", "--json", "--quiet", *options)[0])

    def test_what_is_healed_is_as_if_nothing_had_been(self):
        self.assertEqual(self.facts(SQUARE + WHOLE), self.facts(SQUARE + "[[event]]\ntick = 1\nkill = 50\n"))
        self.assertEqual(self.facts(RING + "[[event]]\ntick = 9\ncut = 'id < 9'\nhang = 4\n"
                                    "[[event]]\ntick = 50\nheal = 'all'\nrestart = 4\n"), self.facts(RING))

    def test_a_cut_parts_the_world(self):
        for conditions in ("", LATENCY, PAUSES):
            out = self.facts(SQUARE + conditions + '[[event]]\ntick = 20\ncut = { between = ["x < 0", "x >= 0"] }\n'
                             '[[event]]\ntick = 60\ntake = { source = "id == 3" }\n')
            self.assertEqual(len([line for line in out if line.startswith("dist")]), 54)
        for n in (1, 2, 3):
            found = self.summary(SQUARE + "[[event]]\ntick = 2\ncut = 'id == 20'\nhang = 'id < 3'\n[[event]]\ntick = 5\nheal = [[20, 21]]\n"
                                 "restart = [1, 2]\n", "-n", n)
            self.assertEqual([found[key] for key in ("killed", "hung", "restarted", "links_cut", "links_made")], [0, 3, 2, 4, 1])

    def test_links_of_a_graph_can_be_joined(self):
        facts = self.facts(RING + "[[event]]\ntick = 20\njoin = [[0, 12], [12, 0], [0, 1], [3, 20]]\n")
        self.assertIn("dist(@12, 1).", facts)
        self.assertIn("dist(@11, 2).", facts)
        self.assertIn("degree(@0, 3).", facts)
        self.assertIn("degree(@1, 2).", facts)

    def test_a_catom_that_hangs_says_nothing(self):
        line = 'lattice = "square"\n[[body]]\nshape = "box(7, 1, 1)"\n[facts]\nsource = "id == 0"\n'
        hang = "[[event]]\ntick = 20\nhang = 3\n[[event]]\ntick = 22\ntake = { source = 'id == 0' }\ngive = { source = 'id == 2' }\n"
        # The others beyond it go on with what it had told.
        facts = self.facts(line + hang)
        self.assertIn("dist(@3, 3).", facts)
        self.assertIn("dist(@6, 6).", facts)
        self.assertIn("dist(@1, 1).", facts)
        self.assertIn("dist(@6, 4).", self.facts(line + hang + "[[event]]\ntick = 40\nrestart = 3\n"))
        self.assertFalse([f for f in self.facts(line + hang + "[[event]]\ntick = 40\nkill = 3\n") if f.startswith("dist(@6")])

    def test_an_end_is_sensed_after_the_detection_delay(self):
        self.write("q.meld", GRADIENT + "type place(node, int).\nplace(A, P) :- vacant(A, P).\n")
        line = 'lattice = "square"\n[[body]]\nshape = "box(7, 1, 1)"\n[facts]\nsource = "id == 0"\n'
        kill = "[[event]]\ntick = 20\nkill = 3\n[[event]]\ntick = 22\nrestart = 3\nhang = 3\nkill = 3\n"
        for detect, conditions in ((0, ""), (9, ""), (9, 'kind = "latency"\nmost = 3\n')):
            world = line + kill + f"[network]\ndetect = {detect}\n" + conditions
            for n in (1, 2, 3):
                def at(tick):
                    return self.facts(world, "-n", n, "--ticks", tick, program="q.meld")
                gone = 20 + detect
                before, after = at(gone - 1), at(gone + 8)
                # It takes up its place until then, and its neighbour goes on with what it had told.
                self.assertIn("dist(@6, 6).", before)
                self.assertIn("degree(@4, 2).", before)
                self.assertEqual(len([f for f in before if f.startswith("place(@4")]), 2)
                self.assertIn("degree(@4, 1).", after)
                self.assertEqual(len([f for f in after if f.startswith("place(@4")]), 3)
                self.assertFalse([f for f in after if f.startswith(("place(@3", "dist(@6"))])
                found = self.summary(world, "-n", n, program="q.meld")
                self.assertEqual([found[key] for key in ("killed", "hung", "restarted", "catoms")], [1, 0, 0, 6])
        # What has been silent says nothing.
        self.write("s.meld", "type source(node).\ntype linear go(node, int).\ntype heard(node, int).\ngo(@3, 0).\n"
                             "go(A, N) -o go(A, N + 1)@+1, { B | neighbor(A, B) | heard(B, N) }.\n")
        facts = self.facts(line + "[network]\ndetect = 30\n[[event]]\ntick = 10\nkill = 3\n", "--ticks", 60, program="s.meld")
        self.assertEqual(len([f for f in facts if f.startswith("heard(@2")]), 9)

    def test_one_that_restarts_has_what_it_had_at_the_start(self):
        world = ('lattice = "square"\n[[body]]\nshape = "box(3, 1, 1)"\n[facts]\nsource = "id == 1"\n'
                 "[[event]]\ntick = 5\ngive = { source = 'id == 2' }\n[[event]]\ntick = 9\nrestart = 'all'\n")
        self.write("q.meld", GRADIENT + "type base(node, int).\nbase(A, 7).\ntype linear token(node, int).\ntoken(A, 1).\n")
        facts = self.facts(world, program="q.meld")
        self.assertEqual([f for f in facts if f.startswith(("source", "base", "token"))],
                         ["base(@0, 7).", "base(@1, 7).", "base(@2, 7).", "source(@1).", "token(@0, 1).", "token(@1, 1).", "token(@2, 1)."])
        self.assertIn("dist(@2, 1).", facts)
        for n in (1, 2):
            self.assertEqual(self.summary(world, "-n", n, program="q.meld")["lost_linear_facts"], 3)

    def test_on_any_number_of_processes(self):
        worlds = (SQUARE + PARTIAL, SQUARE + LATENCY + PARTIAL, SQUARE + PAUSES + PARTIAL, RING + JOIN, RING + LATENCY + JOIN,
                  RING + SLOWLY + JOIN + FAULTS, SQUARE + SLOWLY + PARTIAL, SQUARE + SLOWLY + 'kind = "latency"\nmost = 3\n' + FAULTS,
                  SQUARE + DOWN + PARTIAL, SQUARE + PAUSES + PARTIAL + JAM, SQUARE + FAULTS, SQUARE + LATENCY + FAULTS, RING + FAULTS)
        for world in one_in(2, worlds):
            with self.subTest(world=world):
                alone = self.digests(world)
                if CAMPAIGN:
                    self.assertEqual(self.digests(world, "-n", 2), alone)
                self.assertEqual(self.digests(world, "-n", 3, "--threads", 2), alone)

    def test_a_run_goes_on_in_the_midst_of_failures(self):
        stops = ((SQUARE + PARTIAL, 22), (SQUARE + LATENCY + PARTIAL + JAM, 28), (RING + JOIN, 30), (RING + JOIN, 41),
                 (RING + PAUSES + JOIN, 44), (SQUARE + FAULTS, 30), (SQUARE + DOWN + PARTIAL, 34), (SQUARE + SLOWLY + PARTIAL, 35),
                 (RING + SLOWLY + FAULTS, 30))
        for number, (world, stop) in enumerate(one_in(3, stops)):
            whole = self.digests(world)
            for processes in (1, 2) if CAMPAIGN else (1 + number % 2,):
                with self.subTest(world=world, stop=stop, processes=processes):
                    self.call("meldsim", "run", "p.meld", "--world", "w.toml", "--ticks", stop, "--checkpoint", f"c{number}{processes}",
                              "--digest", "d.txt", "--quiet", "-n", processes)
                    self.call("meldsim", "resume", f"c{number}{processes}", "--ticks", 100000, "--quiet", "-n", 3 - processes)
                    found = [line.split() for line in self.read("d.txt").decode().splitlines() if line.startswith("tick ")]
                    self.assertEqual(found, whole)

    def test_what_is_under_way_to_nobody_is_lost_when_it_would_have_arrived(self):
        # Also in a run that stops in between and goes on.
        go = "type linear go(node).\ntype linear letter(node).\ngo(@0).\n"
        graph = 'lattice = "graph"\n{}[network]\nkind = "latency"\nleast = 8\nmost = 8\n'
        linked = go + "go(A), !neighbor(A, B) -o letter(B).\n", graph.format('graph = "line(2)"\n')
        far = go + "go(A) -o letter(@1).\n", graph.format("links = []\nnodes = 3\n") + 'reach = "any"\n'
        for number, ((program, world), strike) in enumerate(((linked, "cut = [[0, 1]]"), (linked, "kill = 1"), (far, "kill = 1"))):
            self.write("q.meld", program)
            whole = self.summary(world + f"[[event]]\ntick = 3\n{strike}\n", program="q.meld")
            self.assertEqual(whole["dropped_messages"], 1)
            self.assertGreaterEqual(whole["ticks"], 8)
            for n in (1, 2):
                checkpoint = f"c{number}{n}"
                self.call("meldsim", "run", "q.meld", "--world", "w.toml", "--ticks", 5, "--quiet", "--checkpoint", checkpoint, "-n", n)
                out, _ = self.call("meldsim", "resume", checkpoint, "--ticks", 100, "--json", "--quiet", "-n", 3 - n)
                again = json.loads(out)
                for key in ("ticks", "dropped_messages"):
                    self.assertEqual(again[key], whole[key], (program, strike, n, key))

    def test_a_recording_makes_its_run_again(self):
        self.write("w.toml", SQUARE + FAULTS + PARTIAL)
        self.call("meldsim", "run", "p.meld", "--world", "w.toml", "--record", "r.vtkhdf", "--digest", "d", "--quiet")
        self.call("meldsim", "replay", "r.vtkhdf", "--digest", "again", "--quiet", "-n", 2)
        self.assertEqual(self.read("again"), self.read("d"))

    def test_a_checkpoint_in_a_jam_keeps_the_order_of_messages(self):
        # What is held up was sent before what arrives in the meantime, of another column.
        self.write("t.meld", "type source(node).\ntype dist(node, min int).\ntype far(node, max int).\ntype least(node, min int).\n"
                             "dist(A, 0) :- source(A).\ndist(B, D + 1) :- neighbor(A, B), dist(A, D).\n"
                             "far(A, D) :- dist(A, D).\nfar(B, F) :- neighbor(A, B), far(A, F).\n"
                             "least(A, N) :- id(A, N).\nleast(B, N) :- neighbor(A, B), least(A, N).\n")
        self.write("w.toml", 'lattice = "fcc"\nseed = 7\n[[body]]\nshape = "box(7, 7, 7)"\n[network]\nkind = "latency"\nleast = 3\n'
                             '[facts]\nsource = "id % 150 == 7"\n[[event]]\ntick = 9\nkill = [107, 30, 31]\ncut = "id % 11 == 2"\n'
                             '[[event]]\ntick = 14\nrestart = "id % 20 == 3"\n[[event]]\ntick = 20\n'
                             'jam = { where = "id % 7 == 1", ticks = 6 }\n')
        self.call("meldsim", "run", "t.meld", "--world", "w.toml", "--quiet", "--digest", "whole", "--ticks", 60)
        for tick in (21, 23, 25):
            with self.subTest(tick):
                self.call("meldsim", "run", "t.meld", "--world", "w.toml", "--quiet", "--digest", "d", "--ticks", tick,
                          "--checkpoint", f"c{tick}", "-n", 2)
                self.call("meldsim", "resume", f"c{tick}", "--quiet", "--ticks", 60, "-n", 1)
                self.assertEqual(self.read("d"), self.read("whole"))

    def test_a_jam_delays_and_loses_nothing_unless_the_network_is_raw(self):
        self.write("t.meld", TRICKLE)
        jam = "[[event]]\ntick = 2\nevery = 50\ntimes = 3\njam = { ticks = 20 }\n"
        heard = {}
        for name, conditions in (("ideal", ""), ("jam", jam), ("latency", LATENCY + jam), ("pauses", PAUSES + jam)):
            facts = [self.facts(PAIR + conditions, "-n", n, program="t.meld") for n in (1, 2)]
            self.assertEqual(facts[0], facts[1])
            heard[name] = [f for f in facts[0] if f.startswith("heard")]
        self.assertEqual(len(heard["ideal"]), 300)
        for name in ("jam", "latency", "pauses"):
            self.assertEqual(heard[name], heard["ideal"])
        # Rules find them from tick 22 on, the first after the jam.
        for tick, known in ((2, 0), (20, 0), (21, 300)):
            facts = self.facts(PAIR + jam, "--ticks", tick, program="t.meld")
            self.assertEqual(len([f for f in facts if f.startswith("heard")]), known)
        raw = self.summary(PAIR + '[network]\nkind = "raw"\n' + jam, program="t.meld")
        self.assertEqual(raw["dropped_messages"], 300)

    def test_a_catom_ends_alone_if_it_holds_nothing(self):
        self.write("e.meld", "type want(node).\nwant(A) :- holds(A, 0).\nwant(A) :- id(A, 3).\ndestroy(A, A) :- want(A).\n")
        world = 'lattice = "square"\nheld = {}\n[motion]\nkind = "lattice"\ncapacity = 2\n[[body]]\nshape = "box(6, 3, 1)"\n'
        for n in (1, 2, 3):
            self.assertEqual(self.summary(world.format(0), "-n", n, program="e.meld")["catoms"], 0)
            found = self.summary(world.format(1), "-n", n, program="e.meld")
            self.assertEqual((found["catoms"], found["refused_actions"]),
                             (18, [{"action": "destroy", "reason": "holds_units", "count": 1}]))

    def test_mistakes_have_places_and_cures(self):
        for base, text, said in (
                (SQUARE, "cut = 3\n", "write cut = \"id == 3\""),
                (SQUARE, "cut = [3, 4]\n", "write cut = \"id == 3\""),
                (SQUARE, "cut = [[3, 3]]\n", "no link with itself"),
                (SQUARE, "cut = [[3, -1]]\n", "the numbers of two catoms"),
                (SQUARE, "cut = { between = ['x > 0'] }\n", "between two regions"),
                (SQUARE, "heal = 'w > 0'\n", "w.toml:9:9"),
                (SQUARE, "join = [[3, 4]]\n", "only nodes of a graph"),
                (RING, "join = [[3, 40]]\n", "no node 40"),
                (RING, "join = 3\n", "array of links"),
                (SQUARE, "jam = 'x > 0'\n", "ticks = 20"),
                (SQUARE, "jam = { where = 'x > 0' }\n", "for how long"),
                (SQUARE, "jam = { where = 'x > 0', ticks = 9999 }\nevery = 9999\ntimes = 3\n", "may be under way for"),
                (SQUARE, "hang = -1\n", "there is no catom @-1"),
                (SQUARE, "restart = true\n", "a region or the number of a catom"),
                (SQUARE, "[faults]\n", "does nothing"),
                (SQUARE, "kill = 3\n[faults]\nuntil = 3\n", "do nothing"),
                (SQUARE, "kill = 3\n[faults]\nkill = 2\n", "kill"),
                (SQUARE, "kill = 3\n[faults]\nkill = 0.1\nfrom = 9\nuntil = 3\n", "until is 3, and from is 9"),
                (SQUARE + '[motion]\nkind = "bodies"\n', "hang = 3\n", "these are bodies")):
            with self.subTest(text):
                self.write("w.toml", base + "[[event]]\ntick = 3\n" + text)
                _, err = self.call("meldsim", "run", "p.meld", "--world", "w.toml", code=2)
                self.assertIn(said, err)
                self.assertIn("w.toml", err)

    def test_what_strikes_nothing_is_warned_of(self):
        for text, said in (("cut = [[0, 999]]", "links of @0 and @999"), ("heal = 'x > 99'", "links of `x > 99`"),
                           ("hang = 999", "no catom @999, so nothing hangs"), ("restart = 'x > 99'", "so nothing restarts"),
                           ("jam = { where = 'x > 99', ticks = 3 }", "so nothing is jammed")):
            self.write("w.toml", SQUARE + f"[[event]]\ntick = 3\n{text}\n")
            for n in (1, 2):
                self.assertIn(said, self.call("meldsim", "run", "p.meld", "--world", "w.toml", "-n", n)[1])
        self.write("w.toml", SQUARE + "".join(f"[[event]]\ntick = 3\ncut = [[0, {999 + i}]]\n" for i in range(50)))
        err = self.call("meldsim", "run", "p.meld", "--world", "w.toml", "-n", 2)[1]
        self.assertEqual(err.count("so nothing is cut"), 20, err)
        self.assertIn("there are 30 more warnings like these", err)
        self.write("w.toml", SQUARE + "[faults]\ncut = 0.01\n")
        self.assertIn("no `until`", self.call("meldsim", "run", "p.meld", "--world", "w.toml", "--ticks", 9)[1])


if __name__ == "__main__":
    main("meldc", "meldsim")
