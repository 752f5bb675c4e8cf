"""Worlds whose catoms run different programs over the same predicates.

    programs_test.py --meldc PATH --meldsim PATH [unittest options]
"""
import pathlib
import re
import sys

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1]))

from frame import Case, main  # noqa: E402

HONEST = """type source(node).
type dist(node, min int D).
type linear start(node).
type told(node, node From).
source(@0).
dist(A, 0) :- source(A).
dist(B, D + 1) :- neighbor(A, B), dist(A, D).
start(A).
start(A) -o { B | neighbor(A, B) | told(B, A) }.
"""
LIAR = """type dist(node, min int).
type said(node, int).
dist(A, -5) :- neighborCount(A, _).
said(A, D) :- dist(A, D).
"""
WORLD = """lattice = "square"
[[body]]
shape = "box(9, 1, 1)"
[[program]]
where = "id == 8"
file = "liar.meld"
"""


class Programs(Case):
    def setUp(self):
        super().setUp()
        self.write("p.meld", HONEST)
        self.write("liar.meld", LIAR)
        self.write("p.toml", WORLD)

    def rows(self, predicate, sizes=((1, 1), (2, 1), (3, 2))):
        """The facts of a predicate at the end as tuples of numbers, the same for each number of processes and threads."""
        seen = []
        for processes, threads in sizes:
            self.call("meldsim", "run", "p.meld", "-n", processes, "--threads", threads, "--quiet", "--facts-out", "f", "--digest", "d")
            seen.append((self.read("f").decode(), self.read("d")))
            self.assertEqual(seen[-1], seen[0], f"{processes} processes, {threads} threads")
        found = re.findall(rf"^{predicate}\((.*)\)\.", seen[0][0], re.M)
        return sorted(tuple(int(word.strip().lstrip("@")) for word in each.split(",")) for each in found)

    def test_each_catom_runs_the_rules_of_its_own_program(self):
        # What the liar exports, the others believe; it tells nobody anything.
        self.write("p.meld", HONEST.replace("source(@0).\n", ""))
        at = dict(self.rows("dist"))
        self.assertEqual(at[8], -5)
        order = sorted(at, key=lambda catom: at[catom])
        self.assertEqual([at[catom] for catom in order], list(range(-5, 4)))
        self.assertEqual(self.rows("said"), [(8, -5)])
        told = self.rows("told")
        self.assertEqual({sender for _, sender in told}, set(range(8)))
        self.assertEqual(len(told), 15)

    def test_catoms_that_restart_run_their_program_again(self):
        self.write("p.toml", WORLD + '[[event]]\ntick = 12\nrestart = "id > 5"\n')
        self.write("p.meld", HONEST.replace("source(@0).\n", ""))
        self.assertEqual(dict(self.rows("dist"))[8], -5)
        self.assertEqual(self.rows("said"), [(8, -5)])

    def test_facts_of_the_text_are_those_of_its_catoms(self):
        self.write("p.toml", WORLD.replace("id == 8", "id == 0"))
        self.assertEqual(self.rows("source"), [])
        self.assertEqual(dict(self.rows("dist"))[0], -5)

    def test_later_regions_override_earlier_ones(self):
        self.write("other.meld", "type dist(node, min int D).\ntype said(node, int).\ndist(A, 7).\nsaid(A, 1).\n")
        self.write("p.toml", WORLD + '[[program]]\nwhere = "id > 6"\nfile = "other.meld"\n[[program]]\nwhere = "id == 7"\n'
                   'file = "liar.meld"\n')
        self.assertEqual(self.rows("said"), [(7, -5), (8, 1)])

    def test_shared_files_are_compiled_once(self):
        self.write("common.meld", "type seen(node, int).\ntype linear once(node).\ntype fired(node, int).\nseen(A, 1) :- id(A, _).\n"
                   "once(A).\nonce(A), seen(A, N) -o fired(A, N).\n")
        for name in ("p.meld", "liar.meld"):
            self.write(name, 'include "common.meld".\nuse "gradient".\n' + self.read(name).decode())
        self.assertEqual(len(self.rows("seen")), 9)
        self.assertEqual(len(self.rows("fired")), 9)
        out, _ = self.call("meldc", "compile", "p.meld", "--with", "liar.meld", "--emit=program")
        self.assertEqual(out.count("seen(A, 1) :-"), 1)
        rules = [line for line in out.splitlines() if "gradient-" in line and ":-" in line]
        self.assertTrue(rules)
        self.assertFalse([line for line in rules if "runs-program" in line])
        # One that only the liar uses runs there alone.
        self.write("p.meld", HONEST)
        out, _ = self.call("meldc", "compile", "p.meld", "--with", "liar.meld", "--emit=program")
        rules = [line for line in out.splitlines() if re.search(r"gradient-\S*\(.*:-", line)]
        self.assertTrue(rules)
        self.assertTrue(all("runs-program" in line for line in rules), rules)

    def test_created_catoms_run_the_program_of_their_region(self):
        self.write("p.meld", "type kind(node, int).\nkind(A, 0).\ncreate(A, I) :- id(A, I), I < 4.\n")
        self.write("liar.meld", "type kind(node, int).\nkind(A, 1).\n")
        self.write("p.toml", 'lattice = "square"\nheld = 1\n[[body]]\ncells = [[0, 0], [0, 10], [0, 20], [0, 30]]\n'
                   '[motion]\nkind = "lattice"\n'
                   '[[program]]\nwhere = "x > 0"\nfile = "liar.meld"\n')
        kinds = self.rows("kind")
        self.assertEqual(sorted(kind for _, kind in kinds), [0] * 7 + [1])
        self.assertTrue(all(catom > 3 for catom, kind in kinds if kind))

    def test_a_catom_keeps_its_program_where_it_goes(self):
        self.write("liar.meld", 'type kind(node, int).\nkind(A, X) :- cell(A, X, _, _).\nmoveTo(A, 20, 0, 0) :- cell(A, 3, _, _).\n')
        self.write("p.meld", "type kind(node, int).\nkind(A, -1).\n")
        self.write("p.toml", 'lattice = "square"\n[[body]]\ncells = [[0, 0], [1, 0], [3, 0], [40, 0]]\n[motion]\nkind = "lattice"\n'
                   '[[program]]\nwhere = "x == 3"\nfile = "liar.meld"\n')
        self.assertEqual(sorted(kind for _, kind in self.rows("kind")), [-1, -1, -1, 20])

    def test_explanations_name_rules_by_file_and_line(self):
        out, _ = self.call("meldsim", "why", "p.meld", "dist(@8, D)", "--quiet")
        self.assertRegex(out, r"liar\.meld:3")
        self.assertIn("runs-program(@8, 1)", out)
        out, _ = self.call("meldsim", "why", "p.meld", "dist(@7, D)", "--quiet")
        self.assertRegex(out, r"\b7\b")
        out, _ = self.call("meldsim", "why-not", "p.meld", "said(@3, 2)", "--quiet")
        self.assertIn("runs-program(@3", out)

    def test_recordings_and_checkpoints_go_on_with_all_programs(self):
        self.call("meldsim", "run", "p.meld", "--record", "r.vtkhdf", "--quiet", "--facts-out", "f")
        self.write("liar.meld", "type nothing(node).\n")
        self.call("meldsim", "replay", "r.vtkhdf", "--quiet")
        self.write("liar.meld", LIAR)
        self.call("meldsim", "run", "p.meld", "--checkpoint", "c", "--ticks", 3, "--quiet")
        self.call("meldsim", "resume", "c", "--ticks", 100, "-n", 2, "--quiet")
        out, _ = self.call("meldsim", "facts", "c", "dist", "--quiet")
        self.assertIn("dist(@8, -5)", out)

    def test_what_differs_is_an_error_at_both_places(self):
        self.write("liar.meld", LIAR.replace("min int", "max int"))
        _, said = self.call("meldsim", "run", "p.meld", code=1)
        self.assertIn("E0201", said)
        self.assertIn("liar.meld:1", said)
        self.assertIn("p.meld:2", said)
        self.assertIn("same words", said)
        self.write("liar.meld", "const k = 1.\ntype said(node, int).\nsaid(A, k).\n")
        self.write("p.meld", HONEST + "const k = 2.\ntype n(node, int).\nn(A, k).\n")
        _, said = self.call("meldc", "check", "p.meld", "--with", "liar.meld", code=1)
        self.assertIn("another name", said)
        # The same constant is one.
        self.write("p.meld", HONEST + "const k = 1.\ntype n(node, int).\nn(A, k).\n")
        self.call("meldc", "check", "p.meld", "--with", "liar.meld")

    def test_mistakes_of_the_world_have_a_place(self):
        for section, what in (('where = "id == 8"', "file"), ('file = "liar.meld"', "where"),
                              ('where = "id == 8"\nfile = "liar.meld"\nfil = 3', "fil"), ('where = "id = 8"\nfile = "liar.meld"', "==")):
            self.write("p.toml", WORLD[:WORLD.index("[[program]]")] + "[[program]]\n" + section + "\n")
            _, said = self.call("meldsim", "world", "p.toml", code=2)
            self.assertRegex(said, r"p\.toml:\d+:\d+: ")
            self.assertIn(what, said)
        self.write("p.toml", WORLD.replace("liar.meld", "nobody.meld"))
        _, said = self.call("meldsim", "run", "p.meld", code=2)
        self.assertIn("nobody.meld", said)

    def test_a_region_without_catoms_is_a_warning(self):
        self.write("p.toml", WORLD.replace("id == 8", "id == 80"))
        for processes in (1, 2):
            _, said = self.call("meldsim", "run", "p.meld", "-n", processes, "--ticks", 1)
            self.assertEqual(said.count("`id == 80` matches no catom"), 1, said)

    def test_a_module_has_as_many_programs_as_the_world(self):
        self.call("meldc", "compile", "p.meld", "-o", "one.so")
        _, said = self.call("meldsim", "run", "one.so", "--world", "p.toml", code=2)
        self.assertIn("--with", said)
        self.call("meldc", "compile", "p.meld", "--with", "liar.meld", "-o", "two.so")
        self.call("meldsim", "run", "two.so", "--world", "p.toml", "--quiet", "--facts-out", "g")
        self.rows("dist")
        self.assertEqual(self.read("f"), self.read("g"))
        _, said = self.call("meldc", "check", "p.meld", "--with", "p.meld", code=2)
        self.assertIn("twice", said)


if __name__ == "__main__":
    main("meldc", "meldsim")
