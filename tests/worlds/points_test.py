"""Points and bodies with a range: neighbours are exactly those within it, while they move too, on any number of processes.

    points_test.py --meldc PATH --meldsim PATH [unittest options]
"""
import itertools
import json
import math
import pathlib
import random
import re
import sys

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1]))

from frame import CAMPAIGN, Case, main  # noqa: E402

TELL = """type where(node, float, float, float).
type near(node, node).
type far(node, node, float).
type to(node, node, float, float, float).
type towards(node, node, vec3).
where(A, X, Y, Z) :- position(A, X, Y, Z).
near(A, B) :- neighbor(A, B).
far(A, B, D) :- distance(A, B, D).
to(A, B, X, Y, Z) :- bearing(A, B, X, Y, Z).
towards(A, B, V) :- bearing(A, B, V).
"""
# Each moves in every tick, by a way that follows from its number and the tick alone, and back and forth, so that links come and go.
DRIFT = TELL + """
moveBy(A, X, Y, 0) :- tick(A, T), id(A, I), T < 60,
    X = float((I * 7 + T * 3) % 11 - 5) / 8, Y = float((I * 5 + T * 2) % 13 - 6) / 8.
"""
STILL = TELL + "type rest(node).\nmoveBy(A, 1.0, 0, 0) :- rest(A).\n"
ROUTES = TELL + """type source(node).
type dist(node, min int D).
type linear rumour(node, int).
type heard(node, max int).
dist(A, 0) :- source(A).
dist(B, D + 1) :- neighbor(A, B), dist(A, D).
rumour(@0, 3).
rumour(A, N), N > 0 -o {B | neighbor(A, B) | rumour(B, N - 1)}.
rumour(A, N) -o heard(A, N).
moveBy(A, X, Y, 0) :- tick(A, T), id(A, I), T < 40,
    X = float((I * 7 + T * 3) % 11 - 5) / 8, Y = float((I * 5 + T * 2) % 13 - 6) / 8.
"""
# Bodies fly apart and come back, past each other.
FLY = TELL + """
type action force(node, float, float, float) while.
type way(node, float, float).
way(A, X, Y) :- tick(A, T), position(A, PX, PY, _), S = if T % 50 < 25 then 6.0 else -6.0 end, X = S * PX + PY * 3.0, Y = S * PY - PX * 3.0.
force(A, X, Y, 0) :- way(A, X, Y).
type met(node, node, int).
met(A, B, F) :- contact(A, B, F).
"""
MOTION = '[motion]\nkind = "points"\n'
SIZES = [(1, 1), (1, 2), (2, 1), (3, 2), (4, 1)]


def world(points, reach=3.0, more="", seed=1):
    return f'lattice = "graph"\n{points}\nseed = {seed}\n{more}\n[links]\nrange = {reach}\n'


def square(a, b):
    x, y, z = (q - p for p, q in zip(a, b))
    return x * x + y * y + z * z


def within(places, reach):
    """The plain way: all pairs."""
    return {(a, b) for a, b in itertools.permutations(places, 2) if square(places[a], places[b]) <= reach * reach}


def blocked_by_ball(a, b, centre, radius):
    way = [q - p for p, q in zip(a, b)]
    to = [c - p for p, c in zip(a, centre)]
    long = sum(w * w for w in way)
    share = min(1, max(0, sum(w * t for w, t in zip(way, to)) / long)) if long else 0
    return sum((share * w - t) ** 2 for w, t in zip(way, to)) <= radius * radius


def blocked_by_box(a, b, low, high):
    enter, leave = 0, 1
    for p, q, least, most in zip(a, b, low, high):
        if p == q:
            if not least <= p <= most:
                return False
            continue
        ends = sorted(((least - p) / (q - p), (most - p) / (q - p)))
        enter, leave = max(enter, ends[0]), min(leave, ends[1])
    return enter <= leave


def seen(places, reach, thickness, boxes=()):
    """The plain way: all pairs in range, and everything that may be between them."""
    def free(a, b):
        return not (any(blocked_by_box(places[a], places[b], *each) for each in boxes) or thickness > 0 and any(
            blocked_by_ball(places[a], places[b], at, thickness / 2) for c, at in places.items() if c not in (a, b)))
    return {(a, b) for a, b in within(places, reach) if free(min(a, b), max(a, b))}


def facts_of(text):
    """{predicate: [arguments]}, with numbers as floats; of vectors the parts."""
    found = {}
    for name, rest in re.findall(r"^([\w-]+)\((.*)\)\.$", text, re.M):
        words = rest.replace("vec3(", "").replace(")", "").split(",")
        found.setdefault(name, []).append(tuple(float(word.strip().lstrip("@")) for word in words))
    return found


