"""Moves of catoms on lattices as the literature has them, from geometry alone: bodies that rotate sweep the cells that must be empty. And
who may carry out what, plainly, as docs/motion.md says."""

import collections
import functools
import itertools
import math

from lattice import position

CODES = {"slide": 5, "turn": 6, "move": 12}
NAMES = {"square": ("sliding", "pivoting", "leapfrog", "monkey"), "cubic": ("sliding", "pivoting", "leapfrog", "monkey"),
         "hex": ("rolling", "pivoting", "monkey"), "fcc": ("rolling",)}
FLAT = ("square", "hex")

# A move: where it leads, what must be full, what must be empty, and pairs of which one must be empty; all in order.
Move = collections.namedtuple("Move", "by full empty pairs")


def add(a, b):
    return tuple(x + y for x, y in zip(a, b))


def minus(a, b):
    return tuple(x - y for x, y in zip(a, b))


def times(k, a):
    return tuple(k * x for x in a)


def cell_at(lattice, place):
    """The cell whose centre this is."""
    x, y, z = place
    if lattice == "hex":
        row = y / (math.sqrt(3) / 2)
        return (round(x - row / 2), round(row), 0)
    if lattice == "fcc":
        layer = round(z / (math.sqrt(2) / 2))
        return (round(x - layer % 2 / 2), round(y - layer % 2 / 2), layer)
    return (round(x), round(y), round(z))


@functools.cache
def ports(lattice, layer=0):
    """The cells beside one, in the order of its ports, as seen from there."""
    if lattice == "square":
        return [(1, 0, 0), (0, 1, 0), (-1, 0, 0), (0, -1, 0)]
    if lattice == "cubic":
        return [(1, 0, 0), (-1, 0, 0), (0, 1, 0), (0, -1, 0), (0, 0, 1), (0, 0, -1)]
    if lattice == "hex":
        return [(1, 0, 0), (0, 1, 0), (-1, 1, 0), (-1, 0, 0), (0, -1, 0), (1, -1, 0)]
    plane = [(1, 0, 0), (0, 1, 0), (-1, 0, 0), (0, -1, 0)]
    corners = [(0.5, 0.5), (-0.5, 0.5), (-0.5, -0.5), (0.5, -0.5)]
    here = (0, 0, layer)
    return plane + [minus(cell_at("fcc", add(position("fcc", here), (x, y, up * math.sqrt(0.5)))), here) for up in (1, -1)
                    for x, y in corners]


# ---- symmetries, as maps of places

def rotation(degrees):
    c, s = math.cos(math.radians(degrees)), math.sin(math.radians(degrees))
    return [[c, -s, 0], [s, c, 0], [0, 0, 1]]


def product(a, b):
    return [[sum(a[i][k] * b[k][j] for k in range(3)) for j in range(3)] for i in range(3)]


def determinant(m):
    return sum(m[0][i] * (m[1][(i + 1) % 3] * m[2][(i + 2) % 3] - m[1][(i + 2) % 3] * m[2][(i + 1) % 3]) for i in range(3))


def apply(m, place):
    return tuple(sum(m[i][k] * place[k] for k in range(3)) for i in range(3))


@functools.cache
def symmetries(lattice, which="all"):
    if which == "none":
        return [rotation(0)]
    if lattice == "hex":
        mirror = [[1, 0, 0], [0, -1, 0], [0, 0, 1]]
        found = [product(rotation(60 * k), m) for k in range(6) for m in (rotation(0), mirror)]
    else:
        found = [[[sign[i] if order[i] == k else 0 for k in range(3)] for i in range(3)]
                 for order in itertools.permutations(range(3)) for sign in itertools.product((1, -1), repeat=3)]
        if lattice == "square":
            found = [m for m in found if m[2] == [0, 0, 1]]
        if lattice == "fcc":
            # The axes of its cube lie at 45 degrees to those of its layers.
            found = [product(rotation(45), product(m, rotation(-45))) for m in found]
    return [m for m in found if which == "all" or determinant(m) > 0]


