#include "runtime/sim/bodies/scripted_motion.h"

#include <algorithm>
#include <numbers>
#include <optional>

namespace meld::sim {

namespace {

constexpr double kDegree = std::numbers::pi / 180;

physics::Vec3 scaled(double factor, const world::Vec3& v) { return {factor * v[0], factor * v[1], factor * v[2]}; }

// `unit`: of the swing.
physics::PrescribedMotion swing_of(const world::SwingOptions& swing, double unit) {
    return {.swing_m = scaled(unit, swing.swing),
            .tilt_rad = scaled(kDegree, swing.tilt),
            .frequency_hz = swing.frequency,
            .phase_rad = kDegree * swing.phase};
}

}  // namespace

physics::PrescribedMotion motion_of(const world::World& world, const world::MoverOptions& mover) {
    const double diameter_m = 2 * world.radius;
    physics::PrescribedMotion motion = swing_of(mover.swing, diameter_m);
    motion.spin_rad_s = scaled(1, mover.spin);
    if (mover.pivot) motion.pivot_m = scaled(diameter_m, *mover.pivot);
    return motion;
}

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
    physics::PrescribedMotion motion = swing_of(*world.physics.gravity_swing, 1);
    motion.pivot_m = physics::Vec3{};
    return motion.at({steady, {}}, static_cast<double>(step) * world.physics.step).centre_m;
}

}  // namespace meld::sim