class InRange(Case):
    def run_sizes(self, program, toml, *options, sizes=SIZES):
        """The facts, and the summary, which are the same on all numbers of processes and threads, as is every digest."""
        self.write("p.meld", program)
        self.write("w.toml", toml)
        first = None
        for n, threads in sizes:
            out, _ = self.call("meldsim", "run", "p.meld", "--world", "w.toml", "-n", n, "--threads", threads, "--facts-out", "f",
                               "--digest", "d", "--json", *options)
            seen = (self.read("f"), self.read("d"))
            first = first or seen
            self.assertEqual(seen[1], first[1], f"{n} processes of {threads} threads: digests")
            self.assertEqual(seen[0], first[0], f"{n} processes of {threads} threads: facts")
        return facts_of(first[0].decode()), json.loads(out)

    def places(self, facts):
        return {int(a): tuple(place) for a, *place in facts["where"]}

    def expect_in_range(self, facts, reach, without=(), wanted=None):
        """Neighbours are those in range, but for these, or these; and what is sensed of them is what geometry says."""
        places = self.places(facts)
        pairs = {(int(a), int(b)) for a, b in facts.get("near", [])}
        self.assertEqual(pairs, (within(places, reach) if wanted is None else wanted) - set(without))
        self.assertEqual({(int(a), int(b), d) for a, b, d in facts.get("far", [])},
                         {(a, b, math.sqrt(square(places[a], places[b]))) for a, b in pairs})
        for name in ("to", "towards"):
            self.assertEqual({(int(a), int(b)) for a, b, *_ in facts.get(name, [])}, pairs)
            for a, b, *way in facts.get(name, []):
                length = math.sqrt(square(places[a], places[b]))
                for got, p, q in zip(way, places[a], places[b]):
                    self.assertAlmostEqual(got, (q - p) / length if length else 0, 12)
        return pairs


