"""What connected bodies do, against statics and mechanics, and what ends a connection or forbids it: connections_test.py MELDSIM."""

import math
import subprocess
import sys
import tempfile

from bodies_test import FINE, PLACE, SPEED, Bodies, close, same
from recorded import Recorded
from runner import Outcome

TELLING = "type joined(node, node).\njoined(A, B) :- connected(A, B).\ntype beside(node, node).\nbeside(A, B) :- neighbor(A, B).\n"
GRIP = "connect(A, B) :- neighbor(A, B).\n"
NO_WEIGHT = "gravity = [0, 0, 0]\n"


def row(count, *lines, height=0):
    """A row of catoms along x, and lines of [motion]."""
    return f'[[body]]\npositions = {[[x, 0, height] for x in range(count)]}\n[motion]\nkind = "bodies"\n' + "\n".join(lines) + "\n"


def both_ways(pairs):
    return sorted({(a, b) for a, b in pairs} | {(b, a) for a, b in pairs})


def chain(count):
    return both_ways([(i, i + 1) for i in range(count - 1)])


def hangs(bodies):
    """A cantilever of 40, from one fixed catom, by the program and by the world: it does not sag, at 1 and 2 threads."""
    fixed = '[[motion.catoms]]\nwhere = "id == 0"\nfixed = true\n'
    for program, more in ((GRIP, ""), ("", '[[motion.catoms]]\nwhere = "x >= 0"\nconnected = true\n')):
        for threads in ("1", "2"):
            facts, summary = bodies.run(PLACE + TELLING + program, row(40, "steps = 4", FINE) + fixed + more, 60, "--threads", threads)
            same((sorted(facts["joined"]), sorted(facts["beside"])), (chain(40), chain(40)), "connections and neighbours of a cantilever")
            same("; 39 connections" in summary["outcomes"][0], True, summary["outcomes"][0])
            heights = [z for _, _, _, z in sorted(facts["place"])]
            close(max(heights[1:]), min(heights[1:]), 1e-9, "the sag of a cantilever")
            # Before the program is evaluated, and its actions carried out, it falls for a tick of four steps of two substeps.
            close(heights[-1], 0 if more else -9.81 * 36 / 480**2, 1e-9 if more else 1e-6, "how far it has fallen")


def flies(bodies):
    """Two bodies of 1 and 3 kg keep their momentum when one hits the other and connects; the pair then turns about its centre."""
    world = (f'[[body]]\npositions = [[0, 0, 0], [1.2, 0.6, 0]]\n[motion]\nkind = "bodies"\nfriction = 0\n{NO_WEIGHT}{FINE}'
             '[[motion.catoms]]\nwhere = "id == 0"\nvelocity = [1, 0, 0]\n[[motion.catoms]]\nwhere = "id == 1"\nmass = 3\n')
    facts, _ = bodies.run(SPEED + PLACE + TELLING + GRIP, world, 300)
    same(sorted(facts["joined"]), both_ways([(0, 1)]), "whether they have connected")
    speeds = {catom: v for catom, *v in facts["speed"]}
    for axis, wanted in ((0, 1), (1, 0)):
        close(speeds[0][axis] + 3 * speeds[1][axis], wanted, 1e-5, "the momentum of the pair")
    places = {catom: v for catom, *v in facts["place"]}
    apart = [b - a for a, b in zip(places[0], places[1])]
    close(math.hypot(*apart), 1, 0.02, "their distance")
    # Rigid: no speed along the line between them.
    close(sum(d * (b - a) for d, a, b in zip(apart, speeds[0], speeds[1])), 0, 1e-5, "the speed at which they part")


def lets_go(bodies):
    """A row that hangs from its first catom is released in the middle: the outer half falls freely, and what touches stays a neighbour
    until it is gone."""
    fixed = '[[motion.catoms]]\nwhere = "id == 0"\nfixed = true\n[[motion.catoms]]\nconnected = true\n'
    program = PLACE + TELLING + "type now(node).\nnow(A) :- tick(A, 4).\nrelease(A, @5) :- now(A), id(A, 4).\n"
    for ticks, beside in ((4, chain(10)), (6, chain(10)), (65, [p for p in chain(10) if set(p) != {4, 5}])):
        facts, _ = bodies.run(program, row(10, "substeps = 1", FINE) + fixed, ticks)
        same(sorted(facts["beside"]), beside, f"neighbours in tick {ticks}")
        wanted = chain(10) if ticks == 4 else [p for p in chain(10) if set(p) != {4, 5}]
        same(sorted(facts["joined"]), wanted, f"connections in tick {ticks}")
        heights = [z for _, _, _, z in sorted(facts["place"])]
        steps = max(0, ticks - 4)
        for catom, z in enumerate(heights):
            close(z, 0 if catom < 5 else -9.81 * steps * (steps + 1) / 2 / 240**2, 1e-6, f"the height of catom {catom} in tick {ticks}")


