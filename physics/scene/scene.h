// The physics of an ensemble: spheres, boxes and capsules that fall, touch, slide, roll and pull on each other, by the million.
//
//     auto scene = physics::Scene::make({});
//     scene->add_obstacle(physics::Plane{}, 0);
//     scene->add_body({.id = 0, .position = {0, 0, 3}});
//     Workers workers(2);
//     auto done = scene->step(1.0 / 240, 2, workers);
//
// All quantities are in SI units. One thread calls a scene; `step` uses the workers it is given. The state after a step is the same, bit
// for bit, for any number of workers (with the Blocks engine, and with Ode, which uses only one). docs/physics.md explains how it works.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "physics/bodies/actuation.h"
#include "physics/bodies/body_shape.h"
#include "physics/bodies/material.h"
#include "physics/bodies/prescribed_motion.h"
#include "physics/bodies/reports.h"
#include "physics/bodies/settings.h"
#include "physics/bodies/symmetric.h"
#include "physics/bodies/types.h"
#include "physics/collision/core_contacts.h"
#include "physics/collision/obstacles.h"
#include "physics/joints/joint.h"
#include "physics/statics/connection_load.h"
#include "runtime/base/bytes.h"
#include "runtime/base/error.h"
#include "runtime/base/exact_sum.h"
#include "runtime/base/hash.h"
#include "runtime/base/process/parallel_for.h"

namespace meld::physics {

struct BodySpec {
    BodyId id = 0;
    Vec3 position_m = {};
    Quat orientation = {};
    Vec3 linear_velocity_m_s = {};
    Vec3 angular_velocity_rad_s = {};
    double radius_m = 0.5;
    double mass_kg = 1;
    // Moment of inertia / (mass radius^2): 0.4 for a solid ball, 2/3 for a hollow one.
    double inertia_factor = 0.4;
    std::uint8_t material = 0;
    // Moves only at its own velocity, whatever forces act on it.
    bool fixed = false;
    // If it has one, radius and inertia factor follow from it. The engine Hash has no shapes.
    std::optional<BodyShape> shape = {};
};

struct BodyState {
    Vec3 position_m = {};
    Quat orientation = {};
    Vec3 linear_velocity_m_s = {};
    Vec3 angular_velocity_rad_s = {};
};

// As bits: which features are on, and which of them point inwards.
struct SwitchedFeatures {
    std::uint32_t on = 0, reversed = 0;
};

// Bodies that are rigidly connected, as one.
struct CompositeState {
    std::size_t bodies = 0;
    double mass_kg = 0;
    Vec3 centre_m = {};
    Vec3 linear_velocity_m_s = {};
    Vec3 angular_velocity_rad_s = {};
    // About its centre, along the axes of the world, kg m^2.
    Symmetric inertia_kg_m2 = {};
    // One of its bodies is fixed and carries it; its place and motion are given as that body's.
    bool carried = false;
};

class Engine;
struct World;

// A home in a snapshot. The bytes are those of the reader.
struct SavedHome {
    Home home = 0;
    std::span<const std::byte> bodies = {}, contacts = {};

    void write(ByteWriter& out) const;
    static SavedHome read(ByteReader& in);
    // Where its bodies are, for somebody who makes no scene of them. Errors: the bytes end too early.
    struct SavedPlace {
        BodyId body;
        Vec3 position_m;
    };
    Result<std::vector<SavedPlace>> places() const;
};

class Scene {
  public:
    // The error names the invalid setting.
    static Result<std::unique_ptr<Scene>> make(const Settings& settings);
    ~Scene();
    Scene(const Scene&) = delete;
    Scene& operator=(const Scene&) = delete;

