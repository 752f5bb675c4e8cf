"""Very long modules are compiled in pieces: what a change compiles again, and that the result is the same as in one piece.

    pieces_test.py --meldc PATH --meldsim PATH [unittest options]
"""
import pathlib
import sys

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1]))
sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1] / "bench"))

import large_program  # noqa: E402
from frame import Case, main, square  # noqa: E402

# Enough for a module in pieces.
PREDICATES = 45
QUICK = {"CLAYMELD_OPTIMIZATION": None}


class Pieces(Case):
    def setUp(self):
        super().setUp()
        self.write("w.toml", square(4))

    def compile(self, text):
        """Returns how many pieces were made."""
        before = self.pieces()
        self.write("p.meld", text)
        self.call("meldc", "compile", "p.meld", "--cache", "cache", "--quiet", environment=QUICK)
        return len(self.pieces() - before)

    def pieces(self):
        return {name for name in self.files() if name.endswith(".piece")}

    def test_a_changed_rule_changes_one_piece(self):
        text = large_program.linked(PREDICATES)
        every = self.compile(text)
        self.assertGreater(every, 10)
        self.assertEqual(self.compile(text), 0)
        # Its own piece, and what tells where rules are in the text. No value needs more bytes than before.
        self.assertLessEqual(self.compile(text.replace("p30(A, X + 30)", "p30(A, X + 31)")), 2)
        self.assertLessEqual(self.compile(text.replace("Y > 30.", "Y > 31.")), 2)

    def test_lines_and_rules_before_it_change_no_piece(self):
        text = large_program.linked(PREDICATES)
        self.compile(text)
        self.assertLessEqual(self.compile("// A line.\n\n" + text), 1)
        first, second = (text.index(f"type p{i}(") for i in (21, 31))
        more = text[:second] + "p30(A, X + 20) :- p29(A, X), X < 800.\n" + text[second:]
        self.assertLessEqual(self.compile(more), 2)
        still_more = more[:first] + "p20(A, X + 20) :- p19(A, X), X < 300.\n" + more[first:]
        self.assertLessEqual(self.compile(still_more), 2)
        # Without the one, with the other.
        self.assertLessEqual(self.compile(still_more.replace("p30(A, X + 20) :- p29(A, X), X < 800.\n", "")), 2)

    def test_lines_before_rules_over_two_links_change_no_piece(self):
        """The compiler makes predicates of its own for them, and names these by lines."""
        text = large_program.linked(PREDICATES) + "".join(
            f"type far{i}(node, max int).\nfar{i}(A, X) :- neighbor(A, B), neighbor(B, C), p{i}(C, X).\n" for i in range(1, 9))
        self.assertGreater(self.compile(text), 10)
        # The tables, and the names of predicates.
        self.assertLessEqual(self.compile("// A line.\n\n" + text), 2)

    def test_predicates_may_be_called_as_rules_are_numbered(self):
        text = large_program.linked(PREDICATES).replace("p7(", "number_of_parts(").replace("p8(", "numberOf_rule_p9_n0(")
        self.assertGreater(self.compile(text), 10)

    def test_the_text_grows_as_the_program_does(self):
        for kind, program in large_program.KINDS.items():
            self.write("p.meld", program(100))
            self.write("q.meld", program(200))
            once, twice = (len(self.call("meldc", "compile", name, "--emit=cpp", environment=QUICK)[0]) for name in ("p.meld", "q.meld"))
            self.assertLess(twice, 2.2 * once, kind)

    def results(self, compiled, processes, threads):
        environment = {"CLAYMELD_CACHE": self.folder / "cache", **compiled}
        digests, _ = self.call("meldsim", "run", "p.meld", "--world", "w.toml", "--ticks", 12, "--quiet", "--digest", "-",
                               "--facts-out", "facts", "-n", processes, "--threads", threads, environment=environment)
        return digests, self.read("facts")

    def check_same(self, program):
        self.write("p.meld", program)
        expected = self.results({"CLAYMELD_OPTIMIZATION": "0"}, 1, 1)
        self.assertGreater(len(expected[1].splitlines()), 12)
        self.assertFalse(self.pieces())
        for processes, threads in ((1, 1), (3, 2)):
            self.assertEqual(self.results(QUICK, processes, threads), expected)
        self.assertTrue(self.pieces())


def add(kind):
    setattr(Pieces, f"test_{kind}_are_the_same_in_one_piece", lambda self: self.check_same(large_program.KINDS[kind](90)))


for name in large_program.KINDS:
    add(name)

if __name__ == "__main__":
    main("meldc", "meldsim")
