"""meldsim view: frames that are kept from one picture to the next are those that are made from the whole run, byte by byte.

    frames_test.py --meldc PATH --meldsim PATH [unittest options]

A body that also asks for the tick is asked of all catoms each time, and says the same; so the frame of a look with it is the one that the
frame of the look without it has to be.
"""
import pathlib
import random
import sys

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1]))

from frame import CAMPAIGN, FRONT, OPEN_MPI, main, one_in  # noqa: E402
from viewing import Viewing  # noqa: E402

ROUNDS = 40 if CAMPAIGN else 12

# Values of several kinds, which come, change and go.
VALUES = FRONT + """
type far(node).
type half(node, float).
type word(node, string).
type linear token(node, int).
type linear passed(node, int).
far(A)              :- dist(A, D), D > 4.
half(A, 0.5 * D)    :- dist(A, D).
word(A, "near")     :- dist(A, D), D < 3.
word(A, "middle")   :- dist(A, D), D >= 3, D < 7.
passed(A, 0).
token(A, 40), id(A, 0) -o 1.
token(A, N), N > 0, neighbor(A, B), A < B, passed(A, M) -o token(B, N - 1), passed(A, M + 1).
setColor(A, 40 * D, 0, 200) :- dist(A, D), D < 6.
"""
# Catoms that rise above the others, that merge into others, and that come from these.
MOVING = """
type height(node, int).
height(A, Z)           :- cell(A, _, _, Z).
moveTo(A, X, Y, Z + 5) :- tick(A, T), cell(A, X, Y, Z), (T + X + Y) % 7 = 0.
destroy(A, B)          :- tick(A, T), id(A, I), (T + I) % 23 = 5, neighbor(A, B, 0).
create(A, P)           :- tick(A, T), id(A, I), (T + I) % 11 = 3, vacant(A, P).
"""


def world(lattice, sides, rest=""):
    return f'lattice = "{lattice}"\n[[body]]\nshape = "box({sides})"\n{rest}'


