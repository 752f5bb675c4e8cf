// The passes over contacts of bodies with shapes (shape_contacts.h).
#include "physics/solver/lane_contacts.h"
#include "physics/solver/shapes/shape_contacts.h"
#include "physics/solver/turning/turning_lanes.h"

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

// What the solver moves in a batch, and the arms of its points: the bodies themselves, or in part the composites that they are members of.
struct OwnArms {
    const std::uint32_t *a_slots, *b_slots;
    MELD_INLINE Vector a(const ShapePoint& point) const { return {point.ax, point.ay, point.az}; }
    MELD_INLINE Vector b(const ShapePoint& point) const { return {point.bx, point.by, point.bz}; }
};
struct MovedArms {
    const MovedLanes& moved;
    const std::uint32_t *a_slots = moved.a, *b_slots = moved.b;
    MELD_INLINE Vector a(const ShapePoint& point) const {
        return moved.a_scale * Vector{point.ax, point.ay, point.az} + Vector{moved.ax, moved.ay, moved.az};
    }
    MELD_INLINE Vector b(const ShapePoint& point) const {
        return moved.b_scale * Vector{point.bx, point.by, point.bz} + Vector{moved.bx, moved.by, moved.bz};
    }
};
// Calls f(batch, arms) for the batches with points.
template <class Batches, class F>
MELD_INLINE void each_batch(Batches batches, const MovedLanes* moved, const F& f) {
    for (auto& batch : batches) {
        if (batch.used == 0) continue;
        if (batch.moved == kNoSlot)
            f(batch, OwnArms{batch.a, batch.b});
        else
            f(batch, MovedArms{moved[batch.moved]});
    }
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
        const Lanes speed =
            square_root_of(dot(apart, apart)) + square_root_of(dot(a.surface, a.surface)) + square_root_of(dot(b.surface, b.surface));
        batch.same_m -= step_s * speed;
    }
}

MELD_INLINE void prepare_shapes_kernel(std::span<ShapeBatch> batches, const MovedLanes* moved, const BodyVelocity* velocities,
                                       const Turning* turnings) {
    each_batch(batches, moved, [&](ShapeBatch& batch, const auto& arms) MELD_INLINE_CALL {
        const LaneBodies a = load_bodies(velocities, turnings, arms.a_slots), b = load_bodies(velocities, turnings, arms.b_slots);
        const Vector normal{batch.nx, batch.ny, batch.nz};
        const Tangents tangents = across(normal);
        for (std::uint32_t p = 0; p < batch.used; ++p) {
            ShapePoint& point = batch.points[p];
            PointLightness sum;
            add_lightness(sum, a.moving.inverse_mass, a.turning, arms.a(point), normal, tangents);
            add_lightness(sum, b.moving.inverse_mass, b.turning, arms.b(point), normal, tangents);
            const Lanes half = 0.5f * (sum.first - sum.second);
            point.lightness = sum.along;
            point.slip_lightness = 0.5f * (sum.first + sum.second) + square_root_of(half * half + sum.mixed * sum.mixed);
        }
    });
}

MELD_INLINE void warm_start_shapes_kernel(std::span<const ShapeBatch> batches, const MovedLanes* moved, BodyVelocity* velocities,
                                          const Turning* turnings) {
    each_batch(batches, moved, [&](const ShapeBatch& batch, const auto& arms) MELD_INLINE_CALL {
        LaneBodies a = load_bodies(velocities, turnings, arms.a_slots), b = load_bodies(velocities, turnings, arms.b_slots);
        const Vector normal{batch.nx, batch.ny, batch.nz};
        for (std::uint32_t p = 0; p < batch.used; ++p) {
            const ShapePoint& point = batch.points[p];
            const Vector impulse = point.normal_impulse * normal + Vector{point.tx, point.ty, point.tz};
            push(a, arms.a(point), lanes(-1) * impulse);
            push(b, arms.b(point), impulse);
        }
        store(velocities, arms.a_slots, a.moving);
        store(velocities, arms.b_slots, b.moving);
    });
}

