"""What programs do that make joints and take them off: attach_test.py MELDSIM."""

import math
import sys
import tempfile

import h5py
from bodies_test import FINE, PLACE, Bodies, close, same
from joints_test import ALL, DIVISIONS, FIXED, LOADS, TELLING, both_ways, joint, resumed_alike, row

REFUSED = "type linear failed(node, int).\ntype refused(node, int, int).\nfailed(A, C), tick(A, T) -o refused(A, C, T).\n"


def kind(**keys):
    return joint(**keys).replace("[[motion.joint]]", "[[motion.joint_kind]]")


def at(places, *lines):
    return row(1, *lines).replace("[[0, 0, 0]]", str(places))


def alike(bodies, program, world, ticks, stops=()):
    """The facts and the summary of a run, which are the same on any processes and threads, and from checkpoints after these ticks."""
    seen, summaries = [], []
    for division in DIVISIONS + (("-n", "4"),):
        facts, summary = bodies.run(program, world, ticks, *division)
        seen.append({name: sorted(rows) for name, rows in facts.items()})
        summaries.append((summary["outcomes"][0].split(", with")[0], summary["refused_actions"]))
    for other, said in zip(seen, summaries):
        same((other, said), (seen[0], summaries[0]), "a run on several processes and threads")
    resumed_alike(bodies, program, world, ticks, stops, seen[0])
    return seen[0], summary


def swings_and_flies(bodies):
    """A ball that a fixed one takes by a hinge falls as a pendulum does, and flies on when it is let go."""
    world = at([[0, 0, 0], [1, 0, 0]], "steps = 4", FINE + ALL) + FIXED + kind(axis="[0, 1, 0]", anchor="[0, 0, 0]")
    program = (PLACE + TELLING + "attach(A, @1, 0) :- id(A, 0), tick(A, T), T = 1.\n"
               "detach(A, @1) :- id(A, 0), tick(A, T), T = 40.\n")
    facts, _ = bodies.run(program, world, 40)
    angle, speed = facts["turned"][0][2:]
    same(1.4 < angle < 2, True, f"the ball is about below: {angle}")
    # m g r sin(a) = (m r^2 + I) w^2 / 2.
    close(speed, math.sqrt(2 * 9.81 * math.sin(angle) / 1.1), 0.05, "the speed of the pendulum")
    facts, _ = alike(bodies, program, world, 70, (1, 2, 39, 40, 41))
    last = {a: p for a, *p in facts["place"]}
    same((last[1][2] < -1.5, last[1][0] < -1, facts.get("beside", [])), (True, True, []), f"the ball flies on: {last[1]}")


def changes_neighbours(bodies):
    """Catoms with a joint are neighbours, far or near, for as long as they have it; those that touch are so before and after, each tick."""
    places = [[0, 0, 0], [60, 3, 0], [20, 0, 0], [21, 0, 0]]
    world = at(places, "steps = 3", "gravity = [0, 0, 0]", FINE + ALL) + FIXED + kind(kind='"ball"', reach="90") + kind(kind='"ball"')
    program = (TELLING + "type alone(node).\nalone(A) :- id(A, I), I > 1, not neighbor(A, _).\n"
               "type was(node, int).\ntype linear last(node, int).\nlast(A, 0).\n"
               "last(A, L), alone(A), tick(A, T), T > L -o last(A, T), was(A, T).\n"
               "attach(A, @1, 0) :- id(A, 0), tick(A, T), T = 5.\ndetach(A, @0) :- id(A, 1), tick(A, T), T = 10.\n"
               "attach(A, @3, 1) :- id(A, 2), tick(A, T), T = 4.\ndetach(A, @3) :- id(A, 2), tick(A, T), T = 8.\n")
    for ticks, far in ((5, False), (6, True), (10, True), (11, False), (14, False)):
        facts, _ = alike(bodies, program, world, ticks, (2, ticks - 1))
        same(facts.get("beside", []), both_ways([(2, 3)] + [(0, 1)] * far), f"neighbours after tick {ticks}")
        same(facts.get("was", []), [], "those that touch are neighbours in each tick")