    // Building. Material 0 exists from the start.
    Result<std::uint8_t> add_material(Material material);
    Result<std::uint32_t> add_obstacle(Shape shape, std::uint8_t material);
    Result<std::uint16_t> add_feature_table(std::vector<Feature> features);
    // Prescribed motions: from the first step on, if all have the same length and substeps, a fixed body is where its motion says, and what
    // touches it feels its velocity. Given to all subdomains alike, whether the body is here or not; a new scene for a snapshot has the
    // same ones. `start`: where the body is before the first step. Not with the engine Hash. Errors: a number that is not finite, a
    // frequency below 0. Cost of a substep: in proportion to such bodies.
    Result<std::uint32_t> add_motion(const PrescribedMotion& motion);
    Result<void> prescribe(BodyId body, std::uint32_t motion, const PrescribedMotion::Place& start);
    // The surface of an obstacle runs round about this vector and takes along what touches it (Obstacles::set_belt), m/s; nothing if it is
    // 0. Once for an obstacle, and not with the engine Hash.
    Result<void> set_belt(std::uint32_t obstacle, Vec3 belt_m_s);
    // An obstacle of any kind moves from now on as prescribed bodies do, with its belt; without a pivot about its middle
    // (Obstacles::set_motion). What it may meet stays awake. Once for an obstacle, before the first step, on all subdomains alike, and not
    // with the engine Hash. Errors: a number that is not finite, a frequency below 0. Cost: each contact with it takes some nanoseconds
    // more in a substep, and lists of contacts are made again whenever it has come as far as the radius of the smallest body.
    Result<void> move_obstacle(std::uint32_t obstacle, const PrescribedMotion& motion);
    // Reserves memory for `bodies` bodies with ids below `ids`, so that arrays need not grow.
    void reserve(std::size_t bodies, std::size_t ids);
    Result<void> add_body(const BodySpec& spec);
    // A body that another subdomain has, to which joints lead from here; before the world is divided (subdomain.h).
    Result<void> add_ghost(const BodySpec& spec);
    Result<void> remove_body(BodyId body);

    // From the next step on; on all subdomains alike. Wakes all bodies, unless it is the present gravity. Errors: it is not finite.
    Result<void> set_gravity(Vec3 gravity_m_s2);
    Vec3 gravity_m_s2() const;

    // Acting. A wrench stays until it is set again; setting it wakes the body.
    Result<void> set_state(BodyId body, const BodyState& state);
    Result<void> set_wrench(BodyId body, Vec3 force_n, Vec3 torque_nm);
    Result<void> set_feature_table(BodyId body, std::uint16_t table);
    // Bit i of `on`: feature i is on; of `reversed`: its magnet points inwards.
    Result<void> set_features(BodyId body, std::uint32_t on, std::uint32_t reversed);
    // The current of an electromagnet, A, or the voltage of a plate or an electrode, V, from now on, while it is on. What is switched on
    // has the current or the voltage of its table until then. Errors: another feature; a value that is negative or not finite.
    Result<void> set_supply(BodyId body, std::size_t feature, double level);

    // Connections (scene_connections.cpp) hold two bodies rigidly where they are. Bodies that connections join, however indirectly, move as
    // one composite from the next step on: it has the sums of their masses, momenta and angular momenta, and they do not touch each other.
    // Those that are released go on with the velocities that they have as parts of it. A composite with a fixed body is carried by it (by
    // the one with the lowest number). Both may be called when it is so already. Only the engine Blocks has connections. Cost: the smaller
    // of the two parts, and in the next step, one pass over the bodies of the composite and a new candidate list.
    Result<void> connect(BodyId body, BodyId other);
    Result<void> release(BodyId body, BodyId other);
    // The scene is, or will be, the share of a subdomain (subdomain.h). All subdomains make and break all connections alike, whether the
    // bodies are here or not.
    void share() { shared_ = true; }
    // All subdomains have all bodies with joints or connections, wherever these are: a world needs that which has both. On all alike,
    // before the first step or the step after loading.
    void have_all_joined() { has_all_joined_ = true; }
    bool has_all_joined() const { return has_all_joined_; }
    // Of a body that is removed elsewhere.
    void release_all(BodyId body);
    // Whether connections lead from one to the other.
    bool together(BodyId body, BodyId other) const;
    bool connected(BodyId body, BodyId other) const;
    // The bodies connected to it directly; valid until the next call that connects or releases.
    std::span<const BodyId> connected_to(BodyId body) const;
    std::size_t connection_count() const;
    // All connections, the lower number first; sorted.
    std::vector<std::pair<BodyId, BodyId>> connections() const;
    // Whether a touch that the bodies' connections have ended goes on as far as anybody can see: both are parts of one composite, or fixed
    // bodies at rest carry both. Such a touch has no forces and no events. The bodies exist; as of the last step.
    bool lasts(const Touch& touch) const;
    // The composite that a body was part of in the last step.
    std::optional<CompositeState> composite(BodyId body) const;

