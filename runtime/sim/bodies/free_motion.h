// [motion] kind = "bodies": catoms are bodies that fall, touch, roll and pull on each other, moved by the physics between the ticks of
// their programs.
#pragma once

#include <cstdint>
#include <optional>
#include <set>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "physics/bodies/buffer.h"
#include "runtime/sim/bodies/body_actions.h"
#include "runtime/sim/bodies/body_connections.h"
#include "runtime/sim/bodies/body_joints.h"
#include "runtime/sim/bodies/contact_links.h"
#include "runtime/sim/bodies/divided_bodies.h"
#include "runtime/sim/bodies/fixed_touches.h"
#include "runtime/sim/bodies/joint_changes.h"
#include "runtime/sim/bodies/physics_scene.h"
#include "runtime/sim/bodies/senses/body_senses.h"
#include "runtime/sim/bodies/senses/lamps.h"
#include "runtime/sim/bodies/senses/light_sensors.h"
#include "runtime/sim/bodies/senses/load_senses.h"
#include "runtime/sim/bodies/senses/range_finders.h"
#include "runtime/sim/bodies/senses/surroundings.h"
#include "runtime/sim/core/extension.h"
#include "runtime/sim/core/subdomain.h"
#include "runtime/sim/points/range_links.h"
#include "runtime/sim/points/range_senses.h"

namespace meld::sim {

class FreeMotion : public SimModule {
  public:
    explicit FreeMotion(const world::World& world)
        : world_(world),
          connections_(world),
          joints_(world),
          joint_changes_(world),
          range_finders_(world),
          lamps_(world),
          light_sensors_(world) {
        if (world.links) in_range_.emplace(*world.links);
    }
    Result<void> start(Subdomain& subdomain) override;
    // Carries out the actions of the last tick, moves the bodies for the duration of a tick, and updates what the programs sense.
    Result<void> step(Subdomain& subdomain) override;
    // In a snapshot (saved_motion.cpp): the scene goes by its homes, and what contact links and fixed touches wait for by pairs.
    Result<void> saveable() const override { return {}; }
    Result<void> lose(Subdomain& subdomain, std::span<const Killed> killed) override;
    Result<void> resume(Subdomain& subdomain) override;
    void save_catoms(const Subdomain& subdomain, std::span<const Catom> catoms, ByteWriter& out) const override;
    void load_catoms(Subdomain& subdomain, std::span<const tuple::SavedCatom> catoms, ByteReader& in) override;
    void save_rest(const Subdomain& subdomain, ByteWriter& out) const override;
    Result<void> load_rest(Subdomain& subdomain, ByteReader& in) override;
    Result<void> resumed(Subdomain& subdomain) override;
    void struck(Subdomain& subdomain) override;
    void finish(Subdomain& subdomain) override;
    std::string status() const override;
    std::string outcome() const override;
    Stages stages() const override;

  private:
    // What all bodies of all processes are made of, which the scene must fit.
    struct Kinds {
        RadiusRange radii;
        std::set<Surface> surfaces;
        std::vector<MovedCatom> moved;
    };
    // What a snapshot has brought, until the scene is made of it.
    struct Loading {
        std::vector<physics::Buffer<std::byte>> bytes;  // Those of our homes.
        std::vector<physics::SavedHome> homes;
        std::vector<std::vector<std::byte>> scenes;  // What the scene of each process has kept besides.
        std::vector<std::pair<Catom, world::Vec3>> positions, sensed;
    };
    Result<void> check(const Subdomain& subdomain) const;
    // Finds what the program acts on and senses.
    Result<void> look_up(Subdomain& subdomain);
    Result<void> load_scene(Subdomain& subdomain);
    Result<void> place_catoms(Subdomain& subdomain);
    void tell_looks(Subdomain& subdomain);
    world::RoundedBody rounded_of(const Subdomain& subdomain, Catom catom) const;
    // Makes the same scene on all processes, with the bodies of this one.
    Result<void> make_scene(Subdomain& subdomain);
    Result<void> step_once(Subdomain& subdomain);
    // After the last step of a tick: finds what is around our bodies, if anybody looks.
    void look_around(Subdomain& subdomain);
    // Of a world whose neighbours are those within a range: places catoms where their bodies are, and links them.
    void find_in_range(Subdomain& subdomain);
    // After the first step: adds the touches that began in it to those of immovable and connected catoms.
    void note_fixed_touches(Subdomain& subdomain, std::span<const physics::TouchEvent> events);
    // Whether something will change, as far as this process knows.
    bool goes_on() const;
    void connect_bodies(Subdomain& subdomain);
    void drive_joints(Subdomain& subdomain);
    void change_joints(Subdomain& subdomain);
    void dim_lamps(Subdomain& subdomain);
    // After a step, on every process: tells of the joints that broke in it.
    void part_broken(Subdomain& subdomain);
    // After the last step of a tick: what connections carry, and those that break.
    Result<void> load_connections(Subdomain& subdomain);
    Result<physics::StepReport> move(Subdomain& subdomain);
    // Catoms below the lowest height that the world allows end the run, or are removed.
    Result<void> lose_catoms(Subdomain& subdomain);
    // Catoms of all processes, by their numbers.
    Result<void> take_out_all(Subdomain& subdomain, std::vector<physics::BodyId> ids);
    // The events of the last step, without lost catoms.
    std::span<const physics::TouchEvent> events();
    // Moves bodies and their catoms to the processes whose blocks they are in; returns whether any migrated.
    Result<bool> hand_over(Subdomain& subdomain, double step_s, int substeps);

    const world::World& world_;
    PhysicsScene physics_;
    Kinds kinds_;
    BodyActions actions_;
    BodySenses senses_;
    BodyConnections connections_;
    BodyJoints joints_;
    JointChanges joint_changes_;
    LoadSenses load_senses_;
    RangeFinders range_finders_;
    Lamps lamps_;
    LightSensors light_sensors_;
    // For line of sight, range finders and light.
    std::optional<BodySurroundings> surroundings_;
    ContactLinks links_;
    // If neighbours are those within a range, instead of those that touch.
    struct InRange {
        explicit InRange(const world::RangeOptions& options) : links(options.range), senses(options), sight(options.sight) {}
        RangeLinks links;
        RangeSenses senses;
        bool sight;
        std::uint64_t seen = 0;  // Links::version() when catoms last sensed their neighbours.
    };
    std::optional<InRange> in_range_;
    std::optional<DividedBodies> divided_;
    std::vector<physics::TouchEvent> fixed_touches_;  // Of this process, until they become links.
    std::uint64_t bodies_ = 0, awake_ = 0, connected_ = 0, joined_ = 0;
    std::uint64_t crossed_ = 0;                // Catoms that have migrated, not counting those that did before anything moved.
    std::vector<physics::BodyId> lost_;        // In the last tick, on all processes; sorted.
    std::vector<physics::TouchEvent> events_;  // If some catoms are lost.
    std::uint64_t lost_count_ = 0, broken_count_ = 0, broken_joints_ = 0;  // Of catoms, connections and joints.
    Loading loading_;
    bool moved_ = false;
    double energy_j_ = 0;
    double handing_over_s_ = 0, linking_s_ = 0, sensing_s_ = 0;
};

}  // namespace meld::sim