def meets_all_refusals(bodies):
    """Each reason, in the summary and for the catom; of two who ask for the same, the one with the lower number goes first."""
    places = [[0, 0, 0], [1, 0, 0], [2, 0, 0], [3, 0, 0], [6, 0, 0], [30, 0, 0]]
    world = at(places, "steps = 2", "gravity = [0, 0, 0]", FINE + ALL) + FIXED.replace("id == 0", "id < 2") + joint(
        between="[1, 2]", axis="[0, 1, 0]") + kind(axis="[0, 1, 0]") + kind(kind='"ball"') + '[[event]]\ntick = 3\nkill = "id == 5"\n'
    program = (TELLING + REFUSED + "type now(node, int).\nnow(A, T) :- tick(A, T), T % 4 = 0.\n"
               "attach(A, @1, 0) :- id(A, 0), now(A, 4).\nattach(A, @2, 0) :- id(A, 1), now(A, 4).\n"
               "attach(A, @3, 2) :- id(A, 2), now(A, 4).\nattach(A, @3, 0 - 1) :- id(A, 2), now(A, 4).\n"
               "attach(A, @4, 0) :- id(A, 3), now(A, 4).\nattach(A, A, 0) :- id(A, 3), now(A, 4).\n"
               "attach(A, @5, 0) :- id(A, 4), now(A, 4).\nattach(A, @77, 0) :- id(A, 4), now(A, 4).\n"
               "detach(A, @3) :- id(A, 4), now(A, 4).\n"
               "attach(A, @2, 0) :- id(A, 3), now(A, 8).\nattach(A, @3, 1) :- id(A, 2), now(A, 8).\n"
               "attach(A, @3, 0) :- id(A, 2), now(A, 8).\n"
               "detach(A, @1) :- id(A, 2), now(A, 8).\nattach(A, @2, 0) :- id(A, 1), now(A, 8).\n").replace("@77", "@4 ")
    facts, summary = alike(bodies, program, world, 12, (4, 5, 8, 9))
    count = {each["reason"]: each["count"] for each in summary["refused_actions"] if each["action"] == "attach"}
    same(count, {"both_fixed": 1, "already_joined": 2, "no_such_kind": 2, "too_far": 1, "no_such_catom": 3, "conflict": 2}, "attach")
    same([each for each in summary["refused_actions"] if each["action"] == "detach"],
         [{"action": "detach", "reason": "not_joined", "count": 1}], "detach")
    same(sorted((a, b) for a, b, *_ in facts["turned"]), both_ways([(2, 3)]), "the joint that two asked for")
    same(28 in {code for _, code, _ in facts["refused"]} and 29 in {code for _, code, _ in facts["refused"]}, True, "what failed")


