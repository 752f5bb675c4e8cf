// The passes over contacts of bodies with shapes (shape_contacts.h).
#include "physics/solver/lane_contacts.h"
#include "physics/solver/shape_contacts.h"

namespace meld::physics {

namespace {

// How often the points of two bodies push along the normal before friction.
constexpr int kRoundsOfFaces = 2;

struct LaneBodies {
    LaneVelocities moving;
    Tensors turning;
};

MELD_INLINE Tensors load_turnings(const Turning* turnings, const std::uint32_t* slots) {
    const Quad* quads = reinterpret_cast<const Quad*>(turnings);
    Lanes first[4], last[4];
    gather(quads, 2, 0, slots, first);
    gather(quads, 2, 1, slots, last);
    return {first[0], first[1], first[2], first[3], last[0], last[1]};
}
MELD_INLINE LaneBodies load_bodies(const BodyVelocity* velocities, const Turning* turnings, const std::uint32_t* slots) {
    return {load(velocities, slots), load_turnings(turnings, slots)};
}

MELD_INLINE Vector velocity_at(const LaneBodies& body, const Vector& arm) { return body.moving.linear + cross(body.moving.surface, arm); }

MELD_INLINE void push(LaneBodies& body, const Vector& arm, const Vector& impulse) {
    LaneVelocities& v = body.moving;
    v.linear = v.linear + v.inverse_mass * impulse;
    v.surface = v.surface + v.inverse_mass * (body.turning * cross(arm, impulse));
}

// The inverse masses at an arm, along the normal and across it as a symmetric 2x2 matrix.
struct PointLightness {
    Lanes along = {}, first = {}, mixed = {}, second = {};
};
MELD_INLINE void add_lightness(PointLightness& sum, const Lanes& inverse_mass, const Tensors& turning, const Vector& arm,
                               const Vector& normal, const Tangents& tangents) {
    const Vector along = cross(arm, normal), first = cross(arm, tangents.first), second = cross(arm, tangents.second);
    const Vector turned = turning * first;
    sum.along += inverse_mass * (1.0f + dot(along, turning * along));
    sum.first += inverse_mass * (1.0f + dot(first, turned));
    sum.mixed += inverse_mass * dot(second, turned);
    sum.second += inverse_mass * (1.0f + dot(second, turning * second));
}

MELD_INLINE void follow_shapes_kernel(std::span<ShapeBatch> batches, const BodyVelocity* velocities, float step_s) {
    for (ShapeBatch& batch : batches) {
        if (batch.used == 0) continue;
        const LaneVelocities a = load(velocities, batch.a), b = load(velocities, batch.b);
        const Vector normal{batch.nx, batch.ny, batch.nz}, apart = b.linear - a.linear;
        for (std::uint32_t p = 0; p < batch.used; ++p) {
            ShapePoint& point = batch.points[p];
            const Vector moving =
                apart + cross(b.surface, {point.bx, point.by, point.bz}) - cross(a.surface, {point.ax, point.ay, point.az});
            point.gap += step_s * dot(moving, normal);
        }
    }
}

MELD_INLINE void prepare_shapes_kernel(std::span<ShapeBatch> batches, const BodyVelocity* velocities, const Turning* turnings) {
    for (ShapeBatch& batch : batches) {
        if (batch.used == 0) continue;
        const LaneBodies a = load_bodies(velocities, turnings, batch.a), b = load_bodies(velocities, turnings, batch.b);
        const Vector normal{batch.nx, batch.ny, batch.nz};
        const Tangents tangents = across(normal);
        for (std::uint32_t p = 0; p < batch.used; ++p) {
            ShapePoint& point = batch.points[p];
            PointLightness sum;
            add_lightness(sum, a.moving.inverse_mass, a.turning, {point.ax, point.ay, point.az}, normal, tangents);
            add_lightness(sum, b.moving.inverse_mass, b.turning, {point.bx, point.by, point.bz}, normal, tangents);
            const Lanes half = 0.5f * (sum.first - sum.second);
            point.lightness = sum.along;
            point.slip_lightness = 0.5f * (sum.first + sum.second) + square_root_of(half * half + sum.mixed * sum.mixed);
        }
    }
}

MELD_INLINE void warm_start_shapes_kernel(std::span<const ShapeBatch> batches, BodyVelocity* velocities, const Turning* turnings) {
    for (const ShapeBatch& batch : batches) {
        if (batch.used == 0) continue;
        LaneBodies a = load_bodies(velocities, turnings, batch.a), b = load_bodies(velocities, turnings, batch.b);
        const Vector normal{batch.nx, batch.ny, batch.nz};
        for (std::uint32_t p = 0; p < batch.used; ++p) {
            const ShapePoint& point = batch.points[p];
            const Vector impulse = point.normal_impulse * normal + Vector{point.tx, point.ty, point.tz};
            push(a, {point.ax, point.ay, point.az}, lanes(-1) * impulse);
            push(b, {point.bx, point.by, point.bz}, impulse);
        }
        store(velocities, batch.a, a.moving);
        store(velocities, batch.b, b.moving);
    }
}

MELD_INLINE void sweep_shapes_kernel(std::span<ShapeBatch> batches, BodyVelocity* velocities, const Turning* turnings,
                                     const SweepRule& rule) {
    for (ShapeBatch& batch : batches) {
        if (batch.used == 0) continue;
        LaneBodies a = load_bodies(velocities, turnings, batch.a), b = load_bodies(velocities, turnings, batch.b);
        const Vector normal{batch.nx, batch.ny, batch.nz};
        // The points of a face push each other's apart, so one round over them leaves half of an approach.
        for (int round = 1; round < kRoundsOfFaces && batch.used > 1; ++round)
            for (std::uint32_t p = 0; p < batch.used; ++p) {
                ShapePoint& point = batch.points[p];
                const Vector a_arm{point.ax, point.ay, point.az}, b_arm{point.bx, point.by, point.bz};
                const Lanes parting = dot(velocity_at(b, b_arm) - velocity_at(a, a_arm), normal);
                const Lanes now = point.normal_impulse;
                point.normal_impulse =
                    max_lanes(now - wanted_change<false>(point.gap, now, parting, point.lightness, LaneMask{}, rule), lanes(0));
                const Vector impulse = (point.normal_impulse - now) * normal;
                push(a, a_arm, lanes(-1) * impulse);
                push(b, b_arm, impulse);
            }
        for (std::uint32_t p = 0; p < batch.used; ++p) {
            ShapePoint& point = batch.points[p];
            const Vector a_arm{point.ax, point.ay, point.az}, b_arm{point.bx, point.by, point.bz};
            const Vector apart = velocity_at(b, b_arm) - velocity_at(a, a_arm);
            const Lanes parting = dot(apart, normal);
            const Vector slip = apart - parting * normal;
            const Lanes now = point.normal_impulse;
            const Lanes pressed =
                max_lanes(now - wanted_change<false>(point.gap, now, parting, point.lightness, LaneMask{}, rule), lanes(0));
            const Vector friction_now{point.tx, point.ty, point.tz};
            const Vector wanted = friction_now - (mass_of(point.slip_lightness) * rule.over_relaxation) * slip;
            constexpr float kNoImpulseSquared = 1e-36f;
            const Lanes inverse = 1.0f / sqrt_lanes(max_lanes(dot(wanted, wanted), lanes(kNoImpulseSquared)));
            const Vector friction = min_lanes(batch.friction * pressed * inverse, lanes(1)) * wanted;
            const Vector impulse = (pressed - now) * normal + (friction - friction_now);
            push(a, a_arm, lanes(-1) * impulse);
            push(b, b_arm, impulse);
            point.normal_impulse = pressed;
            point.tx = friction.x, point.ty = friction.y, point.tz = friction.z;
        }
        store(velocities, batch.a, a.moving);
        store(velocities, batch.b, b.moving);
    }
}

}  // namespace

MELD_KERNEL_VARIANTS(follow_shapes, (std::span<ShapeBatch> batches, const BodyVelocity* velocities, float step_s),
                     (batches, velocities, step_s))
MELD_KERNEL_VARIANTS(prepare_shapes, (std::span<ShapeBatch> batches, const BodyVelocity* velocities, const Turning* turnings),
                     (batches, velocities, turnings))
MELD_KERNEL_VARIANTS(warm_start_shapes, (std::span<const ShapeBatch> batches, BodyVelocity* velocities, const Turning* turnings),
                     (batches, velocities, turnings))
MELD_KERNEL_VARIANTS(sweep_shapes,
                     (std::span<ShapeBatch> batches, BodyVelocity* velocities, const Turning* turnings, const SweepRule& rule),
                     (batches, velocities, turnings, rule))

}  // namespace meld::physics
