// Catoms that events of the world end. Such a catom is gone in the tick of the event, with its facts and with what it holds, and its
// neighbours sense it.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "runtime/sim/core/subdomain.h"

namespace meld::sim {

struct Killed {
    std::uint64_t id = 0;
    Cell cell = {};  // On a lattice.
};

class Kills {
  public:
    explicit Kills(Subdomain& subdomain) : subdomain_(subdomain) {}

    // Warns of events that would end nothing, where that is known beforehand. Every process calls it.
    void look_at_events() const;
    // Those of this tick's events, of all processes, by their numbers. Every process calls it. Cost: nothing in a tick without such an
    // event; otherwise a look at each catom for every region, and one exchange.
    std::vector<Killed> of_this_tick() const;
    // Takes them out of this process, ghosts too, on a lattice. Elsewhere motion does so, which made their links.
    void take_out(std::span<const Killed> killed);

  private:
    // Calls visit(Catom) for the catoms of this process, some of them several times.
    template <class Visit>
    void each(const world::Killing& killing, const Visit& visit) const;
    void take_node(std::uint64_t id);
    Subdomain& subdomain_;
};

}  // namespace meld::sim
