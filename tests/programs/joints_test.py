"""What joints of a world and their motors do, what ends them or forbids them: joints_test.py MELDSIM."""

import math
import shutil
import subprocess
import sys
import tempfile

from bodies_test import FINE, PLACE, Bodies, close, same
from recorded import Recorded
from runner import Outcome

TELLING = ("type turned(node, node, float Place, float Speed).\nturned(A, B, P, S) :- joint(A, B, P, S).\n"
           "type beside(node, node).\nbeside(A, B) :- neighbor(A, B).\n")
ALL = "joint = 0\njoint_speed = 0\n"
LOADS = ("type carries(node, node, float, float, float).\ncarries(A, B, T, S, M) :- load(A, B, T, S, M).\n"
         "type lost(node, node).\nbroke(A, B) -o lost(A, B).\n")
# One process and several, with one thread and two.
DIVISIONS = (("-n", "1", "--threads", "1"), ("-n", "1", "--threads", "2"), ("-n", "2", "--threads", "2"), ("-n", "3", "--threads", "1"))
FIXED = '[[motion.catoms]]\nwhere = "id == 0"\nfixed = true\n'


def row(count, *lines):
    """A row of catoms along x, and lines of [motion]."""
    return f'[[body]]\npositions = {[[x, 0, 0] for x in range(count)]}\n[motion]\nkind = "bodies"\n' + "\n".join(lines) + "\n"


def joint(**keys):
    return "[[motion.joint]]\n" + "".join(f"{key} = {value}\n" for key, value in keys.items())


def both_ways(pairs):
    return sorted({(a, b) for a, b in pairs} | {(b, a) for a, b in pairs})


def chain(count):
    return both_ways([(i, i + 1) for i in range(count - 1)])


def swings(bodies):
    """A pendulum of five balls, in a loop of time: the same bits on any processes and threads; its hinges do not part, and its catoms are
    neighbours although the physics finds no touch."""
    world = row(6, "steps = 4", FINE + ALL) + FIXED + joint(where='"all"', axis="[0, 1, 0]")
    seen = []
    for division in DIVISIONS:
        facts, summary = bodies.run(PLACE + TELLING, world, 100, *division)
        same(sorted(facts["beside"]), chain(6), "neighbours in a chain of hinges")
        same("; 5 joints" in summary["outcomes"][0], True, summary["outcomes"][0])
        seen.append(sorted(facts["place"]) + sorted(facts["turned"]))
        places = [p for _, *p in sorted(facts["place"])]
        angles = {(a, b): place for a, b, place, _ in facts["turned"]}
        # Each hinge is half a diameter from both centres, so the place follows from the angles.
        x = z = heading = 0.0
        for i in range(5):
            x, z = x + 0.5 * math.cos(heading), z - 0.5 * math.sin(heading)
            heading += angles[i, i + 1]
            x, z = x + 0.5 * math.cos(heading), z - 0.5 * math.sin(heading)
            close(places[i + 1][0], x, 1e-4, f"the place of catom {i + 1}")
            close(places[i + 1][2], z, 1e-4, f"the height of catom {i + 1}")
    for other in seen[1:]:
        same(other, seen[0], "a chain on several processes and threads")


def reaches_far(bodies):
    """A chain of 40 over several processes, with a ball at its end that swings from one's space into another's; two catoms 60 diameters
    apart on a hinge between them; and what is killed on one process ends joints on the other."""
    places = [[x, 0, 0] for x in range(40)] + [[-30, 30, 0], [30, 30, 0]]
    world = (row(1, "steps = 4", FINE + ALL + "load = 0\n").replace("[[0, 0, 0]]", str(places)) + FIXED +
             joint(where='"id < 40"', axis="[0, 1, 0]") +
             joint(between="[40, 41]", anchor="[0, 30, 0]", axis="[0, 0, 1]", torque="900", motor="0.2") +
             '[[event]]\ntick = 30\nkill = "id == 30"\n')
    program = PLACE + TELLING + LOADS + ("type now(node, int).\nnow(A, T) :- tick(A, T), T % 20 = 7.\n"
                                         "motor(A, B, 0 - 0.5) :- now(A, 27), joint(A, B, _, _), id(A, 41).\n")
    seen = []
    for division in DIVISIONS + (("-n", "4"),):
        facts, summary = bodies.run(program, world, 50, *division)
        same(len(facts["turned"]), 2 * 38, "joints that are left")
        same("; 38 joints" in summary["outcomes"][0], True, summary["outcomes"][0])
        seen.append({name: sorted(rows) for name, rows in facts.items()})
    for other in seen[1:]:
        same(other, seen[0], "a long chain on several processes")
    speeds = {(a, b): speed for a, b, _, speed in seen[0]["turned"]}
    close(speeds[40, 41], -0.5, 1e-3, "a motor between two processes")


