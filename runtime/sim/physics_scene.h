// From what a world says of its bodies to a scene of the physics.
#pragma once

#include <memory>
#include <vector>

#include "physics/physics.h"
#include "runtime/world/world_file.h"

namespace meld::sim {

// The scene without bodies: settings, ground and obstacles, features. Errors name the place in the world file where there is one.
struct PhysicsScene {
    std::unique_ptr<physics::Scene> scene;
    std::vector<physics::Feature> features;  // Of every catom, in the order of their numbers; empty: none.
    std::uint16_t feature_table = 0;
};
Result<PhysicsScene> make_physics_scene(const world::World& world);

// Gives catoms their bodies.
class BodyMaker {
  public:
    BodyMaker(const world::World& world, PhysicsScene& scene) : world_(world), scene_(scene) {}
    // The cell is that in which the catom starts, for the regions of [[motion.catoms]].
    Result<void> add(std::uint64_t id, world::Cell cell, const world::Vec3& position);

  private:
    struct Surface {
        double friction, restitution;
        std::uint8_t material;
    };
    Result<std::uint8_t> material(double friction, double restitution);

    const world::World& world_;
    PhysicsScene& scene_;
    std::vector<Surface> surfaces_;
};

// An error of the physics in the words of worlds and programs: bodies are catoms, and its settings have their names in the
// world file.
Error about_catoms(Error error);

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
