// Who touches whom, as the links over which programs see neighbours, kept up to date from what the physics says has begun and
// ended to touch.
#pragma once

#include <cstdint>
#include <map>
#include <set>
#include <span>
#include <utility>
#include <vector>

#include "physics/physics.h"
#include "runtime/sim/part_state.h"

namespace meld::sim {

// A catom has as many links as there are ports, which equal spheres do not exceed unless they are pressed into each other. A
// touch beyond that is no link until both have a port free.
class ContactLinks {
  public:
    // After each step of the physics. Events that name obstacles are passed over.
    void update(PartState& part, std::span<const physics::TouchEvent> events);
    // Touches that wait for a port.
    std::size_t waiting() const { return waiting_.size(); }

  private:
    using Pair = std::pair<std::uint64_t, std::uint64_t>;
    void end(PartState& part, Pair ids);
    bool begin(PartState& part, Pair ids);

    std::set<Pair> waiting_;  // By the numbers of the catoms, the lower first.
};

}  // namespace meld::sim
