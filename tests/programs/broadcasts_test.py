"""What catoms tell all their neighbours need not be delivered while nobody looks on: the facts in every tick are those of a run in which
somebody does."""
import pathlib
import sys

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1]))

from frame import Case, main, one_in  # noqa: E402

# Facts of later rounds wait for their turn.
ROUNDS = """
type linear hot(node, int Round, float T).
type linear told(node, int Round, float T).
type linear hears(node, int Round, int Missing, float Sum).
type linear unstarted(node).

unstarted(A).
unstarted(A), id(A, I), tick(A, U), U > I % 3 -o hot(A, 0, float(I * 7 % 11)).
hot(A, R, T), neighborCount(A, N), R < 9 -o { B | neighbor(A, B) | told(B, R, T) }, hears(A, R, N, T).
hears(A, R, M, S), told(A, R, U) -o hears(A, R, M - 1, S + U / 3.0).
hears(A, R, 0, S) -o hot(A, R + 1, S / 2.0).
"""
# A catom tells several things in one tick, and one neighbour alone another one; nobody takes what is even.
MANY = """
type linear step(node, int, int Tick).
type linear told(node, int).
type linear odd(node, int).
type linear unstarted(node).

unstarted(A).
unstarted(A), id(A, I) -o step(A, I % 5, 0).
odd(A, 0).
step(A, N, T), tick(A, U), T < U, N % 3 = 0, N < 40
    -o { B | neighbor(A, B) | told(B, N) }, { B | neighbor(A, B) | told(B, N + 1) }, step(A, N + 4, U).
step(A, N, T), tick(A, U), T < U, N % 3 = 1, N < 40 -o { B, P | neighbor(A, B, P), P < 2 | told(B, N + P) }, step(A, N + 1, U).
step(A, N, T), tick(A, U), T < U, N % 3 = 2, N < 40 -o { B | neighbor(A, B) | told(B, N) }, step(A, N + 2, U).
told(A, N), N % 2 = 1, odd(A, S) -o odd(A, (S * 3 + N) % 101).
"""
# Views, absence, and an action now and then.
SEEN = """
type linear told(node, int).
type linear left(node, int, int Tick).
type seen(node, int).
type most(node, max int).

left(A, 12, 0).
left(A, N, T), tick(A, U), T < U, N > 0, not told(A, _) -o { B | neighbor(A, B) | told(B, N + U % 3) }, left(A, N - 1, U).
told(A, N), tick(A, U), U % 3 > 0 -o seen(A, N).
most(A, N) :- seen(A, N).
most(B, N - 1) :- neighbor(A, B), most(A, N), N > 3.
setColor(A, N, 0, 0) :- seen(A, N), N % 4 = 0.
"""
# No rule reads what is told.
UNREAD = """
type linear told(node, int, int).
type linear step(node, int).

step(A, 0).
step(A, T), tick(A, U), T < U, id(A, I), (U + I) % 4 < 2 -o { B | neighbor(A, B) | told(B, U, I) }, step(A, U).
"""


class Broadcasts(Case):
    FILES = {
        "rounds.meld": ROUNDS, "many.meld": MANY, "seen.meld": SEEN, "unread.meld": UNREAD,
        "w.toml": 'lattice = "cubic"\n[[body]]\nshape = "box(7, 5, 4)"\n',
        "flat.toml": 'lattice = "hex"\n[[body]]\nshape = "box(9, 8, 1)"\n',
    }

    def facts(self, program, world, ticks, *options):
        self.call("meldsim", "run", program, "--world", world, "--ticks", str(ticks), "--facts-out", "f", "--quiet", *options)
        text = (self.folder / "f").read_text()
        (self.folder / "f").unlink()
        return text

    def compare(self, program):
        for world in ("w.toml", "flat.toml"):
            for ticks in one_in(3, range(1, 28)):
                expected = self.facts(program, world, ticks, "--digest", "d")
                (self.folder / "d").unlink()
                for options in ((), ("--threads", "2"), ("-n", "2"), ("-n", "3", "--threads", "2")):
                    self.assertEqual(self.facts(program, world, ticks, *options), expected, f"{world}, {ticks} ticks, {options}")

    def test_rounds(self):
        self.compare("rounds.meld")

    def test_many(self):
        self.compare("many.meld")

    def test_unread(self):
        self.compare("unread.meld")

    def test_views_and_actions(self):
        self.compare("seen.meld")

    def test_a_run_that_ends_by_itself_has_delivered_all(self):
        ends = "type linear told(node, int).\ntype linear start(node).\n" \
               "start(A).\nstart(A) -o { B | neighbor(A, B) | told(B, 3) }, stop-program(A).\n"
        (self.folder / "ends.meld").write_text(ends)
        self.call("meldsim", "run", "ends.meld", "--world", "w.toml", "--facts-out", "f", "--quiet")
        self.assertIn("told", (self.folder / "f").read_text())


if __name__ == "__main__":
    main("meldsim")
