"""What `why-not` says of a part of a body within another: of `forall`, and of `not` within `not`.

    why_parts_test.py --meldc PATH --meldsim PATH [unittest options]
"""
import sys
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT / "tests"))

from frame import main  # noqa: E402
from why_test import Why  # noqa: E402

# Bodies with parts within parts, where @0 has p(@0, 2), q(@0, 5) and r(@0), and @1 has p(@1, 3): what the answer says beside the part
# that fails, and the fact about which it then asks.
WITHIN = {
    "forall p(A, X) [q(A, X)]": ("p(@0, 2) holds, and this does not hold:", "q(@0, 2)"),
    "forall neighbor(A, B) [r(B)]": ("neighbor(@0, @1) holds, and this does not hold:", "r(@1)"),
    "forall neighbor(A, B) [q(B, _)]": ("neighbor(@0, @1) holds, and this does not hold:", "q(@1, _)"),
    "forall p(A, X) [X > 2]": ("p(@0, 2) holds, and this fails: 2 > 2", None),
    "forall p(A, X) [q(A, Y), X > Y]": ("p(@0, 2) holds, and beside q(@0, 5) this fails: 2 > 5", None),
    "forall p(A, X) [q(A, Y), p(A, Y)]": ("p(@0, 2) holds, and beside q(@0, 5) this does not hold:", "p(@0, 5)"),
    "forall p(A, X) [not r(A)]": ("p(@0, 2) holds, and this fails: not (r(@0)): r(@0) holds", None),
    "forall p(A, X) [forall r(A) [q(A, X)]]":
        ("p(@0, 2) holds, and this fails: not (r(@0), not (q(@0, 2))): r(@0) holds, and this does not hold:", "q(@0, 2)"),
    "forall p(A, X) [N = count : { q(A, _) }, N > X]": ("p(@0, 2) holds, and this fails: 1 > 2", None),
    "not (p(A, X), Y = X + 1, not q(A, Y))": ("p(@0, 2) holds, and this does not hold:", "q(@0, 3)"),
    "not (p(A, X), q(A, Y), not q(A, X), not r(A))": None,
    "not (p(A, X), not r(B), neighbor(A, B), not q(A, X))":
        ("p(@0, 2), neighbor(@0, @1) holds, and this does not hold:", "r(@1)"),
    "not (X in [4, 7], not q(A, X))": ("this does not hold:", "q(@0, 4)"),
    "not (p(A, X), q(A, Y))": ("p(@0, 2), q(@0, 5) holds", None),
    "not (neighbor(A, B), p(B, X), X > 2)": ("neighbor(@0, @1), p(@1, 3) holds", None),
}


class Parts(Why):
    def test_parts_within_parts(self):
        self.write("p.toml", 'lattice = "square"\n[[body]]\nshape = "box(2, 1, 1)"\n')
        for body, says in WITHIN.items():
            self.write("p.meld", "type p(node, int).\ntype q(node, int).\ntype r(node).\ntype all(node).\n"
                                 f"p(@0, 2).\np(@1, 3).\nq(@0, 5).\nr(@0).\nall(A) :- id(A, _), {body}.\n")
            for processes in (1, 2):
                with self.subTest(body=body, processes=processes):
                    _, answer = self.ask("p.meld", "p.toml", ["run", "why-not all(@0)"], processes)
                    if says is None:
                        self.assertEqual(answer["nodes"], [])
                        continue
                    (way,) = answer["nodes"][0]["ways"]
                    part = way["parts"][-1]
                    self.assertEqual((part["is"], part.get("note")), ("fails", says[0]), part)
                    self.assertEqual(answer["nodes"][part["node"]]["fact"] if "node" in part else None, says[1], part)


if __name__ == "__main__":
    main("meldc", "meldsim")
