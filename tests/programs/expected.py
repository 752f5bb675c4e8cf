"""What each program must derive, computed anew: a function a program from (outcome, cells and links of a world) to facts."""

import collections
import math

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
        raise AssertionError(f"cells are taken that should not be: {sorted(set(final.values()) - ground)}, expected {sorted(tops.values())}")
    walkers = {cell: catom for catom, cell in final.items() if cell in tops.values()}
    return {"goal": [(walkers[top], *top[:2]) for top in tops.values()], "arrived": [(walkers[top],) for top in tops.values()]}
