// What stands where: links, and what the world tells every catom of itself.
#pragma once

#include <map>

#include "runtime/world/lattice.h"
#include "value.h"

namespace meld::reference {

struct Link {
    int port = 0;
    std::int64_t other = 0;
    int back = 0;       // The port at which the other sees this catom.
};

struct Scene {
    const Program* program = nullptr;
    std::int64_t tick = 0;
    std::int64_t first_catoms = 0;                    // How many there were at the start: @world.
    std::map<std::int64_t, std::vector<Link>> links;  // By catom, in the order of ports. Every catom has an entry.
    Facts world;                                      // Of the world predicates, except those that are links.
};

Scene make_scene(const Program& program, const std::map<world::Cell, std::uint64_t>& at, world::LatticeKind lattice, std::int64_t tick, std::size_t first_catoms);

}  // namespace meld::reference
