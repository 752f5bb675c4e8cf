#include "runtime/sim/bodies/scripted_motion.h"

#include <algorithm>

#include "runtime/world/description/motions.h"

namespace meld::sim {

namespace {

physics::Vec3 scaled(double factor, const world::Vec3& v) { return {factor * v[0], factor * v[1], factor * v[2]}; }

}  // namespace

bool changes_gravity(const world::World& world) {
    return world.physics.gravity_swing || std::ranges::any_of(world.events, [](const world::Event& e) { return e.gravity.has_value(); });
}

double greatest_gravity(const world::World& world) {
    double greatest = length(scaled(1, world.physics.gravity));
    for (const world::Event& event : world.events)
        if (event.gravity) greatest = std::max(greatest, length(scaled(1, *event.gravity)));
    return world.physics.gravity_swing ? greatest + 2 * length(scaled(1, world.physics.gravity_swing->swing)) : greatest;
}

physics::Vec3 gravity_in_step(const world::World& world, std::uint64_t step) {
    const auto tick = static_cast<std::int64_t>(step / static_cast<std::uint64_t>(world.physics.steps)) + 1;
    world::Vec3 gravity = world.physics.gravity;
    std::int64_t since = 0;
    for (const world::Event& event : world.events) {
        if (!event.gravity) continue;
        const std::int64_t latest = event.latest(tick);
        if (latest > 0 && latest >= since) since = latest, gravity = *event.gravity;
    }
    const physics::Vec3 steady = scaled(1, gravity);
    if (!world.physics.gravity_swing) return steady;
    physics::PrescribedMotion motion = world::motion_of({.swing = *world.physics.gravity_swing, .spin = {}, .pivot = {}}, 1);
    motion.pivot_m = physics::Vec3{};
    return motion.at({steady, {}}, static_cast<double>(step) * world.physics.step).centre_m;
}

}  // namespace meld::sim
