// The passes over contacts of composites. A contact has a lever arm on each composite: its surface moves there with v + w x arm, and an
// impulse P changes v by P/m and w by I^-1 (arm x P). The other body of a mixed batch is a sphere with its surface velocity
// (contact_kernels.cpp), or the motionless entry of the block.
#include <array>

#include "physics/solver/composite_rows.h"
#include "physics/solver/lane_contacts.h"
#include "physics/solver/turning/turning_lanes.h"

namespace meld::physics {

namespace {

constexpr int kQuadsOfCopy = 4;

struct LaneCopies {
    Vector linear;
    Lanes inverse_mass;
    Vector spin;
    Lanes zero;
    Tensors inverse_inertia;
};

MELD_INLINE LaneCopies load_copies(const CompositeCopy* copies, const std::uint32_t* index) {
    const Quad* quads = reinterpret_cast<const Quad*>(copies);
    Lanes linear[4], spin[4], first[4], last[4];
    gather(quads, kQuadsOfCopy, 0, index, linear);
    gather(quads, kQuadsOfCopy, 1, index, spin);
    gather(quads, kQuadsOfCopy, 2, index, first);
    gather(quads, kQuadsOfCopy, 3, index, last);
    return {{linear[0], linear[1], linear[2]},
            linear[3],
            {spin[0], spin[1], spin[2]},
            spin[3],
            {first[0], first[1], first[2], first[3], last[0], last[1]}};
}

MELD_INLINE void store_copies(CompositeCopy* copies, const std::uint32_t* index, const LaneCopies& changed) {
    Quad* quads = reinterpret_cast<Quad*>(copies);
    scatter(quads, kQuadsOfCopy, 0, index, {changed.linear.x, changed.linear.y, changed.linear.z, changed.inverse_mass});
    scatter(quads, kQuadsOfCopy, 1, index, {changed.spin.x, changed.spin.y, changed.spin.z, changed.zero});
}

// The second body of a batch: a composite, or a sphere.
template <RowKind kKind>
struct Second {
    LaneCopies composite;
    LaneVelocities sphere;