    // Joints (scene_joints.cpp) let two bodies turn or slide against each other and hold them otherwise; the two do not collide. One may be
    // fixed, and two bodies have one joint at most. A joint of a body that is part of a composite acts on the composite, at that body; it
    // is idle while both of its bodies are parts of one, or nothing can move them. It ends with one of its bodies, or breaks at the end of
    // a step in which it carried more than it can: of those that hang together, the one that did so by the greatest factor. The engines
    // Blocks and Ode have joints. Cost of a step: in proportion to the joints, but for loops.
    // They are added before the world is divided (subdomain.h); or later where all subdomains have all of them, which add and remove them
    // alike: then the caller says where the two are, since a body that has had no joint yet may be elsewhere until the next step.
    Result<void> add_joint(const JointSpec& joint);
    Result<void> add_joint(const JointSpec& joint, const JointPose& first, const JointPose& second);
    // The two have a joint. They collide from the next step on.
    Result<void> remove_joint(BodyId body, BodyId other);
    JointPose pose(BodyId body) const;
    // What moves a body that is here, as of the last step: itself, or the lowest body of its composite; kMaxBodies if nothing can.
    BodyId mover_of(BodyId body) const;
    // The two have a joint that moves along an axis.
    Result<void> drive_joint(BodyId body, BodyId other, const JointDrive& drive);
    bool joined(BodyId body, BodyId other) const;
    // Sorted; valid until a joint begins or ends.
    std::span<const BodyId> joined_to(BodyId body) const;
    // In a divided world, of those that this subdomain counts, so that the sum over all is the count.
    std::size_t joint_count() const;
    bool counts(const Joint& joint) const;
    std::optional<JointKind> joint_kind(BodyId body, BodyId other) const;
    // Whether they have a joint whose motor has any strength.
    bool has_motor(BodyId body, BodyId other) const;
    // None if the two have no joint; zeros for a ball.
    std::optional<JointState> joint(BodyId body, BodyId other) const;
    // All of them, in the order of their bodies; valid until one begins or ends.
    std::span<const Joint> joints() const;
    // Where the halves of its anchor are, m, and its axis.
    struct JointPlace {
        Vec3 first_anchor_m, second_anchor_m, axis;
    };
    JointPlace place_of(const Joint& joint) const;
    // As of the last solve_loads, the mean over the steps before it; none if the two have no joint.
    std::optional<JointLoad> joint_load(BodyId body, BodyId other) const;
    // Those that broke in the last step, the lower body first; sorted.
    std::span<const ConnectionPair> broken_joints() const;

    // Loads: what connections carry. They are computed if somebody wants them, or some body has limits.
    void want_loads();
    // The connections of a body break if they carry more than this; of its limits and those of the other body the lower ones count. Errors:
    // a limit that is not above 0.
    Result<void> set_breaking(BodyId body, const BreakingLimits& limits);
    // The loads of all connections and joints over the steps since the last call, as means; those of what slept stay as they were. Breaks
    // the most overloaded connection of each composite, then finds the loads of the parts anew, at most 16 times; returns what broke,
    // sorted. Connections that are made or broken take effect in the next step. Cost: in proportion to the connections; see
    // docs/physics.md.
    Result<std::vector<ConnectionPair>> solve_loads(Workers& workers);
    // As of the last solve_loads; none if the two were not connected then. And all of them, sorted.
    std::optional<ConnectionLoad> load(BodyId body, BodyId other) const;
    std::span<const CarriedLoad> loads() const;

    // One tick of dt_s seconds, in `substeps` substeps. After an error the state is that before the step (see keep_last_good) and contacts
    // start without warm-start impulses.
    Result<StepReport> step(double dt_s, int substeps, Workers& workers);

    // Reading. The body must exist (`has`).
    bool has(BodyId body) const;
    std::size_t body_count() const;
    std::vector<BodyId> bodies() const;
    BodyState state(BodyId body) const;
    // Change of velocity over the last step; 0 unless the settings keep former velocities.
    Vec3 acceleration(BodyId body) const;
    // Of a body with a shape that of the sphere around it.
    double radius(BodyId body) const;
    std::optional<BodyShape> shape(BodyId body) const;
    double surface_m2(BodyId body) const;
    // Whether two bodies are nearer to each other than this, surface to surface.
    bool nearer(BodyId body, BodyId other, double within_m) const;
    // About an axis through its centre, kg m^2; of a body with a shape the mean of those about its axes.
    double moment_of_inertia(BodyId body) const;
    SwitchedFeatures features(BodyId body) const;
    // The sum of the normal forces on the body divided by its surface, Pa.
    double pressure(BodyId body);
    double energy_drawn_j(BodyId body) const;
    // Of the coil of a magnet; of other features that of their surroundings.
    double temperature_k(BodyId body, std::size_t feature) const;
    // Whether any coil has yet to warm or cool by more than this, K, as it is switched now. Cost: in proportion to the warm ones.
    bool warming(double by_k) const;
    bool asleep(BodyId body) const;
    bool fixed(BodyId body) const;
    std::size_t awake_bodies() const;

