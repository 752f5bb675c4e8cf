// Catoms that fail, by events of the world and by chance.
//
// One that is killed is gone in the tick of the event, with its facts and with what it holds, and its neighbours sense it; if the network
// has a detection delay, it hangs until that is over. One that hangs
// stays where it is and says nothing any more: its rules do not run, and its neighbours keep what it last told them. One that restarts has
// nothing but the facts of the start, as if it had just been made; its links go and come back in that tick, so that its neighbours drop
// what it had told.
#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <span>
#include <vector>

#include "runtime/sim/core/subdomain.h"

namespace meld::sim {

struct Killed {
    std::uint64_t id = 0;
    Cell cell = {};  // On a lattice.
    bool operator==(const Killed&) const = default;
};

// Of all processes, each by their numbers.
struct Struck {
    std::vector<Killed> killed, hung, restarted;
};

class CatomFailures {
  public:
    explicit CatomFailures(Subdomain& subdomain) : subdomain_(subdomain) {}

    // Warns of events that strike nothing, where that is known beforehand. Every process calls it.
    void look_at_events() const;
    // The same of faults, at the start of a run.
    void look_at_faults() const;
    // Those of this tick's events and faults. Every process calls it. Cost: nothing in a tick without; otherwise a look at each catom for
    // every region, and one exchange.
    Struck of_this_tick() const;
    // Where neighbours sense an end only after a while: those that are killed hang until then, whatever else happens to them. Afterwards
    // `killed` are those that are gone now. Returns how many were killed in this tick.
    std::size_t let_die(Struck& struck);
    // Takes them out of this process, ghosts too, on a lattice and in a graph. Elsewhere motion does so, which made their links.
    void take_out(std::span<const Killed> killed);
    void hang(std::span<const Killed> hung);
    // Returns those that this process owns; they have yet to be given the facts of the start.
    std::vector<Catom> restart(std::span<const Killed> restarted);

  private:
    // Calls visit(Catom) for the catoms of this process, some of them several times.
    template <class Visit>
    void each(const world::CatomChoice& choice, const Visit& visit) const;
    template <class Visit>
    void each_struck(world::Fault fault, double world::Faults::* probability, const Visit& visit) const;
    // Nobody moves, and no catoms are made.
    bool still() const;
    // Whether this process has one.
    bool any(const world::CatomChoice& choice) const;
    std::optional<Catom> here(const Killed& one) const;
    // What a catom of this process loses with its facts.
    void count_lost(Catom catom);
    void take_node(std::uint64_t id);
    Subdomain& subdomain_;
};

}  // namespace meld::sim
