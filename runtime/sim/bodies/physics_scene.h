// Makes a scene of the physics from a world with bodies.
#pragma once

#include <compare>
#include <limits>
#include <map>
#include <memory>
#include <optional>
#include <set>
#include <unordered_map>
#include <vector>

#include "physics/scene/scene.h"
#include "runtime/sim/bodies/fixed_touches.h"
#include "runtime/world/description/compounds.h"
#include "runtime/world/description/world.h"
#include "runtime/world/shapes/rounded_body.h"

namespace meld::sim {

// The scene without bodies: settings, ground and obstacles, features. Errors name the place in the world file if there is one.
struct RadiusRange {
    double min = 0, max = 0;
    // Half of the least thickness of any body: less than the least radius where some have shapes.
    double least = 0;
};
// Of the bodies of both.
RadiusRange both(const RadiusRange& a, const RadiusRange& b);
// Heights of centres against gravity, m.
struct HeightRange {
    double low = std::numeric_limits<double>::infinity(), high = -low;
};
struct PhysicsScene {
    std::unique_ptr<physics::Scene> scene;
    std::vector<physics::Feature> features;  // The features of every catom, in the order of their numbers; empty: none.
    std::uint16_t feature_table = 0;
    double touch_m = 0;  // Surfaces nearer than this touch.
};
// `radii`: of all bodies of all processes; senses_acceleration: whether the program senses it.
Result<PhysicsScene> make_physics_scene(const world::World& world, RadiusRange radii, bool senses_acceleration);

// The body of a catom.
struct Surface {
    double friction = 0, restitution = 0;
    double rolling_friction = 0, spinning_friction = 0;  // Diameters.
    auto operator<=>(const Surface&) const = default;
};

// A catom that moves by a script, and where it starts.
struct MovedCatom {
    physics::BodyId body = 0;
    std::uint32_t mover = 0;
    physics::PrescribedMotion::Place start = {};
};
// Adds the motions of the world's movers, and says which catoms of all processes have which; the same on all processes.
Result<void> add_movers(const world::World& world, PhysicsScene& scene, std::span<const MovedCatom> catoms);

// Adds a material for each, in the same order on all processes.
Result<std::map<Surface, std::uint8_t>> add_materials(const world::World& world, PhysicsScene& scene, const std::set<Surface>& surfaces);

// Gives catoms their bodies: a first pass examines all of them; then the scene is made to fit the bodies of all processes, and their
// materials are added in the same way everywhere; then each catom's body is made. Computing its properties twice saves the memory for
// storing them all.
class BodyMaker {
  public:
    // `catoms`: of all processes; the last of them are those at listed positions.
    BodyMaker(const world::World& world, std::uint64_t catoms)
        : world_(world),
          compounds_(world::compounds_of(world.physics, 2 * world.radius)),
          first_placed_(catoms - world.placed.size()),
          groups_met_(world.physics.groups.size()),
          movers_met_(world.physics.movers.size()) {
        for (std::size_t i = 0; i < world.physics.joints.size(); ++i)
            if (!world.physics.joints[i].between) joined_in_[i];
    }
    // `cell` is the one in which the catom starts, for the regions of [[motion.catoms]].
    void look_at(std::uint64_t id, world::Cell cell, const world::Vec3& position);
    const std::set<Surface>& surfaces() const { return surfaces_; }
    // Of the examined bodies.
    RadiusRange radii() const { return radii_; }
    HeightRange heights() const { return heights_; }
    // By group of the world: whether any examined catom is in its region.
    const std::vector<bool>& groups_met() const { return groups_met_; }
    // The same by mover; and the examined catoms that move by a script.
    const std::vector<bool>& movers_met() const { return movers_met_; }
    std::span<const MovedCatom> moved() const { return moved_; }
    // Examined catoms among which the physics may find no touches: those that are fixed and do not move, and connected ones.
    const std::vector<FixedBody>& unwatched() const { return unwatched_; }
    // The group of the world in which an examined catom is connected to those that it touches; or, behind all groups, its robot, in which
    // it is connected to those that the assembly says.
    std::optional<std::size_t> connected_in(std::uint64_t id) const {
        const auto found = connected_in_.find(id);
        return found == connected_in_.end() ? std::nullopt : std::optional(found->second);
    }
    // What connected_in() says of a part of a robot whose assembly connects it to others.
    std::optional<std::size_t> robot_piece(const world::RobotPart& part) const;
    // By joint of the world that is of a region: the examined catoms in it.
    const std::vector<FixedBody>& joined_in(std::size_t joint) const { return joined_in_.at(joint); }
    // `surfaces`: of all processes.
    Result<void> add_materials(PhysicsScene& scene, const std::set<Surface>& surfaces);
    // `here`: false for a catom of another process, of which this one makes a ghost.
    Result<void> make(PhysicsScene& scene, std::uint64_t id, world::Cell cell, const world::Vec3& position, bool here = true) const;
    // What the body looks like at the start; a sphere is a point within its radius.
    world::RoundedBody looks(std::uint64_t id, world::Cell cell, const world::Vec3& position) const;

  private:
    struct Described {
        physics::BodySpec spec;
        Surface surface;
        std::optional<std::size_t> connected_in;
        physics::BreakingLimits breaking = {};
        std::optional<std::uint32_t> mover = {};
    };
    Described describe(std::uint64_t id, world::Cell cell, const world::Vec3& position) const;
    const world::World& world_;
    std::vector<physics::BodyShape> compounds_;
    std::uint64_t first_placed_;
    std::vector<bool> groups_met_, movers_met_;
    std::vector<MovedCatom> moved_;
    std::set<Surface> surfaces_;
    std::map<Surface, std::uint8_t> materials_;
    RadiusRange radii_;
    HeightRange heights_;
    std::vector<FixedBody> unwatched_;
    std::unordered_map<std::uint64_t, std::size_t> connected_in_;
    std::map<std::size_t, std::vector<FixedBody>> joined_in_;  // Joints of regions only: those between two catoms may be many.
};

// An error of the physics in the words of worlds and programs: bodies are catoms, and settings have their names in the world file.
Error about_catoms(Error error);

// The height of a position against gravity; without gravity, along z.
double height_of(const world::World& world, physics::Vec3 place);

// Metres to catom diameters and back.
inline physics::Vec3 to_metres(const world::World& world, const world::Vec3& diameters) {
    const double d = 2 * world.radius;
    return {d * diameters[0], d * diameters[1], d * diameters[2]};
}
inline world::Vec3 to_diameters(const world::World& world, physics::Vec3 metres) {
    const double d = 2 * world.radius;
    return {metres.x / d, metres.y / d, metres.z / d};
}

}  // namespace meld::sim
