"""Random bodies that connect and release at random while they fall, push each other and die, and whose connections may break: the same
facts and digests with any number of threads and through a checkpoint; and whatever happened, what is connected keeps its shape, and
neighbours are those that touch.

Usage: grips_test.py MELDSIM [FIRST_SEED [SEEDS]]
"""

import pathlib
import random
import subprocess
import sys
import tempfile

from motion_test import check_neighbours
from recorded import Recorded
from runner import Outcome, Runner

import numpy

TELLING = ("\ntype beside(node, node).\nbeside(A, B) :- neighbor(A, B).\ntype grips(node, node).\ngrips(A, B) :- connected(A, B).\n"
           "type refused(node, int).\nfailed(A, C) -o refused(A, C).\n"
           "type carries(node, node, float, float, float).\ncarries(A, B, T, S, M) :- load(A, B, T, S, M).\n"
           "type lost(node, node).\nbroke(A, B) -o lost(A, B).\n")


# What the rules ask for ends with a tick; this many later, the views over connections are up to date.
SETTLES = 80


def case(rng, last):
    """A program, which acts until a tick, and a world."""
    ask = rng.choice([5, 9, 17])
    program = "type part(node, min int).\n"
    rules = [
        f"connect(A, B) :- neighbor(A, B), tick(A, T), id(A, I), id(B, J), (I * 7 + J * 3 + T * 5) % {ask} = 0.",
        f"connect(A, B) :- tick(A, T), neighbor(A, B), T % {rng.randint(9, 30)} = 0.",
        f"connect(A, @{rng.randrange(20)}) :- tick(A, T), id(A, I), (I + T) % {ask} = 1.",
        f"release(A, B) :- connected(A, B), neighbor(A, B), tick(A, T), id(A, I), id(B, J), (I * 3 + J * 5 + T * 7) % {ask + 4} = 0.",
        f"release(A, @{rng.randrange(20)}) :- tick(A, T), id(A, I), (I + T) % {ask} = 2.",
        f"release(A, B) :- tick(A, T), T = {rng.randint(20, 60)}, connected(A, B).",
        "force(A, 0, 6, 15) :- tick(A, T), id(A, I), (I + T) % 11 < 3.",
        "roll(A, 3, 0, 0) :- tick(A, T), id(A, I), (I * 5 + T) % 13 < 2.",
    ]
    kept = rules[:1] + rng.sample(rules[1:], rng.randint(3, len(rules) - 1))
    program += "".join(rule.replace("tick(A, T)", f"tick(A, T), T < {last}") + "\n" for rule in kept)
    # Over connections: the least number of a piece.
    program += "part(A, I) :- id(A, I).\npart(B, I) :- part(A, I), neighbor(A, B), connected(B, A).\n"
    x, y, z = rng.randint(2, 4), rng.randint(1, 3), rng.randint(2, 4)
    count = x * y * z
    world = (f'[[body]]\nshape = "move(box({x}, {y}, {z}), 0, 0, {z // 2 + rng.randint(0, 2)})"\n[motion]\nkind = "bodies"\n'
             f"steps = {rng.randint(1, 4)}\nground = -0.5\nlowest = -3\nlost = \"remove\"\nspacing = {rng.choice([1, 1.004, 1.1])}\n"
             f"gravity = [{rng.choice([0, 2])}, 0, {rng.choice([-9.81, -3, 0])}]\nsleep_ticks = {rng.choice([0, 4])}\n"
             f"restitution = {rng.choice([0, 0.4])}\n")
    for _ in range(rng.randint(0, 3)):
        where = rng.choice([f"id % {rng.randint(2, 6)} == 1", f"z >= {rng.randint(1, 3)}", f"id == {rng.randrange(count)}"])
        what = rng.choice(["connected = true", "connected = true", "fixed = true", "mass = 3", "velocity = [1, -1, 0]", "spin = [0, 0, 5]"])
        world += f'[[motion.catoms]]\nwhere = "{where}"\n{what}\n'
    for _ in range(rng.randint(0, 2)):
        what = rng.choice([f"breaking_force = {rng.randint(3, 40)}", f"breaking_torque = {rng.randint(1, 15)}"])
        world += f'[[motion.catoms]]\nwhere = "id % {rng.randint(1, 3)} == 0"\n{what}\n'
    for _ in range(rng.randint(0, 2)):
        world += f'[[event]]\ntick = {rng.randint(1, 49)}\nkill = "id == {rng.randrange(count)}"\n'
    return program, world


