// The world's data that all engines share, and the interface of an engine.
#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "physics/actuation.h"
#include "physics/bodies.h"
#include "physics/material.h"
#include "physics/obstacles.h"
#include "physics/reports.h"
#include "physics/settings.h"
#include "physics/stage.h"
#include "runtime/base/error.h"
#include "runtime/base/exact_sum.h"
#include "runtime/base/parallel_for.h"
#include "runtime/base/stage_clock.h"

namespace meld::physics {

// The bodies as they were before the last step, by slot, as far as the settings ask for them: velocities for accelerations, all to
// go back to.
struct LastGood {
    Buffer<BodyVelocity> velocity;
    Buffer<Place> place;
    Buffer<Orientation> orientation;
    // Whether all of it was taken in the present step: one that fails earlier has nothing to go back to, and need not.
    bool complete = false;
};

// The partner is a body or an obstacle's code (contacts.h).
Touch touch_of(BodyId body, std::uint32_t partner);

struct World {
    Settings settings;
    Bodies bodies;
    Obstacles obstacles;
    std::vector<Material> materials{Material{}};
    std::vector<std::vector<Feature>> tables{{}};
    // Of all tables.
    double feature_range = 0, feature_depth = 0;
    std::vector<TouchEvent> events;
    double last_step_s = 0;
    std::uint64_t tick = 0;
    StageTimes times;
    LastGood last_good;

    // The error for something found wrong in the present tick.
    tl::unexpected<Error> wrong(const std::string& problem, std::string suggestion) const;
    // The error for the body with the lowest number that is faster than the settings allow, or whose velocity is not a number.
    Result<void> check_speeds() const;
    // The error for two bodies that overlap by more than the settings allow.
    tl::unexpected<Error> too_deep(BodyId one, BodyId other, double overlap_m) const;
    // The same for a body in an obstacle, without the tick: nothing, if it is not so deep.
    Result<void> check_depth(BodyId body, double radius_m, std::uint32_t obstacle, double depth_m) const;
    // The farthest that two features act on each other, surface to surface; 0 without features.
    double feature_range_m() const { return feature_range; }
    // How deep below the surface the deepest acts.
    double feature_depth_m() const { return feature_depth; }
    void add_table(std::vector<Feature> features);
    // By what the settings or the bodies say; 2 m without bodies.
    double smallest_diameter_m() const;
    bool has_features() const { return tables.size() > 1; }
    bool bounces() const;
};

class Engine {
  public:
    virtual ~Engine() = default;
    virtual Result<StepReport> step(const StepTimes& times, Workers& workers) = 0;
    // Bodies or obstacles were added or removed.
    virtual void structure_changed() = 0;
    // A body was pushed, switched or put elsewhere.
    virtual void body_changed(std::uint32_t slot, bool moved) = 0;
    // The bodies are again as before the step; nothing learnt in it holds.
    virtual void state_restored() = 0;
    virtual bool asleep(std::uint32_t) const { return false; }
    // Calls visit for what touches now, in no order; forces are averages over the last step.
    virtual void each_contact(const ContactVisitor& visit) const = 0;
    // Adds the normal forces in them that press to the sums of the bodies they press on.
    virtual void add_normal_forces(std::span<ExactSum> of_slot, Workers& workers) const = 0;
    virtual std::size_t bytes() const = 0;
    virtual double residual() { return 0; }
};

std::unique_ptr<Engine> make_block_engine(World& world);

}  // namespace meld::physics
