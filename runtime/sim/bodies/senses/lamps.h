// The lamps of a world, [[motion.lamp]]: those that stand somewhere, those that catoms carry, and the action `lamp`.
//
// Every process knows all of them, since each may shine on any catom.
#pragma once

#include <cstddef>
#include <optional>
#include <span>
#include <vector>

#include "physics/scene/scene.h"
#include "runtime/base/bytes.h"
#include "runtime/sim/core/subdomain.h"

namespace meld::sim {

// An action on the lamps of a catom.
struct AskedLamp {
    Catom catom = 0;
    double share = 0;  // Of their power.
};

// A lamp that shines.
struct Shining {
    physics::Vec3 place_m;
    double power_w = 0;
    double reach_m = 0;                   // Infinite if it has none.
    std::optional<physics::BodyId> body;  // Who carries it.
};

class Lamps {
  public:
    explicit Lamps(const world::World& world) : world_(world) {}
    // At the start, on every process, while catoms know their start cells: finds those that carry lamps. Warns of regions without catoms.
    void find(Subdomain& subdomain);
    // On every process: dims the lamps of those that asked; of several wishes of one catom the brightest counts. Shares beyond 0 and 1
    // count as these. Returns the catoms that carry none.
    std::vector<Catom> carry_out(Subdomain& subdomain, std::span<const AskedLamp> asked);
    // Catoms of all processes, sorted, that are no longer there.
    void lose(std::span<const physics::BodyId> lost);
    // On every process, after the last step of a tick: where lamps are. Cost: an exchange of the places of those that catoms carry.
    void place(Subdomain& subdomain, const physics::Scene& scene);
    // Since then: those of the world, then those of catoms in the order of their numbers. The same on all processes.
    std::span<const Shining> shining() const { return shining_; }
    // What differs from the world's start.
    void save(ByteWriter& out) const;
    void load(ByteReader& in);

  private:
    struct Carried {
        physics::BodyId body = 0;
        std::uint32_t lamp = 0;  // Which [[motion.lamp]].
        double share = 1;
        bool operator<(const Carried& other) const { return body != other.body ? body < other.body : lamp < other.lamp; }
    };
    bool is_carried(std::size_t lamp) const { return !world_.physics.lamps[lamp].position; }
    Shining shining_at(physics::Vec3 place_m, std::size_t lamp, double share) const;

    const world::World& world_;
    std::vector<Carried> carried_;  // Sorted.
    std::vector<Shining> shining_;
};

}  // namespace meld::sim
