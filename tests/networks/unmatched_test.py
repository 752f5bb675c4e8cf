"""What a world says of catoms and links that are not there is a warning, whatever key says it.

    unmatched_test.py --meldc PATH --meldsim PATH [unittest options]
"""
import pathlib
import sys

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1]))

from frame import Case, main  # noqa: E402

PROGRAM = "type source(node).\ntype dist(node, min int).\ndist(A, 0) :- source(A).\ndist(B, D + 1) :- neighbor(A, B), dist(A, D).\n"
# Catoms @0 to @8, of which @0 and @6 do not touch; the catom at x = 9 has no neighbour.
SQUARE = 'lattice = "square"\n[[body]]\nshape = "box(3, 3, 1)"\n[[body]]\ncells = [[9, 9]]\n[facts]\nsource = "id == 0"\n'
GRAPH = 'lattice = "graph"\nlinks = [[0, 1], [1, 2], [2, 3]]\nnodes = 6\n[facts]\nsource = "id == 0"\n'
LOSSY = '[network]\nkind = "lossy"\nloss = 0.1\n'
# Nodes without links: a region that matches them alone has no link.
ALONE = "id >= 4"


def event(text, tick=3):
    return f"[[event]]\ntick = {tick}\n{text}\n"


# Key; world; the warning if it matches nothing; with what it matches something, instead of what it says there.
TABLE = [
    ("facts", SQUARE.replace("id == 0", "x > 99"), "`x > 99` matches no catom, so it changes no facts of source", ("x > 99", "x == 9")),
    ("give", SQUARE + event("give = { source = 'id == 77' }"), "`id == 77` matches no catom", ("77", "7")),
    ("take", SQUARE + event("take = { source = 'id == 77' }"), "`id == 77` matches no catom", ("77", "0")),
    *((key, SQUARE + event(f"{key} = 77"), f"there is no catom @77, so nothing {done}", ("77", "7"))
      for key, done in (("kill", "is killed"), ("hang", "hangs"), ("restart", "restarts"))),
    *((key + " by number", SQUARE + event(f"{key} = [[0, 6]]"), f"there are no links of @0 and @6, so nothing is {done}", ("0, 6", "0, 1"))
      for key, done in (("cut", "cut"), ("heal", "healed"))),
    *((key + " a region", SQUARE + event(f"{key} = 'x == 9'"), f"there are no links of `x == 9`, so nothing is {done}", ("x == 9",
     "x == 1"))
      for key, done in (("cut", "cut"), ("heal", "healed"))),
    *((key + " between", SQUARE + event(f"{key} = {{ between = ['x < 0', 'x == 1'] }}"),
       f"there are no links between `x < 0` and `x == 1`, so nothing is {done}", ("x == 1'", "x == 0'"))
      for key, done in (("cut", "cut"), ("heal", "healed"))),
    ("jam", SQUARE + event("jam = { between = ['x < 0', 'x == 1'], ticks = 2 }"), "so nothing is jammed", ("x == 1'", "x == 0'")),
    ("jam where", SQUARE + event("jam = { where = 'x == 9', ticks = 2 }"), "so nothing is jammed", ("x == 9", "x == 1")),
    ("cut of a graph", GRAPH + event("cut = [[0, 3]]"), "there are no links of @0 and @3, so nothing is cut", ("[0, 3]]", "[3, 2]]")),
    ("cut of nodes alone", GRAPH + event(f"cut = '{ALONE}'"), f"there are no links of `{ALONE}`", (ALONE, "id >= 3")),
    ("heal of a link that was joined", GRAPH + event("join = [[0, 5]]") + event("cut = [[0, 5]]", 6) + event("heal = [[5, 0]]", 9),
     "@5 and @0 have no link of the graph, only one that an event joins, so nothing is healed. write join", ("[[5, 0]]", "[[1, 0]]")),
    ("network.region", SQUARE + LOSSY + "[[network.region]]\nwhere = 'x == 9'\nloss = 0.5\n",
     "there are no links of `x == 9`, so this [[network.region]] has no effect", ("x == 9", "x == 1")),
    ("network.region of a graph", GRAPH + LOSSY + f"[[network.region]]\nwhere = '{ALONE}'\nloss = 0.5\n", "has no effect", (ALONE,
     "id >= 3")),
    ("network links", SQUARE + LOSSY + "links = 'pair.csv'\n", "pair.csv:2: there is no link from @0 to @6, so this line has no effect",
     ("pair.csv", "link.csv")),
    *((f"faults {key}", SQUARE + f"[faults]\nuntil = 3\n{key} = 0.01\nwhere = 'x > 99'\n", says, ("x > 99", "x == 1"))
      for key, says in (("kill", "`x > 99` matches no catom, so nothing is killed"), ("hang",
          "`x > 99` matches no catom, so nothing hangs"),
                        ("restart", "`x > 99` matches no catom, so nothing restarts"),
                        ("cut", "there are no links of `x > 99`, so nothing is cut"),
                        ("heal", "there are no links of `x > 99`, so nothing is healed"))),
    ("faults at a catom alone", SQUARE + "[faults]\nuntil = 3\ncut = 0.01\nwhere = 'x == 9'\n", "there are no links of `x == 9`", ("9'",
     "1'")),
    ("without", SQUARE.replace("[facts]", "[without]\ncells = [[5, 5], [9, 9], [6, 6]]\n[facts]"),
     "w.toml:7:9: cell (5, 5, 0) and 1 more are in no body, so [without] has no effect there", ("[5, 5], [9, 9], [6, 6]", "[0, 0]")),
    ("program", SQUARE + "[[program]]\nwhere = 'x > 99'\nfile = 'q.meld'\n", "`x > 99` matches no catom, so none runs", ("x > 99",
     "x == 9")),
    ("motion.catoms", '[[body]]\npositions = [[0, 0, 9]]\n[motion]\nkind = "bodies"\n[[motion.catoms]]\nwhere = "id == 9"\nmass = 2\n',
     "`id == 9` matches no catom, so these [[motion.catoms]] have no effect", ("== 9", "== 0")),
]
MATCH_NOTHING = ("matches no catom", "there are no links", "there is no link", "there is no catom", "have no link", "has no node",
    "in no body")