class Frames(Viewing):
    FILES = {"values.meld": VALUES, "moving.meld": MOVING, "cubic.toml": world("cubic", "9, 8, 7"), "fcc.toml": world("fcc", "7, 7, 6"),
             "square.toml": world("square", "20, 20, 1"), "hex.toml": world("hex", "20, 15, 1"),
             "lattice.toml": world("cubic", "6, 6, 6", "[motion]\nkind = 'lattice'\n"),
             "layers.toml": world("fcc", "5, 5, 5", "[motion]\nkind = 'lattice'\n")}
    BODIES = ("dist(A, D)", "far(A)", "half(A, H)", "word(A, W)", "passed(A, N), N > 0", "neighbor(A, B), B > A",
              "neighborCount(A, N), N < 6", "cell(A, X, _, _)", "dist(A, D), not far(A)", "")
    SHOWN = ("", "", "dist(A, _)", "cell(A, X, _, _), X > 1", "neighborCount(A, N), N > 2")

    @staticmethod
    def whole(look):
        """The same look, each of whose bodies is asked of all catoms."""
        whole = {name: body + ", tick(A, _)" if name in ("colour", "only", "hide") and body else body for name, body in look.items()}
        if not any(look.get(name) for name in ("colour", "only", "hide")):
            whole["only"] = "tick(A, _)"
        return whole

    def same(self, page, look, most, context):
        asked = {"most": most, "values": True}
        kept, block = page.ask("frame", look=look, **asked)
        whole, expected = page.ask("frame", look=self.whole(look), **asked)
        self.assertTrue(kept["ok"] and whole["ok"], (kept, whole, context))
        for said in (kept, whole):
            del said["id"]
        self.assertEqual(kept["mistakes"], [], context)
        if kept["legend"] and kept["legend"]["title"] == look.get("colour"):
            whole["legend"]["title"] = kept["legend"]["title"]
            for kinds in (whole["legend"].get("kinds", []),):
                for kind in kinds:
                    kind[0] = kind[0].removesuffix(", tick(A, _)")
        self.assertEqual(kept, whole, context)
        self.assertEqual(block, expected, context)
        return kept

    def looks(self, draw, bodies):
        look = {"colour": draw.choice(bodies), "only": draw.choice(self.SHOWN if bodies is self.BODIES else self.SHOWN[:1]),
                "hide": draw.choice(self.SHOWN[:4] if draw.random() < 0.3 and bodies is self.BODIES else ("",))}
        if draw.random() < 0.3:
            look["form"] = draw.choice(("cube", "sphere", "rounded"))
        if draw.random() < 0.3:
            look["cut"] = {"axis": draw.randrange(3), "at": draw.randrange(4), "above": draw.random() < 0.5}
        if draw.random() < 0.2:
            look["range"] = [1, 5]
        return {name: value for name, value in look.items() if value}

    def changed(self, draw, tick, catoms):
        """A command, most often one that goes forward."""
        somebody = draw.randrange(catoms)
        return draw.choice(["step", "step", "step 2", "step 5", f"kill @{somebody}", f"kill cell(A, {draw.randrange(6)}, _, _)",
                            f"to {draw.randrange(tick + 1)}", "back", "back 2"])

    def compare(self, program, world_file, seed, bodies, more=(), options=()):
        draw = random.Random(seed)
        page = self.page(self.view(program, "--world", world_file, "--ticks", 60, *options, environment=OPEN_MPI), seconds=60)
        catoms = page.ask("hello")[0]["catoms"]
        # Two frames are kept at a time; a third look drops one.
        looks = [(self.looks(draw, bodies), draw.choice((10, 60, 150, 100000))) for _ in range(3)]
        sent = set()
        for turn in range(ROUNDS):
            line = draw.choice(more) if more and draw.random() < 0.3 else self.changed(draw, page.ask("hello")[0]["tick"], catoms)
            page.ask("command", line=line.format(draw.randrange(catoms)))
            look, most = draw.choice(looks)
            said = self.same(page, look, most, (program, world_file, seed, turn, line, look, most))
            sent.add((said["sent"], said["coarse"]))
            if draw.random() < 0.2:
                page.ask("image", look=look, size=[40, 30], camera={})
            # Again, although nothing has happened.
            if draw.random() < 0.3:
                self.same(page, look, most, (program, world_file, seed, turn, "again", look, most))
        self.interrupt()
        return sent

    def test_values_that_change(self):
        by_hand = ("give source(@{})", "take source(@0)", "give passed(@{}, 7)", "give source(@{})")
        runs = (("cubic", ()), ("square", ()), ("fcc", ()), ("hex", ()), ("cubic", ("-n", 2)), ("fcc", ("-n", 3)))
        for i, (name, options) in one_in(2, enumerate(runs)):
            self.compare("values.meld", f"{name}.toml", 10 + i, self.BODIES, by_hand, options)

    def test_catoms_that_move(self):
        for i, (name, options) in one_in(2, enumerate((("layers", ()), ("lattice", ()), ("lattice", ("-n", 2))))):
            self.compare("moving.meld", f"{name}.toml", 20 + i, ("height(A, Z)", "neighborCount(A, N)", ""), (), options)

    def test_a_frame_of_the_same_state_is_the_same(self):
        page = self.page(self.view("values.meld", "--world", "cubic.toml"))
        look = {"colour": "dist(A, D)"}
        page.ask("command", line="run")
        first, block = page.ask("frame", look=look)
        second, again = page.ask("frame", look=look)
        self.assertEqual((first["shown"], block), (second["shown"], again))
        # A tick in which nothing happens says only another tick.
        page.ask("command", line="give token(@3, 0)")
        page.ask("command", line="step")
        third, later = page.ask("frame", look=look)
        self.assertEqual(third["legend"], first["legend"])
        self.assertEqual(block[16:], later[16:])
        self.assertEqual(int.from_bytes(later[8:16], "little"), third["tick"])


if __name__ == "__main__":
    main("meldc", "meldsim")
