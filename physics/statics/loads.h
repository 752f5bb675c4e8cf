// What the connections of composites carry, and which of them break.
//
// A step adds up what acts on each member, in the frame of its composite: contacts and wrenches, gravity, and how the composite turns.
// `solve` takes the means since it was last called. A composite without a fixed member gets the acceleration and angular acceleration that
// these imply, so forces and inertia are in balance; otherwise the fixed members hold it. A composite that sleeps keeps what it carried.
//
// In a divided world, each subdomain that has a composite finds its loads, all from the same sums. What contacts do is noted by the owner
// of their block, and added up by all that have the composite in the order in which an undivided world adds it up.
#pragma once

#include <cstdint>
#include <functional>
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
    // An impulse on a member (by its place among all), and the torque about its centre times time, as seen from the world. `order`: when an
    // undivided world adds what a contact does in this step.
    struct Order {
        // The same for all contacts that are added up together, one after the other; then by block, by its index here.
        std::uint32_t turn = 0, block = 0;
    };
    void push(const Composites& composites, std::uint32_t composite, std::uint32_t member, Vec3 impulse_ns, Vec3 turning_nms, Order order);
    // The same of what all that have the composite know, on a body that is a member: added up at once.
    void add_push(const Composites& composites, BodyId body, Vec3 impulse_ns, Vec3 turning_nms);
    // After a step: what the wrenches (null: none) and gravity did in it.
    void end_step(const Composites& composites, const Wrench* first, const Wrench* second, Vec3 gravity_m_s2, double step_s);
    // A step has failed, or nobody wants loads any more.
    void forget();

    // What contacts did in this step is noted, until add_noted adds it up: of our blocks, and of those of other subdomains.
    void note_pushes() { notes_ = true; }
    struct Noted {
        std::uint64_t block;
        std::uint32_t turn;
        BodyId member;
        Pull pull;
    };
    std::span<Noted> noted() { return noted_; }
    std::span<const Noted> noted() const { return noted_; }
    void add_note(const Noted& push) { noted_.push_back(push); }
    void add_noted(const Composites& composites);

    // Composites that are here have changed their places among all, or come from another subdomain: first takes what is known of each out,
    // by its lowest body; then puts it where its composite is now.
    struct OfComposite;
    using OfComposites = std::map<BodyId, OfComposite>;
    OfComposites take_out(const Composites& composites);
    void put_in(OfComposites of, const Composites& composites);
    void write(const Composites& composites, const Composite& composite, ByteWriter& out) const;
    static OfComposite read_one(ByteReader& in);

    // The loads of all composites that have moved or were awake since the last call, and the connections that break, sorted. Of each
    // composite the most overloaded connection breaks, then the loads of the parts are found anew, up to kMostBreaks times. The caller
    // releases them. Errors: the loads of a composite were not found.
    Result<std::vector<ConnectionPair>> solve(const Composites& composites, const Bodies& bodies, const BodyShapes& shapes,
                                              Workers& workers);
    // All, sorted; and one, if it was found.
    std::span<const CarriedLoad> all() const { return carried_; }
    std::optional<ConnectionLoad> of(BodyId one, BodyId other) const;

    // `divided`: of loads those for which `ours` says so of the lower body. Adds what was written, several times in a divided world.
    void write(ByteWriter& out, bool divided, const std::function<bool(BodyId)>& ours) const;
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
    void add(const Composites& composites, BodyId body, const Pull& pull);
    Solved solve_one(const Composites& composites, const Composite& composite, const Sums& sums, const Bodies& bodies,
                     const BodyShapes& shapes, Kept& kept) const;

    bool wanted_ = false;
    std::map<BodyId, BreakingLimits> limits_;  // Those that are not infinite.
    std::vector<Sums> sums_;
    std::vector<Pull> acted_;
    std::vector<Kept> kept_;
    std::vector<CarriedLoad> carried_;
    std::vector<Noted> noted_;
    bool notes_ = false;
};

struct Loads::OfComposite {
    Sums sums;
    std::vector<Pull> acted;
    std::vector<CarriedLoad> carried;
};

}  // namespace meld::physics