    const Obstacles& obstacles() const;

    // The slot of the body, below slot_count(); valid until the next step.
    std::uint32_t slot(BodyId body) const;
    std::size_t slot_count() const;

    // The touches that began and ended in the last step, sorted.
    std::span<const TouchEvent> events() const;
    // Frees the memory of the events if there are many, as in the first step of a pile.
    void forget_events();
    // All present touches, sorted; computed when first asked for after a step. Surfaces of triangles and compounds have one for each two
    // parts that touch, all others one.
    std::span<const ContactReport> contacts();
    // The same, unordered and not stored, at a fraction of the cost.
    void each_contact(const ContactVisitor& visit) const;
    // Adds the normal forces that press on each body, N, by slot; in a divided world those known to this subdomain, see subdomain.h. Cost:
    // one pass over the contacts on all workers.
    void sum_normal_forces(std::vector<ExactSum>& of_slot, Workers& workers) const;
    // The contacts of one body (in some of them it is `other`), as indices into contacts().
    std::span<const std::uint32_t> contacts_of(BodyId body);

    // Kinetic energy, potential energy in the gravity of the settings, and the sum of momenta.
    double kinetic_energy_j() const;
    double potential_energy_j() const;
    Vec3 momentum() const;
    Vec3 angular_momentum() const;

    // A digest of the positions, orientations and velocities of all bodies; it does not depend on their order.
    Digest digest() const;
    std::uint64_t tick() const;
    StageTimes stage_times() const;
    std::size_t bytes() const;
    // Residual of the contact equations at the present velocities (see docs/physics.md); for studies.
    double residual();

    // ---- snapshots between two steps (saved_scene.cpp)
    // Bodies are saved by their homes, with all that the next steps depend on. A new scene with the same settings, materials, obstacles and
    // feature tables, and without bodies, loads the rest first, then homes in any order, then all is `loaded`: its steps are those of the
    // scene that was saved, bit for bit. Touches of bodies removed since the last step end without an event. The engine Hash is the same
    // with one worker only.
    Home home(BodyId body) const;
    // `bodies`: those that live there. Also saves those that were removed since the last step.
    void save_home(Home home, std::span<const BodyId> bodies, ByteWriter& out) const;
    void save_rest(ByteWriter& out) const;
    // In a divided world, what each subdomain has saved, one after the other.
    void load_rest(ByteReader& in);
    // The bytes of the contacts of own bodies are read until all is loaded. Errors: what is invalid.
    Result<void> load_home(const SavedHome& saved, Holds holds);
    Result<void> loaded(Workers& workers);

    // For code that steps by stages (subdomain.h): drops the contacts that contacts() has computed.
    void forget_contacts() { contacts_known_ = false; }
    // The engine underneath, for code within physics and its tests.
    World& world() { return *world_; }
    Engine& engine() { return *engine_; }

  private:
    explicit Scene(const Settings& settings);
    Result<void> known(BodyId body) const;
    void joints_changed(BodyId body, BodyId other);
    // Bodies that joints hold to this one may be far away and asleep.
    void wake_joined(BodyId body);
    // Of the body in a slot, and its angular momentum about its centre per kg.
    Vec3 spin_of(std::uint32_t slot) const;
    Vec3 spin_momentum(std::uint32_t slot) const;
    Result<void> check_shape(const BodySpec& spec) const;
    double depth_in(std::uint32_t obstacle, const BodySpec& spec) const;
    double depth_in(std::uint32_t obstacle, const PlacedSolid& solid) const;

    std::unique_ptr<World> world_;
    std::unique_ptr<Engine> engine_;
    std::vector<ContactReport> contacts_;
    std::vector<std::uint32_t> contact_start_, contact_index_;
    bool contacts_known_ = false;
    bool shared_ = false, has_all_joined_ = false;
};

}  // namespace meld::physics