// The impulse along the normal that a point wants now, and the force times the time with which it may pull at most.
template <bool kHeld>
struct Press {
    const HeldPoints* held;
    float step_s;
    MELD_INLINE Lanes pull(std::uint32_t p) const {
        if constexpr (kHeld)
            return held->force[p] * step_s;
        else
            return lanes(0);
    }
    MELD_INLINE Lanes wanted(const ShapePoint& point, const Lanes& parting, const Lanes& pull, const SweepRule& rule) const {
        const Lanes now = point.normal_impulse;
        const LaneMask holds = kHeld ? pull > 0.0f : LaneMask{};
        return max_lanes(now - wanted_change<kHeld>(point.gap, now, parting, point.lightness, holds, rule), lanes(0) - pull);
    }
};

template <bool kHeld>
MELD_INLINE void sweep_points(std::span<ShapeBatch> batches, const HeldPoints* held, float step_s, const MovedLanes* moved,
                              BodyVelocity* velocities, const Turning* turnings, const SweepRule& rule) {
    each_batch(batches, moved, [&](ShapeBatch& batch, const auto& arms) MELD_INLINE_CALL {
        const Press<kHeld> press{kHeld ? held + (&batch - batches.data()) : nullptr, step_s};
        LaneBodies a = load_bodies(velocities, turnings, arms.a_slots), b = load_bodies(velocities, turnings, arms.b_slots);
        const Vector normal{batch.nx, batch.ny, batch.nz};
        // The points of a face push each other's apart, so one round over them leaves half of an approach.
        for (int round = 1; round < kRoundsOfFaces && batch.used > 1; ++round)
            for (std::uint32_t p = 0; p < batch.used; ++p) {
                ShapePoint& point = batch.points[p];
                const Vector a_arm = arms.a(point), b_arm = arms.b(point);
                const Lanes parting = dot(velocity_at(b, b_arm) - velocity_at(a, a_arm), normal);
                const Lanes now = point.normal_impulse;
                point.normal_impulse = press.wanted(point, parting, press.pull(p), rule);
                const Vector impulse = (point.normal_impulse - now) * normal;
                push(a, a_arm, lanes(-1) * impulse);
                push(b, b_arm, impulse);
            }
        for (std::uint32_t p = 0; p < batch.used; ++p) {
            ShapePoint& point = batch.points[p];
            const Vector a_arm = arms.a(point), b_arm = arms.b(point);
            const Vector apart = velocity_at(b, b_arm) - velocity_at(a, a_arm);
            const Lanes parting = dot(apart, normal);
            const Vector slip = apart - parting * normal;
            const Lanes now = point.normal_impulse;
            const Lanes pull = press.pull(p), pressed = press.wanted(point, parting, pull, rule);
            const Vector friction_now{point.tx, point.ty, point.tz};
            const Vector wanted = friction_now - (mass_of(point.slip_lightness) * rule.over_relaxation) * slip;
            constexpr float kNoImpulseSquared = 1e-36f;
            const Lanes inverse = 1.0f / sqrt_lanes(max_lanes(dot(wanted, wanted), lanes(kNoImpulseSquared)));
            const Vector friction = min_lanes(batch.friction * (pressed + pull) * inverse, lanes(1)) * wanted;
            const Vector impulse = (pressed - now) * normal + (friction - friction_now);
            push(a, a_arm, lanes(-1) * impulse);
            push(b, b_arm, impulse);
            point.normal_impulse = pressed;
            point.tx = friction.x, point.ty = friction.y, point.tz = friction.z;
        }
        store(velocities, arms.a_slots, a.moving);
        store(velocities, arms.b_slots, b.moving);
    });
}

