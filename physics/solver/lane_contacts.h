// Vectors, bodies and the contact law in lanes, for the passes over batches of contacts.
#pragma once

#include <cstdint>

#include "physics/bodies/bodies.h"
#include "physics/bodies/lanes.h"
#include "physics/bodies/stage.h"
#include "physics/solver/contacts.h"

namespace meld::physics {

struct Vector {
    Lanes x, y, z;
};

MELD_INLINE Vector operator+(const Vector& a, const Vector& b) { return {a.x + b.x, a.y + b.y, a.z + b.z}; }
MELD_INLINE Vector operator-(const Vector& a, const Vector& b) { return {a.x - b.x, a.y - b.y, a.z - b.z}; }
MELD_INLINE Vector operator*(const Lanes& s, const Vector& a) { return {s * a.x, s * a.y, s * a.z}; }
MELD_INLINE Lanes dot(const Vector& a, const Vector& b) { return a.x * b.x + a.y * b.y + a.z * b.z; }
MELD_INLINE Vector cross(const Vector& a, const Vector& b) { return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x}; }
MELD_INLINE Vector select(LaneMask mask, const Vector& yes, const Vector& no) {
    return {mask ? yes.x : no.x, mask ? yes.y : no.y, mask ? yes.z : no.z};
}

// Eight symmetric matrices.
struct Tensors {
    Lanes xx, xy, xz, yy, yz, zz;
};
MELD_INLINE Vector operator*(const Tensors& m, const Vector& v) {
    return {m.xx * v.x + m.xy * v.y + m.xz * v.z, m.xy * v.x + m.yy * v.y + m.yz * v.z, m.xz * v.x + m.yz * v.y + m.zz * v.z};
}

// Two unit vectors across a unit normal (Duff and others: "Building an Orthonormal Basis, Revisited", 2017).
struct Tangents {
    Vector first, second;
};
MELD_INLINE Tangents across(const Vector& n) {
    const Lanes sign = physics::select(n.z >= 0.0f, lanes(1), lanes(-1));
    const Lanes a = -1.0f / (sign + n.z), b = n.x * n.y * a;
    return {{1.0f + sign * n.x * n.x * a, sign * b, -sign * n.x}, {b, sign + n.y * n.y * a, -n.y}};
}

// The velocities of eight bodies.
struct LaneVelocities {
    Vector linear;
    Lanes inverse_mass;
    Vector surface;
    Lanes inverse_surface_mass;
};

constexpr int kQuadsOfVelocity = 2;

MELD_INLINE LaneVelocities load(const BodyVelocity* velocities, const std::uint32_t* slots) {
    const Quad* quads = reinterpret_cast<const Quad*>(velocities);
    Lanes linear[4], angular[4];
    gather(quads, kQuadsOfVelocity, 0, slots, linear);
    gather(quads, kQuadsOfVelocity, 1, slots, angular);
    return {{linear[0], linear[1], linear[2]}, linear[3], {angular[0], angular[1], angular[2]}, angular[3]};
}

MELD_INLINE void store(BodyVelocity* velocities, const std::uint32_t* slots, const LaneVelocities& changed) {
    Quad* quads = reinterpret_cast<Quad*>(velocities);
    scatter(quads, kQuadsOfVelocity, 0, slots, {changed.linear.x, changed.linear.y, changed.linear.z, changed.inverse_mass});
    scatter(quads, kQuadsOfVelocity, 1, slots, {changed.surface.x, changed.surface.y, changed.surface.z, changed.inverse_surface_mass});
}

// Impulse `along` the normal and `across` it, on b and reversed on a.
MELD_INLINE void apply_impulse(LaneVelocities& a, LaneVelocities& b, const Vector& normal, const Lanes& along, const Vector& across) {
    const Vector impulse = along * normal + across;
    const Vector twist = cross(normal, across);
    a.linear = a.linear - a.inverse_mass * impulse;
    b.linear = b.linear + b.inverse_mass * impulse;
    a.surface = a.surface - a.inverse_surface_mass * twist;
    b.surface = b.surface - b.inverse_surface_mass * twist;
}

// The inverse of a sum of inverse masses, 0 if the sum is 0: between two bodies that cannot move nothing changes, and the impulses wait
// until one of them wakes.
MELD_INLINE Lanes mass_of(const Lanes& lightness) {
    constexpr float kLightest = 1e-30f;
    return keep(lightness > 0.0f, 1.0f / max_lanes(lightness, lanes(kLightest)));
}

// The change of the normal impulse that a contact needs, before the impulse is kept from pulling. `holds`: lanes with a latch, which pull a
// gap together as they push an overlap apart.
template <bool kAdhesive>
MELD_INLINE Lanes wanted_change(const Lanes& gap, const Lanes& now, const Lanes& parting, const Lanes& lightness, LaneMask holds,
                                const SweepRule& rule) {
    LaneMask pressed = gap <= 0.0f;
    const Lanes fastest = max_lanes(rule.load_rate * (lightness * now), lanes(rule.max_depenetration_speed));
    Lanes bias = max_lanes(gap, lanes(0)) * rule.apart_rate + max_lanes(min_lanes(gap, lanes(0)) * rule.overlap_rate, -fastest);
    if constexpr (kAdhesive) {
        pressed |= holds;
        bias = physics::select(
            holds, min_lanes(max_lanes(gap * rule.overlap_rate, lanes(-rule.max_latch_speed)), lanes(rule.max_latch_speed)), bias);
    }
    const Lanes mass_scale = 1.0f + keep(pressed, lanes(rule.mass_scale - 1));
    const Lanes kept_back = keep(pressed & (lightness > 0.0f), rule.impulse_scale * now);
    return (mass_of(lightness) * mass_scale * rule.over_relaxation) * (parting + bias) + kept_back;
}
template <bool kAdhesive>
MELD_INLINE Lanes wanted_change(const Batch& batch, const Lanes& parting, const Lanes& lightness, LaneMask holds, const SweepRule& rule) {
    return wanted_change<kAdhesive>(batch.gap, batch.normal_impulse, parting, lightness, holds, rule);
}

MELD_INLINE Lanes square_root_of(const Lanes& square) { return sqrt_lanes(max_lanes(square, lanes(0))); }

}  // namespace meld::physics
