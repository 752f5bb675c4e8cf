// What stands where: links, and what every catom senses of the world.
#pragma once

#include <map>

#include "tests/reference/evaluator/value.h"
#include "tests/retraction/case.h"

namespace meld::reference {

// Random bits as the language says: for the seed, the catom, the tick, and how many have been drawn in it.
struct Chance {
    std::uint64_t seed = 0, catom = 0, tick = 0, draws = 0;
    std::uint64_t next();
    // The numbers of nodes that rules make: the first of this catom in this tick, how far they are apart, and how many it has taken.
    std::uint64_t first_node = 0, nodes_apart = 0, nodes = 0;
    std::uint64_t next_node() { return first_node + nodes_apart * nodes++; }
};

struct Link {
    int port = 0;
    std::int64_t other = 0;
    int back = 0;  // The port at which the other sees this catom.
};

using Links = std::map<std::int64_t, std::vector<Link>>;  // By catom, in the order of ports.

struct Scene {
    const Program* program = nullptr;
    std::int64_t tick = 0;
    std::int64_t first_catoms = 0;  // How many there were at the start: @world.
    Links links;                    // Every catom has an entry.
    Facts world;                    // Of the world predicates, except those that are links.
    Chance* chance = nullptr;       // Where linear rules are applied.
};

// What the catoms of a case sense, as things stand in the mirror.
Scene make_scene(const Program& program, const retraction::Case& world, const retraction::Mirror& mirror, std::int64_t tick);
// The same at another time.
void set_tick(Scene& scene, std::int64_t tick);

}  // namespace meld::reference
