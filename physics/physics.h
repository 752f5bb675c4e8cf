// The physics of an ensemble: spheres that fall, touch, slide, roll and pull on each other, by the million.
//
//     auto scene = physics::Scene::make({});
//     scene->add_obstacle(physics::Plane{}, 0);
//     scene->add_body({.id = 0, .position = {0, 0, 3}});
//     Workers workers(2);
//     auto done = scene->step(1.0 / 240, 2, workers);
//
// Everything is in SI units. One thread calls a scene; `step` uses the workers it is given. The state after a step is the same,
// bit for bit, for any number of workers (with the Blocks engine, and with Ode, which uses only one). docs/physics.md says how it works.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "physics/actuation.h"
#include "physics/material.h"
#include "physics/obstacles.h"
#include "physics/types.h"
#include "runtime/base/error.h"
#include "runtime/base/exact_sum.h"
#include "runtime/base/hash.h"
#include "runtime/base/parallel_for.h"

namespace meld::physics {

enum class EngineKind {
    // The sparse grid of blocks and the coloured solver: deterministic, for millions of bodies.
    Blocks,
    // The seed design, for comparison: bins filled by atomic exchange, and a parallel sweep without locks, which is not
    // deterministic with several workers.
    Hash,
    // ODE as it is: a hash space and dWorldQuickStep, one thread, at most kMaxOdeBodies.
    Ode,
};

enum class SolverMode {
    // Soft contacts, warm started, with a relaxing pass: stacks stand. Only Blocks has them; the other engines take pgs20's
    // sweeps instead.
    Soft,
    // Projected Gauss-Seidel from nothing, with error reduction, as ODE's QuickStep.
    Pgs,
};

struct SolverSettings {
    SolverMode mode = SolverMode::Soft;
    // Sweeps over all colours in a substep, and how often each block is swept while it is in the cache.
    int sweeps = 2;
    int inner_sweeps = 1;
    // Soft: sweeps that take the pushing velocity out again.
    int relax_sweeps = 1;
    // Soft: how stiff, as a share of the substep rate, and how strongly damped contacts are.
    double stiffness_share = 0.25;
    double damping_ratio = 10;
    // Pgs: over-relaxation and the share of an overlap removed in a step (ODE's ERP).
    double over_relaxation = 1.3;
    double error_reduction = 0.2;
    // The fastest that an overlap is undone.
    double push_speed_m_s = 3;
    // Slower approaches do not bounce.
    double least_bounce_m_s = 0.05;

    // What ODE does by default: 20 cold sweeps.
    static SolverSettings pgs20();
};

struct Settings {
    EngineKind engine = EngineKind::Blocks;
    SolverSettings solver = {};
    Vec3 gravity_m_s2{0, 0, -9.81};
    // Velocities lose this share a second (in the limit of small steps).
    double linear_damping_per_s = 0;
    double angular_damping_per_s = 0;
    // Candidates are kept until something has moved half the skin; a share of the smallest body's diameter.
    double skin_share = 0.1;
    // Surfaces nearer than touch_m touch; they part when farther than part_m. Shares of the smallest diameter.
    double touch_share = 0.005;
    double part_share = 0.02;
    // A block sleeps when it and the blocks around have been slower than this for so many ticks; 0 ticks: never.
    int sleep_ticks = 30;
    double sleep_speed_m_s = 0.005;
    // The radii of all bodies lie between these, where a scene is part of a larger one and must cut space as all parts do; 0:
    // the bodies are asked.
    double least_radius_m = 0;
    double largest_radius_m = 0;
    // Limits beyond which a step ends with an error.
    double greatest_speed_m_s = 1000;
    double deepest_overlap_share = 0.5;
    // Keep a copy of the state before each step, to go back to when it ends with an error (80 bytes a body).
    bool keep_last_good = true;
    // Keep the velocities of before each step, of which accelerations come (32 bytes a body).
    bool keep_former_velocities = true;
};

struct BodySpec {
    BodyId id = 0;
    Vec3 position_m = {};
    Quat orientation = {};
    Vec3 velocity_m_s = {};
    Vec3 spin_rad_s = {};
    double radius_m = 0.5;
    double mass_kg = 1;
    // Moment of inertia / (mass radius^2): 0.4 for a solid ball, 2/3 for a hollow one.
    double inertia_factor = 0.4;
    std::uint8_t material = 0;
    // Moves only as its velocity says, whatever pushes it.
    bool fixed = false;
};

struct BodyState {
    Vec3 position_m = {};
    Quat orientation = {};
    Vec3 velocity_m_s = {};
    Vec3 spin_rad_s = {};
};

// By bit: which features are on, and which of them point inwards.
struct SwitchedFeatures {
    std::uint32_t on = 0, reversed = 0;
};

// A body and what it meets: another body, or an obstacle.
struct Touch {
    Touch() = default;
    Touch(BodyId body_id, std::uint32_t other_number, bool is_obstacle)
        : body(body_id), other(other_number & (kMaxBodies - 1)), other_is_obstacle(is_obstacle) {}
    BodyId body = 0;
    // In 31 bits, for in the first step of a pile there are three touches a body.
    std::uint32_t other : 31 = 0;
    bool other_is_obstacle : 1 = false;
    // In the order of body, other, and whether it is an obstacle.
    constexpr std::uint64_t key() const { return std::uint64_t{body} << 32 | std::uint64_t{other} << 1 | std::uint64_t{other_is_obstacle}; }
    bool operator==(const Touch& that) const { return key() == that.key(); }
    auto operator<=>(const Touch& that) const { return key() <=> that.key(); }
};
struct TouchEvent {
    Touch touch;
    bool began;
    auto operator<=>(const TouchEvent&) const = default;
};

struct ContactReport {
    Touch touch;
    // From the body to the other.
    Vec3 normal;
    double gap_m;
    // What the other feels, averaged over the step; the body feels the opposite. Negative: a latch holds.
    double normal_force_n;
    Vec3 friction_n;
};

using ContactVisitor = std::function<void(const ContactReport&)>;

struct StepReport {
    std::uint64_t tick = 0;
    std::size_t bodies = 0;
    std::size_t awake_bodies = 0;
    std::size_t blocks = 0;
    std::size_t candidates = 0;
    bool rebuilt = false;
};

// Seconds a stage has taken since the scene was made, by wall clock.
struct StageTimes {
    double sort = 0, pairs = 0, actuation = 0, refresh = 0, solve = 0, move = 0, events = 0;
    double total() const { return sort + pairs + actuation + refresh + solve + move + events; }
};

inline constexpr std::size_t kMaxOdeBodies = 131072;

class Engine;
struct World;

class Scene {
  public:
    // The error says which setting cannot be.
    static Result<std::unique_ptr<Scene>> make(const Settings& settings);
    ~Scene();
    Scene(const Scene&) = delete;
    Scene& operator=(const Scene&) = delete;