class Points(InRange):
    def test_neighbours_are_those_in_range(self):
        for points, reach, least in (('graph = "scatter(150, 20, 14)"', 3.0, 300), ('graph = "scatter(120, 9, 9, 9)"', 2.5, 200),
                                     ('graph = "disc(100, 10)"', 0.01, 0), ('graph = "ball(90, 5)"', 40, 90 * 89 / 2),
                                     ('graph = "disc(1, 5)"', 3.0, 0), ('graph = "scatter(60, 0, 0)"', 1e-6, 60 * 59 / 2),
                                     ('graph = "scatter(80, 1e6, 0)"', 5e4, 100)):
            with self.subTest(points=points):
                facts, _ = self.run_sizes(TELL, world(points, reach))
                self.assertGreaterEqual(len(self.expect_in_range(facts, reach)) / 2, least)

    def test_points_come_from_files(self):
        drawn = random.Random(5)
        rows = [[round(drawn.uniform(-9, 9), 3) for _ in range(3)] for _ in range(70)]
        for name, columns, lines in (("x,y", 2, range(70)), ("x;y;z", 3, range(70)), ("node,x,y,z", 3, range(3, 493, 7))):
            separator = ";" if ";" in name else ","
            text = [name] + [separator.join(map(str, ([n] if "node" in name else []) + row[:columns])) for n, row in zip(lines, rows)]
            self.write("points.csv", "\n".join(text) + "\n")
            facts, _ = self.run_sizes(TELL, world('nodes = "points.csv"', 4), sizes=[(1, 1), (3, 1)])
            self.assertEqual(self.places(facts), {n: tuple(row[:columns] + [0] * (3 - columns)) for n, row in zip(lines, rows)})
            self.expect_in_range(facts, 4)

    def test_points_on_the_edge_of_the_range_are_in_it(self):
        self.write("points.csv", "x,y\n" + "".join(f"{3 * i},{4 * k}\n" for i in range(5) for k in range(5)))
        for reach, degree in ((3, 2), (4, 4), (5, 8), (math.nextafter(5, 0), 4)):
            facts, _ = self.run_sizes(TELL, world('nodes = "points.csv"', repr(float(reach))), sizes=[(1, 1), (2, 1)])
            self.expect_in_range(facts, reach)
            # The one in the middle.
            self.assertEqual(len([a for a, _ in facts["near"] if a == 12]), degree)

    def drifted(self, places, ticks):
        """Where they are after so many ticks, and how often links were made and cut."""
        now, made, cut = dict(places), 0, 0
        links = within(now, 3.0)
        for tick in range(1, ticks):
            if tick < 60:
                now = {i: (x + ((i * 7 + tick * 3) % 11 - 5) / 8, y + ((i * 5 + tick * 2) % 13 - 6) / 8, z) for i, (x, y, z) in now.items()}
            before, links = links, within(now, 3.0)
            made, cut = made + len(links - before) // 2, cut + len(before - links) // 2
        return now, made, cut

    def test_links_come_and_go_as_points_move(self):
        for seed, ticks in itertools.product(range(6 if CAMPAIGN else 2), (1, 2, 7, 40)):
            toml = world('graph = "scatter(90, 22, 15)"', 3.0, seed=seed)
            start = self.places(self.run_sizes(TELL, toml, sizes=[(1, 1)])[0])
            facts, summary = self.run_sizes(DRIFT, toml + MOTION, "--ticks", ticks)
            now, made, cut = self.drifted(start, ticks)
            self.assertEqual(self.places(facts), now)
            self.expect_in_range(facts, 3.0)
            self.assertEqual([summary[key] for key in ("links_made", "links_cut")], [made, cut])
        self.assertGreater(min(made, cut), 100)

    def test_views_are_those_of_the_links_that_there_are(self):
        toml = world('graph = "scatter(90, 22, 15)"', 3.0) + MOTION + '[facts]\nsource = "id == 0"\n'
        for more in ("", '[network]\nkind = "latency"\nleast = 1\nmost = 4\n',
                     '[network]\nkind = "lossy"\nloss = 0.2\nretry = 3\ntries = 9\n',
                     '[clock]\nkind = "random"\nrate = 0.5\nmost = 3\n',
                     '[network]\ndetect = 5\n[[event]]\ntick = 9\nkill = "id % 7 == 3"\n'):
            # With every condition they come to rest at other times, but rest on the same.
            facts, _ = self.run_sizes(ROUTES, toml + more, "--ticks", 1000)
            pairs = self.expect_in_range(facts, 3.0)
            hops, front = {0: 0}, [0]
            for a in front:
                for b in sorted(b for c, b in pairs if c == a and b not in hops):
                    hops[b] = hops[a] + 1
                    front.append(b)
            found = {int(a): int(d) for a, d in facts["dist"]}
            self.assertEqual({a: (found.get(a), hops.get(a)) for a in found | hops if found.get(a) != hops.get(a)}, {}, more)

    def test_a_run_goes_on_from_a_checkpoint(self):
        self.write("p.meld", ROUTES)
        self.write("w.toml", world('graph = "scatter(80, 20, 15)"', 3.0) + MOTION + '[facts]\nsource = "id == 0"\n'
                   '[links.noise]\ndistance = 0.1\n'
                   '[[event]]\ntick = 12\nkill = "id % 9 == 4"\ncut = "id == 7"\n')
        run = ("meldsim", "run", "p.meld", "--world", "w.toml", "--quiet")
        self.call(*run, "--ticks", 100, "--facts-out", "whole", "--digest", "whole.d")
        for tick, n, m in ((5, 1, 3), (20, 3, 1), (33, 2, 4)):
            self.call(*run, "--ticks", tick, "--facts-out", "f", "--digest", "d", "--checkpoint", f"c{tick}", "-n", n)
            self.call("meldsim", "resume", f"c{tick}", "--quiet", "--ticks", 100, "-n", m)
            self.assertEqual(self.read("d"), self.read("whole.d"))
            self.assertEqual(self.read("f"), self.read("whole"))

    def test_speed_is_the_most_that_a_point_moves(self):
        self.write("points.csv", "x,y,z\n0,0,0\n2,0,0\n")
        program = (TELL + "moveBy(A, vec3(6.0, 0.0, 8.0)) :- id(A, 0).\nmoveBy(A, 0.125, 0.0, 0.0) :- id(A, 1).\n"
                   "moveBy(A, 0.125, 0.25, 0.0) :- id(A, 1).\n")
        facts, _ = self.run_sizes(program, world('nodes = "points.csv"') + MOTION + "speed = 1\n", sizes=[(1, 1), (2, 1)])
        places = self.places(facts)
        for got, wanted in zip(places[0] + places[1], (0.6, 0, 0.8, 2.25, 0.25, 0)):
            self.assertAlmostEqual(got, wanted, 12)

    def test_events_change_links_and_what_is_sensed_of_them(self):
        toml = world('graph = "scatter(60, 12, 12)"', 3.0)
        for more, motion in itertools.product(("", MOTION), ("", "[[event]]\ntick = 20\ngive = { rest = 'id == 5' }\n")):
            facts, _ = self.run_sizes(STILL, toml + more + "[[event]]\ntick = 5\ncut = ['id == 5', [1, 2]]\nkill = 9\n"
                                      "[[event]]\ntick = 7\nrestart = 'id % 8 == 3'\n" + motion)
            moved = bool(more and motion)
            self.assertEqual(len(self.places(facts)), 59)
            lost = {pair for a in range(60) for pair in ((5, a), (a, 5))} if not moved else set()
            self.expect_in_range(facts, 3.0, lost | {(1, 2), (2, 1)})
        # A link that is joined is as long as it is, until one of its ends moves.
        facts, _ = self.run_sizes(STILL, world('graph = "scatter(60, 40, 40)"') + MOTION + "[[event]]\ntick = 2\njoin = [[3, 4], [5, 6]]\n"
                                  "[[event]]\ntick = 9\ngive = { rest = 'id == 5' }\n")
        places = self.places(facts)
        self.assertEqual({(a, b) for a, b in self.pairs(facts) if square(places[a], places[b]) > 9}, {(3, 4), (4, 3)})

    def pairs(self, facts):
        return {(int(a), int(b)) for a, b, _ in facts["far"]}

    def test_nodes_that_rules_make_are_linked(self):
        program = TELL + "type linear grow(node, int).\ngrow(@0, 5).\ngrow(_, N), N > 0 -o exists B. (grow(B, N - 1)).\n"
        for more in ("", MOTION):
            facts, _ = self.run_sizes(program, world('graph = "disc(20, 4)"') + more)
            self.assertEqual(len(self.places(facts)), 25)
            self.expect_in_range(facts, 3.0)

    def test_noise_has_the_spread_that_the_world_says(self):
        toml = world('graph = "disc(300, 8)"', 4.0) + "[links.noise]\ndistance = 0.25\nbearing = 10\n"
        facts, _ = self.run_sizes(TELL, toml, sizes=[(1, 1), (1, 2), (3, 1)])
        places = self.places(facts)
        errors = [d - math.sqrt(square(places[a], places[b])) for a, b, d in facts["far"] if square(places[a], places[b]) > 4]
        self.expect_normal(errors, 0.25, 5000)
        turns = []
        for a, b, x, y, z in facts["to"]:
            self.assertAlmostEqual(x * x + y * y + z * z, 1, 12)
            dx, dy = places[b][0] - places[a][0], places[b][1] - places[a][1]
            turns.append(math.degrees(math.atan2(dx * y - dy * x, dx * x + dy * y)))
        self.expect_normal(turns, 10, 5000)
        # The two ends of a link err by themselves, and another seed errs otherwise.
        far = {(a, b): d for a, b, d in facts["far"]}
        self.assertLess(sum(far[a, b] == far[b, a] for a, b in far), len(far) / 100)
        # In space the angle from the true direction has two parts.
        facts, _ = self.run_sizes(TELL, world('graph = "ball(200, 5)"', 4.0) + "[links.noise]\nbearing = 5\n", sizes=[(1, 1), (2, 2)])
        places = self.places(facts)
        angles = []
        for a, b, *way in facts["to"]:
            length = math.sqrt(square(places[a], places[b]))
            cosine = sum(w * (q - p) for w, p, q in zip(way, places[a], places[b])) / length
            angles.append(math.degrees(math.acos(min(1, cosine))))
        self.assertAlmostEqual(math.sqrt(sum(x * x for x in angles) / len(angles)) / math.sqrt(2) / 5, 1, 1)

    # Two walls, as boxes of a world and as corners.
    WALLS = ('[[links.obstacle]]\nkind = "box"\ncentre = [1.5, 0.5, 0]\nsize = [0.5, 9, 2]\n'
             '[[links.obstacle]]\nkind = "box"\ncentre = [-5, 1, 0]\nsize = [6, 0.25, 1]\n')
    CORNERS = (((1.25, -4, -1), (1.75, 5, 1)), ((-8, 0.875, -0.5), (-2, 1.125, 0.5)))

    def test_neighbours_see_each_other(self):
        for points, reach, thickness in (('graph = "scatter(150, 20, 14)"', 5.0, 0.5), ('graph = "scatter(120, 9, 9, 9)"', 4.0, 1.0),
                                         ('graph = "disc(100, 10)"', 6.0, 0), ('graph = "disc(60, 10)"', 0.5, 3.0)):
            with self.subTest(points=points):
                more = f"sight = true\nthickness = {thickness}\n{self.WALLS}"
                for motion in ("", MOTION):
                    facts, _ = self.run_sizes(TELL, world(points, reach) + more + motion)
                    wanted = seen(self.places(facts), reach, thickness, self.CORNERS)
                    self.expect_in_range(facts, reach, wanted=wanted)
                    if reach > 1:
                        self.assertGreater(len(within(self.places(facts), reach)), len(wanted) + 20)
                        self.assertGreater(len(wanted), 200)
        # Points on one line, of which each sees the next ones alone, or all if they have no thickness.
        self.write("points.csv", "x,y\n" + "".join(f"{2 * i},{i}\n" for i in range(6)))
        for thickness, links in ((1, 10), (0, 30)):
            facts, _ = self.run_sizes(TELL, world('nodes = "points.csv"', 100) + f"sight = true\nthickness = {thickness}\n")
            self.assertEqual(len(facts["near"]), links)

    def test_all_kinds_of_obstacles_are_in_the_way(self):
        self.write("points.csv", "x,y,z\n-2,0,0.5\n2,0.25,0.5\n0,8,5\n")
        self.write("wall.obj", "v 0 -1 -1\nv 0 1 -1\nv 0 1 2\nv 0 -1 2\nf 1 2 3\nf 1 3 4\n")
        for obstacle, pairs in (('kind = "plane"\nnormal = [0, 0, 1]\noffset = 0.25', {(0, 1), (0, 2), (1, 2)}),
                                ('kind = "plane"\nnormal = [1, 0, 0]\noffset = -1', {(1, 2)}),
                                ('kind = "box"\ncentre = [0, 0, 0]\nsize = [0.5, 1, 2]', {(0, 2), (1, 2)}),
                                ('kind = "box"\ncentre = [0.5, 0.75, 0.5]\nsize = [0.5, 0.5, 1]\ndegrees = 45', {(0, 1), (0, 2), (1, 2)}),
                                ('kind = "box"\ncentre = [0.5, 0.5, 0.5]\nsize = [0.5, 0.5, 1]\ndegrees = 45', {(0, 2), (1, 2)}),
                                ('kind = "box"\ncentre = [0, 0, 1.2]\nsize = [1, 1, 1]\nturned = [0, 45, 0]', {(0, 2), (1, 2)}),
                                ('kind = "box"\ncentre = [0, 0, 1.2]\nsize = [1, 1, 1]', {(0, 1), (0, 2), (1, 2)}),
                                ('kind = "sphere"\ncentre = [0, 0, 1]\ndiameter = 2', {(0, 2), (1, 2)}),
                                ('kind = "cylinder"\ncentre = [0, 0, 1]\nheight = 2', {(0, 2), (1, 2)}),
                                ('kind = "cylinder"\ncentre = [0, 0, 1]\nheight = 0.5', {(0, 1), (0, 2), (1, 2)}),
                                ('kind = "capsule"\ncentre = [0, 3, 0.5]\nlength = 7\nturned = [90, 0, 0]', {(0, 2), (1, 2)}),
                                ('kind = "terrain"\ncentre = [-4, -4, -0.1]\ncell = 4\nheights = [[0, 0, 0], [0, 1, 0], [0, 0, 0]]',
                                 {(0, 2), (1, 2)}),
                                ('kind = "mesh"\nshape = "mesh(\'wall.obj\', scale = 1)"', {(0, 2), (1, 2)})):
            with self.subTest(obstacle=obstacle):
                facts, _ = self.run_sizes(TELL, world('nodes = "points.csv"', 100) + f"sight = true\n[[links.obstacle]]\n{obstacle}\n",
                                          sizes=[(1, 1), (2, 1)])
                self.assertEqual({(int(a), int(b)) for a, b in facts.get("near", []) if a < b}, pairs)

    def test_sight_comes_and_goes_as_points_move(self):
        # Some of them never move, and see those pass between them.
        program = TELL + """
moveBy(A, X, Y, 0) :- tick(A, T), id(A, I), T < 60, I % 3 > 0,
    X = float((I * 7 + T * 3) % 11 - 5) / 8, Y = float((I * 5 + T * 2) % 13 - 6) / 8.
"""
        for seed, (reach, thickness) in itertools.product(range(4 if CAMPAIGN else 1), ((4.0, 0.5), (3.0, 1.0), (1.0, 2.0))):
            toml = world('graph = "scatter(90, 16, 12)"', reach, seed=seed) + f"sight = true\nthickness = {thickness}\n{self.WALLS}"
            for ticks in (2, 7, 40):
                facts, _ = self.run_sizes(program, toml + MOTION + "[[event]]\ntick = 5\nkill = 'id % 10 == 3'\n", "--ticks", ticks)
                self.expect_in_range(facts, reach, wanted=seen(self.places(facts), reach, thickness, self.CORNERS))
        # One who is killed, and one that a rule makes.
        self.write("points.csv", "x,y\n0,0\n2,0\n4,0\n")
        for ticks, links in ((3, 4), (6, 2), (9, 2)):
            toml = world('nodes = "points.csv"', 5) + "sight = true\n" + MOTION + "[[event]]\ntick = 5\nkill = 1\n"
            facts, _ = self.run_sizes(STILL, toml, "--ticks", ticks)
            self.assertEqual(len(facts["near"]), links)
        grow = TELL + "type linear grow(node, int).\ngrow(@0, 5).\ngrow(_, N), N > 0 -o exists B. (grow(B, N - 1)).\n"
        for more in ("", MOTION):
            facts, _ = self.run_sizes(grow, world('graph = "disc(20, 6)"', 6) + "sight = true\n" + more)
            self.expect_in_range(facts, 6, wanted=seen(self.places(facts), 6, 1))

    def test_a_run_with_sight_goes_on_from_a_checkpoint(self):
        self.write("p.meld", ROUTES)
        self.write("w.toml", world('graph = "scatter(80, 20, 15)"', 4.0) + f"sight = true\n{self.WALLS}" + MOTION +
                   '[facts]\nsource = "id == 0"\n[[event]]\ntick = 12\nkill = "id % 9 == 4"\n')
        run = ("meldsim", "run", "p.meld", "--world", "w.toml", "--quiet")
        self.call(*run, "--ticks", 100, "--facts-out", "whole", "--digest", "whole.d")
        for tick, n, m in ((5, 1, 3), (12, 2, 1), (20, 3, 1)):
            self.call(*run, "--ticks", tick, "--facts-out", "f", "--digest", "d", "--checkpoint", f"c{tick}", "-n", n)
            self.call("meldsim", "resume", f"c{tick}", "--quiet", "--ticks", 100, "-n", m)
            self.assertEqual(self.read("d"), self.read("whole.d"))
            self.assertEqual(self.read("f"), self.read("whole"))

    def test_without_motion_moves_are_not_carried_out(self):
        self.write("p.meld", STILL)
        self.write("w.toml", world('graph = "disc(5, 2)"') + '[facts]\nrest = "id == 0"\n')
        _, said = self.call("meldsim", "run", "p.meld", "--world", "w.toml", "--quiet")
        self.assertIn('give it [motion] kind = "points"', said)

    def test_errors_say_what_to_write(self):
        self.write("p.meld", TELL)
        self.write("bad.csv", "node,a,b\n1,2,3\n")
        self.write("word.csv", "x,y\n1,2\n3,north\n")
        reach, motion = "[links]\nrange = 3\n", MOTION
        for text, place, says in (
                (reach, "2", "which nodes are linked, but not which there are"),
                ('graph = "ring(5)"\n' + reach, "2", "has links of its own"),
                ('graph = "disc(5, 2)"\nnodes = "bad.csv"\n' + reach, "3", "both graph and nodes"),
                ('nodes = "bad.csv"\n' + reach, "2", "no columns x and y of numbers"),
                ('nodes = "word.csv"\n' + reach, "2", "no columns x and y of numbers"),
                ('graph = "disc(5, 2)"\n[links]\n', "3", "does not say how far"),
                ('graph = "disc(5, 2)"\n[links]\nrange = 0\n', "4", "range"),
                ('graph = "disc(5, 2)"\n[links]\nrange = inf\n', "4", "range"),
                ('graph = "disc(5, 2)"\n[links]\nrnge = 3\n', "4", "rnge"),
                ('graph = "disc(5, 2)"\n' + reach + "[links.noise]\ndistance = -1\n", "6", "distance"),
                ('graph = "disc(5, 2)"\n' + reach + "noise = 3\n", "5", "a table [links.noise]"),
                ('graph = "disc(5, 2)"\n' + reach + "sight = 3\n", "5", "sight"),
                ('graph = "disc(5, 2)"\n' + reach + "thickness = 1\n", "5", "write sight = true"),
                ('graph = "disc(5, 2)"\n' + reach + "sight = true\nthickness = -1\n", "6", "thickness"),
                ('graph = "disc(5, 2)"\n' + reach + "[[links.obstacle]]\n", "5", "write sight = true"),
                ('graph = "disc(5, 2)"\n' + reach + "sight = true\nobstacle = 3\n", "6", "tables [[links.obstacle]]"),
                ('graph = "disc(5, 2)"\n' + reach + "sight = true\n[[links.obstacle]]\nkind = 'bax'\n", "7", "'box'"),
                ('graph = "disc(5, 2)"\n' + reach + "sight = true\n[[links.obstacle]]\nfriction = 1\n", "7", "friction"),
                ('graph = "disc(5, 2)"\n' + reach + "sight = true\n[[links.obstacle]]\nkind = 'box'\nsize = [1, 0, 1]\n", "6",
                 "no box"),
                ('graph = "disc(5, 2)"\ndirected = true\n' + reach, "3", "goes with a list of links"),
                ('graph = "disc(5)"\n' + reach, "2", "disc(n, r)"),
                ('graph = "disc(5, -1)"\n' + reach, "2", "below 0"),
                ('graph = "scatter(5, 2, 2, 2, 2)"\n' + reach, "2", "scatter(n, w, h)"),
                ('graph = "disc(1000000, 2)"\n' + reach, "2", "links"),
                ('graph = "ring(5)"\n' + motion, "3", "has links of its own"),
                ('graph = "disc(5, 2)"\n' + reach + '[motion]\nkind = "lattice"\n', "5", "kind = \"points\""),
                ('graph = "disc(5, 2)"\n' + reach + motion + "speed = 0\n", "7", "speed"),
                ('graph = "disc(5, 2)"\n' + reach + motion + "[[event]]\ntick = 3\nheal = 'all'\n", "9", "linked again"),
                ('graph = "disc(5, 2)"\n' + reach + motion + "[faults]\nuntil = 9\nheal = 0.1\n", "9", "linked again")):
            with self.subTest(text=text):
                self.write("w.toml", 'lattice = "graph"\n' + text)
                code = 4 if "1000000" in text and "memory" in self.run_tool("meldsim", "world", "w.toml").stderr else 2
                _, said = self.call("meldsim", "world", "w.toml", code=code)
                self.assertIn(says, said)
                self.assertIn(f"w.toml:{place}:", said)
        self.write("w.toml", '[[body]]\nshape = "box(2, 2, 2)"\n' + MOTION)
        self.assertIn("points are nodes of a graph", self.call("meldsim", "world", "w.toml", code=2)[1])
        self.write("p.meld", TELL + "type action moveBy(node, float, float, float) while.\nmoveBy(A, 1e308, 0, 0) :- tick(A, _).\n")
        self.write("w.toml", world('graph = "disc(5, 2)"') + MOTION)
        for n in (1, 3):
            _, said = self.call("meldsim", "run", "p.meld", "--world", "w.toml", "-n", n, "--quiet", code=1)
            self.assertIn("which leads nowhere", said)


    def test_the_example_gathers_and_loses_nobody(self):
        examples = pathlib.Path(__file__).resolve().parents[2] / "examples/meld"
        program, toml = (examples / f"swarm_gather.{ending}" for ending in ("meld", "toml"))
        for seed in (4, 5, 7) if CAMPAIGN else (4,):
            facts, summary = self.run_sizes(program.read_text() + TELL, toml.read_text().replace("seed = 4", f"seed = {seed}"),
                                            sizes=SIZES if seed == 4 else [(1, 1)])
            self.assertEqual(summary["ended"], "quiet")
            self.assertEqual(summary["links_cut"], 0)
            self.assertEqual(len(facts["arrived"]), 60)
            self.assertEqual(len(facts["far"]), 60 * 59)
            self.assertLessEqual(max(d for _, _, d in facts["far"]), 1.5)


