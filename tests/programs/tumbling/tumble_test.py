"""Bodies of all shapes fall, roll and fly through each other in small random worlds. Whatever the number of processes and threads, also
where a run is stopped in the middle and goes on with others, the facts and places after each tick are the same.

Usage: tumble_test.py MELDSIM [FIRST_SEED [SEEDS [TICKS]]]
"""

import pathlib
import random
import shutil
import subprocess
import sys

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1]))

from seeds import Divided  # noqa: E402

PROGRAM = """
type action force(node, float, float, float) while.
type action torque(node, float, float, float) while.
type action roll(node, float, float, float) while.
type source(node).
type dist(node, min int).
type degree(node, count int).
type turned(node, float, float, float, float).
type moves(node, vec3).
type jolt(node, float, float, float).
type pressed(node, float).
type touched(node, node, int).
type lies(node, int).
type linear token(node, int).
type visited(node, int).
dist(A, 0) :- source(A).
dist(B, D + 1) :- dist(A, D), neighbor(A, B).
degree(A, 1) :- neighbor(A, _).
turned(A, W, X, Y, Z) :- orientation(A, W, X, Y, Z).
moves(A, V) :- velocity(A, V).
jolt(A, X, Y, Z) :- acceleration(A, X, Y, Z), id(A, I), I % 3 = 0.
pressed(A, P) :- pressure(A, P).
touched(A, B, F) :- contact(A, B, F).
lies(A, O) :- contact(A, O).
token(A, N), neighbor(A, B), N > 0 -o visited(A, N), token(B, N - 1).
force(A, 0 - X, 0, 2) :- position(A, X, _, _), degree(A, N), N > 1.
torque(A, 1, 0, 2) :- lies(A, _), id(A, I), I % 5 = 0.
roll(A, 3, 3, 0) :- dist(A, D), D % 2 = 1.
latch(A, F, 1) :- contact(A, _, F).
latch(A, F, 0) :- touched(A, _, F), visited(A, 37).
"""

# Processes and threads. Those of two threads are stopped in the middle and go on with other numbers.
SETTINGS = [(1, 1), (2, 1), (3, 1), (4, 1), (1, 2), (2, 2), (3, 2)]


