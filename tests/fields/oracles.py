"""What each block of aggregate programming has to have, from inputs and network alone: by networkx, or computed plainly."""

import collections
import heapq
import math

import networkx

# Sums are added up in another order here.
ROUNDED = 1e-9


def distances(graph, sources):
    sources = [source for source in sources if source in graph]
    return dict(networkx.multi_source_dijkstra_path_length(graph, sources)) if sources else {}


def way_is_shortest(final, found, next_of, length):
    """Each catom but the sources goes on to a neighbour from which the rest of the way is as short as it can be."""
    if set(next_of) != {catom for catom, distance in found.items() if distance > 0}:
        raise AssertionError("not those go on that are reached")
    for catom, other in next_of.items():
        if other not in final.links[catom] or found[catom] != found[other] + length(catom, other):
            raise AssertionError(f"@{catom} goes on to @{other}")


def field(final, name="field"):
    walls = final.all("wall")
    found = distances(final.graph(walls), final.all("source") - walls)
    final.same(f"{name}-dist", found)
    next_of, source_of = final.map(f"{name}-next"), final.map(f"{name}-from")
    way_is_shortest(final, found, next_of, final.length)
    for catom in found:
        if source_of[catom] != (source_of[next_of[catom]] if catom in next_of else catom):
            raise AssertionError(f"@{catom} belongs to @{source_of[catom]}")
    # The second instance in the same program, with hops that are longer in one direction.
    graph = networkx.DiGraph()
    graph.add_nodes_from(final.links)
    graph.add_weighted_edges_from((b, a, 1.0 if a < b else 2.0) for a in final.links for b in final.links[a])
    found = distances(graph, final.all("source"))
    final.same("uphill-dist", found)
    way_is_shortest(final, found, final.map("uphill-next"), lambda a, b: 1.0 if a < b else 2.0)


def cast(final):
    found = distances(final.graph(), final.all("source"))
    final.same("cast-dist", found)
    heard, source_of = final.map("cast-heard"), final.map("cast-from")
    if set(heard) != set(found):
        raise AssertionError("not those have heard that are reached")
    words = final.map("words-heard")
    for catom, distance in found.items():
        if words[catom] != f"from {final.map('words-from')[catom]}":
            raise AssertionError(f"@{catom} has heard {words[catom]}")
        if distance == 0:
            right = heard[catom] == 100.0 + catom and source_of[catom] == catom
        else:
            right = any(found[other] + final.length(catom, other) == distance and source_of[other] == source_of[catom] and
                        heard[catom] == heard[other] - 0.5 * final.length(catom, other) for other in final.links[catom] if other in found)
        if not right:
            raise AssertionError(f"@{catom} has heard {heard[catom]} from @{source_of[catom]}")


def behind(final, next_of, reached):
    """The catoms whose way leads over each catom."""
    below = collections.defaultdict(list)
    for catom in reached:
        at = catom
        while at is not None:
            below[at].append(catom)
            at = next_of.get(at)
    return below


def collect(final):
    found = distances(final.graph(), final.all("source"))
    below = behind(final, final.map("field-next"), found)
    final.same("collect-total", {a: math.fsum(0.5 + b for b in all_) for a, all_ in below.items()}, ROUNDED)
    # Those with an odd number have no value, and pass on those of others.
    final.same("best-total", {a: max(b for b in all_ if b % 2 == 0) for a, all_ in below.items() if any(b % 2 == 0 for b in all_)})


def multipath(final, reach=2.5):
    found = distances(final.graph(), final.all("source"))
    sums = {catom: 0.5 + catom for catom in found}
    for catom in sorted(found, key=found.get, reverse=True):
        weight = {other: max(reach - final.length(catom, other), 0.001 * reach) * (found[catom] - found[other])
                  for other in final.links[catom] if found[other] < found[catom]}
        for other, part in weight.items():
            sums[other] += sums[catom] * part / sum(weight.values())
    final.same("multipath-sum", sums, ROUNDED)
    arrived = math.fsum(sums[catom] for catom, distance in found.items() if distance == 0)
    if found and not math.isclose(arrived, math.fsum(0.5 + catom for catom in found), rel_tol=ROUNDED):
        raise AssertionError(f"{arrived} has arrived at the sources")