    MELD_INLINE void load(const Batch& batch, const CompositeRow& row, const CompositeCopy* copies, const BodyVelocity* velocities) {
        if constexpr (kKind == RowKind::Joint)
            composite = load_copies(copies, row.b);
        else
            sphere = physics::load(velocities, batch.b);
    }
    MELD_INLINE void store(const Batch& batch, const CompositeRow& row, CompositeCopy* copies, BodyVelocity* velocities) const {
        if constexpr (kKind == RowKind::Joint)
            store_copies(copies, row.b, composite);
        else
            physics::store(velocities, batch.b, sphere);
    }
    // Of its surface.
    MELD_INLINE Vector velocity(const CompositeRow& row, const Vector& normal) const {
        if constexpr (kKind == RowKind::Joint)
            return composite.linear + cross(composite.spin, {row.bx, row.by, row.bz});
        else
            return sphere.linear - cross(sphere.surface, normal);
    }
    MELD_INLINE void push(const CompositeRow& row, const Vector& normal, const Vector& impulse) {
        if constexpr (kKind == RowKind::Joint) {
            composite.linear = composite.linear + composite.inverse_mass * impulse;
            composite.spin = composite.spin + composite.inverse_inertia * cross({row.bx, row.by, row.bz}, impulse);
        } else {
            sphere.linear = sphere.linear + sphere.inverse_mass * impulse;
            sphere.surface = sphere.surface - sphere.inverse_surface_mass * cross(normal, impulse);
        }
    }
};

MELD_INLINE void push_back(LaneCopies& a, const CompositeRow& row, const Vector& impulse) {
    a.linear = a.linear - a.inverse_mass * impulse;
    a.spin = a.spin - a.inverse_inertia * cross({row.ax, row.ay, row.az}, impulse);
}

// What impulses at an arm change: the inverse masses along the normal, and across it the symmetric 2x2 matrix.
struct Lightness {
    Lanes along = {}, first = {}, mixed = {}, second = {};
};
MELD_INLINE void add(Lightness& sum, const LaneCopies& body, const Vector& arm, const Vector& normal, const Tangents& tangents) {
    const Vector along = cross(arm, normal), first = cross(arm, tangents.first), second = cross(arm, tangents.second);
    const Vector turned = body.inverse_inertia * first;
    sum.along += body.inverse_mass + dot(along, body.inverse_inertia * along);
    sum.first += body.inverse_mass + dot(first, turned);
    sum.mixed += dot(second, turned);
    sum.second += body.inverse_mass + dot(second, body.inverse_inertia * second);
}

// The arm to the surface: the body's place from the centre of its composite, and its radius along the normal.
MELD_INLINE Vector arm_to(const Place* places, const std::uint32_t* slots, const Place* centres, const std::uint32_t* copies,
                          const Vector& normal, float side) {
    Quad rows[kLanes];
#pragma GCC unroll 8
    for (int i = 0; i < kLanes; ++i) {
        const DoubleQuad place = *reinterpret_cast<const DoubleQuad*>(places + slots[i]);
        const DoubleQuad centre = *reinterpret_cast<const DoubleQuad*>(centres + copies[i]);
        rows[i] = __builtin_convertvector(place - centre, Quad);
    }
    const Lanes joined[4] = {join(rows[0], rows[4]), join(rows[1], rows[5]), join(rows[2], rows[6]), join(rows[3], rows[7])};
    Lanes columns[4];
    transpose(joined, columns);
    return Vector{columns[0], columns[1], columns[2]} + (side * columns[3]) * normal;
}

template <RowKind kKind>
MELD_INLINE void refresh(std::span<const Batch> batches, CompositeRow* rows, const CompositeCopy* copies, const Place* centres,
                         const Bodies& bodies) {
    for (const Batch& batch : batches) {
        CompositeRow& row = *rows++;
        const Vector normal{batch.nx, batch.ny, batch.nz};
        const Tangents tangents = across(normal);
        Lightness sum;
        const Vector a = arm_to(bodies.place.data(), batch.a, centres, row.a, normal, 1);
        add(sum, load_copies(copies, row.a), a, normal, tangents);
        row.ax = a.x, row.ay = a.y, row.az = a.z;
        if constexpr (kKind == RowKind::Joint) {
            const Vector b = arm_to(bodies.place.data(), batch.b, centres, row.b, normal, -1);
            add(sum, load_copies(copies, row.b), b, normal, tangents);
            row.bx = b.x, row.by = b.y, row.bz = b.z;
        } else {
            const LaneVelocities b = load(bodies.velocity.data(), batch.b);
            row.bx = row.by = row.bz = lanes(0);
            sum.along += b.inverse_mass;
            sum.first += b.inverse_mass + b.inverse_surface_mass;
            sum.second += b.inverse_mass + b.inverse_surface_mass;
        }
        const Lanes half = 0.5f * (sum.first - sum.second);
        row.lightness = sum.along;
        row.slip_lightness = 0.5f * (sum.first + sum.second) + square_root_of(half * half + sum.mixed * sum.mixed);
    }
}

template <RowKind kKind>
MELD_INLINE void start(std::span<const Batch> batches, const CompositeRow* rows, CompositeCopy* copies, BodyVelocity* velocities) {
    for (const Batch& batch : batches) {
        const CompositeRow& row = *rows++;
        const Vector normal{batch.nx, batch.ny, batch.nz};
        const Vector impulse = batch.normal_impulse * normal + Vector{batch.tx, batch.ty, batch.tz};
        LaneCopies a = load_copies(copies, row.a);
        Second<kKind> b;
        b.load(batch, row, copies, velocities);
        push_back(a, row, impulse);
        b.push(row, normal, impulse);
        store_copies(copies, row.a, a);
        b.store(batch, row, copies, velocities);
    }
}

template <RowKind kKind, bool kAdhesive>
MELD_INLINE void sweep_one(std::span<Batch> batches, const CompositeRow* rows, CompositeCopy* copies, BodyVelocity* velocities,
                           const Lanes* holding, float step_s, const SweepRule& rule) {
    for (Batch& batch : batches) {
        const CompositeRow& row = *rows++;
        LaneCopies a = load_copies(copies, row.a);
        Second<kKind> b;
        b.load(batch, row, copies, velocities);
        const Vector normal{batch.nx, batch.ny, batch.nz};
        const Vector apart = b.velocity(row, normal) - (a.linear + cross(a.spin, {row.ax, row.ay, row.az}));
        const Lanes parting = dot(apart, normal);
        const Vector slip = apart - parting * normal;
        const Lanes now = batch.normal_impulse;
        Lanes pressed, held = lanes(0);
        if constexpr (kAdhesive) {
            held = *holding++ * step_s;
            pressed = max_lanes(now - wanted_change<true>(batch, parting, row.lightness, held > 0.0f, rule), -held);
        } else {
            pressed = max_lanes(now - wanted_change<false>(batch, parting, row.lightness, LaneMask{}, rule), lanes(0));
        }
        const Vector friction_now{batch.tx, batch.ty, batch.tz};
        const Vector wanted = friction_now - (mass_of(row.slip_lightness) * rule.over_relaxation) * slip;
        constexpr float kNoImpulseSquared = 1e-36f;
        const Lanes inverse = 1.0f / sqrt_lanes(max_lanes(dot(wanted, wanted), lanes(kNoImpulseSquared)));
        const Vector friction = min_lanes(batch.friction * (pressed + held) * inverse, lanes(1)) * wanted;
        const Vector impulse = (pressed - now) * normal + (friction - friction_now);
        push_back(a, row, impulse);
        b.push(row, normal, impulse);
        batch.normal_impulse = pressed;
        batch.tx = friction.x, batch.ty = friction.y, batch.tz = friction.z;
        store_copies(copies, row.a, a);
        b.store(batch, row, copies, velocities);
    }
}

// Composites turn as their inverse tensors say, spheres alike about all axes.
template <RowKind kKind>
MELD_INLINE void resist_turning_of(std::span<const Batch> batches, const CompositeRow* rows, TurningLanes* beside, CompositeCopy* copies,
                                   BodyVelocity* velocities, const Lanes* held, float step_s, const SweepRule& rule) {
    for (std::size_t n = 0; n < batches.size(); ++n) {
        const Batch& batch = batches[n];
        TurningLanes& own = beside[n];
        Lanes pressed = batch.normal_impulse;
        if (held != nullptr) pressed += held[n] * step_s;
        if (!may_resist(own, pressed)) continue;
        LaneCopies a = load_copies(copies, rows[n].a);
        Second<kKind> b;
        b.load(batch, rows[n], copies, velocities);
        Tensors ease = a.inverse_inertia;
        Vector spin;
        if constexpr (kKind == RowKind::Joint) {
            ease = ease + b.composite.inverse_inertia;
            spin = b.composite.spin;
        } else {
            const Lanes same = b.sphere.inverse_surface_mass * own.b_curvature * own.b_curvature, none = lanes(0);
            ease = ease + Tensors{same, none, none, same, none, same};
            spin = own.b_curvature * b.sphere.surface;
        }
        const Vector change = resist(own, {batch.nx, batch.ny, batch.nz}, pressed, spin - a.spin, ease, rule);
        a.spin = a.spin - a.inverse_inertia * change;
        if constexpr (kKind == RowKind::Joint)
            b.composite.spin = b.composite.spin + b.composite.inverse_inertia * change;
        else
            b.sphere.surface = b.sphere.surface + (b.sphere.inverse_surface_mass * own.b_curvature) * change;
        store_copies(copies, rows[n].a, a);
        b.store(batch, rows[n], copies, velocities);
    }
}

MELD_INLINE void resist_turning_of_rows_kernel(RowKind kind, std::span<const Batch> batches, const CompositeRow* rows, TurningLanes* beside,
                                               CompositeCopy* copies, BodyVelocity* velocities, const Lanes* held, float step_s,
                                               const SweepRule& rule) {
    if (kind == RowKind::Joint)
        resist_turning_of<RowKind::Joint>(batches, rows, beside, copies, velocities, held, step_s, rule);
    else
        resist_turning_of<RowKind::Mixed>(batches, rows, beside, copies, velocities, held, step_s, rule);
}

MELD_INLINE void refresh_rows_kernel(RowKind kind, std::span<const Batch> batches, CompositeRow* rows, const CompositeCopy* copies,
                                     const Place* centres, const Bodies& bodies) {
    if (kind == RowKind::Joint)
        refresh<RowKind::Joint>(batches, rows, copies, centres, bodies);
    else
        refresh<RowKind::Mixed>(batches, rows, copies, centres, bodies);
}
MELD_INLINE void warm_start_rows_kernel(RowKind kind, std::span<const Batch> batches, const CompositeRow* rows, CompositeCopy* copies,
                                        BodyVelocity* velocities) {
    if (kind == RowKind::Joint)
        start<RowKind::Joint>(batches, rows, copies, velocities);
    else
        start<RowKind::Mixed>(batches, rows, copies, velocities);
}
MELD_INLINE void sweep_rows_kernel(RowKind kind, std::span<Batch> batches, const CompositeRow* rows, CompositeCopy* copies,
                                   BodyVelocity* velocities, const Lanes* held, float step_s, const SweepRule& rule) {
    if (kind == RowKind::Joint && held == nullptr)
        sweep_one<RowKind::Joint, false>(batches, rows, copies, velocities, held, step_s, rule);
    else if (kind == RowKind::Joint)
        sweep_one<RowKind::Joint, true>(batches, rows, copies, velocities, held, step_s, rule);
    else if (held == nullptr)
        sweep_one<RowKind::Mixed, false>(batches, rows, copies, velocities, held, step_s, rule);
    else
        sweep_one<RowKind::Mixed, true>(batches, rows, copies, velocities, held, step_s, rule);
}

}  // namespace

MELD_KERNEL_VARIANTS(refresh_rows,
                     (RowKind kind, std::span<const Batch> batches, CompositeRow* rows, const CompositeCopy* copies, const Place* centres,
                      const Bodies& bodies),
                     (kind, batches, rows, copies, centres, bodies))
MELD_KERNEL_VARIANTS(warm_start_rows,
                     (RowKind kind, std::span<const Batch> batches, const CompositeRow* rows, CompositeCopy* copies,
                      BodyVelocity* velocities),
                     (kind, batches, rows, copies, velocities))
MELD_KERNEL_VARIANTS(sweep_rows,
                     (RowKind kind, std::span<Batch> batches, const CompositeRow* rows, CompositeCopy* copies, BodyVelocity* velocities,
                      const Lanes* held, float step_s, const SweepRule& rule),
                     (kind, batches, rows, copies, velocities, held, step_s, rule))

MELD_KERNEL_VARIANTS(resist_turning_of_rows,
                     (RowKind kind, std::span<const Batch> batches, const CompositeRow* rows, TurningLanes* beside, CompositeCopy* copies,
                      BodyVelocity* velocities, const Lanes* held, float step_s, const SweepRule& rule),
                     (kind, batches, rows, beside, copies, velocities, held, step_s, rule))

}  // namespace meld::physics