def turned(lattice, places, which="all", layer=0):
    """A move given by places, as seen from the origin, in all its forms for a mover in a layer: as cells seen from there."""
    by, full, empty, pairs = places
    here = (0, 0, layer)
    found = set()
    for m in symmetries(lattice, which):
        def cell(place):
            return minus(cell_at(lattice, add(position(lattice, here), apply(m, place))), here)
        found.add(Move(cell(by), tuple(sorted(set(map(cell, full)))), tuple(sorted({cell(by), *map(cell, empty)})),
                       tuple(sorted({tuple(sorted((cell(a), cell(b)))) for a, b in pairs}))))
    return found


# ---- what a body sweeps

def corners_of(lattice):
    if lattice == "hex":
        return [(math.cos(math.radians(30 + 60 * k)) / math.sqrt(3), math.sin(math.radians(30 + 60 * k)) / math.sqrt(3)) for k in range(6)]
    return [(0.5, 0.5), (-0.5, 0.5), (-0.5, -0.5), (0.5, -0.5)]


def inside(lattice, point, cell):
    """Whether a point lies in the body of a cell, and not at its edge."""
    x, y, _ = position(lattice, cell)
    dx, dy = point[0] - x, point[1] - y
    normals = [math.radians(60 * k) for k in range(6)] if lattice == "hex" else [math.radians(90 * k) for k in range(4)]
    return all(dx * math.cos(a) + dy * math.sin(a) < 0.5 - 1e-3 for a in normals)


@functools.cache
def points_of(lattice):
    return [(x / 40, y / 40) for x in range(-24, 25) for y in range(-24, 25) if inside(lattice, (x / 40, y / 40), (0, 0, 0))]


def rotate(point, about, degrees):
    c, s = math.cos(math.radians(degrees)), math.sin(math.radians(degrees))
    x, y = point[0] - about[0], point[1] - about[1]
    return (about[0] + c * x - s * y, about[1] + s * x + c * y)


@functools.cache
def swept(lattice, stages):
    """The cells that a body touches on its way, and where it ends: stages are points about which it rotates, and degrees."""
    shape, touched = [(0.0, 0.0), *points_of(lattice)], set()
    for about, degrees in stages:
        for part in range(41):
            for point in shape:
                x, y = rotate(point, about, degrees * part / 40)
                i, j, _ = cell_at(lattice, (x, y, 0))
                touched.update(c for c in itertools.product((i - 1, i, i + 1), (j - 1, j, j + 1), (0,)) if c not in touched
                               and inside(lattice, (x, y), c))
        shape = [rotate(point, about, degrees) for point in shape]
    return frozenset(touched - {(0, 0, 0)}), cell_at(lattice, (*shape[0], 0))


# ---- the tables

def pivots(lattice, name):
    """Bodies that rotate: (stages, full, more that is empty), cells in the plane."""
    if lattice == "hex":
        # The corner between the mover, its pivot east of it and the cell to the north east; then that between the two cells beyond.
        first, second = (0.5, 0.5 / math.sqrt(3)), (0.0, 2 / math.sqrt(3))
        found = [(((first, -120),), [(1, 0)], [])]
        if name == "monkey":
            found.append((((first, -60), (second, -60)), [(1, 0), (-1, 2)], []))
        return found
    edge = (0.5, -0.5)
    found = [(((edge, -90),), [(0, -1), (1, -1)], []), (((edge, -180),), [(0, -1)], [])]
    if name in ("leapfrog", "monkey"):
        found += [(((edge, -90),), [(0, -1), (2, 0)], [(1, -1)]), (((edge, -90),), [(1, -1), (-1, 0)], [(0, -1)])]
        if lattice == "cubic":
            found += [(((edge, -90),), [(0, -1), (1, 0, 1)], [(1, -1)]), (((edge, -90),), [(1, -1), (0, 0, 1)], [(0, -1)])]
    if name == "monkey":
        found += [(((edge, -90), ((1.5, -0.5), -90)), [(0, -1), (2, -1)], [(1, -1)]),
                  (((edge, -90), ((1.5, 0.5), -90)), [(0, -1), (2, 1)], [(1, -1), (2, 0)])]
    return found


