// What stands where: links, and what every catom senses of the world.
#pragma once

#include <map>
#include <set>
#include <utility>

#include "runtime/world/lattice.h"
#include "value.h"

namespace meld::reference {

// Random bits as the language says: for the seed, the catom, the tick, and how many have been drawn in it.
struct Chance {
    std::uint64_t seed = 0, catom = 0, tick = 0, draws = 0;
    std::uint64_t next();
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

// `missing`: catoms that touch and have no link, the lower number first.
Scene make_scene(const Program& program, const std::map<world::Cell, std::uint64_t>& at, world::LatticeKind lattice, std::int64_t tick,
                 std::size_t first_catoms, const std::set<std::pair<std::uint64_t, std::uint64_t>>& missing = {});
// The same at another time.
void set_tick(Scene& scene, std::int64_t tick);

}  // namespace meld::reference
