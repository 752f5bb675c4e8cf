// What the connections of composites carry, and which of them break.
//
// A step adds up what acts on each member, in the frame of its composite: contacts and wrenches, gravity, and how the composite turns.
// `solve` takes the means since it was last called. A composite without a fixed member gets the acceleration and angular acceleration that
// these imply, so forces and inertia are in balance; otherwise the fixed members hold it. A composite that sleeps keeps what it carried.
#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <span>
#include <utility>
#include <vector>

#include "physics/bodies/composites.h"
#include "physics/statics/connection_load.h"
#include "runtime/base/bytes.h"
#include "runtime/base/error.h"
#include "runtime/base/process/parallel_for.h"

namespace meld::physics {

// Of one composite, connections that break in one call of `solve`.
inline constexpr int kMostBreaks = 16;

class Loads {
  public:
    Loads();
    ~Loads();
    Loads(const Loads&) = delete;
    Loads& operator=(const Loads&) = delete;

    // Computes loads even where nothing can break.
    void want() { wanted_ = true; }
    // Whether anybody wants them: otherwise nothing here costs anything.
    bool wanted() const { return wanted_ || !limits_.empty(); }
    void set_limits(BodyId body, const BreakingLimits& limits);
    BreakingLimits limits_of(BodyId body) const;
    void remove_body(BodyId body) { limits_.erase(body); }

    // At the beginning of a step. What was added up is lost if the members of some composite have changed.
    void begin(const Composites& composites, bool recomposed);
    // An impulse on a member (by its place among all), and the torque about its centre times time, as seen from the world.
    void push(const Composite& composite, std::uint32_t member, Vec3 impulse_ns, Vec3 turning_nms);
    // After a step: what the wrenches (null: none) and gravity did in it.
    void end_step(const Composites& composites, const Wrench* first, const Wrench* second, Vec3 gravity_m_s2, double step_s);
    // A step has failed, or nobody wants loads any more.
    void forget();

    // The loads of all composites that have moved or were awake since the last call, and the connections that break, sorted. Of each
    // composite the most overloaded connection breaks, then the loads of the parts are found anew, up to kMostBreaks times. The caller
    // releases them. Errors: the loads of a composite were not found.
    Result<std::vector<ConnectionPair>> solve(const Composites& composites, const Bodies& bodies, const BodyShapes& shapes,
                                              Workers& workers);
    // All, sorted; and one, if it was found.
    std::span<const CarriedLoad> all() const { return carried_; }
    std::optional<ConnectionLoad> of(BodyId one, BodyId other) const;

    void write(ByteWriter& out) const;
    void read(ByteReader& in);
    std::size_t bytes() const;

  private:
    // Over the time since the last call of solve; of a member, in the frame of its composite.
    struct Sums {
        double time_s = 0;
        Vec3 gravity;         // m/s
        Symmetric spin_spin;  // Products of the angular velocity's components, rad^2/s.
    };
    // The lattice of a composite, and where its connections sit, kept while it is the same.
    struct Kept;
    struct Solved;
    Solved solve_one(const Composites& composites, const Composite& composite, const Sums& sums, const Bodies& bodies,
                     const BodyShapes& shapes, Kept& kept) const;

    bool wanted_ = false;
    std::map<BodyId, BreakingLimits> limits_;  // Those that are not infinite.
    std::vector<Sums> sums_;
    std::vector<Pull> acted_;
    std::vector<Kept> kept_;
    std::vector<CarriedLoad> carried_;
};

}  // namespace meld::physics
