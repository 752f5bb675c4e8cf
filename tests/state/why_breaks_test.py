"""`why`, `history` and the way back of `meldsim debug` across a joint that breaks.

    why_breaks_test.py --meldc PATH --meldsim PATH [unittest options]
"""
import json
import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))

from frame import Case, main  # noqa: E402


class Breaks(Case):
    def ask(self, program, where, commands):
        out, _ = self.call("meldsim", "debug", program, "--world", where, "--json", "--quiet", "--commands", "-", stdin=None,
                           input="".join(c + "\n" for c in commands).encode())
        return [json.loads(line) for line in out.splitlines()]

    def test_what_breaks(self):
        """A joint that breaks in the first tick: taken by a rule in the same tick, or kept until a later one; also on the way back."""
        self.write("rope.toml", """[[body]]
positions = [[0, 0, 5], [0, 0, 4], [0, 0, 3], [0, 0, 2]]
[motion]
kind = "bodies"
steps = 4
[[motion.catoms]]
where = "id == 0"
fixed = true
[[motion.catoms]]
where = "id == 3"
mass = 3
[[motion.joint]]
where = "all"
axis = [0, 1, 0]
breaking_force = 35
""")
        self.write("at_once.meld", "type torn(node, node).\nbroke(A, B) -o torn(A, B).\n")
        self.write("later.meld", "type torn(node, node).\ntype late(node).\ntype bent(node, node, float).\nlate(A) :- tick(A, T), T > 4.\n"
                   "late(A), broke(A, B) -o torn(A, B).\nbent(A, B, P) :- joint(A, B, P, _).\n")
        said = self.call("meldsim", "why", "at_once.meld", "torn(@0, @1)", "--world", "rope.toml", "--tick", 3)[0]
        self.assertEqual(said, "torn(@0, @1)  made\n  made in tick 1\n  at_once.meld:2: broke(A, B) -o torn(A, B).  at @0\n"
                         "    broke(@0, @1)  in tick 1  sensed\n")
        said = self.call("meldsim", "history", "at_once.meld", "torn(@0, _)", "--world", "rope.toml", "--tick", 3)[0]
        self.assertEqual(said, "tick 1      +torn(@0, @1)  by at_once.meld:2 at @0\n")
        said = self.call("meldsim", "why", "later.meld", "torn(@1, @0)", "--world", "rope.toml", "--tick", 6)[0]
        self.assertEqual(said, "torn(@1, @0)  made\n  made in tick 5\n  later.meld:5: late(A), broke(A, B) -o torn(A, B).  at @1\n"
                         "    late(@1)  in tick 5\n    broke(@1, @0)  in tick 4\n")
        said = self.call("meldsim", "history", "later.meld", "broke(@0, _)", "--world", "rope.toml", "--tick", 7)[0]
        self.assertEqual(said, "tick 1      +broke(@0, @1)  sensed\ntick 5      -broke(@0, @1)  consumed by later.meld:5 at @0\n")
        said = self.call("meldsim", "why-not", "later.meld", "broke(@1, @2)", "--world", "rope.toml", "--tick", 4)[0]
        self.assertEqual(said, "broke(@1, @2)  does not hold\n  it is not sensed\n")
        # There and back again, the same is so in each tick.
        asked = ["query broke(A, B)", "query bent(A, B, P)", "query torn(A, B)", "query neighbor(A, B)", "why broke(@0, @1)", "facts"]

        def seen(moves):
            answers = self.ask("later.meld", "rope.toml", [c for move in moves for c in (move, *asked)])
            by_move = [answers[i:i + len(asked) + 1] for i in range(0, len(answers), len(asked) + 1)]
            return [(parts[0]["tick"], [{k: v for k, v in part.items() if k != "seconds"} for part in parts[1:]]) for parts in by_move]

        forward = dict(seen([f"to {tick}" for tick in range(8)]))
        # Tick 0 has not sensed anything yet; in tick 1 the upper joint is gone, and both know it.
        self.assertEqual([len(forward[tick][0]["rows"]) for tick in range(8)], [0, 2, 2, 2, 2, 0, 0, 0])
        self.assertEqual([len(forward[tick][1]["rows"]) for tick in range(8)], [0, 4, 4, 4, 4, 4, 4, 4])
        self.assertEqual([len(forward[tick][2]["rows"]) for tick in range(8)], [0, 0, 0, 0, 0, 2, 2, 2])
        back = seen(["to 7", "back 1", "back 1", "back 3", "step 1", "back 2", "back 1", "step 2", "back 2", "to 7"])
        self.assertEqual([tick for tick, _ in back], [7, 6, 5, 2, 3, 1, 0, 2, 0, 7])
        for tick, parts in back:
            self.assertEqual(parts, forward[tick], tick)


if __name__ == "__main__":
    main("meldc", "meldsim")
