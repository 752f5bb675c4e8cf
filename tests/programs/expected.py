"""What each program must derive, computed independently: one function per program, from (outcome, cells and links of a world) to facts."""

import collections
import heapq
import itertools
import math

import numpy

from lattice import components, hops, parents, position


def gradient(case):
    found = hops(case.links, case.sources)
    return {"source": [(s,) for s in case.sources], "dist": list(found.items())}


def spanning_tree(case):
    found = hops(case.links, case.sources)
    parent = parents(case.links, found)
    above = set(parent.values())
    return {
        "root": [(s,) for s in case.sources],
        "hops": list(found.items()),
        "parent": list(parent.items()),
        "children": [(b, a) for a, b in parent.items()],
        "leaf": [(a,) for a in found if a not in above],
    }


def leader(case):
    highest = {catom: max(part) for part in components(case.links) for catom in part}
    return {"leader": list(highest.items()), "elected": [(a,) for a, b in highest.items() if a == b]}


def census(case):
    found = hops(case.links, case.sources)
    parent = parents(case.links, found)
    below = collections.defaultdict(list)
    for catom in case.links:
        at = catom
        below[at].append(catom)
        while at in parent:
            at = parent[at]
            below[at].append(catom)

    def added(axis):
        return {catom: math.fsum(case.places[b][axis] for b in all_below) for catom, all_below in below.items()}

    sums = [added(axis) for axis in range(3)]
    return {
        "root": [(s,) for s in case.sources],
        "hops": list(found.items()),
        "parent": list(parent.items()),
        "size": [(a, len(below[a])) for a in found],
        "sum-x": list(sums[0].items()),
        "sum-y": list(sums[1].items()),
        "sum-z": list(sums[2].items()),
        "total": [(s, len(below[s])) for s in case.sources],
        "centre": [(s, *(axis[s] / len(below[s]) for axis in sums)) for s in case.sources],
    }


def temperature(case):
    now = {catom: case.degrees(cell) for catom, cell in case.outcome.cell_of.items()}
    before = math.fsum(now.values())
    for _ in range(case.rounds):
        now = {a: t + 0.0625 * math.fsum(now[b] - t for b in case.links[a]) for a, t in now.items()}
    after = math.fsum(row[2] for row in case.outcome.facts["temperature"])
    if not math.isclose(before, after, rel_tol=1e-12):
        raise AssertionError(f"the sum of all temperatures was {before} and is {after}")
    case.expect_messages(case.rounds * sum(len(others) for others in case.links.values()))
    return {"temperature": [(a, case.rounds, t) for a, t in now.items()]}


def flood(case):
    found = hops(case.links, case.sources)
    case.expect_messages(sum(len(case.links[a]) for a in found))
    return {"visited": list(found.items()), "unvisited": [(a,) for a in case.links if a not in found]}