def dies(bodies):
    """A catom that is killed, or lost, lets go, and its piece is two."""
    groups = '[[motion.catoms]]\nconnected = true\n'
    kill = '[[event]]\ntick = 5\nkill = "id == 2"\n'
    facts, _ = bodies.run(SPEED + TELLING, row(5, NO_WEIGHT) + groups + kill, 12)
    same(sorted(facts["joined"]), both_ways([(0, 1), (3, 4)]), "connections after a death")
    same(sorted(facts["beside"]), both_ways([(0, 1), (3, 4)]), "neighbours after a death")
    # Pushed by its end, each piece goes on its own.
    pushed = SPEED + TELLING + "force(A, 0 - 6, 0, 0) :- tick(A, T), T > 5, id(A, 0).\n"
    facts, _ = bodies.run(pushed, row(5, NO_WEIGHT, FINE) + groups + kill, 16)
    speeds = {catom: x for catom, x, _, _ in facts["speed"]}
    close(speeds[1], -6 / 2 / 240, 1e-6, "the speed of a piece of two")
    close(speeds[3], 0, 1e-9, "the speed of the other piece")
    # Below the lowest height a catom is taken out of its piece, and the others fall on.
    world = row(3, "steps = 4", "lowest = -1", 'lost = "remove"').replace("[2, 0, 0]", "[1, 0, -1]") + groups
    facts, summary = bodies.run(TELLING, world, 2)
    same((sorted(facts["joined"]), summary["catoms"]), (both_ways([(0, 1)]), 2), "connections after a catom is lost")


def rests(bodies):
    """Catoms that lie on the ground and beside each other are connected to a fixed one: nothing moves them any more, and they go on
    sensing the ground and each other; released, they lie as before."""
    fixed = '[[motion.catoms]]\nwhere = "id == 0 || id == 5"\nfixed = true\n'
    program = (TELLING + "type lies(node, int).\nlies(A, O) :- contact(A, O).\n"
               "type wish(node, int T).\nwish(A, T) :- tick(A, T), T % 20 = 0.\n"
               "connect(A, B) :- wish(A, 20), neighbor(A, B), id(A, I), I <> 2.\nrelease(A, B) :- wish(A, 60), connected(A, B).\n")
    world = row(6, "steps = 4", "ground = -0.5", FINE) + fixed
    for ticks, joined in ((15, []), (40, chain(6)), (80, [])):
        facts, _ = bodies.run(program, world, ticks)
        same(sorted(facts["joined"]), joined, f"connections in tick {ticks}")
        same(sorted(facts["beside"]), chain(6), f"neighbours in tick {ticks}")
        same(sorted(facts["lies"]), [(i, 0) for i in range(1, 5)], f"who lies on the ground in tick {ticks}")


def groups_by_the_world(bodies):
    """Each group is connected by itself, a later group decides, and a group of which no two touch triggers a warning."""
    groups = ('[[motion.catoms]]\nwhere = "id < 3"\nconnected = true\n[[motion.catoms]]\nwhere = "id >= 3"\nconnected = true\n'
              '[[motion.catoms]]\nwhere = "id == 5"\nconnected = false\n')
    facts, _ = bodies.run(TELLING, row(6, NO_WEIGHT) + groups, 3)
    same(sorted(facts["joined"]), both_ways([(0, 1), (1, 2), (3, 4)]), "connections of two groups")
    same(sorted(facts["beside"]), chain(6), "neighbours of two groups")
    done = bodies.command(TELLING, row(6, NO_WEIGHT) + '[[motion.catoms]]\nwhere = "id % 2 == 0"\nconnected = true\n', 1)
    same("w.toml:7:1: no two catoms of `id % 2 == 0` touch at the start, so none are connected" in done.stderr, True, done.stderr)