def rolls():
    """The 3D catom around its neighbour, as places seen from the mover."""
    beside = [position("fcc", c) for c in ports("fcc")]
    apart = lambda a, b: math.dist(a, b)
    near = lambda a, b: abs(apart(a, b) - 1) < 1e-6
    for start in beside:
        pivot = times(-1, start)
        for end in beside:
            if end == start or apart(start, end) > 1.5:
                continue
            faces = []
            if near(start, end):
                faces += [[c] for c in beside if near(c, start) and near(c, end)]
                faces += [[c, d] for c in beside for d in beside if near(c, end) and near(d, start) and near(c, d)
                          and abs(apart(c, start) - math.sqrt(2)) < 1e-6 and abs(apart(d, end) - math.sqrt(2)) < 1e-6]
            else:
                faces.append([c for c in beside if near(c, start) and near(c, end)])
            there = add(pivot, end)
            for rest in faces:
                empty = [add(pivot, c) for c in rest] + [add(pivot, times(2, start)), add(pivot, times(2, end))]
                known = [cell_at("fcc", c) for c in [*empty, there, pivot, (0, 0, 0)]]
                pairs = [(add(there, c), minus(there, c)) for c in beside]
                pairs = [pair for pair in pairs if not any(cell_at("fcc", c) in known for c in pair)]
                yield there, [pivot], empty, pairs


@functools.cache
def table(lattice, name, layer=0):
    """All moves of a table, in the order in which the first that fits is taken."""
    spread = lambda cells: [position(lattice, (*c, 0)[:3]) for c in cells]
    given = []
    if name == "sliding":
        given = [((1, 0, 0), spread([(0, -1), (1, -1)]), [], []), ((1, -1, 0), spread([(0, -1)]), spread([(1, 0)]), [])]
    elif lattice == "fcc":
        given = list(rolls())
    elif name == "rolling":
        given = [(position("hex", (0, 1, 0)), spread([(1, 0)]), spread([(-1, 1)]), [])]
    else:
        for stages, full, empty in pivots(lattice, name):
            touched, end = swept("hex" if lattice == "hex" else "square", stages)
            given.append((position(lattice, end), spread(full), spread([*empty, *touched]), []))
    return sorted(set().union(*(turned(lattice, one, "all", layer) for one in given)))


def own_table(lattice, listed, layer=0):
    """The same of moves that a world lists: (move, symmetries), cells as seen from an even layer."""
    places = lambda cells: [position(lattice, c) for c in cells]
    found = set()
    for (by, full, empty, pairs), which in listed:
        given = (position(lattice, by), places(full), places(empty), [tuple(places(pair)) for pair in pairs])
        found |= turned(lattice, given, which, layer)
    return sorted(found)


# ---- who may carry out what

Request = collections.namedtuple("Request", "action catom arguments")