def height_colour(case):
    case.expect_messages(0)
    if case.outcome.summary["exported_changes"] != 0:
        raise AssertionError("catoms tell one another about layers")
    layers = {catom: (cell[2] + 3_000_000) // case.thickness for catom, cell in case.outcome.cell_of.items()}
    return {"layer": list(layers.items()), "colour": [(a, layer % 3) for a, layer in layers.items()]}


def thermometer(case):
    degrees = {catom: case.degrees(position(case.lattice, cell)) for catom, cell in case.outcome.cell_of.items()}
    warm = {catom for catom, t in degrees.items() if t >= case.limit}
    hottest = {catom: max(degrees[b] for b in part) for part in components(case.links) for catom in part}
    return {
        "temperature": list(degrees.items()),
        "warm": [(a,) for a in warm],
        "front": [(a,) for a in warm if any(b not in warm for b in case.links[a])],
        "hottest": list(hottest.items()),
    }


def walk(case):
    """Walkers end on top of the columns of their goals; everything else stays."""
    ground = set(case.cells) - set(case.goals)
    tops = {start: (*goal, 1 + max(z for x, y, z in ground if (x, y) == goal)) for start, goal in case.goals.items()}
    final = case.outcome.cell_of
    if sorted(final.values()) != sorted(ground | set(tops.values())):
        raise AssertionError(f"cells are taken that should not be: {sorted(set(final.values()) - ground)}, "
                             f"expected {sorted(tops.values())}")
    walkers = {cell: catom for catom, cell in final.items() if cell in tops.values()}
    return {"goal": [(walkers[top], *top[:2]) for top in tops.values()], "arrived": [(walkers[top],) for top in tops.values()]}


def life(case):
    cell_of = case.outcome.cell_of
    at = {cell: catom for catom, cell in cell_of.items()}
    alive = {cell for cell in at if cell in case.first}

    def around(cell):
        x, y, z = cell
        return sum((x + i, y + j, z) in alive for i in (-1, 0, 1) for j in (-1, 0, 1) if (i, j) != (0, 0))

    for _ in range(case.generations):
        alive = {cell for cell in at if around(cell) == 3 or (cell in alive and around(cell) == 2)}
    side, level = collections.defaultdict(list), collections.defaultdict(list)
    for catom, (x, y, z) in cell_of.items():
        side[catom] = [at[c] for c in ((x - 1, y, z), (x + 1, y, z)) if c in at]
        level[catom] = [at[c] for c in ((x, y - 1, z), (x, y + 1, z)) if c in at]
    case.expect_messages(case.generations * sum(len(case.links[a]) for a in cell_of))
    return {
        "alive": [(at[cell],) for cell in case.first if cell in at],
        "cell-at": [(catom, case.generations, int(cell in alive)) for catom, cell in cell_of.items()],
        "beside": [(a, b) for a, all_b in side.items() for b in all_b],
        "above": [(a, b) for a, all_b in level.items() for b in all_b],
        "sides": [(a, len(all_b)) for a, all_b in side.items() if all_b],
        "levels": [(a, len(all_b)) for a, all_b in level.items() if all_b],
    }


def length(a, b):
    return 1 + (a * b + a + b) % 9


def least_distances(case):
    """Dijkstra's algorithm over the lengths of the links."""
    found, heap = {}, [(0, s) for s in case.sources]
    while heap:
        d, catom = heapq.heappop(heap)
        if catom in found:
            continue
        found[catom] = d
        for other in case.links[catom]:
            if other not in found:
                heapq.heappush(heap, (d + length(catom, other), other))
    return found


def shortest_paths(case):
    found = least_distances(case)
    told = {}
    for catom, d, via in case.outcome.facts["dist"]:
        # Several neighbours may lead there as fast; the one it names must be one of them.
        if via != catom and (via not in case.links[catom] or found[via] + length(catom, via) != d):
            raise AssertionError(f"@{catom} is not reached over @{via} in {d}")
        told[catom] = via
    return {
        "source": [(s,) for s in case.sources],
        "link": [(a, b, length(a, b)) for a, others in case.links.items() for b in others],
        "dist": [(a, d, told.get(a, a)) for a, d in found.items()],
    }


def relaxation(case):
    found = least_distances(case)
    rows = {}
    for catom, d, via in case.outcome.facts["shortest"]:
        if catom in found and catom not in case.sources and (via not in case.links[catom] or found[via] + length(catom, via) != d):
            raise AssertionError(f"@{catom} is not reached over @{via} in {d}")
        rows[catom] = via
    return {"shortest": [(a, found.get(a, 1_000_000), rows.get(a, a)) for a in case.links]}


def ranks(case, rounds):
    now = {a: 1.0 for a in case.links}
    for _ in range(rounds):
        now = {a: 0.15 + 0.85 * math.fsum(now[b] / len(case.links[b]) for b in others) for a, others in case.links.items()}
    return now


def pagerank(case):
    now = ranks(case, case.rounds)
    # A catom without neighbours has nobody to give to and stays in round 0.
    alone = {a for a, others in case.links.items() if not others}
    case.expect_messages(case.rounds * sum(len(others) for others in case.links.values()))
    return {"rank": [(a, 0, 1.0) if a in alone else (a, case.rounds, r) for a, r in now.items()]}


def pagerank_async(case):
    exact = ranks(case, 300)
    left = {a: e for a, e in case.outcome.facts["residue"]}
    for a, r in case.outcome.facts["rank"]:
        if case.links[a] and (left[a] > case.enough or not exact[a] - 40 * case.enough <= r <= exact[a] + 1e-9):
            raise AssertionError(f"the rank of @{a} is {r} with {left[a]} left, and should be {exact[a]}")
    if sorted(left) != sorted(case.links) or sorted(a for a, _ in case.outcome.facts["rank"]) != sorted(case.links):
        raise AssertionError("each catom must have one rank and one residue")
    return {name: case.outcome.facts[name] for name in ("rank", "residue")}


def bipartite(case):
    found = hops(case.links, case.sources)
    odd = {a for a in found if any(found[b] % 2 == found[a] % 2 for b in case.links[a])}
    bad = set(hops(case.links, odd))
    return {
        "root": [(s,) for s in case.sources],
        "hops": list(found.items()),
        "side": [(a, h % 2) for a, h in found.items()],
        "odd": [(a,) for a in odd],
        "not-bipartite": [(a,) for a in bad],
        "bipartite": [(a,) for a in found if a not in bad],
    }


def colouring(case):
    colour = {}
    for a in sorted(case.links, reverse=True):
        colour[a] = next(c for c in itertools.count() if all(colour.get(b) != c for b in case.links[a]))
    higher = {a: [b for b in others if b > a] for a, others in case.links.items()}
    return {
        "colour": list(colour.items()),
        "taken": [(a, c) for a in case.links for c in {colour[b] for b in higher[a]}],
        "higher": [(a, len(others)) for a, others in higher.items() if others],
    }


def minimum_spanning_tree(case):
    def weight(a, b):
        return (a + b) * 37 % 101 * 1_000_000 + max(a, b) * 1000 + min(a, b)

    # Kruskal's algorithm; what is heaviest on the way between two catoms is the link that joined their parts.
    part = {a: {a} for a in case.links}
    tree, ease = [], [(a, a, 0) for a in case.links]
    for w, a, b in sorted((weight(a, b), a, b) for a, others in case.links.items() for b in others if a < b):
        if part[a] is part[b]:
            continue
        tree += [(a, b), (b, a)]
        ease += [row for x in part[a] for y in part[b] for row in ((x, y, w), (y, x, w))]
        part[a] |= part[b]
        for c in part[b]:
            part[c] = part[a]
    return {"tree": tree, "ease": ease, "link": [(a, b, weight(a, b)) for a, others in case.links.items() for b in others]}


def consensus(case):
    found = hops(case.links, case.sources)
    parent = parents(case.links, found)
    votes = collections.Counter()
    for catom in found:
        vote = 1 if case.wants(case.outcome.cell_of[catom]) else -1
        at = catom
        votes[at] += vote
        while at in parent:
            at = parent[at]
            votes[at] += vote
    root = case.sources[0]
    return {
        "root": [(root,)],
        "yes": [(a,) for a, cell in case.outcome.cell_of.items() if case.wants(cell)],
        "hops": list(found.items()),
        "parent": list(parent.items()),
        "votes": [(a, votes[a]) for a in found],
        "decision": [(a, int(votes[root] > 0)) for a in found],
    }


def queens(case):
    def ways(above):
        if len(above) == case.columns:
            return [above]
        safe = [c for c in range(case.columns) if all(q != c and abs(q - c) != d for d, q in enumerate(above, 1))]
        return [board for c in safe for board in ways([c, *above])]

    boards = ways([])
    order = sorted(case.links, key=lambda a: case.outcome.cell_of[a])
    told = case.outcome.facts["example"]
    if len(told) != (1 if boards else 0) or any(a != order[-1] or list(board) not in boards for a, board in told):
        raise AssertionError(f"{told} is no example of {len(boards)} boards")
    return {
        "column": [(a, c) for a in order for c in range(case.columns)],
        "next": list(zip(order, order[1:])),
        "ways": [(a, 0) for a in order[:-1]] + [(order[-1], len(boards))],
        "example": told,
    }


def quicksort(case):
    at = {cell: catom for catom, cell in case.outcome.cell_of.items()}
    return {"sorted": [(at[cell], sorted(numbers), 0) for cell, numbers in case.lists.items()]}


def belief_propagation(case):
    doubt, rough, colours = 1.6, 1.2, range(3)

    def normalized(beliefs):
        top = max(beliefs)
        total = top + math.log(math.fsum(math.exp(b - top) for b in beliefs))
        return [b - total for b in beliefs]

    def added(lists):
        return [math.fsum(column) for column in zip(*lists)]

    cell_of = case.outcome.cell_of
    seen = {a: case.colour(cell) for a, cell in cell_of.items()}
    evidence = {a: [0.0 if i == c else -doubt for i in colours] for a, c in seen.items()}

    def message(cavity):
        through = [[b - (0.0 if i == j else rough) for j, b in enumerate(cavity)] for i in colours]
        return normalized([math.log(math.fsum(math.exp(b) for b in row)) for row in through])

    heard = {(a, b): message(evidence[b]) for a, others in case.links.items() for b in others}
    for _ in range(case.rounds - 1):
        heard = {(a, b): message(added([evidence[b]] + [heard[b, c] for c in case.links[b] if c != a])) for a, b in heard}
    belief = {a: normalized(added([evidence[a]] + [heard[a, b] for b in case.links[a]])) for a in cell_of}
    case.expect_messages(case.rounds * len(heard))
    # A catom without neighbours hears nothing in any round.
    return {
        "seen": list(seen.items()),
        "evidence": list(evidence.items()),
        "kept": [(a, b, m) for (a, b), m in heard.items()],
        "belief": list(belief.items()),
        "likely": [(a, max(colours, key=lambda i, b=b: b[i])) for a, b in belief.items()],
    }


def mutual_exclusion(case):
    found = hops(case.links, case.sources)
    parent = parents(case.links, found)
    wants = {a for a in found if case.wants(case.outcome.cell_of[a])}
    alone = case.outcome.facts["alone"]
    if {a for a, _ in alone} != wants or sorted(n for _, n in alone) != list(range(1, len(wants) + 1)):
        raise AssertionError(f"{sorted(alone)} is not one turn after the other for {sorted(wants)}")
    case.expect_messages(2 * (len(found) - 1))
    return {
        "root": [(s,) for s in case.sources],
        "wants": [(a,) for a, cell in case.outcome.cell_of.items() if case.wants(cell)],
        "hops": list(found.items()),
        "parent": list(parent.items()),
        "children": [(b, a) for a, b in parent.items()],
        "token": [(s, len(wants)) for s in case.sources],
        "fresh": [(a,) for a in case.links if a not in found],
        "asleep": [(a,) for a in case.links if a not in case.sources],
        "alone": alone,
    }


# Root of the mean square of the distances between what catoms believe and where they are, after the rotation and the shift that make it
# least (Kabsch): a picture in a mirror is no rotation. And that rotation.
def misfit(believed, places):
    here = numpy.array([believed[a] for a in sorted(places)])
    there = numpy.array([places[a] for a in sorted(places)])
    here, there = here - here.mean(0), there - there.mean(0)
    u, _, v = numpy.linalg.svd(here.T @ there)
    rotation = v.T @ numpy.diag([1, 1, numpy.linalg.det(v.T @ u.T)]) @ u.T
    return math.sqrt(((here @ rotation.T - there) ** 2).sum(1).mean()), rotation


def localization(case):
    facts = case.outcome.facts
    believed = dict(facts["place"])
    if sorted(believed) != sorted(case.links) or len(facts["place"]) != len(believed):
        raise AssertionError(f"{len(believed)} of {len(case.links)} catoms know where they are")
    seen = {(a, b): numpy.array(d) for a, b, d in facts["seen"]}
    own = {a: numpy.array(axes).T for a, *axes in facts["axes"]}
    for part in components(case.links):
        error, rotation = misfit({a: believed[a] for a in part}, {a: case.places[a] for a in part})
        if error > case.within:
            raise AssertionError(f"the places are wrong by {error} diameters, which may be {case.within}")
        for a in part:
            if abs(own[a] @ own[a].T - numpy.eye(3)).max() > 1e-9 or numpy.linalg.det(own[a]) < 0:
                raise AssertionError(f"the axes of @{a} are no rotation")
            # Each catom sees its neighbours where they are: at worst as wrong as three places in a part that is large and noisy.
            for b in case.links[a]:
                off = math.dist(rotation @ own[a] @ seen[a, b], numpy.subtract(case.places[b], case.places[a]))
                if len(part) > 2 and off > 10 * case.within:
                    raise AssertionError(f"@{a} sees @{b} in a direction that is off by {off}")
    if sorted(facts["inner"]) != sorted((a, b) for a, others in case.links.items() for b in others):
        raise AssertionError("a link is not known to be in one component")
    branches = {a: [] for a in case.links}
    for a, b in facts["branch"]:
        branches[a].append(b)
    parts = len(list(components(case.links)))
    if len(facts["branch"]) != 2 * (len(case.links) - parts) or len(list(components(branches))) != parts:
        raise AssertionError(f"{len(facts['branch'])} branches do not span {len(case.links)} catoms in {parts} parts")
    return facts


def kmeans(case):
    (root, rounds, means), = case.outcome.facts["finished"]
    cluster = dict(case.outcome.facts["mine"])
    part = set(hops(case.links, case.sources))
    if (root,) != tuple(case.sources) or set(cluster) != part:
        raise AssertionError(f"{len(cluster)} catoms are in a cluster, and {len(part)} hear of the root")
    # Nothing changes any more: each catom is nearest to the mean of its cluster, and that is where the mean is.
    for a in part:
        far = [math.dist(case.places[a], mean) for mean in means]
        if far[cluster[a]] > min(far) + 1e-9:
            raise AssertionError(f"@{a} is in the cluster of a mean that is farther")
    for number, mean in enumerate(means):
        mine = [case.places[a] for a in part if cluster[a] == number]
        if mine and math.dist(mean, numpy.mean(mine, axis=0)) > 1e-9:
            raise AssertionError(f"the mean of cluster {number} is wrong")
    # The first round makes a tree.
    branches = {a: [] for a in part}
    for a, b in case.outcome.facts["child"]:
        branches[a].append(b)
    if len(case.outcome.facts["child"]) != len(part) - 1 or set(hops(branches, case.sources)) != part:
        raise AssertionError("the children are not those of a tree")
    case.expect_messages(sum(len(case.links[a]) for a in part) + 2 * (len(part) - 1) * (rounds - 1))
    return case.outcome.facts


def heat(case):
    warm = {a: t for a, t, _ in case.outcome.facts["warmth"]}
    told = {a: t for a, _, t in case.outcome.facts["warmth"]}
    fixed = {}
    for a, cell in case.outcome.cell_of.items():
        degrees = case.held(cell)
        if degrees is not None:
            fixed[a] = degrees
    for a, others in case.links.items():
        if a in fixed:
            if others and warm[a] != fixed[a] and not any(b in fixed for b in others):
                raise AssertionError(f"@{a} is held at {fixed[a]} and has {warm[a]}")
            continue
        if others and abs(warm[a] - math.fsum(told[b] for b in others) / len(others)) > 1e-9:
            raise AssertionError(f"@{a} is not the mean of what its neighbours told")
        if abs(warm[a] - told[a]) > case.step:
            raise AssertionError(f"@{a} has told {told[a]} and has {warm[a]}")
    return {name: case.outcome.facts[name] for name in ("warmth", "heard", "hot", "cold")}