class Bodies(InRange):
    """The same of bodies, which migrate between processes."""

    def bodies(self, spacing, reach, more="", size=5.1):
        return (f'lattice = "hex"\n[[body]]\nshape = "sphere({size})"\n[motion]\nkind = "bodies"\nspacing = {spacing}\nsteps = 4\n'
                f'ground = -0.5\n[motion.sense]\nposition = 0\n[links]\nrange = {reach}\n{more}')

    def test_neighbours_are_those_in_range(self):
        for spacing, reach in ((1.5, 3.0), (1.05, 4.0), (3, 2.0), (2, 12.0)):
            for ticks in (1, 20, 60) if CAMPAIGN else (1, 45):
                facts, _ = self.run_sizes(FLY, self.bodies(spacing, reach), "--ticks", ticks)
                pairs = self.expect_in_range(facts, reach)
                links = max(sum(a == each for a, _ in pairs) for each in range(91))
                if reach == 4.0:
                    self.assertGreater(links, 12)

    def test_neighbours_see_each_other(self):
        # A wall where some catoms are left out.
        for spacing, reach, ticks in ((1.5, 5.0, 1), (1.5, 5.0, 30), (2, 8.0, 20), (1.05, 4.0, 40)):
            wall = f'[[motion.obstacle]]\nkind = "box"\ncentre = [{2 * spacing}, 0, 0]\nsize = [0.2, {4 * spacing}, 5]\n'
            toml = self.bodies(spacing, reach, "sight = true\n" + wall)
            toml = toml.replace("sphere(5.1)", "minus(sphere(5.1), move(box(1, 5, 9), 2, 0, 0))")
            facts, _ = self.run_sizes(FLY, toml, "--ticks", ticks)
            places = self.places(facts)
            corners = ((2 * spacing - 0.1, -2 * spacing, -2.5), (2 * spacing + 0.1, 2 * spacing, 2.5))
            wanted = seen(places, reach, 1, [corners])
            self.expect_in_range(facts, reach, wanted=wanted)
            self.assertGreater(len(within(places, reach)), 1.2 * len(wanted))
            self.assertGreater(len(wanted), 300)

    def test_sight_is_blocked_by_shapes_as_they_are(self):
        # A plank between two balls, upright and turned flat; a can and a capsule; a large ball.
        plank, can, capsule = 'shape = "box"\nedges = [0.2, 0.4, 4]', 'shape = "cylinder"\nheight = ', 'shape = "capsule"\nlength = 5'
        for form, turned, sees in ((plank, (0, 0, 0), False), (plank, (90, 0, 0), True), (can + "3", (0, 0, 0), False),
                                   (can + "0.2", (0, 0, 0), True), (capsule, (0, 90, 0), True), (capsule, (0, 0, 0), False),
                                   ("radius = 0.7", (0, 0, 0), True), ("radius = 1.3", (0, 0, 0), False)):
            toml = (f'[[body]]\npositions = [[-3, 0, 1], [3, 0, 1], [0, 0, 0]]\n[motion]\nkind = "bodies"\ngravity = [0, 0, 0]\n'
                    f'[[motion.catoms]]\nwhere = "id == 2"\nfixed = true\n{form}\nturned = {list(turned)}\n'
                    "[links]\nrange = 9\nsight = true\n")
            facts, _ = self.run_sizes(TELL, toml, "--ticks", 3, sizes=[(1, 1), (2, 1)])
            self.assertEqual((0, 1) in {(int(a), int(b)) for a, b in facts["near"]}, sees, f"{form} {turned}")

    def test_they_migrate_and_are_lost(self):
        toml = self.bodies(3, 5.0, "[[event]]\ntick = 30\nkill = 'id % 11 == 4'\n", size=9.1)
        out = None
        for n in (1, 2, 3, 4):
            self.write("p.meld", FLY)
            self.write("w.toml", toml)
            self.call("meldsim", "run", "p.meld", "--world", "w.toml", "-n", n, "--ticks", 55, "--facts-out", "f", "--digest", "d",
                      "--quiet")
            seen = (self.read("f"), self.read("d"))
            out = out or seen
            self.assertEqual(seen[1], out[1], f"{n} processes")
            self.assertEqual(seen[0], out[0], f"{n} processes")
        self.expect_in_range(facts_of(out[0].decode()), 5.0)

    def test_a_run_goes_on_from_a_checkpoint(self):
        self.write("p.meld", FLY)
        self.write("w.toml", self.bodies(2, 4.0, "sight = true\n[links.noise]\ndistance = 0.1\n", size=7.1))
        self.expect_goes_on(60)

    def test_contacts_are_those_that_touch(self):
        feature = '[[motion.feature]]\nkind = "dipole"\ndirections = 6\n'
        toml = self.bodies(1, 3.0, feature)
        facts, _ = self.run_sizes(FLY, toml, "--ticks", 1, sizes=[(1, 1), (2, 2), (3, 1)])
        places = self.places(facts)
        met = {(int(a), int(b)) for a, b, _ in facts["met"]}
        self.assertTrue(met)
        for a, b in within(places, 3.0):
            self.assertEqual((a, b) in met, math.sqrt(square(places[a], places[b])) < 1.005, f"{a} {b}")

    def test_what_is_of_points_is_an_error(self):
        for more, place in (("thickness = 1\n", 14), ("[[links.obstacle]]\n", 14)):
            self.write("w.toml", self.bodies(2, 4.0, "sight = true\n" + more))
            said = self.call("meldsim", "world", "w.toml", code=2)[1]
            self.assertIn("is of points, and this world has bodies", said)
            self.assertIn(f"w.toml:{place}:", said)

    def test_a_lattice_has_no_range(self):
        self.write("w.toml", '[[body]]\nshape = "box(2, 2, 2)"\n[links]\nrange = 3\n')
        self.assertIn("linked where they touch", self.call("meldsim", "world", "w.toml", code=2)[1])


if __name__ == "__main__":
    main("meldc", "meldsim")