class Tumbling(Divided):
    def outcome(self, folder, processes, threads):
        if threads == 1:
            return super().outcome(folder, processes, threads)
        ticks = int(self.options[self.options.index("--ticks") + 1])
        kept, digests = folder / f"kept{processes}", folder / "digests"
        first = [self.meldsim, "run", folder / f"{self.name}.meld", "--world", folder / f"{self.name}.toml", "--quiet", "-n",
                 str(processes), "--threads", str(threads), "--ticks", str(ticks // 2), "--digest", digests, "--checkpoint", kept]
        second = [self.meldsim, "resume", kept, "--ticks", str(ticks), "-n", str(4 - processes), "--threads", "1", "--quiet"]
        shutil.rmtree(kept, ignore_errors=True)
        for command in (first, second):
            done = subprocess.run(command, capture_output=True, text=True, timeout=600)
            if done.returncode != 0:
                return done.returncode, "", done.stderr
        return 0, digests.read_text(), ""


def shape(rng, world_radius):
    """A shape in the words of a world."""
    kind = rng.choice(["cube", "box", "cylinder", "capsule", "sphere"])
    text = f'shape = "{kind}"\n'
    if kind == "box":
        text += f"edges = [{', '.join(f'{rng.uniform(0.4, 1.1):.2f}' for _ in range(3))}]\n"
    if kind in ("cube", "box", "cylinder") and rng.random() < 0.4:
        text += f"rounding = {rng.choice([0, 0.05, 0.1])}\n"
    if kind == "cylinder":
        text += f"height = {rng.uniform(0.3, 1.1):.2f}\n"
    if kind == "capsule":
        text += f"length = {rng.uniform(0.9, 1.5):.2f}\n"
    if kind != "box":
        text += f"radius = {world_radius * rng.uniform(0.6, 1):.3f}\n"
    return text


def turning_friction(seed):
    """Every third world resists rolling and spinning."""
    return "rolling_friction = 0.03\nspinning_friction = 0.02\n" if seed % 3 == 0 else ""


def obstacles_that_move(seed, beside):
    """The motion of the obstacle before, and another obstacle, which may stand beside the bodies. So slow that what they push can give
    way."""
    if seed % 6 != 1:
        return ""
    rng = random.Random(seed)
    return (f"swing = [0.2, {rng.uniform(-0.2, 0.2):.2f}, 0]\nspin = [0, 0, {rng.choice([-0.5, 0.5])}]\n"
            f"frequency = {rng.choice([0.5, 2])}\n"
            f'[[motion.obstacle]]\nkind = "capsule"\ncentre = [-4, {-4 if beside else 0}, 0.4]\n'
            f"diameter = 0.3\nlength = 3\nturned = [0, 90, 0]\n"
            f"spin = [0, 0, {rng.choice([-1, 1])}]\ntilt = [{rng.randint(1, 5)}, 0, 0]\nfrequency = 1\n")


def what_the_world_moves(seed, about_z=False):
    """In every third world catoms are moved, a belt runs, and gravity changes; in every sixth the belt's box moves and a beam turns. What
    hangs on catoms that turn may be long: it stays above the ground and the belt if they turn about z."""
    if seed % 3 != 1:
        return ""
    rng = random.Random(seed)

    def vector(most):
        return [round(rng.uniform(-most, most), 2) for _ in range(3)]

    def turning(most):
        return [0, 0, round(rng.uniform(-most, most) / 3, 2)] if about_z else vector(most)

    text = (f'[[motion.mover]]\nwhere = "id % 11 == {rng.randint(0, 10)}"\nswing = {vector(0.3)}\ntilt = {turning(30)}\n'
            f"frequency = {rng.choice([0.5, 2, 5])}\nphase = {rng.randint(0, 359)}\n"
            f'[[motion.mover]]\nwhere = "id == {rng.randint(0, 9)}"\nspin = {turning(3)}\npivot = {vector(2)}\n'
            f'[[motion.obstacle]]\nkind = "box"\ncentre = [5, 2, {-0.45 if about_z else 0.2}]\nsize = [4, 4, 1]\nbelt = {vector(2)}\n'
            f"{obstacles_that_move(seed, beside=about_z)}[[event]]\ntick = {rng.randint(5, 15)}\ngravity = {vector(8)}\n")
    return text + (f"[motion.gravity_swing]\nswing = {vector(3)}\ntilt = {vector(20)}\nfrequency = 3\n" if rng.random() < 0.5 else "")


def compound(rng):
    """Two or three solids that are held together, and catoms that are such bodies."""
    text = '[[motion.compound]]\nname = "thing"\n'
    with_shares = rng.random() < 0.5
    for _ in range(rng.randint(2, 3)):
        part = "\n".join(line for line in shape(rng, 0.5).splitlines() if not line.startswith("radius"))
        at, turned = ([round(rng.uniform(-most, most), 2) for _ in range(3)] for most in (0.35, 180))
        text += f"[[motion.compound.part]]\n{part}\nat = {at}\nturned = {turned}\n"
        if 'shape = "box"' not in part:
            text += f"diameter = {rng.uniform(0.3, 0.6):.2f}\n"
        if with_shares:
            text += f"share = {rng.uniform(0.2, 3):.2f}\n"
    return text + f'[[motion.catoms]]\nwhere = "id % {rng.randint(2, 4)} == 0"\nshape = "thing"\n'


def with_heart(world):
    """The compound of a world with a ball that has most of its mass, so that each direction leads through a part."""
    header = "[[motion.compound.part]]\n"
    if "\nshare = " not in world:
        world = world.replace(header, header + "share = 1\n")
    return world.replace(header, header + 'shape = "sphere"\ndiameter = 0.5\nshare = 20\n' + header, 1)


def other_shapes(rng):
    """Of some catoms, for two groups; some are compounds."""
    text = compound(rng) if rng.random() < 0.5 else ""
    for _ in range(2):
        form = shape(rng, 0.5)
        if "sphere" not in form:
            text += f'[[motion.catoms]]\nwhere = "id % {rng.randint(2, 4)} == 1"\n' + form
    return text


def held_and_thrown(rng, thrown):
    """One catom may be fixed, and move all the same; those from `thrown` on may fly."""
    text = ""
    if rng.random() < 0.6:
        text += f'[[motion.catoms]]\nwhere = "id == {rng.randint(0, 9)}"\nfixed = true\n'
        text += rng.choice([f"velocity = [{rng.choice([0.5, -1])}, 0, 0.2]\n", "", ""])
    if rng.random() < 0.5:
        text += f'[[motion.catoms]]\nwhere = "id >= {thrown}"\nvelocity = [{rng.randint(-9, 9)}, {rng.randint(-4, 4)}, -1]\n'
    return text


def range_and_kills(rng, reach, first_tick):
    """The end of a world: neighbours in range, sources, and catoms that are killed."""
    text = f"[links]\nrange = {reach}\n" if rng.random() < 0.25 else ""
    text += '[facts]\nsource = ["id % 9 == 0"]\n'
    for _ in range(rng.randint(0, 2)):
        text += f'[[event]]\ntick = {rng.randint(first_tick, 14)}\nkill = "id % {rng.randint(7, 17)} == {rng.randint(0, 6)}"\n'
    return text


def case(seed):
    rng = random.Random(seed)
    radius = rng.choice([0.5, 0.05])
    size = [rng.randint(1, 6), rng.randint(1, 4), rng.randint(1, 4)]
    size[rng.randrange(2)] += 8
    world = (f'seed = {seed}\nradius = {radius}\n[[body]]\nshape = "move(box({size[0]}, {size[1]}, {size[2]}), 0, 0, {size[2] // 2 + 1})"\n'
             f"[[body]]\npositions = [[-30, 0, 2.5], [-28.2, 0.3, 2.5], [35, 1, 6], [-40, 0, 1.2], [-40.2, 0, 2.8]]\n"
             f'[motion]\nkind = "bodies"\nground = 0\nsteps = {rng.choice([6, 12])}\nspacing = {rng.choice([1.4, 1.7])}\n'
             f"friction = {rng.choice([0.2, 0.5, 0.9])}\nrestitution = {rng.choice([0, 0, 0.3, 0.8])}\n"
             f"sleep_ticks = {rng.choice([0, 4, 30])}\ndeepest_overlap = 0.9\n" + turning_friction(seed))
    world += rng.choice(['solver = "pgs20"\n', "", "", ""]) + rng.choice(['lowest = 0.3\nlost = "remove"\n', "", ""])
    world += shape(rng, radius).split("radius")[0]
    speed = 12 * radius ** 0.5
    for _ in range(rng.randint(2, 5)):
        world += f'[[motion.catoms]]\nwhere = "id % {rng.randint(2, 5)} == {rng.randint(0, 4)}"\n' + shape(rng, radius)
        if rng.random() < 0.7:
            world += f"turned = [{rng.randint(-90, 90)}, {rng.randint(-90, 90)}, {rng.randint(-90, 90)}]\n"
        if rng.random() < 0.7:
            world += f"velocity = [{', '.join(f'{rng.uniform(-speed, speed):.2f}' for _ in range(3))}]\n"
        if rng.random() < 0.3:
            world += f"spin = [{rng.randint(-9, 9)}, {rng.randint(-9, 9)}, {rng.randint(-9, 9)}]\n"
        if rng.random() < 0.5:
            world += f"mass = {rng.uniform(0.2, 4):.2f}\n"
    if rng.random() < 0.4:
        world += f'[[motion.catoms]]\nwhere = "x == 0 && y == 0 && z <= 1"\nfixed = true\nvelocity = [{rng.choice([0, 1])}, 0, 0]\n'
    # Two rest, and one comes fast through the others.
    world += '[[motion.catoms]]\nwhere = "x == -40"\nvelocity = [0, 0, 0]\nspin = [0, 0, 0]\nturned = [0, 0, 0]\n'
    world += f'[[motion.catoms]]\nwhere = "x == 35"\nvelocity = [{-8 * speed:.1f}, 0, -1]\n'
    if rng.random() < 0.6:
        world += f'[[motion.obstacle]]\nkind = "box"\ncentre = [2, 0, 0]\nsize = [7, 4, 0.8]\ndegrees = {rng.randint(0, 90)}\n'
    with_compounds = seed % 2 == 0
    if with_compounds:
        world += compound(rng)
    world += '[facts]\nsource = ["id % 9 == 0"]\ntoken = [{ where = "id % 20 == 0", args = [40] }]\n'
    if rng.random() < 0.5:
        world += f'[[event]]\ntick = {rng.randint(3, 12)}\nkill = "id % 7 == 3"\n'
    if rng.random() < 0.6:
        world += (f'[[motion.feature]]\nkind = "latch"\ndirections = {rng.choice([6, 12])}\nstrength = {rng.choice([5, 50, 500])}\n'
                  f"range = {rng.choice([0.02, 0.1, 0.3]) * 2 * radius:.3f}\n")
        world = with_heart(world) if with_compounds else world
    return PROGRAM, world + what_the_world_moves(seed)


def main(name, make):
    """Compares the programs and worlds that make(seed) gives, on all settings."""
    meldsim, first, seeds, ticks = sys.argv[1], *(int(word) for word in (sys.argv[2:] + ["0", "4", "24"][len(sys.argv) - 2:])[:3])
    divided = Tumbling(meldsim, name, SETTINGS, ["--ticks", str(ticks), "--digest", "-"])
    return divided.compare(((seed, *make(seed)) for seed in range(first, first + seeds)),
                           lambda digests: len(set(digests.splitlines())) > ticks // 2)


if __name__ == "__main__":
    sys.exit(main("tumble", case))