class Grips:
    def __init__(self, meldsim, folder):
        self.meldsim = meldsim
        self.folder = pathlib.Path(folder)
        self.connections = self.refused = self.broken = 0

    def check(self, seed):
        rng = random.Random(seed)
        program, world = self.folder / "grips.meld", self.folder / "grips.toml"
        acts = rng.randint(50, 90)
        texts = case(rng, acts)
        for path, text in zip((program, world), texts):
            path.write_text(text)
        runner = Runner(self.meldsim, program, self.folder, TELLING)
        ticks, half = str(acts + SETTLES), str(rng.randint(1, acts))
        recording = self.folder / "out.vtkhdf"

        def run(until, threads, *options):
            text, digests, summary = runner.run(runner.telling, world, 1, threads, ("--ticks", until, *options))
            return text, digests, Outcome(text, summary)

        text, digests, found = run(ticks, 1)
        self.check_pieces(found)
        assert run(ticks, 2)[:2] == (text, digests), "two threads go another way"
        kept = self.folder / f"kept{seed}"
        run(half, 1, "--checkpoint", kept)
        self.resume(kept, ticks)
        assert (self.folder / "out.facts").read_text() == text, f"after a checkpoint of tick {half}, the facts are others"
        assert (self.folder / "out.digest").read_text() == digests, f"after a checkpoint of tick {half}, the digests are others"
        ways = []
        for until in (half, str(int(half) + 1)):
            outcome = run(until, 1, "--record", recording)[2]
            ways += [outcome, Recorded(recording).positions[-1]]
        self.compare(*ways)
        self.broken += len(found.facts["lost"]) // 2
        self.connections += len(ways[2].facts["grips"]) // 2
        self.refused += sum(each["count"] for each in found.summary["refused_actions"] if each["action"] in ("connect", "release"))

    def resume(self, kept, ticks):
        done = subprocess.run([self.meldsim, "resume", kept, "--ticks", ticks, "--threads", "2", "--quiet"], capture_output=True, text=True)
        assert done.returncode == 0, done.stderr

    def compare(self, before, places_before, now, places):
        alive = sorted(a for a, _ in now.facts["part"])
        index = {catom: i for i, catom in enumerate(alive)}
        index_before = {catom: i for i, catom in enumerate(sorted(a for a, _ in before.facts["part"]))}
        assert len(places) == len(alive) and len(places_before) == len(index_before), "the recording has other catoms"
        grips = {tuple(row) for row in now.facts["grips"]}
        assert all((b, a) in grips for a, b in grips), "a connection holds in one direction"
        loads = {(a, b): numbers for a, b, *numbers in now.facts["carries"]}
        assert set(loads) == grips, f"loads of no connections, or none of some: {sorted(set(loads) ^ grips)[:5]}"
        assert all(loads[b, a] == numbers for (a, b), numbers in loads.items()), "two catoms sense different loads of their connection"
        beside = {tuple(row) for row in now.facts["beside"]}
        assert grips <= beside, f"connected catoms are no neighbours: {sorted(grips - beside)[:5]}"
        check_neighbours([(index[a], index[b]) for a, b in beside], places)
        # Who is together in both ticks has not moved against each other.
        kept = grips & {tuple(row) for row in before.facts["grips"]}
        piece = {catom: catom for catom in alive}

        def find(catom):
            while piece[catom] != catom:
                catom = piece[catom]
            return catom

        for a, b in kept:
            piece[find(a)] = find(b)
        for a in alive:
            for b in alive:
                if a < b and find(a) == find(b):
                    change = numpy.linalg.norm(places[index[a]] - places[index[b]])
                    change -= numpy.linalg.norm(places_before[index_before[a]] - places_before[index_before[b]])
                    assert abs(change) < 1e-5, f"@{a} and @{b} are connected and move apart by {change}"

    def check_pieces(self, now):
        """The least number of each piece, as the program's own rules have found it."""
        grips = now.facts["grips"]
        for catom, least in now.facts["part"]:
            todo, seen = [catom], {catom}
            while todo:
                new = {b for a, b in grips if a == todo[-1]} - seen
                todo.pop()
                seen |= new
                todo += new
            assert least == min(seen), f"part(@{catom}, {least}), and its piece is {sorted(seen)}"


def main():
    meldsim, first, seeds = sys.argv[1], int((sys.argv[2:] + ["0"])[0]), int((sys.argv[3:] + ["4"])[0])
    with tempfile.TemporaryDirectory() as folder:
        grips = Grips(meldsim, folder)
        for seed in range(first, first + seeds):
            try:
                grips.check(seed)
            except AssertionError as error:
                sys.exit(f"seed {seed}: {error}\n{(pathlib.Path(folder) / 'grips.meld').read_text()}"
                         f"{(pathlib.Path(folder) / 'grips.toml').read_text()}")
        told = f"{grips.connections} connections, {grips.broken} broke, {grips.refused} refused actions"
        if not grips.connections or not grips.refused:
            sys.exit(f"{told}: the seeds test nothing")
        print(f"{seeds} seeds: {told}")


if __name__ == "__main__":
    main()
