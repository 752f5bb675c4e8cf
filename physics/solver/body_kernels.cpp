// The passes over bodies: velocities under forces, then positions and orientations.
#include <algorithm>
#include <cmath>
#include <limits>

#include "physics/solver/kernels.h"

namespace meld::physics {

namespace {

MELD_INLINE void accelerate_kernel(BodyVelocity* velocities, const Place* places, const Wrench* first_wrench, const Wrench* second_wrench,
                                   std::uint32_t first, std::uint32_t count, const MoveRule& rule) {
    const Quad gained{rule.gravity[0] * rule.step_s, rule.gravity[1] * rule.step_s, rule.gravity[2] * rule.step_s, 0};
    const Quad linear_kept{rule.linear_kept, rule.linear_kept, rule.linear_kept, 1};
    const Quad angular_kept{rule.angular_kept, rule.angular_kept, rule.angular_kept, 1};
    for (std::uint32_t slot = first; slot < first + count; ++slot) {
        BodyVelocity& velocity = velocities[slot];
        if (velocity.inverse_mass == 0) continue;
        Quad& linear = *reinterpret_cast<Quad*>(velocity.linear);
        Quad& angular = *reinterpret_cast<Quad*>(velocity.surface);
        linear += gained;
        for (const Wrench* wrenches : {first_wrench, second_wrench}) {
            if (!wrenches) continue;
            const Wrench& wrench = wrenches[slot];
            const float by_force = rule.step_s * velocity.inverse_mass,
                        by_torque = rule.step_s * velocity.inverse_surface_mass / static_cast<float>(places[slot].radius);
            linear += by_force * Quad{wrench.force[0], wrench.force[1], wrench.force[2], 0};
            angular += by_torque * Quad{wrench.torque[0], wrench.torque[1], wrench.torque[2], 0};
        }
        linear *= linear_kept;
        angular *= angular_kept;
    }
}

MELD_INLINE void move_range_kernel(Bodies& bodies, std::uint32_t first, std::uint32_t count, float step_s, Moved& moved) {
    const Quad* velocities = reinterpret_cast<const Quad*>(bodies.velocity.data());
    Quad* turns = reinterpret_cast<Quad*>(bodies.orientation.data());
    Lanes fastest = lanes(0), farthest = lanes(0);
    LaneMask finite = ~LaneMask{};
    for (std::uint32_t begin = first; begin < first + count; begin += kLanes) {
        std::uint32_t slots[kLanes];
        Lanes inverse_radius, drift_squared;
        const Quad step{step_s, step_s, step_s, 0};
        for (int i = 0; i < kLanes; ++i) {
            // The last group repeats its last body; all lanes are read before any is written.
            const std::uint32_t slot = slots[i] = std::min(begin + static_cast<std::uint32_t>(i), first + count - 1);
            inverse_radius[i] = static_cast<float>(bodies.place[slot].radius);
        }
        inverse_radius = 1.0f / inverse_radius;
        Lanes v[4], u[4], q[4];
        gather(velocities, 2, 0, slots, v);
        gather(velocities, 2, 1, slots, u);
        gather(turns, 1, 0, slots, q);
        const Lanes speed = v[0] * v[0] + v[1] * v[1] + v[2] * v[2] + u[0] * u[0] + u[1] * u[1] + u[2] * u[2];
        finite &= speed <= std::numeric_limits<float>::max();
        fastest = max_lanes(fastest, speed);

        const Lanes half = 0.5f * step_s * inverse_radius;
        const Lanes x = half * u[0], y = half * u[1], z = half * u[2];
        Lanes turned[4] = {q[0] - (x * q[1] + y * q[2] + z * q[3]), q[1] + (x * q[0] + y * q[3] - z * q[2]),
                           q[2] + (y * q[0] + z * q[1] - x * q[3]), q[3] + (z * q[0] + x * q[2] - y * q[1])};
        const Lanes norm = 1.0f / sqrt_lanes(turned[0] * turned[0] + turned[1] * turned[1] + turned[2] * turned[2] + turned[3] * turned[3]);
        for (Lanes& part : turned) part *= norm;
        scatter(turns, 1, 0, slots, turned);

        const std::uint32_t here = std::min<std::uint32_t>(kLanes, first + count - begin);
        drift_squared = lanes(0);
        for (std::uint32_t i = 0; i < here; ++i) {
            const std::uint32_t slot = begin + i;
            const Quad way = *reinterpret_cast<const Quad*>(bodies.velocity[slot].linear) * step;
            DoubleQuad& place = *reinterpret_cast<DoubleQuad*>(&bodies.place[slot]);
            place += __builtin_convertvector(way, DoubleQuad);
            Drift& drift = bodies.drift[slot];
            drift.x += way[0], drift.y += way[1], drift.z += way[2];
            drift_squared[static_cast<int>(i)] = drift.x * drift.x + drift.y * drift.y + drift.z * drift.z;
        }
        farthest = max_lanes(farthest, drift_squared);
    }
    for (int i = 0; i < kLanes; ++i) {
        moved.speed_squared = std::max(moved.speed_squared, fastest[i]);
        moved.drift_squared = std::max(moved.drift_squared, farthest[i]);
    }
    if (any(~finite)) moved.speed_squared = std::numeric_limits<float>::infinity();
}

MELD_KERNEL_VARIANTS(move_range, (Bodies & bodies, std::uint32_t first, std::uint32_t count, float step_s, Moved& moved),
                     (bodies, first, count, step_s, moved))

}  // namespace

MELD_KERNEL_VARIANTS(accelerate,
                     (BodyVelocity * velocities, const Place* places, const Wrench* first_wrench, const Wrench* second_wrench,
                      std::uint32_t first, std::uint32_t count, const MoveRule& rule),
                     (velocities, places, first_wrench, second_wrench, first, count, rule))

Moved move_bodies(Bodies& bodies, std::uint32_t first, std::uint32_t count, float step_s) {
    Moved moved;
    move_range(bodies, first, count, step_s, moved);
    return moved;
}

}  // namespace meld::physics