class Unmatched(Case):
    FILES = {"p.meld": PROGRAM, "q.meld": PROGRAM, "pair.csv": "from,to,loss\n0,6,0.5\n", "link.csv": "from,to,loss\n0,1,0.5\n"}

    def said(self, world, processes):
        self.write("w.toml", world)
        err = self.call("meldsim", "run", "p.meld", "--world", "w.toml", "--ticks", 20, "-n", processes, "--quiet")[1]
        return [line for line in err.splitlines() if any(words in line for words in MATCH_NOTHING)]

    def test_what_matches_nothing_is_said(self):
        for key, world, says, _ in TABLE:
            for processes in (1, 2):
                with self.subTest(key, processes=processes):
                    said = self.said(world, processes)
                    self.assertEqual(len(said), 1, said)
                    self.assertTrue(said[0].startswith("warning: "), said)
                    self.assertIn(says, said[0])
                    self.assertRegex(said[0], r"(w\.toml|pair\.csv):\d+")

    def test_what_matches_something_is_not(self):
        for key, world, _, (nothing, something) in TABLE:
            with self.subTest(key):
                self.assertIn(nothing, world)
                self.assertEqual(self.said(world.replace(nothing, something), 1), [])

    def test_links_that_events_join_are_there(self):
        joins = GRAPH + event("join = [[0, 5], [4, 5]]")
        for more in (event("cut = [[5, 0]]", 5), event("jam = { where = 'id == 4', ticks = 2 }", 5),
                     "[faults]\ncut = 0.1\nuntil = 9\nwhere = 'id == 4'\n", LOSSY + "links = 'far.csv'\n",
                     LOSSY + "[[network.region]]\nwhere = 'id == 4'\n"):
            with self.subTest(more):
                self.write("far.csv", "from,to,loss\n5,0,0.5\n")
                self.assertEqual(self.said(joins + more, 2), [])
                self.assertEqual(self.call("meldsim", "world", "w.toml")[1], "")
        # Not before they are.
        self.assertEqual(len(self.said(GRAPH + event("cut = [[0, 5]]", 2) + event("join = [[0, 5]]", 4), 1)), 1)

    def test_a_world_is_checked_without_a_program(self):
        self.write("w.toml", GRAPH + LOSSY + "[[network.region]]\nwhere = 'id > 99'\n")
        self.assertIn("this [[network.region]] has no effect", self.call("meldsim", "world", "w.toml")[1])


if __name__ == "__main__":
    main("meldc", "meldsim")