def acts_on_both(bodies):
    """A motor turns two bodies of 1 and 3 kg against each other: angular momentum stays 0."""
    world = row(2, "gravity = [0, 0, 0]", "steps = 4", FINE + ALL) + '[[motion.catoms]]\nwhere = "id == 1"\nmass = 3\n' + joint(
        between="[0, 1]", axis="[1, 0, 0]", torque="0.3", motor="100")
    facts, _ = bodies.run(TELLING, world, 15)
    # I = 0.1 and 0.3 kg m^2, a quarter of a second.
    close(facts["turned"][0][3], 0.25 * (0.3 / 0.1 + 0.3 / 0.3), 1e-3, "the speed of a motor")


def later_tables_go(bodies):
    """Of two tables about the same catoms the later one goes; a slider in diameters, limits and springs of catoms of 0.2 m."""
    world = "radius = 0.1\n" + row(3, "steps = 16", FINE + ALL).replace("[2, 0, 0]", "[0, 5, 0], [1, 5, 0]") + FIXED.replace(
        '"id == 0"', '"id == 0 || id == 2"') + joint(where='"all"', axis="[0, 1, 0]") + joint(
            between="[1, 0]", kind='"slider"', axis="[0, 0, 1]", limits="[-2, 2.5]") + joint(
                between="[2, 3]", kind='"slider"', axis="[0, 0, 1]", stiffness="9.81", damping="5", rest="1")
    facts, _ = bodies.run(PLACE + TELLING, world, 600)
    places = {a: p for a, *p in facts["place"]}
    angles = {(a, b): place for a, b, place, _ in facts["turned"]}
    # The first catom as the second one sees it: the second has fallen by 2.5 diameters.
    close(places[1][2], -2.5, 1e-3, "a slider at its limit")
    close(angles[0, 1], 2.5, 1e-3, "the place of a slider")
    # 1 kg at g stretches the spring by a metre, five diameters, from where it is loose.
    close(places[3][2], 1 - 5, 0.02, "a catom on a spring")


def dies(bodies):
    """A catom that is killed takes its joints with it; the rest of the chain falls."""
    world = row(4, "steps = 4", FINE + ALL) + FIXED + joint(where='"all"', axis="[0, 1, 0]") + '[[event]]\ntick = 5\nkill = "id == 2"\n'
    facts, summary = bodies.run(TELLING, world, 12)
    same(sorted((a, b) for a, b, *_ in facts["turned"]), [(0, 1), (1, 0)], "joints after a death")
    same(sorted(facts["beside"]), [(0, 1), (1, 0)], "neighbours after a death")
    same("; 1 joint" in summary["outcomes"][0], True, summary["outcomes"][0])


def carries(bodies):
    """Both catoms sense what hangs on each joint, and forget it with a catom that dies."""
    world = row(5, "steps = 4", "gravity = [9.81, 0, 0]", FINE + "load = 0\n") + FIXED + joint(where='"all"', axis="[0, 1, 0]")
    facts, _ = bodies.run(LOADS, world, 20)
    same(sorted((a, b) for a, b, *_ in facts["carries"]), chain(5), "loads of a chain")
    for a, b, tension, shear, torque in facts["carries"]:
        close(tension, (4 - min(a, b)) * 9.81, 1e-3, f"the tension of {a} and {b}")
        close(math.hypot(shear, torque), 0, 1e-3, f"the shear and torque of {a} and {b}")
    facts, _ = bodies.run(LOADS, world + '[[event]]\ntick = 5\nkill = "id == 2"\n', 12)
    same(sorted((a, b) for a, b, *_ in facts["carries"]), both_ways([(0, 1), (3, 4)]), "loads after a death")
    same(facts.get("lost", []), [], "a joint that ends with a catom did not break")


def resumed_alike(bodies, program, world, ticks, stops, expected):
    """A run that goes on from a checkpoint of each of these ticks, on one process instead of two or the other way round, has these facts.
    """
    kept, out = bodies.folder / "kept", bodies.folder / "forked.facts"
    for stop in stops:
        bodies.run(program, world, stop, "--checkpoint", kept, "-n", str(stop % 2 + 1))
        command = [bodies.meldsim, "fork", kept, "--ticks", str(ticks), "--facts-out", out, "--quiet", "-n", str(2 - stop % 2)]
        done = subprocess.run(command, env=bodies.environment, capture_output=True, text=True, check=False)
        same(done.returncode, 0, done.stderr)
        facts = Outcome(out.read_text(), {}).facts
        same({name: sorted(rows) for name, rows in facts.items()}, expected, f"a run from tick {stop}")
        shutil.rmtree(kept)


