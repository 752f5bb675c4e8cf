"""What tests of instruments share: facts as numbers, vectors, and runs on several numbers of processes and threads."""
import math
import pathlib
import re
import sys

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[2]))

from frame import Case  # noqa: E402

SIZES = [(1, 1), (1, 2), (2, 1), (3, 2), (4, 1)]


def facts_of(text):
    """{predicate: [arguments]}, with numbers as floats; of vectors the parts."""
    found = {}
    for name, rest in re.findall(r"^([\w-]+)\((.*)\)\.$", text, re.M):
        words = rest.replace("vec3(", "").replace(")", "").split(",")
        found.setdefault(name, []).append(tuple(float(word.strip().lstrip("@")) for word in words))
    return found


def dot(a, b):
    return sum(x * y for x, y in zip(a, b))


def minus(a, b):
    return [x - y for x, y in zip(a, b)]


def cross(a, b):
    return [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]


def rotated(q, v):
    w, axis = q[0], q[1:]
    t = [2 * x for x in cross(axis, v)]
    return [x + w * y + z for x, y, z in zip(v, t, cross(axis, t))]


def to_ball(start, way, centre, radius):
    """How far along a unit vector a ball is; nothing if it is not ahead."""
    to = minus(centre, start)
    if dot(to, to) <= radius * radius:
        return 0
    along = dot(to, way)
    beside = dot(to, to) - along * along
    return along - math.sqrt(radius * radius - beside) if along > 0 and beside <= radius * radius else None


class InstrumentCase(Case):
    def run_sizes(self, program, toml, ticks, sizes=SIZES, *options):
        """The facts, which are the same on all numbers of processes and threads, as is every digest."""
        self.write("p.meld", program)
        self.write("w.toml", toml)
        first = None
        for n, threads in sizes:
            self.call("meldsim", "run", "p.meld", "--world", "w.toml", "-n", n, "--threads", threads, "--ticks", ticks, "--facts-out", "f",
                      "--digest", "d", "--quiet", *options)
            seen = (self.read("f"), self.read("d"))
            first = first or seen
            self.assertEqual(seen[1], first[1], f"{n} processes of {threads} threads: digests")
            self.assertEqual(seen[0], first[0], f"{n} processes of {threads} threads: facts")
        return facts_of(first[0].decode())

    def expect_close(self, found, wanted, places=5):
        for one, other in zip(found, wanted, strict=True):
            self.assertAlmostEqual(one, other, places)
