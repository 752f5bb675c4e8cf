#include "tests/reference/trials/worlds.h"

#include <fmt/format.h>

#include <algorithm>
#include <iterator>

#include "runtime/world/graph/layout.h"

namespace meld::reference {

using retraction::below;

std::shared_ptr<const graph::Graph> make_graph(const retraction::Case& c) {
    std::vector<std::uint64_t> ids;
    for (const world::Cell& cell : c.cells) ids.push_back(static_cast<std::uint64_t>(cell.x));
    const auto place = [&](std::uint64_t id) { return static_cast<graph::Node>(std::ranges::lower_bound(ids, id) - ids.begin()); };
    std::vector<graph::Link> links;
    for (const auto& [a, b] : c.links) links.push_back({place(a), place(b)});
    graph::Graph graph = graph::make(ids.size(), std::move(links)).graph;
    if (ids.back() + 1 != ids.size()) graph.ids = std::move(ids);
    graph.places = graph::by_distances(graph);
    return std::make_shared<const graph::Graph>(std::move(graph));
}

world::World make_world(const retraction::Case& c) {
    world::World world;
    world.seed = c.seed;
    if (c.graph) {
        world.graph = make_graph(c);
        world.by_links = true;
    } else {
        world.lattice = c.lattice;
        world.cells = c.cells;
    }
    return world;
}

void set_conditions(world::World& world, std::uint64_t number) {
    if (number == 0) return;
    world.by_links = true;
    retraction::Random random(number);
    const auto choose = [&](std::uint32_t least, std::uint32_t most) {
        return least + static_cast<std::uint32_t>(below(random, most - least + 1));
    };
    const auto terms = [&](world::LinkTerms& t) {
        t.least = choose(1, 3);
        t.most = t.least + choose(0, 4);
        if (world.network.kind != world::NetworkKind::Lossy) return;
        t.loss = 0.02 * choose(0, 5);
        t.retry = choose(1, 3);
        t.tries = 15;
    };
    const std::uint32_t form = choose(0, 5);
    if (form != 0) {
        world.network.kind = form < 4 ? world::NetworkKind::Latency : world::NetworkKind::Lossy;
        terms(world.network.terms);
        for (const char* where : {"x > 0", "id % 3 == 0"}) {
            if (below(random, 4) != 0) continue;
            world::NetworkOptions::Part part{*world::Region::parse(where), {}};
            terms(part.terms);
            world.network.parts.push_back(std::move(part));
        }
    }
    if (form != 0 && below(random, 2) == 0) return;
    using enum world::ClockKind;
    constexpr world::ClockKind kKinds[] = {Random, Drift, Priority, Sequential};
    world.clock.kind = kKinds[below(random, std::size(kKinds))];
    const std::uint32_t rate = choose(1, 10), most = choose(1, 6);
    if (world.clock.gives_turns()) return;
    world.clock.rate = 0.1 * rate;
    world.clock.most = most;
}

void set_jams(world::World& world, std::uint64_t number) {
    world.by_links = true;
    if (!world.apart() || number / 1000 % 2 == 0) return;
    world::Event event{.tick = 5, .every = 20, .times = 6};
    event.jam.push_back({.links = {.where = *world::Region::parse("x >= 0")}, .ticks = 3});
    event.jam.push_back({.links = {.where = *world::Region::parse("y < 0"), .other = *world::Region::parse("y >= 0")}, .ticks = 5});
    // They are further from each other than any clock pauses.
    world.longest_jam = 5 + world.clock.most - 1;
    world.events.push_back(std::move(event));
}

std::string describe_conditions(std::uint64_t number) {
    if (number == 0) return "an ideal network";
    world::World world;
    set_conditions(world, number);
    const world::LinkTerms& t = world.network.terms;
    return fmt::format("network {} ({}: {} to {} ticks, loss {:.2f}, retry {}, {} regions; clock {}, rate {:.1f}, most {})", number,
                       static_cast<int>(world.network.kind), t.least, t.most, t.loss, t.retry, world.network.parts.size(),
                       static_cast<int>(world.clock.kind), world.clock.rate, world.clock.most);
}

}  // namespace meld::reference