def elected(final, rank, reach):
    """The best candidate leads all that it reaches; the next best leads what it reaches of the rest, over the rest; and so on."""
    graph, leader_of, distance_of = final.graph(), {}, {}
    for catom in sorted((a for a in final.place if rank(a) is not None), key=lambda a: (rank(a), a)):
        if catom in leader_of:
            continue
        heap = [(0.0, catom)]
        while heap:
            distance, at = heapq.heappop(heap)
            if at in leader_of:
                continue
            leader_of[at], distance_of[at] = catom, distance
            for other, link in graph[at].items():
                if other not in leader_of and distance + link["weight"] <= reach:
                    heapq.heappush(heap, (distance + link["weight"], other))
    return leader_of, distance_of


def leaders(final):
    leader_of, distance_of = elected(final, lambda a: a * 7919 % 1009 if a % 5 else None, 4.0)
    final.same("leaders-of", leader_of)
    final.same("leaders-dist", distance_of)
    if final.all("leaders-elected") != {a for a, leader in leader_of.items() if a == leader}:
        raise AssertionError("leaders-elected")
    way_is_shortest(final, distance_of, final.map("leaders-next"), final.length)
    final.same("spread-heard", leader_of)


def channel(final):
    walls = final.all("wall")
    graph = final.graph(walls)
    here, there = final.all("source") - walls, final.all("goal") - walls
    to_here, to_there = distances(graph, here), distances(graph, there)
    long = {}
    for part in networkx.connected_components(graph):
        ways = [to_there[catom] for catom in part & here if catom in to_there]
        if ways:
            long.update({catom: min(ways) for catom in part})
    final.same("channel-long", long)
    inside = {a for a in long if to_here[a] + to_there[a] <= long[a] + 2.0}
    # Both sums are rounded, each in its own order.
    doubtful = {a for a in long if abs(to_here[a] + to_there[a] - long[a] - 2.0) < ROUNDED}
    if (final.all("channel-inside") ^ inside) - doubtful:
        raise AssertionError(f"channel-inside differs at {sorted(final.all('channel-inside') ^ inside)}")


def partition(final):
    best = {}
    graph = final.graph()
    for seed in sorted(final.all("source") & set(graph)):
        for catom, distance in networkx.single_source_dijkstra_path_length(graph, seed).items():
            best[catom] = min(best.get(catom, (math.inf, 0)), (distance, seed))
    final.same("partition-dist", {a: distance for a, (distance, _) in best.items()})
    final.same("partition-of", {a: seed for a, (_, seed) in best.items()})
    wanted = {(a, best[b][1]) for a in best for b in final.links[a] if best[b][1] != best[a][1]}
    if set(final.facts["partition-border"]) != wanted:
        raise AssertionError("partition-border")


def gossip(final, rounds=12):
    degree = {catom: len(others) for catom, others in final.links.items()}
    marked = final.all("source")
    at_first = state = {catom: float(catom) + (500.0 if catom in marked else 0.0) for catom in final.links}
    for _ in range(rounds):
        state = {a: state[a] + math.fsum((state[b] - state[a]) / (1.0 + max(degree[a], degree[b])) for b in final.links[a]) for a in state}
    final.same("gossip-mean", state, ROUNDED)
    for part in networkx.connected_components(final.graph()):
        values = [at_first[catom] for catom in part]
        for predicate, value in (("gossip-least", min(values)), ("gossip-greatest", max(values))):
            if {final.map(predicate)[catom] for catom in part} != {value}:
                raise AssertionError(predicate)


def countdown(final):
    wanted = final.all("countdown-from")
    if final.all("countdown-over") != wanted:
        raise AssertionError(f"countdown-over differs at {sorted(final.all('countdown-over') ^ wanted)}")
    if final.all("countdown-left") != wanted:
        raise AssertionError("countdown-left is not where the timer ran")


def every_round(name, stretch=0.0, factor=1.0, limit=100.0):
    """Distances up to a factor; links count with at least this length."""
    def check(final):
        graph = final.graph()
        for _, _, link in graph.edges(data=True):
            link["weight"] = max(link["weight"], stretch)
        right = distances(graph, final.all("source"))
        found = final.map(f"{name}-dist")
        if set(found) != set(final.place):
            raise AssertionError(f"{name}-dist is not everywhere")
        for catom, distance in found.items():
            wanted = right.get(catom, limit)
            if not wanted / factor - ROUNDED <= distance <= wanted * factor + ROUNDED:
                raise AssertionError(f"@{catom} has {distance}, not {wanted}")
    return check


