"""Runs that are divided anew among their processes: they are the same runs.

    balance_test.py --meldsim PATH [unittest options]
"""
import json
import pathlib
import sys

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1]))

from frame import Case, main  # noqa: E402

# All that waits for a later tick: facts, timers, actions, tokens; and work that is somewhere else all the time.
PROGRAM = """type linear token(node, int).
type seen(node, int).
type near(node, min int).
type late(node, int).
type action setColor(node, int, int, int).
token(@0, 0).
token(@700, 0).
token(A, N), N < 60 -o { B | neighbor(A, B), random() < 0.35 | token(B, N + 1)@+2 }, seen(A, N).
near(A, 0) :- seen(A, _).
near(B, D + 1) :- neighbor(A, B), near(A, D), D < 4.
late(A, D)@+3 :- near(A, D).
setColor(A, 255, 50 * D, 0) :- late(A, D).
"""
WORLD = 'lattice = "square"\n[[body]]\nshape = "box(70, 50, 1)"\n[record]\nevery = 5\n'
# Work in one corner.
CORNER = """type linear beat(node, int).
type busy(node).
busy(A) :- id(A, I), I < 1600.
beat(A, 0).
beat(A, N), busy(A) -o beat(A, N + 1)@+1.
"""


class Balance(Case):
    FILES = {"w.toml": WORLD, "p.meld": PROGRAM, "corner.meld": CORNER}

    def run_on(self, processes, when, program="p.meld", ticks="50"):
        out, _ = self.call("meldsim", "run", program, "--world", "w.toml", "--ticks", ticks, "-n", processes, "--balance", when,
                           "--json", "--quiet", "--digest", "digest", "--facts-out", "facts")
        summary = json.loads(out)
        counts = {key: summary[key] for key in ("evaluations", "derivations", "exported_changes", "linear_messages", "ticks")}
        return (counts, (self.folder / "digest").read_text(), (self.folder / "facts").read_text()), summary

    def test_nothing_else_changes(self):
        alone, _ = self.run_on(1, "never")
        for processes, when in (2, "1ticks"), (3, "4ticks"), (4, "1tick"):
            with self.subTest(processes=processes, when=when):
                divided, summary = self.run_on(processes, when)
                self.assertEqual(divided, alone)
                self.assertTrue(summary["divisions"])
                self.assertGreater(sum(each["moved_catoms"] for each in summary["divisions"]), 100)

    def test_memory_does_not_grow(self):
        # The surroundings of empty bricks were once made at every division, a layer more each time.
        (self.folder / "w.toml").write_text(WORLD.replace("70, 50", "140, 50").replace("[record]", '[motion]\nkind = "lattice"\n[record]'))
        _, kept = self.run_on(2, "never")
        _, divided = self.run_on(2, "1tick")
        self.assertGreater(len(divided["divisions"]), 4)
        self.assertLess(divided["bytes_per_catom"], 1.5 * kept["bytes_per_catom"])

    def test_by_itself_where_it_pays(self):
        (_, digest, _), kept = self.run_on(2, "never", "corner.meld", "300")
        self.assertEqual(kept["divisions"], [])
        (_, again, _), summary = self.run_on(2, "auto", "corner.meld", "300")
        self.assertEqual(again, digest)
        self.assertEqual(len(summary["divisions"]), 1)
        self.assertGreater(summary["divisions"][0]["imbalance_before"], 1.9)
        self.assertLess(summary["imbalance"], 1.5)

    def test_a_run_that_goes_on(self):
        (_, digest, facts), _ = self.run_on(1, "never")
        self.call("meldsim", "run", "p.meld", "--world", "w.toml", "--ticks", "21", "-n", "2", "--balance", "2ticks", "--quiet",
                  "--checkpoint", "c", "--facts-out", "facts")
        self.call("meldsim", "resume", "c", "-n", "3", "--ticks", "50", "--quiet")
        self.assertEqual((self.folder / "facts").read_text(), facts)

    def test_when_is_a_time(self):
        self.write("facts", "kept")
        for when, processes in ("often", 1), ("often", 2), ("0ticks", 2), ("-1ticks", 1), ("5", 2), ("5 ticks", 1):
            with self.subTest(when=when, processes=processes):
                self.refused("meldsim", "run", "p.meld", "--world", "w.toml", "-n", processes, f"--balance={when}", "--facts-out", "facts",
                             code=2, says=["is no time", "100ticks"], lines=None)
                self.assertEqual(self.read("facts"), b"kept")


if __name__ == "__main__":
    main("meldsim")
