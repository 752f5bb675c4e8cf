// Friction against rolling and spinning, in lanes. Two surfaces press on each other over a patch, not in a point: where they roll, the
// pressure's middle lies up to the patch's radius ahead of the point, and where they spin on it, friction acts at some distance from it. So
// a contact with the normal impulse P resists by a torque of at most radius times P, one number across the normal (rolling, over an edge
// too) and one along it (spinning). As in MuJoCo, ODE and Bullet, the radii are given, not computed from pressure and stiffness
// (Johnson: "Contact Mechanics", 1985, sections 9.1 and 8.5).
//
// The torque opposes the difference of the angular velocities, as friction does the slip: Gauss-Seidel, and the sum of a substep is kept
// within the cone. It begins each substep from zero, so there is nothing to save.
#pragma once

#include "physics/bodies/lanes.h"
#include "physics/bodies/stage.h"
#include "physics/solver/lane_contacts.h"
#include "physics/solver/turning/turning_friction.h"

namespace meld::physics {

// Whether anything in these lanes resists, or has and must stop.
MELD_INLINE bool may_resist(const TurningLanes& lanes_of, const Lanes& pressed) {
    const Lanes most = max_lanes(lanes_of.rolling, lanes_of.spinning) * pressed;
    return any((most > 0.0f) | (lanes_of.x != 0.0f) | (lanes_of.y != 0.0f) | (lanes_of.z != 0.0f));
}

// Keeps what is wanted within the cone, notes it, and returns by how much it has changed. `along` is the wanted impulse along the normal,
// `across` that across it; `pressed` the normal impulse, N s.
MELD_INLINE Vector limit_torque(TurningLanes& lanes_of, const Vector& normal, const Lanes& pressed, const Lanes& along,
                                const Vector& across) {
    constexpr float kNoImpulseSquared = 1e-36f;
    const Lanes most = lanes_of.spinning * pressed;
    const Lanes inverse = 1.0f / sqrt_lanes(max_lanes(dot(across, across), lanes(kNoImpulseSquared)));
    const Vector sum =
        max_lanes(min_lanes(along, most), -most) * normal + min_lanes(lanes_of.rolling * pressed * inverse, lanes(1)) * across;
    const Vector change = sum - Vector{lanes_of.x, lanes_of.y, lanes_of.z};
    lanes_of.x = sum.x, lanes_of.y = sum.y, lanes_of.z = sum.z;
    return change;
}

// The change of the torque on b for bodies that turn against each other with `spin`, rad/s, and are turned as easily about all axes: `ease`
// is the sum of their inverse moments of inertia.
MELD_INLINE Vector resist(TurningLanes& lanes_of, const Vector& normal, const Lanes& pressed, const Vector& spin, const Lanes& ease,
                          const SweepRule& rule) {
    const Vector now{lanes_of.x, lanes_of.y, lanes_of.z};
    const Vector wanted = now - (mass_of(ease) * rule.over_relaxation) * spin;
    const Lanes along = dot(wanted, normal);
    return limit_torque(lanes_of, normal, pressed, along, wanted - along * normal);
}

// The same for bodies that are turned more easily about some axes: `ease` is the sum of their inverse tensors of inertia. What stops
// the rolling is the exact solution for the two directions across the normal.
MELD_INLINE Vector resist(TurningLanes& lanes_of, const Vector& normal, const Lanes& pressed, const Vector& spin, const Tensors& ease,
                          const SweepRule& rule) {
    const Vector now{lanes_of.x, lanes_of.y, lanes_of.z};
    const Tangents tangents = across(normal);
    const Vector first = ease * tangents.first, second = ease * tangents.second;
    // Divided by the trace, so that products of large numbers stay finite.
    const Lanes scale = mass_of(dot(tangents.first, first) + dot(tangents.second, second));
    const Lanes a = scale * dot(tangents.first, first), b = scale * dot(tangents.second, first), c = scale * dot(tangents.second, second);
    const Lanes factor = (scale * rule.over_relaxation) * mass_of(a * c - b * b);
    const Lanes u = dot(spin, tangents.first), v = dot(spin, tangents.second);
    const Vector stops = (factor * (c * u - b * v)) * tangents.first + (factor * (a * v - b * u)) * tangents.second;
    const Lanes along_now = dot(now, normal);
    const Lanes along = along_now - (mass_of(dot(normal, ease * normal)) * rule.over_relaxation) * dot(spin, normal);
    return limit_torque(lanes_of, normal, pressed, along, now - along_now * normal - stops);
}

MELD_INLINE Tensors operator*(const Lanes& s, const Tensors& m) { return {s * m.xx, s * m.xy, s * m.xz, s * m.yy, s * m.yz, s * m.zz}; }
MELD_INLINE Tensors operator+(const Tensors& a, const Tensors& b) {
    return {a.xx + b.xx, a.xy + b.xy, a.xz + b.xz, a.yy + b.yy, a.yz + b.yz, a.zz + b.zz};
}

}  // namespace meld::physics
