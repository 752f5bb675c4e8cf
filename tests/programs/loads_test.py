"""What programs sense of the loads of connections, and how connections break, against statics: loads_test.py MELDSIM."""

import subprocess
import sys
import tempfile

from bodies_test import FINE, Bodies, close, same
from connections_test import TELLING, both_ways, chain, row
from runner import Outcome

G = 9.81
FIXED = '[[motion.catoms]]\nwhere = "id == 0"\nfixed = true\n'
CONNECTED = "[[motion.catoms]]\nconnected = true\n"
LOADS = ("type carries(node, node, float, float, float).\ncarries(A, B, T, S, M) :- load(A, B, T, S, M).\n"
         "type lost(node, node).\nbroke(A, B) -o lost(A, B).\n")
ALL_OF_IT = FINE + "load = 0\n"


def senses(bodies):
    """A cantilever: both ends of each connection sense the weight beyond it, and its torque; with 1 and 2 threads."""
    for threads in ("1", "2"):
        facts, _ = bodies.run(LOADS, row(20, "steps = 4", "mass = 2", ALL_OF_IT) + FIXED + CONNECTED, 3, "--threads", threads)
        carried = {(a, b): numbers for a, b, *numbers in facts["carries"]}
        same(sorted(carried), chain(20), "the connections of which loads are sensed")
        for (a, b), (tension, shear, torque) in carried.items():
            beyond = 20 - max(a, b)
            close(tension, 0, 1e-6, "the tension of a cantilever")
            close(shear, beyond * 2 * G, 1e-5 * beyond, "the shear of a cantilever")
            close(torque, beyond * 2 * G * beyond / 2, 1e-4 * beyond, "the torque of a cantilever")


def changes_enough(bodies):
    """A program sees a load once it has changed by more than the threshold; here a force grows by 1 % a tick."""
    pull = ("type action force(node, float, float, float) while.\ntype newton(node, float).\n"
            "newton(A, 100.0 + float(T)) :- id(A, 2), tick(A, T).\nforce(A, F, 0, 0) :- newton(A, F).\n")
    world = row(3, "gravity = [0, 0, 0]", "[motion.sense]\nload = {}") + FIXED + CONNECTED
    last = {}
    for share in ("0", "0.1"):
        facts, _ = bodies.run(LOADS + pull, world.replace("{}", share), 9)
        last[share] = {(a, b): t for a, b, t, _, _ in facts["carries"]}[0, 1]
    close(last["0"], 107, 1.1, "a load with a threshold of 0")
    close(last["0.1"], 101, 1.1, "a load with a threshold of a tenth")


def breaks(bodies):
    """A cantilever breaks at its root, and nowhere else; the weaker end decides; without a limit it holds."""
    root, beside = 10 * G * 5, 9 * G * 4.5
    limit = (root + beside) / 2
    groups = f'[[motion.catoms]]\nwhere = "id == 0"\nbreaking_torque = {limit}\n'
    for limits, lines, broken in ((CONNECTED, (), []), (CONNECTED, (f"breaking_torque = {limit}",), [(0, 1)]),
                                  (CONNECTED + groups, (), [(0, 1)]),
                                  (CONNECTED, (f"breaking_torque = {1.001 * root}",), []),
                                  (CONNECTED, (f"breaking_force = {9.5 * G}",), [(0, 1)]),
                                  (CONNECTED, (f"breaking_force = {10.01 * G}",), [])):
        world = row(11, "steps = 4", *lines) + FIXED + limits
        facts, summary = bodies.run(TELLING + LOADS, world, 2)
        held = [pair for pair in chain(11) if tuple(sorted(pair)) not in broken]
        same((sorted(facts["joined"]), sorted(facts["lost"])), (held, both_ways(broken)), f"what holds with {lines} and {limits}")
        told = f"; {len(held) // 2} connections" + ("; 1 connection broke" if broken else "")
        same(told in summary["outcomes"][0] and summary["outcomes"][0].count("broke"), len(broken), summary["outcomes"][0])


def breaks_apart(bodies):
    """A row that hangs by too little loses its root, and falls; one that is torn everywhere loses 16 in a tick."""
    world = row(41, "gravity = [9.81, 0, 0]", "breaking_force = 0.5") + FIXED + CONNECTED
    counts = []
    for ticks in (1, 2, 3, 4):
        facts, _ = bodies.run(TELLING + LOADS, world, ticks)
        counts.append(len(facts["joined"]) // 2)
    # The root breaks first, and what falls freely carries nothing.
    same(counts, [39, 39, 39, 39], "connections of a row that was cut off")
    # Each is pulled away from the middle, by 10 N more than the one before.
    pulled = "type action force(node, float, float, float) while.\nforce(A, 10.0 * float(I) - 195.0, 0, 0) :- id(A, I).\n"
    counts = []
    for ticks in (2, 3, 4):
        facts, _ = bodies.run(TELLING + LOADS + pulled, row(40, "gravity = [0, 0, 0]", "breaking_force = 4") + CONNECTED, ticks)
        counts.append(len(facts["joined"]) // 2)
    same(counts, [23, 0, 0], "connections of a row that is pulled apart at most sixteen at a time")


def goes_on(bodies):
    """A run that goes on from a checkpoint, before and after something breaks, has the facts of one that was not interrupted."""
    slowly = ("type action force(node, float, float, float) while.\ntype newton(node, float).\n"
              "newton(A, 0.0 - float(T)) :- id(A, 9), tick(A, T).\nforce(A, 0, 0, F) :- newton(A, F).\n")
    world = row(10, "steps = 2", "breaking_torque = 600", "ground = -3") + FIXED + CONNECTED
    program = TELLING + LOADS + slowly
    whole, summary = bodies.run(program, world, 40)
    same(len(whole["lost"]) >= 2, True, "nothing breaks")
    for first in (4, 17, 30):
        kept = bodies.folder / f"kept{first}"
        bodies.run(program, world, first, "--checkpoint", kept)
        # It goes on with the options of the run.
        out = bodies.folder / "out.facts"
        out.unlink()
        done = subprocess.run([bodies.meldsim, "resume", kept, "--ticks", "40", "--threads", "2", "--quiet"],
                              env=bodies.environment, capture_output=True, text=True, check=False)
        same(done.returncode, 0, done.stderr)
        again = Outcome(out.read_text(), {}).facts
        for name in ("joined", "carries", "lost"):
            same(sorted(again[name]), sorted(whole[name]), f"{name} of a run that went on from tick {first}")
        same("broke" in summary["outcomes"][0], True, summary["outcomes"][0])


def refuses(bodies):
    """Limits that are no positive numbers: with the place and the key."""
    for key in ("breaking_force", "breaking_torque"):
        for value in ("0", "-3", "nan", "inf", '"strong"'):
            line = f"{key} = {value}"
            for world, place in ((row(2, line), "w.toml:5"), (row(2) + f"[[motion.catoms]]\n{line}\n", "w.toml:7")):
                done = bodies.command(TELLING, world, 1)
                told = (done.returncode != 0, place in done.stderr, key in done.stderr)
                same(told, (True, True, True), f"{line}: {done.stderr}")


def main():
    with tempfile.TemporaryDirectory() as folder:
        bodies = Bodies(sys.argv[1], folder)
        for check in (senses, changes_enough, breaks, breaks_apart, goes_on, refuses):
            check(bodies)
            print(f"{check.__name__}: fine")


if __name__ == "__main__":
    main()