    // Building. Material 0 exists from the start.
    Result<std::uint8_t> add_material(Material material);
    Result<std::uint32_t> add_obstacle(Shape shape, std::uint8_t material);
    Result<std::uint16_t> add_feature_table(std::vector<Feature> features);
    // Room for so many bodies with ids below `ids`, so that arrays need not grow.
    void reserve(std::size_t bodies, std::size_t ids);
    Result<void> add_body(const BodySpec& spec);
    Result<void> remove_body(BodyId body);

    // Acting. A push stays until it is set again; it wakes the body.
    Result<void> set_state(BodyId body, const BodyState& state);
    Result<void> set_push(BodyId body, Vec3 force_n, Vec3 torque_nm);
    Result<void> set_feature_table(BodyId body, std::uint16_t table);
    // Bit i of `on`: feature i is on; of `reversed`: its magnet points inwards.
    Result<void> set_features(BodyId body, std::uint32_t on, std::uint32_t reversed);

    // One tick of dt_s seconds in so many substeps. After an error the state is that before the step (see keep_last_good)
    // and contacts begin without memory.
    Result<StepReport> step(double dt_s, int substeps, Workers& workers);

    // Reading. The body must exist (`has`).
    bool has(BodyId body) const;
    std::size_t body_count() const;
    std::vector<BodyId> bodies() const;
    BodyState state(BodyId body) const;
    // Change of velocity over the last step; 0 unless the settings keep former velocities.
    Vec3 acceleration(BodyId body) const;
    double radius(BodyId body) const;
    // About an axis through its centre, kg m^2.
    double moment_of_inertia(BodyId body) const;
    SwitchedFeatures features(BodyId body) const;
    // Sum of the normal forces on the body over its surface, Pa.
    double pressure(BodyId body);
    double energy_drawn_j(BodyId body) const;
    bool asleep(BodyId body) const;

    // Where the body is among all that the scene holds, below slot_count(); until the next step.
    std::uint32_t slot(BodyId body) const;
    std::size_t slot_count() const;

    // What began and ended to touch in the last step, sorted.
    std::span<const TouchEvent> events() const;
    // Gives their memory back where they are many, as they are when all that touches begins to.
    void forget_events();
    // All that touch now, sorted, each once; made when first asked for after a step.
    std::span<const ContactReport> contacts();
    // The same in no order, none of them kept, which costs a fraction.
    void each_contact(const ContactVisitor& visit) const;
    // Sums up by slot the normal forces in them that press on each body, N; in a divided world those that this part knows of, see
    // part.h. Cost: one pass over the contacts on all workers.
    void sum_normal_forces(std::vector<ExactSum>& of_slot, Workers& workers) const;
    // Those of one body (in some of them it is `other`), as indices into contacts().
    std::span<const std::uint32_t> contacts_of(BodyId body);

    // Kinetic and, in the gravity of the settings, potential energy; the sum of momenta.
    double kinetic_energy_j() const;
    double potential_energy_j() const;
    Vec3 momentum() const;
    Vec3 angular_momentum() const;

    // Of places, orientations and velocities of all bodies; their order is nothing.
    Digest digest() const;
    std::uint64_t tick() const;
    StageTimes stage_times() const;
    std::size_t bytes() const;
    // Residual of the contact equations at the present velocities (see docs/physics.md); for studies.
    double residual();

    // For code that steps by stages (part.h): the contacts that were asked for are no longer those that are.
    void forget_contacts() { contacts_known_ = false; }
    // The engine underneath, for code within physics and its tests.
    World& world() { return *world_; }
    Engine& engine() { return *engine_; }

  private:
    explicit Scene(const Settings& settings);
    Result<void> known(BodyId body) const;

    std::unique_ptr<World> world_;
    std::unique_ptr<Engine> engine_;
    std::vector<ContactReport> contacts_;
    std::vector<std::uint32_t> contact_start_, contact_index_;
    bool contacts_known_ = false;
};

}  // namespace meld::physics