def within_a_range(bodies):
    """Where neighbours are those within a range, only those that touch can be connected."""
    world = row(3, NO_WEIGHT).replace("[2, 0, 0]", "[2.5, 0, 0]").replace("[motion]", "[links]\nrange = 4\n[motion]")
    facts, summary = bodies.run(TELLING + GRIP, world, 5)
    same((sorted(facts["joined"]), len(facts["beside"])), (both_ways([(0, 1)]), 6), "connections within a range")
    same(summary["refused_actions"], [{"action": "connect", "reason": "not_touching", "count": 4}], "refusals within a range")


def refuses(bodies):
    """Other engines, other worlds: at once, with the place and a cure."""
    connected = "[[motion.catoms]]\nconnected = true\n"
    for program, world, options, said in (
            (GRIP, row(3, 'engine = "hash"'), (),
             'the program asks for `connect`, and the world has the engine "hash" (which connects no catoms). '
             'Write [motion] engine = "blocks"'),
            (TELLING, row(3, 'engine = "ode"') + connected, (), 'these catoms are connected, and the world has the engine "ode"'),
            (TELLING, row(3) + "[[motion.catoms]]\nconnected = 3\n", (), "connected")):
        done = bodies.command(program, world, 2, *options)
        same((done.returncode != 0, said in done.stderr), (True, True), f"{said}\n{done.stderr}")
    # On two processes, too, those who are not connected cannot release each other, and those who are no bodies cannot connect.
    facts, summary = bodies.run(TELLING + "release(A, B) :- neighbor(A, B).\n", row(3, NO_WEIGHT), 3, "-n", "2")
    same(summary["refused_actions"], [{"action": "release", "reason": "not_connected", "count": 4}], "refused releases")
    lattice = 'lattice = "square"\n[[body]]\nshape = "box(3, 1, 1)"\n[motion]\nkind = "lattice"\n'
    facts, summary = bodies.run(GRIP, lattice, 3, "-n", "2")
    same(summary["refused_actions"], [{"action": "connect", "reason": "not_in_this_world", "count": 4}], "refusals on a lattice")


def goes_on(bodies):
    """Another program goes on with what is connected: it senses it, and can release it; on several processes, too."""
    fixed = '[[motion.catoms]]\nwhere = "id == 0"\nfixed = true\n'
    kept, out = bodies.folder / "kept", bodies.folder / "forked.facts"
    bodies.run(GRIP, row(4, "steps = 4") + fixed, 9, "--checkpoint", kept)
    releases = "type go(node).\ngo(A) :- tick(A, 13).\nrelease(A, B) :- go(A), connected(A, B), id(A, 1).\n"
    (bodies.folder / "q.meld").write_text(TELLING + releases)

    def fork(*options):
        command = [bodies.meldsim, "fork", kept, "--program", bodies.folder / "q.meld", "--facts-out", out, "--quiet", *options]
        return subprocess.run(command, env=bodies.environment, capture_output=True, text=True, check=False)

    for ticks, joined, *options in (("12", chain(4)), ("15", both_ways([(2, 3)])), ("12", chain(4), "-n", "2"),
                                    ("15", both_ways([(2, 3)]), "-n", "3")):
        done = fork("--ticks", ticks, *options)
        same((done.returncode, sorted(Outcome(out.read_text(), {}).facts["joined"])), (0, joined), f"tick {ticks}: {done.stderr}")


def is_recorded(bodies):
    """A connected pair is one body in a recording too: its distance stays the same to the last bit of what is recorded."""
    world = row(2, "steps = 4", "ground = -3") + "[[motion.catoms]]\nconnected = true\nspin = [0, 0, 1]\n"
    bodies.run(TELLING, world, 90, "--record", bodies.folder / "out.vtkhdf")
    for step in Recorded(bodies.folder / "out.vtkhdf").positions:
        close(math.dist(*step), 1, 1e-6, "the distance of a connected pair")


def main():
    with tempfile.TemporaryDirectory() as folder:
        bodies = Bodies(sys.argv[1], folder)
        for check in (hangs, flies, lets_go, dies, rests, groups_by_the_world, within_a_range, refuses, goes_on, is_recorded):
            check(bodies)
            print(f"{check.__name__}: fine")


if __name__ == "__main__":
    main()
