"""Amoebots as the papers define them, plainly: who is where, who touches whom at which ports, and what becomes of requests."""

import collections

EAST = [(1, 0), (0, 1), (-1, 1), (-1, 0), (0, -1), (1, -1)]
CODES = {"expand": 8, "contract": 9, "push": 10, "pull": 11}
MASK = (1 << 64) - 1


def step(cell, direction):
    return (cell[0] + EAST[direction][0], cell[1] + EAST[direction][1])


def mix(x):
    x ^= x >> 30
    x = x * 0xBF58476D1CE4E5B9 & MASK
    x ^= x >> 27
    x = x * 0x94D049BB133111EB & MASK
    return x ^ x >> 31


def combine(seed, word):
    return mix(seed + 0x9E3779B97F4A7C15 + mix(word ^ 0xD6E8FEB86659FD93) & MASK)


class Compass:
    """Which direction of the lattice port 0 has, and whether ports run clockwise."""

    def __init__(self, seed, amoebot, own_compass, own_chirality):
        drawn = combine(combine(seed, 0x636F6D70617373), amoebot)
        self.first = (drawn >> 8) % 6 if own_compass else 0
        self.sign = -1 if own_chirality and drawn & 1 else 1

    def lattice(self, direction):
        return (self.first + self.sign * direction) % 6

    def own(self, direction):
        return self.sign * (direction - self.first) % 6


Request = collections.namedtuple("Request", "action amoebot argument")


class Amoebots:
    def __init__(self, heads, compasses, keep_connected=False):
        """heads: by amoebot, all of one cell."""
        self.shape = {amoebot: (cell, cell) for amoebot, cell in heads.items()}
        self.compass = compasses
        self.keep_connected = keep_connected
        self.refused = collections.Counter()
        self.moved = collections.Counter()

    def occupied(self):
        return {cell: amoebot for amoebot, cells in self.shape.items() for cell in cells}

    def expanded(self, amoebot):
        return len(set(self.shape[amoebot])) == 2

    def places(self, amoebot):
        """The cell behind each port."""
        head, tail = self.shape[amoebot]
        compass = self.compass[amoebot]
        all_cells = [step(head, compass.lattice(port)) for port in range(6)]
        return all_cells + [step(tail, compass.lattice(port)) for port in range(6)] if head != tail else all_cells

    def port_towards(self, amoebot, own_cell, other_cell):
        direction = next(d for d in range(6) if step(own_cell, d) == other_cell)
        return self.compass[amoebot].own(direction) + (6 if own_cell != self.shape[amoebot][0] else 0)

    def touches(self, amoebot):
        """(port, other, the port there, how many cells the other occupies) at each port with another amoebot."""
        occupied, found = self.occupied(), set()
        for port, cell in enumerate(self.places(amoebot)):
            other = occupied.get(cell, amoebot)
            if other != amoebot:
                here = self.shape[amoebot][0 if port < 6 else 1]
                found.add((port, other, self.port_towards(other, cell, here), 2 if self.expanded(other) else 1))
        return found

    def vacant(self, amoebot):
        occupied = self.occupied()
        return {port for port, cell in enumerate(self.places(amoebot)) if cell not in occupied}

    # ---- requests

    def plan(self, request):
        """What a request would do: (claims, the shapes afterwards, the cell it leaves, what it rests on), or why it cannot."""
        action, amoebot, argument = request
        head, tail = self.shape[amoebot]
        if self.expanded(amoebot) != (action in ("contract", "pull")):
            return "is_expanded" if self.expanded(amoebot) else "is_contracted"
        body = [("body", amoebot)]
        if action == "contract":
            if argument not in ("head", "tail"):
                return "no_such_end"
            stays, left = (head, tail) if argument == "head" else (tail, head)
            rests = self.ties(left, stays) if self.keep_connected else []
            return "disconnects" if rests is None else (body, {amoebot: (stays, stays)}, left, rests)
        places = self.places(amoebot)
        if not 0 <= argument < len(places):
            return "no_such_port"
        cell, occupied = places[argument], self.occupied()
        if action == "expand":
            return "occupied" if cell in occupied else (body + [("cell", cell)], {amoebot: (cell, head)}, None, [])
        other = occupied.get(cell, amoebot)
        if other == amoebot:
            return "not_a_neighbour"
        claims = body + [("body", other)]
        if action == "push":
            if not self.expanded(other):
                return "other_contracted"
            kept = next(c for c in self.shape[other] if c != cell)
            return claims, {amoebot: (cell, head), other: (kept, kept)}, None, []
        if self.expanded(other):
            return "other_expanded"
        given, kept = (head, tail) if argument < 6 else (tail, head)
        return claims, {amoebot: (kept, kept), other: (given, cell)}, None, []

    def ties(self, left, stays):
        """The cells that hold together the neighbours of a cell that is left, within two cells; None if they do not."""
        occupied = self.occupied()
        near = lambda cell: max(abs(cell[0] - left[0]), abs(cell[1] - left[1])) <= 2
        wanted = [cell for cell in (step(left, d) for d in range(6)) if cell != stays and cell in occupied]
        before, reached = {stays: None}, [stays]
        missing = len(wanted)
        for cell in reached:
            for d in range(6):
                after = step(cell, d)
                if missing and after != left and near(after) and after not in before and after in occupied:
                    before[after] = cell
                    reached.append(after)
                    missing -= after in wanted
            if not missing:
                break
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
        failed, proposals = collections.Counter(), {}

        def refuse(request, why):
            self.refused[request.action, why] += 1
            failed[request.amoebot, CODES[request.action]] += 1

        for request in requests:
            planned = self.plan(request)
            order = (CODES[request.action], request.amoebot, {"head": 0, "tail": 1}.get(request.argument, request.argument))
            if isinstance(planned, str):
                refuse(request, planned)
            elif order in proposals:
                refuse(request, "repeated")
            else:
                proposals[order] = (request, *planned)
        first, leaves, rests_on = {}, {}, {}
        for order in sorted(proposals):
            _, claims, _, left, rests = proposals[order]
            for claim in claims:
                first.setdefault(claim, order)
            if left:
                leaves.setdefault(left, order)
            for cell in rests:
                rests_on.setdefault(cell, order)
        granted = []
        for order, (request, claims, shapes, left, rests) in proposals.items():
            wins = all(first[claim] == order for claim in claims)
            if self.keep_connected:
                wins = wins and not any(leaves.get(cell, order) < order for cell in rests)
                wins = wins and not (left and rests_on.get(left, order) < order)
            if wins:
                granted.append((request.action, shapes))
            else:
                refuse(request, "conflict")
        for action, shapes in granted:
            self.moved[{"expand": "expansions", "contract": "contractions"}.get(action, "handovers")] += 1
            self.shape.update(shapes)
        return failed
