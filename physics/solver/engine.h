// The data of the world that all engines share, and the interface of an engine.
#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "physics/bodies/actuation.h"
#include "physics/bodies/bodies.h"
#include "physics/bodies/body_shape.h"
#include "physics/bodies/coils.h"
#include "physics/bodies/composites.h"
#include "physics/bodies/material.h"
#include "physics/bodies/prescribed_motion.h"
#include "physics/bodies/reports.h"
#include "physics/bodies/settings.h"
#include "physics/bodies/stage.h"
#include "physics/collision/obstacles.h"
#include "physics/joints/joints.h"
#include "physics/statics/loads.h"
#include "runtime/base/bytes.h"
#include "runtime/base/error.h"
#include "runtime/base/exact_sum.h"
#include "runtime/base/process/parallel_for.h"
#include "runtime/base/process/stage_clock.h"

namespace meld::physics {

// The state of the bodies before the last step, by slot, as far as the settings ask for it: velocities to compute accelerations, all of it
// to restore after an error.
struct LastGood {
    Buffer<BodyVelocity> velocity;
    Buffer<Place> place;
    Buffer<Orientation> orientation;
    // Whether all of it was copied in the present step: a step that fails before has changed nothing that must be restored.
    bool complete = false;
};

// The partner is a body or an obstacle's code (contacts.h).
Touch touch_of(BodyId body, std::uint32_t partner);

struct World {
    Settings settings;
    Bodies bodies;
    BodyShapes shapes;
    Composites composites;
    Joints joints;
    Loads loads;
    PrescribedBodies prescribed;
    Obstacles obstacles;
    std::vector<Material> materials{Material{}};
    std::vector<std::vector<Feature>> tables{{}};
    Coils coils;
    // The greatest of all tables; the last is of latches.
    double feature_range = 0, feature_depth = 0, latch_range = 0;
    std::vector<TouchEvent> events;
    double last_step_s = 0;
    std::uint64_t tick = 0;
    StageTimes times;
    LastGood last_good;

    Movers movers() { return {bodies, shapes, composites}; }

    // The error for a problem found in the present tick.
    tl::unexpected<Error> wrong(const std::string& problem, std::string suggestion) const;
    // The error for the body with the lowest number that is faster than the settings allow, or whose velocity is not a number.
    Result<void> check_speeds() const;
    // The error for two bodies that overlap by more than the settings allow; without the tick.
    Error overlapping(BodyId one, BodyId other, double overlap_m) const;
    tl::unexpected<Error> too_deep(BodyId one, BodyId other, double overlap_m) const;
    // The same for a body in an obstacle, without the tick; nothing if it is not too deep.
    Result<void> check_depth(BodyId body, double radius_m, std::uint32_t obstacle, double depth_m) const;
    // The greatest distance at which two features act on each other, surface to surface; 0 without features.
    double feature_range_m() const { return feature_range; }
    // The same for latches.
    double latch_range_m() const { return latch_range; }
    // The depth of the deepest feature below the surface.
    double feature_depth_m() const { return feature_depth; }
    void add_table(std::vector<Feature> features);
    // From the settings or the bodies; 2 m without bodies.
    double smallest_diameter_m() const;
    // Half of the least thickness of all bodies, from the settings or the bodies.
    double least_radius_m() const;
    bool has_features() const { return tables.size() > 1; }
    bool bounces() const;
    bool resists_turning() const;
};

class Engine {
  public:
    virtual ~Engine() = default;
    virtual Result<StepReport> step(const StepTimes& times, Workers& workers) = 0;
    // Bodies or obstacles were added or removed.
    virtual void structure_changed() = 0;
    // A body was pushed, switched or moved by the caller.
    virtual void body_changed(std::uint32_t slot, bool moved) = 0;
    // Gravity has changed: what slept may move.
    virtual void gravity_changed() = 0;
    // The bodies are again as before the step; nothing learnt in it is valid.
    virtual void state_restored() = 0;
    virtual bool asleep(std::uint32_t) const { return false; }
    // Whether it is the share of one process in a divided world.
    virtual bool divided() const { return false; }
    // Calls visit for all present touches, in no particular order; forces are averages over the last step.
    virtual void each_contact(const ContactVisitor& visit) const = 0;
    // Adds the normal forces that press (not those that pull) to the sums of the bodies they act on.
    virtual void add_normal_forces(std::span<ExactSum> of_slot, Workers& workers) const = 0;
    virtual std::size_t bytes() const = 0;
    virtual double residual() { return 0; }
    // Those that it moves: neither asleep nor ghosts.
    virtual std::size_t awake_bodies() const = 0;

    // ---- snapshots, between two steps (physics/scene/saved_scene.cpp)
    // The home of a body, and the slots of the bodies of a home, in the order in which they come back. Before the first step, a home has
    // the bodies in `known`; after it, all that it keeps there.
    virtual Home home(std::uint32_t) const { return 0; }
    virtual std::vector<std::uint32_t> slots_of(Home home, std::span<const std::uint32_t> known) const = 0;
    // What it keeps of the bodies of a home, which ghosts need too; and of their contacts, which only their owner has.
    virtual void save_home(Home, ByteWriter& bodies, ByteWriter& contacts) const = 0;
    // The bodies are in the slots from `first` on. The bytes of contacts stay until loaded(). Errors: what is invalid.
    virtual Result<void> load_home(Home, std::uint32_t first, Holds, ByteReader& bodies, ByteReader& contacts) = 0;
    // State that belongs to no home. It is loaded first, once for each subdomain that saved it.
    virtual void save_rest(ByteWriter&) const {}
    virtual void load_rest(ByteReader&) {}
    // All homes of this subdomain and around it are loaded.
    virtual Result<void> loaded(Workers&) { return {}; }
};

std::unique_ptr<Engine> make_block_engine(World& world);

}  // namespace meld::physics