def breaks(bodies):
    """A chain that is pulled too much breaks at its top, and the rest falls as one piece. The same on any processes and threads, from a
    checkpoint before, in and after the tick, and with steps of a tick each; neighbours are those that touch."""
    for steps, ticks in (("1", 240), ("4", 60)):
        world = row(5, f"steps = {steps}", FINE + ALL + "load = 0\n") + FIXED + joint(
            where='"all"', axis="[0, 1, 0]", breaking_force="38")
        world = world.replace(str([[x, 0, 0] for x in range(5)]), str([[0, 0, -x] for x in range(5)]))
        seen = []
        for division in DIVISIONS:
            facts, summary = bodies.run(PLACE + TELLING + LOADS, world, ticks, *division)
            same(sorted(facts["lost"]), [(0, 1), (1, 0)], "the joint that broke")
            same(sorted((a, b) for a, b, *_ in facts["turned"]), both_ways([(1, 2), (2, 3), (3, 4)]), "the joints that are left")
            same("; 3 joints; 1 joint broke" in summary["outcomes"][0], True, summary["outcomes"][0])
            places = {a: p for a, *p in facts["place"]}
            close(math.dist(places[1], places[4]), 3, 1e-3, "the length of what fell")
            same(places[1][2] < -1.5, True, "it falls")
            seen.append({name: sorted(rows) for name, rows in facts.items()})
        for other in seen[1:]:
            same(other, seen[0], "a break on several processes and threads")
        same((0, 1) in seen[0]["beside"], False, "no neighbours after the break")
        resumed_alike(bodies, PLACE + TELLING + LOADS, world, ticks, (1, 2, 3, ticks // 2), seen[0])


def stays_beside(bodies):
    """What still touches when its joint breaks stays a neighbour, in each tick; a motor that is gone is refused."""
    world = row(2, "steps = 1", FINE).replace("[[0, 0, 0], [1, 0, 0]]", "[[0, 0, 0], [0, 0, 1]]") + FIXED + joint(
        between="[0, 1]", axis="[0, 1, 0]", torque="5", breaking_force="5")
    program = TELLING + LOADS + "type alone(node, int).\nalone(A, T) :- tick(A, T), not neighbor(A, _).\ntype was(node, int).\n" \
        "type linear last(node, int).\nlast(A, 0).\nlast(A, L), alone(A, T), T > L -o last(A, T), was(A, T).\n" \
        "motor(A, B, 1) :- lost(A, B), id(A, 0).\n"
    facts, summary = bodies.run(program, world, 30)
    same((sorted(facts["lost"]), facts.get("was", [])), ([(0, 1), (1, 0)], []), "neighbours after a break")
    same(sorted(facts["beside"]), [(0, 1), (1, 0)], "they touch")
    same(summary["refused_actions"], [{"action": "motor", "reason": "not_joined", "count": 1}], "a motor that is gone")
    facts, _ = bodies.run(program, world.replace("steps = 1\n", "steps = 1\ngravity = [0, 0, 9.81]\n"), 30)
    same((len(facts["was"]) > 5, facts.get("beside", [])), (True, []), "what falls away is no neighbour")


def goes_on(bodies):
    """A run that goes on from a checkpoint arrives where the other does, also after motors have been set; a fork reads its joints."""
    world = row(6, "steps = 4", "ground = -3", FINE + ALL) + FIXED + joint(where='"all"', axis="[0, 1, 0]", torque="40", speed="4")
    program = (PLACE + TELLING + "type now(node, int).\nnow(A, T) :- tick(A, T), T % 20 = 0.\n"
               "servo(A, B, 0.3) :- now(A, 20), joint(A, B, _, _).\nmotor(A, B, 1) :- now(A, 60), joint(A, B, _, _), id(A, 2).\n")
    kept, out = bodies.folder / "kept", bodies.folder / "forked.facts"
    whole, _ = bodies.run(program, world, 90)
    for stop in (15, 45, 75):
        bodies.run(program, world, stop, "--checkpoint", kept)
        done = subprocess.run([bodies.meldsim, "fork", kept, "--ticks", "90", "--facts-out", out, "--quiet"], env=bodies.environment,
                              capture_output=True, text=True, check=False)
        same(done.returncode, 0, done.stderr)
        facts = Outcome(out.read_text(), {}).facts
        for what in ("place", "turned"):
            same(sorted(facts[what]), sorted(whole[what]), f"a run from tick {stop}")
        shutil.rmtree(kept)
    bodies.run(PLACE, world, 30, "--checkpoint", kept)
    (bodies.folder / "q.meld").write_text(TELLING)
    command = [bodies.meldsim, "fork", kept, "--program", bodies.folder / "q.meld", "--facts-out", out, "--quiet", "--ticks", "32"]
    done = subprocess.run(command, env=bodies.environment, capture_output=True, text=True, check=False)
    same((done.returncode, len(Outcome(out.read_text(), {}).facts["turned"])), (0, 10), done.stderr)


def by_ode(bodies):
    """The engine ode moves boxes, a capsule, hinges and a slider nearly as the other does, and goes on from a checkpoint."""
    def world(engine):
        lines = (f'engine = "{engine}"', "step = 0.001", "substeps = 1", "steps = 10", "ground = -2",
                 'shape = "box"', "edges = [1, 0.4, 0.6]")
        return row(4, *lines, FINE + ALL) + FIXED + '[[motion.catoms]]\nwhere = "id == 3"\nshape = "capsule"\nlength = 1.5\n' + joint(
            where='"all"', axis="[0, 1, 0]", torque="15", servo="20") + joint(
                between="[2, 3]", kind='"slider"', axis="[1, 0, 0]", limits="[-0.2, 1]", breaking_force="20000")
    found = {}
    for engine in ("blocks", "ode"):
        facts, summary = bodies.run(PLACE + TELLING, world(engine), 40)
        same("; 3 joints" in summary["outcomes"][0], True, summary["outcomes"][0])
        found[engine] = ({a: p for a, *p in facts["place"]}, {(a, b): p for a, b, p, _ in facts["turned"]}, facts)
    for a, place in found["ode"][0].items():
        close(math.dist(place, found["blocks"][0][a]), 0, 0.05, f"the place of catom {a} by ode")
    for pair, place in found["ode"][1].items():
        close(place, found["blocks"][1][pair], 0.05, f"the joint {pair} by ode")
    same(found["ode"][1][0, 1] > 0.2, True, "the arm has fallen")
    kept, out = bodies.folder / "kept-by-ode", bodies.folder / "forked.facts"
    for stop in (1, 25):
        bodies.run(PLACE + TELLING, world("ode"), stop, "--checkpoint", kept)
        done = subprocess.run([bodies.meldsim, "fork", kept, "--ticks", "40", "--facts-out", out, "--quiet"], env=bodies.environment,
                              capture_output=True, text=True, check=False)
        same(done.returncode, 0, done.stderr)
        facts = Outcome(out.read_text(), {}).facts
        for what in ("place", "turned"):
            same(sorted(facts[what]), sorted(found["ode"][2][what]), f"a run by ode from tick {stop}")
        shutil.rmtree(kept)


def moves_pieces(bodies):
    """An arm of two pieces on motors lifts a ball below its tip, and lets it go: the same on any processes and threads. What is
    connected, too, locks its joint; and those that only a joint makes neighbours do not connect."""
    places = [[x, 0, 0] for x in range(9)] + [[8, 0, -1], [0, 5, 0], [3, 5, 0]]
    world = (row(1, "steps = 4", FINE + ALL + "load = 0\n").replace("[[0, 0, 0]]", str(places)) + FIXED +
             '[[motion.catoms]]\nwhere = "id == 10"\nfixed = true\n' +
             '[[motion.catoms]]\nwhere = "id >= 1 && id <= 4"\nconnected = true\n' +
             '[[motion.catoms]]\nwhere = "id >= 5 && id <= 9"\nconnected = true\n' +
             joint(between="[0, 1]", axis="[0, -1, 0]", torque="9000", speed="1") +
             joint(between="[4, 5]", axis="[0, -1, 0]", torque="4000", speed="1", brake="true") +
             joint(between="[10, 11]", axis="[0, 1, 0]", anchor="[0, 5, 0]"))
    program = (PLACE + TELLING + LOADS + "type linear failed(node, int).\ntype refused(node, int).\ntype now(node, int).\n"
               "failed(A, C) -o refused(A, C).\nnow(A, T) :- tick(A, T), T % 10 = 1.\n"
               "servo(A, B, 0.5) :- id(A, 0), neighbor(A, B).\n"
               "connect(A, B) :- id(A, 4), now(A, 11), neighbor(A, B), id(B, 5).\n"
               "connect(A, B) :- id(A, 10), now(A, 11), neighbor(A, B).\n"
               "release(A, B) :- id(A, 8), now(A, 61), neighbor(A, B), id(B, 9).\n")
    seen = []
    for division in DIVISIONS + (("-n", "4"),):
        facts, summary = bodies.run(program, world, 90, *division)
        place = {a: p for a, *p in facts["place"]}
        angles = {(a, b): p for a, b, p, _ in facts["turned"]}
        close(angles[0, 1], 0.5, 0.01, "the angle of the shoulder")
        close(angles[4, 5], 0, 1e-3, "the angle of the elbow, which is locked")
        close(place[8][2], 7.5 * math.sin(0.5), 0.1, "the height of the tip")
        same(place[9][2] < place[8][2] - 1.8, True, "the ball that was let go has fallen")
        same(facts.get("refused", []), [(10, 22)], "a connection of two that do not touch")
        same("; 3 joints" in summary["outcomes"][0], True, summary["outcomes"][0])
        root = {(a, b): (t, s, m) for a, b, t, s, m in facts["carries"]}[0, 1]
        close(math.hypot(root[0], root[1]), 8 * 9.81, 1, "the weight at the shoulder")
        close(root[2], 8 * 9.81 * 4 * math.cos(0.5), 8, "the torque at the shoulder")
        seen.append({name: sorted(rows) for name, rows in facts.items()})
    for other in seen[1:]:
        same(other, seen[0], "an arm of two pieces on several processes")


def refuses(bodies):
    """Catoms that are not there: at once, with the place and a cure. And motors that are not there."""
    world = row(3, "gravity = [0, 0, 0]")
    for program, text, options, said in (
            (TELLING, world + joint(between="[0, 1]", kind='"slider"', anchor="[0, 0, 0]"), (),
             "w.toml:9:10: a slider has no anchor. it has axis, limits"),
            (TELLING, world + joint(between="[0, 1]", breaking_force="0"), (), "w.toml:8:"),
            (TELLING, row(3, 'engine = "ode"') + joint(between="[0, 1]", limits="[-30, inf]"), (),
             "w.toml:6:1: the joint of catoms @0 and @1 has a limit, but not two within half a turn, "
             "which the engine \"ode\" does not hold. Use the engine \"blocks\", or give it both"),
            (TELLING, world + joint(between="[0, 3]"), (), "w.toml:6:1: there is no catom @3. Name two catoms of the world"),
            (TELLING, world + joint(between="[0, 3]"), ("-n", "2"), "w.toml:6:1: there is no catom @3. Name two catoms of the world"),
            (TELLING, world + '[[motion.catoms]]\nfixed = true\n' + joint(between="[0, 1]"), (),
             "w.toml:8:1: catoms @0 and @1 cannot be joined (both are fixed)")):
        done = bodies.command(program, text, 2, *options)
        same((done.returncode != 0, said in done.stderr), (True, True), f"{said}\n{done.stderr}")
        same("[motion] " in done.stderr, False, f"an error with one place\n{done.stderr}")
    done = bodies.command(TELLING, world + joint(where='"id != 1"'), 1)
    warning = "w.toml:6:1: no two catoms of `id != 1`, one of which can move, touch at the start, so this [[motion.joint]] joins none"
    same(warning in done.stderr, True, done.stderr)
    program = TELLING + "motor(A, B, 1) :- neighbor(A, B).\nbrake(A, A) :- id(A, 0).\n"
    for processes in ("1", "2"):
        _, summary = bodies.run(program, world + joint(between="[0, 1]"), 4, "-n", processes)
        same(summary["refused_actions"], [{"action": "motor", "reason": "not_joined", "count": 4},
                                          {"action": "brake", "reason": "not_joined", "count": 1}], "refusals")


def is_recorded(bodies):
    """The anchor of a hinge stays with both bodies in a recording too."""
    world = row(2, "steps = 4") + FIXED + joint(between="[0, 1]", axis="[0, 1, 0]")
    bodies.run(TELLING, world, 90, "--record", bodies.folder / "out.vtkhdf")
    for step in Recorded(bodies.folder / "out.vtkhdf").positions:
        close(math.dist((0.5, 0, 0), step[1]), 0.5, 1e-5, "the distance of an arm from its hinge")


def main():
    with tempfile.TemporaryDirectory() as folder:
        bodies = Bodies(sys.argv[1], folder)
        for check in (swings, reaches_far, acts_on_both, later_tables_go, dies, carries, breaks, stays_beside, goes_on, by_ode,
                      moves_pieces, refuses, is_recorded):
            check(bodies)
            print(f"{check.__name__}: fine")


if __name__ == "__main__":
    main()