def has_many(bodies):
    """A catom has 493 joints at most; a fixed one has any number."""
    count = 500
    places = [[0, 0, 0]] + [[3 + 2 * (i % 25), 2 * (i // 25), 5] for i in range(count)]
    world = at(places, "steps = 1", "gravity = [0, 0, 0]", FINE + ALL) + kind(kind='"ball"', reach="200")
    program = REFUSED + "attach(A, @0, 0) :- tick(A, T), T = 2, id(A, I), I > 0.\n"
    facts, summary = bodies.run(program, world, 3)
    same(summary["refused_actions"], [{"action": "attach", "reason": "too_many_joints", "count": 7}], "too many joints")
    same(sorted(a for a, *_ in facts["refused"]), list(range(494, 501)), "the last ones are refused")
    same("; 493 joints" in summary["outcomes"][0], True, summary["outcomes"][0])
    _, summary = bodies.run(program, world + FIXED, 3, "-n", "2")
    same("; 500 joints" in summary["outcomes"][0], True, summary["outcomes"][0])


def turns_with_its_catom(bodies):
    """Axis and anchor of a kind are those of the catom that asks: here it is turned by a quarter about z."""
    world = at([[0, 0, 0], [0, 1, 0]], "steps = 4", FINE + ALL) + FIXED + "turned = [0, 0, 90]\n" + kind(
        axis="[0, 1, 0]", anchor="[0.5, 0, 0]", torque="50", servo="30", speed="3")
    facts, _ = alike(bodies, PLACE + TELLING + "attach(A, @1, 0) :- id(A, 0), tick(A, T), T = 1.\n", world, 90)
    # Its y is the world's -x, and its x is the world's y.
    places = {a: p for a, *p in facts["place"]}
    close(math.dist(places[1], [0, 0.5 + 0.5 * math.cos(math.pi / 6), -0.5 * math.sin(math.pi / 6)]), 0, 0.01, "where the servo holds it")


def wakes_and_breaks(bodies):
    """What sleeps wakes when a joint is made and when it is taken off; what a program has made breaks as all joints do."""
    places = [[0, 0, 0.5], [1.02, 0, 0.5], [0, 0, 3]]
    world = at(places, "steps = 4", "ground = 0", "sleep_ticks = 4", FINE + ALL) + FIXED.replace("== 0", "== 2") + kind(
        kind='"slider"', axis="[0, 0, 1]", force="60", servo="1.5", speed="2", reach="3") + kind(
            kind='"ball"', reach="3", breaking_force="15", anchor="[0, 0, 0]")
    program = (PLACE + TELLING + LOADS + "attach(A, @0, 0) :- id(A, 2), tick(A, T), T = 30.\n"
               "detach(A, @0) :- id(A, 2), tick(A, T), T = 90.\n"
               "attach(A, @0, 1) :- id(A, 1), tick(A, T), T = 60.\n")
    facts, summary = alike(bodies, program, world, 160, (31, 61, 62, 91))
    places = {a: p for a, *p in facts["place"]}
    same(len(facts["lost"]), 2, "the ball joint broke")
    close(places[0][2], 0.5, 0.01, "what was let go has fallen")
    same("; 1 joint broke" in summary["outcomes"][0], True, summary["outcomes"][0])


def holds_pieces(bodies):
    """A piece of three takes another one of three by a hinge, both connect and release, and the joint goes on."""
    places = [[x, 0, 0] for x in range(6)]
    world = at(places, "steps = 4", FINE + ALL) + FIXED + '[[motion.catoms]]\nwhere = "id < 3"\nconnected = true\n' + (
        '[[motion.catoms]]\nwhere = "id > 2"\nconnected = true\n' + kind(axis="[0, 1, 0]", torque="900", servo="0"))
    program = (PLACE + TELLING + "attach(A, B, 0) :- id(A, 2), tick(A, T), T = 3, neighbor(A, B), id(B, 3).\n"
               "connect(A, B) :- id(A, 2), tick(A, T), T = 6, neighbor(A, B), id(B, 3).\n"
               "release(A, B) :- id(A, 3), tick(A, T), T = 9, neighbor(A, B), id(B, 2).\n"
               "detach(A, B) :- id(A, 3), tick(A, T), T = 12, neighbor(A, B), id(B, 2).\n")
    held, _ = alike(bodies, program.replace("T = 12", "T = 99"), world, 40, (3, 4, 7, 10))
    same(sorted((a, b) for a, b, *_ in held["turned"]), both_ways([(2, 3)]), "the joint")
    same((2, 3) in held["beside"], True, "neighbours by the joint")
    facts, _ = alike(bodies, program, world, 40, (6, 12, 13))
    places = {a: p for a, *p in facts["place"]}
    same((places[3][2] < -0.5, facts.get("turned", []), (2, 3) in facts["beside"]), (True, [], False), "what was let go falls")


def recorded_joints(path):
    """Of each step of a recording, its joints: the first catoms, kinds and fates."""
    with h5py.File(path) as file:
        steps, table = file["VTKHDF/Steps"], file["meld/joints"]
        names = ("first", "kind", "fate")
        counts, begins = steps["JointCount"][:], {name: steps[f"JointOffsets/{name}"][:] for name in names}
        return [tuple(table[name][begins[name][i]:begins[name][i] + count].tolist() for name in names) for i, count in enumerate(counts)]


def is_recorded(bodies):
    """A recording lists joints that are made later, and says when they are taken off, also those of the same catoms."""
    world = at([[0, 0, 0], [1, 0, 0]], "steps = 1", "gravity = [0, 0, 0]") + FIXED + kind(axis="[0, 1, 0]") + kind(kind='"ball"')
    program = ("attach(A, @1, 0) :- id(A, 0), tick(A, T), T = 2.\ndetach(A, @1) :- id(A, 0), tick(A, T), T = 4.\n"
               "attach(A, @0, 1) :- id(A, 1), tick(A, T), T = 6.\n")
    none, one, ended, both = ([], [], []), ([0], [0], [0]), ([0], [0], [1]), ([0, 1], [0, 2], [1, 0])
    for options in ((), ("-n", "2")):
        out = bodies.folder / "out.vtkhdf"
        bodies.run(program, world, 9, "--record", out, *options)
        same(recorded_joints(out), [none] * 3 + [one] * 2 + [ended] * 2 + [both] * 3, "joints of a recording")


def refuses_worlds(bodies):
    """Engines that cannot, and keys that are wrong, with a cure."""
    asks = "attach(A, @1, 0) :- id(A, 0).\n"
    takes = "detach(A, @1) :- id(A, 0).\n"
    for program, world, said in (
            (asks, row(2, 'engine = "hash"'), 'the program asks for `attach`, and the world has the engine "hash"'),
            (takes, row(2, 'engine = "ode"') + joint(between="[0, 1]"),
             'the program asks for `detach`, and the world has the engine "ode"'),
            (asks, row(2, 'engine = "ode"') + kind(), 'the engine "ode" makes no joints later'),
            (asks, row(2) + kind(between="[0, 1]"), "there is no key 'between' in [[motion.joint_kind]]"),
            (asks, row(2) + kind(reach="-1"), "reach"),
            (asks, row(2) + kind(kind='"slider"', anchor="[0, 0, 0]"), "a slider has no anchor"),
            (asks, row(2) + kind(limits="[10, 20]"), "the limits of a joint are not around 0")):
        done = bodies.command(program, world, 2)
        same((done.returncode != 0, said in done.stderr), (True, True), f"{said}\n{done.stderr}")


def main():
    with tempfile.TemporaryDirectory() as folder:
        bodies = Bodies(sys.argv[1], folder)
        for check in (swings_and_flies, changes_neighbours, meets_all_refusals, has_many, turns_with_its_catom, wakes_and_breaks,
                      holds_pieces, is_recorded, refuses_worlds):
            check(bodies)
            print(f"{check.__name__}: fine")


if __name__ == "__main__":
    main()