ORACLES = {"field": field, "cast": cast, "collect": collect, "multipath": multipath, "leaders": leaders, "channel": channel,
           "partition": partition, "gossip": gossip, "countdown": countdown, "crf": every_round("crf"), "bis": every_round("bis"),
           "flex": every_round("flex", stretch=1.0, factor=1.1, limit=60.0)}


# ---- the examples


def adaptive_channel(final):
    graph = final.graph()
    here, there = final.all("here") & set(graph), final.all("there") & set(graph)
    to_here, to_there = distances(graph, here), distances(graph, there)
    long = min(to_there[a] for a in here)
    inside = {a for a in to_here if to_here[a] + to_there[a] <= long + 1.0}
    if final.all("channel-inside") != inside or not there <= inside:
        raise AssertionError(f"channel-inside differs at {sorted(final.all('channel-inside') ^ inside)}")
    relays = networkx.node_connected_component(graph.subgraph(inside), min(here))
    final.same("heard", {a: 112 for a in relays})
    if not there <= relays:
        raise AssertionError("the second place does not hear the first")


def crowd_alert(final):
    leader_of, graph = elected(final, lambda a: a * 7919 % 10007, 8.0)[0], final.graph()
    areas = collections.defaultdict(list)
    for catom, leader in leader_of.items():
        areas[leader].append(len(final.links[catom]))
    final.same("density", {leader: sum(area) / len(area) for leader, area in areas.items()}, ROUNDED)
    danger = {a for a, leader in leader_of.items() if sum(areas[leader]) / len(areas[leader]) >= 10.5}
    warned = {a for a, distance in distances(graph, danger).items() if distance <= 5.0}
    if not 0 < len(danger) < len(warned) < len(graph):
        raise AssertionError("this world shows nothing")
    if final.all("danger") != danger or final.all("warned") != warned:
        raise AssertionError("not those are warned that should be")


def sensor_areas(final):
    leader_of = elected(final, lambda a: a * 7919 % 1000003, 8.0)[0]
    areas = collections.defaultdict(list)
    for catom, leader in leader_of.items():
        x, y, _ = final.place[catom]
        areas[leader].append(20.0 + x / 4.0 + y * y / 80.0)
    if not 10 < len(areas) < len(leader_of) / 10 or not final.all("carried"):
        raise AssertionError("this world shows nothing")
    means = {leader: sum(area) / len(area) for leader, area in areas.items()}
    final.same("mean", means, ROUNDED)
    final.same("told", {catom: means[leader] for catom, leader in leader_of.items()}, ROUNDED)


def evacuation(final):
    fire, graph = final.all("fire"), networkx.DiGraph()
    smoky = fire | {b for a in fire for b in final.links[a]}
    graph.add_nodes_from(set(final.links) - fire)
    step = {(a, b): 4.0 if {a, b} & smoky else 1.0 for a in final.links for b in final.links[a] if not {a, b} & fire}
    graph.add_weighted_edges_from((b, a, length) for (a, b), length in step.items())
    found = distances(graph, final.all("exit"))
    final.same("way-dist", found)
    next_of = final.map("way-next")
    way_is_shortest(final, found, next_of, lambda a, b: step[a, b])
    people = final.all("person")
    below = behind(final, next_of, found)
    final.same("expected", {e: len(people & set(below[e])) for e in final.all("exit") if people & set(below[e])})
    if final.all("trapped") != people - set(found) or not people - set(found):
        raise AssertionError("not those are trapped that are")


def drone_formation(final):
    slots, targets = final.map("slot"), final.map("target")
    for part in networkx.connected_components(final.graph()):
        leader = min(part)
        if sorted(slots[a] for a in part) != list(range(len(part))) or slots[leader] != 0:
            raise AssertionError(f"the places of {len(part)} drones are {sorted(slots[a] for a in part)}")
        for catom in part:
            arm = (slots[catom] + 1) // 2 * 2.0
            x, y, z = final.place[leader]
            if math.dist(targets[catom], (x - arm, y + (arm if slots[catom] % 2 else -arm), z)) > ROUNDED:
                raise AssertionError(f"@{catom} goes to {targets[catom]}")
            if not math.isclose(final.map("to-go")[catom], math.dist(targets[catom], final.place[catom]), abs_tol=ROUNDED):
                raise AssertionError(f"to-go of @{catom}")


EXAMPLES = {"adaptive_channel": adaptive_channel, "crowd_alert": crowd_alert, "sensor_areas": sensor_areas, "evacuation": evacuation,
            "drone_formation": drone_formation}
