// What catoms sense of the loads of their connections and joints, and of those that broke.
#pragma once

#include <array>
#include <optional>
#include <span>
#include <vector>

#include "runtime/module/abi/senses.h"
#include "runtime/sim/bodies/physics_scene.h"
#include "runtime/sim/core/subdomain.h"

namespace meld::sim {

class LoadSenses {
  public:
    // Finds what the program reads.
    void start(const Subdomain& subdomain, const world::World& world);
    // Whether the program reads loads.
    bool reads_loads() const { return load_.has_value(); }
    // Tells both catoms of each connection that has broken; and the loads of all others, where they have changed by more than the world's
    // threshold. Every process calls both. Cost: one pass over the catoms on all workers, if the program reads them.
    void note_broken(Subdomain& subdomain, std::span<const physics::ConnectionPair> broken) const;
    void sense(Subdomain& subdomain, const physics::Scene& scene) const;
    // Before bodies are removed: those that stay sense nothing of their connections with them any more.
    void lose(Subdomain& subdomain, const physics::Scene& scene, std::span<const physics::BodyId> lost) const;

  private:
    // What a catom has sensed of a connection or a joint.
    struct Reading {
        u64 other = 0;
        double tension_n = 0, shear_n = 0, torque_nm = 0;
        bool operator==(const Reading&) const = default;
    };
    // Changes that count however small the load was: rounding is far below them.
    struct Least {
        double force_n = 0, torque_nm = 0;
    };
    std::vector<Reading> sensed(const Subdomain& subdomain, Catom catom) const;
    static std::array<Value, 4> arguments_of(const Reading& reading);
    static void change(Subdomain& subdomain, u32 predicate, Catom catom, const Reading& reading, bool holds, int worker);
    bool differs(const Reading& last, const Reading& now, const Least& least) const;
    // Whether something has changed.
    bool sense_catom(Subdomain& subdomain, const physics::Scene& scene, Catom catom, const Least& least, int worker) const;

    std::optional<u32> load_, broke_;
    double threshold_ = 0;
};

}  // namespace meld::sim