class Moves:
    def __init__(self, lattice, moves, cells, keep_connected=False):
        """moves: by layer, even and odd; cells: by catom."""
        self.lattice, self.moves, self.cells, self.keep_connected = lattice, moves, dict(cells), keep_connected
        self.refused, self.moved = collections.Counter(), collections.Counter()

    def occupied(self):
        return {cell: catom for catom, cell in self.cells.items()}

    def fits(self, move, here, full):
        at = lambda c: add(here, c) in full
        return all(at(c) for c in move.full) and not any(at(c) for c in move.empty) and not any(at(a) and at(b) for a, b in move.pairs)

    def possible(self, catom, full=None):
        here, full = self.cells[catom], self.occupied() if full is None else full
        return {move.by for move in self.moves[here[2] % 2] if self.fits(move, here, full)}

    def by_table(self, here, by, full):
        """(number, claims) of the first move that fits, or none."""
        for number, move in enumerate(self.moves[here[2] % 2]):
            if move.by == by and self.fits(move, here, full):
                claims = [("body", add(here, c)) for c in move.full] + [("cell", add(here, c)) for c in move.empty]
                return number, claims + [("cell", add(here, b if add(here, a) in full else a)) for a, b in move.pairs]
        return None

    def plan(self, request, full):
        """(direction, claims, the new cell), or why it cannot be."""
        here, arguments = self.cells[request.catom], request.arguments
        if request.action == "move":
            found = self.by_table(here, tuple(arguments), full)
            return (found[0], found[1], add(here, arguments)) if found else "not_allowed"
        count = len(ports(self.lattice))
        if not all(0 <= port < count for port in arguments):
            return "no_such_port"
        pivot, towards = (ports(self.lattice)[port] for port in arguments)
        if sum(a * b for a, b in zip(pivot, towards)) != 0:
            return "not_at_right_angles"
        bodies, empty = [pivot], [towards]
        if request.action == "slide":
            bodies.append(add(pivot, towards))
        else:
            ahead = add(towards, towards)
            empty = [add(pivot, towards), towards, ahead, add(pivot, ahead), times(-1, pivot), minus(towards, pivot)]
        if not all(add(here, c) in full for c in bodies):
            return "no_support"
        if any(add(here, c) in full for c in empty):
            return "occupied"
        by = towards if request.action == "slide" else add(pivot, towards)
        found = self.by_table(here, by, full)
        if not found:
            return "not_allowed"
        claims = [("body", add(here, c)) for c in bodies] + [("cell", add(here, c)) for c in empty]
        return arguments[0] * count + arguments[1], claims + found[1], add(here, by)

    def ties(self, left, stays, full):
        """The cells that hold together the neighbours of a cell that is left, within two cells of it; None if they do not."""
        beside = lambda cell: [add(cell, step) for step in ports(self.lattice, cell[2] % 2)]
        wanted = [cell for cell in beside(left) if cell != stays and cell in full]
        before, reached, missing = {stays: None}, [stays], len(wanted)
        for cell in reached:
            if not missing:
                break
            for after in beside(cell):
                if after != left and after not in before and after in full and max(map(abs, minus(after, left))) <= 2:
                    before[after] = cell
                    reached.append(after)
                    missing -= after in wanted
        if missing:
            return None
        tree = set()
        for cell in wanted:
            while cell != stays and cell not in tree:
                tree.add(cell)
                cell = before[cell]
        return sorted(tree)

    def carry_out(self, requests):
        """All requests of a tick at once; returns who failed with what, each as often as it did."""
        failed, proposals, full = collections.Counter(), {}, self.occupied()

        def refuse(request, why):
            self.refused[request.action, why] += 1
            failed[request.catom, CODES[request.action]] += 1

        for request in requests:
            planned = self.plan(request, full)
            rests = []
            if not isinstance(planned, str) and self.keep_connected:
                rests = self.ties(self.cells[request.catom], planned[2], full)
                planned = "disconnects" if rests is None else planned
            if isinstance(planned, str):
                refuse(request, planned)
                continue
            order = (CODES[request.action], request.catom, planned[0])
            if order in proposals:
                refuse(request, "repeated")
                continue
            proposals[order] = (request, [*planned[1], ("body", self.cells[request.catom])], planned[2], rests)
        first, leaves, rests_on = {}, {}, {}
        for order in sorted(proposals):
            request, claims, _, rests = proposals[order]
            for claim in claims:
                first.setdefault(claim, order)
            leaves.setdefault(self.cells[request.catom], order)
            for cell in rests:
                rests_on.setdefault(cell, order)
        granted = []
        for order, (request, claims, to, rests) in proposals.items():
            left = self.cells[request.catom]
            wins = all(first[claim] == order for claim in claims)
            if self.keep_connected:
                wins = wins and not any(leaves.get(cell, order) < order for cell in rests) and not rests_on.get(left, order) < order
            if wins:
                granted.append((request, to))
            else:
                refuse(request, "conflict")
        for request, to in granted:
            self.moved[request.action] += 1
            self.cells[request.catom] = to
        return failed
