"""Where the cells of a lattice are and which of them touch, from geometry alone: touching centres are one diameter apart."""

import collections
import itertools
import math


def position(lattice, cell):
    x, y, z = cell
    if lattice == "hex":
        return (x + y / 2, y * math.sqrt(3) / 2, float(z))
    if lattice == "fcc":
        shift = (z % 2) / 2
        return (x + shift, y + shift, z * math.sqrt(2) / 2)
    return (float(x), float(y), float(z))


def touching(lattice, cell_of):
    """The ids that each id touches, in ascending order."""
    places = {catom: position(lattice, cell) for catom, cell in cell_of.items()}
    boxes = collections.defaultdict(list)
    for catom, place in places.items():
        boxes[tuple(math.floor(c) for c in place)].append(catom)
    links = {}
    for catom, place in places.items():
        box = [math.floor(c) for c in place]
        near = itertools.product(*((b - 2, b - 1, b, b + 1, b + 2) for b in box))
        others = (other for key in near for other in boxes.get(key, ()))
        links[catom] = sorted(other for other in others if abs(math.dist(place, places[other]) - 1) < 1e-6)
    return links


def hops(links, sources):
    """The links from each reached catom to the nearest source."""
    found = {source: 0 for source in sources}
    wave = list(found)
    while wave:
        following = []
        for catom in wave:
            for other in links[catom]:
                if other not in found:
                    found[other] = found[catom] + 1
                    following.append(other)
        wave = following
    return found


def parents(links, found):
    """The neighbour with the lowest id that is one hop nearer, for all catoms that have one."""
    nearer = {catom: [other for other in links[catom] if found.get(other) == found[catom] - 1] for catom in found}
    return {catom: others[0] for catom, others in nearer.items() if others}


def components(links):
    """The sets of catoms that can reach one another."""
    left = set(links)
    while left:
        part = set(hops(links, [min(left)]))
        left -= part
        yield part
