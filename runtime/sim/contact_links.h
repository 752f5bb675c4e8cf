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
#include "runtime/sim/divided_bodies.h"
#include "runtime/sim/part_state.h"

namespace meld::sim {

// A catom has as many links as there are ports, which equal spheres do not exceed unless they are pressed into each other. A
// touch beyond that is no link until both have a port free.
class ContactLinks {
  public:
    // After each step of the physics, on every part; `divided` where there are several. Events that name obstacles are passed
    // over. A catom of another part that comes to touch one of ours becomes known here as a ghost.
    void update(PartState& part, std::span<const physics::TouchEvent> events, const DividedBodies* divided);

    // By the numbers of two catoms.
    using Pair = std::pair<std::uint64_t, std::uint64_t>;
    // Touches that wait for a port, the lower number first; those of catoms that change parts go with them.
    std::set<Pair> waiting;

  private:
    // A port that a catom keeps free for another.
    struct Offer {
        int port;
        int owner;                           // Of the catom that offers.
        world::Vec3 position = {};
        std::vector<std::byte> exports = {};  // Of a catom of another part.
    };
    std::vector<physics::TouchEvent> share(PartState& part, std::span<const physics::TouchEvent> events, const DividedBodies& divided) const;
    void end(PartState& part, Pair ids);
    void offer(PartState& part, std::uint64_t from, std::uint64_t to);
    void exchange_offers(PartState& part, const DividedBodies& divided);
    Catom known(PartState& part, std::uint64_t id, const Offer& offer) const;
    void connect(PartState& part);

    std::map<Pair, Offer> offers_;           // From the first to the second.
    std::map<std::uint64_t, std::uint32_t> taken_;  // Ports promised, as bits.
};

// A ghost that nothing of this part touches any more is forgotten.
void forget_if_lonely(PartState& part, Catom ghost);

}  // namespace meld::sim
