// Turns touches into the links over which programs see neighbours; kept up to date from the contact events of the physics.
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <map>
#include <optional>
#include <span>
#include <vector>

#include "physics/scene/scene.h"
#include "runtime/sim/bodies/divided_bodies.h"
#include "runtime/sim/core/migration.h"
#include "runtime/sim/core/subdomain.h"

namespace meld::sim {

// A catom has as many links as there are ports, which equal spheres do not exceed unless they are pressed into each other. A touch beyond
// that becomes a link once both catoms have a free port.
class ContactLinks {
  public:
    // The numbers of two catoms.
    struct Pair {
        physics::BodyId first, second;
        auto operator<=>(const Pair&) const = default;
    };

    // After each step of the physics, on every process; `divided` if there are several. First notes which touches have begun and ended:
    // events are sorted; those that name obstacles are skipped. `parted`: touches that have ended as well, the same on all processes.
    void note(Subdomain& subdomain, std::span<const physics::TouchEvent> events, std::span<const physics::TouchEvent> parted,
              const DividedBodies* divided);
    // Then links those that touch and have a free port; the events are no longer needed. A catom of another process that begins to touch
    // one of ours becomes a ghost here.
    void connect(Subdomain& subdomain, const DividedBodies* divided);

    // Catoms with these numbers, sorted, no longer exist: their touches no longer wait.
    void forget(const std::vector<physics::BodyId>& lost);
    // Touches that wait for a port, the lower number first, sorted; those of catoms that migrate go with them.
    std::span<const Pair> waiting() const { return waiting_; }
    bool waits(const physics::ConnectionPair& pair) const { return std::ranges::binary_search(waiting_, Pair{pair.first, pair.second}); }
    // Adds some, and removes those that no longer involve a catom of this process.
    void change_hands(const Subdomain& subdomain, const std::vector<Pair>& arrived);

  private:
    // A port that a catom of another process reserves for one of ours.
    struct Offer {
        int port = 0;
        int owner = 0;
        world::Vec3 position = {};
        Migrant who = {};
    };
    std::vector<physics::TouchEvent> share(Subdomain& subdomain, std::span<const physics::TouchEvent> events,
                                           const DividedBodies& divided) const;
    void end(Subdomain& subdomain, const std::vector<Pair>& ended);
    void begin(std::vector<Pair> begun);
    void make_offers(const Subdomain& subdomain);
    int lowest_free_port(const Subdomain& subdomain, Catom catom);
    void exchange_offers(Subdomain& subdomain, const DividedBodies& divided);
    void connect_promised(Subdomain& subdomain);
    // A catom whose port is promised: one of ours, or the ghost of one that has offered it. None if there is no promise.
    struct Side {
        Catom catom;
        int port;
    };
    std::optional<Side> side(Subdomain& subdomain, physics::BodyId from, physics::BodyId to, int offered) const;

    std::vector<Pair> waiting_;
    // The promises of our catoms, for each touch that waits: the ports of the first and of the second, or -1.
    std::vector<std::array<std::int8_t, 2>> offered_;
    // The promises of catoms of other processes, from the first to the second.
    std::map<Pair, Offer> offers_;
    // By catom, the promised ports as bits; all zero between updates.
    std::vector<std::uint16_t> taken_;
};

// Removes a ghost that no longer touches anything of this process.
void forget_if_lonely(Subdomain& subdomain, Catom ghost);

}  // namespace meld::sim