MELD_INLINE void sweep_shapes_kernel(std::span<ShapeBatch> batches, const MovedLanes* moved, BodyVelocity* velocities,
                                     const Turning* turnings, const SweepRule& rule) {
    sweep_points<false>(batches, nullptr, 0, moved, velocities, turnings, rule);
}
MELD_INLINE void sweep_held_shapes_kernel(std::span<ShapeBatch> batches, const HeldPoints* held, float step_s, const MovedLanes* moved,
                                          BodyVelocity* velocities, const Turning* turnings, const SweepRule& rule) {
    sweep_points<true>(batches, held, step_s, moved, velocities, turnings, rule);
}

// All points of two bodies press on one patch each, and resist together.
MELD_INLINE void resist_turning_of_shapes_kernel(std::span<const ShapeBatch> batches, TurningLanes* beside, const HeldPoints* held,
                                                 float step_s, const MovedLanes* moved, BodyVelocity* velocities, const Turning* turnings,
                                                 const SweepRule& rule) {
    each_batch(batches, moved, [&](const ShapeBatch& batch, const auto& arms) MELD_INLINE_CALL {
        const std::ptrdiff_t n = &batch - batches.data();
        Lanes pressed = lanes(0);
        for (std::uint32_t p = 0; p < batch.used; ++p) {
            pressed += batch.points[p].normal_impulse;
            if (held != nullptr) pressed += held[n].force[p] * step_s;
        }
        TurningLanes& own = beside[n];
        if (!may_resist(own, pressed)) return;
        LaneBodies a = load_bodies(velocities, turnings, arms.a_slots), b = load_bodies(velocities, turnings, arms.b_slots);
        const Vector spin = own.b_curvature * b.moving.surface - own.a_curvature * a.moving.surface;
        const Tensors ease = (a.moving.inverse_mass * own.a_curvature * own.a_curvature) * a.turning +
                             (b.moving.inverse_mass * own.b_curvature * own.b_curvature) * b.turning;
        const Vector change = resist(own, {batch.nx, batch.ny, batch.nz}, pressed, spin, ease, rule);
        a.moving.surface = a.moving.surface - (a.moving.inverse_mass * own.a_curvature) * (a.turning * change);
        b.moving.surface = b.moving.surface + (b.moving.inverse_mass * own.b_curvature) * (b.turning * change);
        store(velocities, arms.a_slots, a.moving);
        store(velocities, arms.b_slots, b.moving);
    });
}

}  // namespace

MELD_KERNEL_VARIANTS(follow_shapes, (std::span<ShapeBatch> batches, const BodyVelocity* velocities, float step_s),
                     (batches, velocities, step_s))
MELD_KERNEL_VARIANTS(prepare_shapes,
                     (std::span<ShapeBatch> batches, const MovedLanes* moved, const BodyVelocity* velocities, const Turning* turnings),
                     (batches, moved, velocities, turnings))
MELD_KERNEL_VARIANTS(warm_start_shapes,
                     (std::span<const ShapeBatch> batches, const MovedLanes* moved, BodyVelocity* velocities, const Turning* turnings),
                     (batches, moved, velocities, turnings))
MELD_KERNEL_VARIANTS(sweep_shapes,
                     (std::span<ShapeBatch> batches, const MovedLanes* moved, BodyVelocity* velocities, const Turning* turnings,
                      const SweepRule& rule),
                     (batches, moved, velocities, turnings, rule))
MELD_KERNEL_VARIANTS(sweep_held_shapes,
                     (std::span<ShapeBatch> batches, const HeldPoints* held, float step_s, const MovedLanes* moved,
                      BodyVelocity* velocities, const Turning* turnings, const SweepRule& rule),
                     (batches, held, step_s, moved, velocities, turnings, rule))

MELD_KERNEL_VARIANTS(resist_turning_of_shapes,
                     (std::span<const ShapeBatch> batches, TurningLanes* beside, const HeldPoints* held, float step_s,
                      const MovedLanes* moved, BodyVelocity* velocities, const Turning* turnings, const SweepRule& rule),
                     (batches, beside, held, step_s, moved, velocities, turnings, rule))

}  // namespace meld::physics
