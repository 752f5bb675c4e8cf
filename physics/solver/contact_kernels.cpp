// The passes over contacts. A body of radius r and angular velocity w has surface velocity u = r w; at a contact with normal n (from a to
// b) the surfaces separate with v_b - v_a - (u_a + u_b) x n, so no lever arm is needed.
#include "physics/solver/kernels.h"
#include "physics/solver/lane_contacts.h"
#include "physics/solver/turning/turning_lanes.h"

namespace meld::physics {

namespace {

MELD_INLINE bool refresh_pairs_kernel(std::span<Batch> batches, const Place* places, float max_overlap) {
    LaneMask bad = {};
    for (Batch& batch : batches) {
        Quad rows[kLanes];
#pragma GCC unroll 8
        for (int i = 0; i < kLanes; ++i) {
            const DoubleQuad a = *reinterpret_cast<const DoubleQuad*>(places + batch.a[i]);
            const DoubleQuad b = *reinterpret_cast<const DoubleQuad*>(places + batch.b[i]);
            const DoubleQuad difference = b - a, sum = b + a;
            rows[i] = __builtin_convertvector(__builtin_shufflevector(difference, sum, 0, 1, 2, 7), Quad);
        }
        const Lanes joined[4] = {join(rows[0], rows[4]), join(rows[1], rows[5]), join(rows[2], rows[6]), join(rows[3], rows[7])};
        Lanes columns[4];
        transpose(joined, columns);
        const Vector apart{columns[0], columns[1], columns[2]};
        const Lanes radii = columns[3];
        const Lanes distance = sqrt_lanes(dot(apart, apart));
        // Bodies in the same place are pushed apart upwards.
        const LaneMask together = distance < 1e-20f;
        const Lanes inverse = 1.0f / physics::select(together, lanes(1), distance);
        const Vector normal = select(together, {lanes(0), lanes(0), lanes(1)}, inverse * apart);
        const LaneMask somebody = radii > 0.0f;
        const Lanes gap = distance - radii;
        bad |= somebody & (gap < -max_overlap * radii);
        batch.gap = physics::select(somebody, gap, lanes(kNoContactGap));
        batch.nx = normal.x, batch.ny = normal.y, batch.nz = normal.z;
        const Vector friction{batch.tx, batch.ty, batch.tz};
        const Vector turned = friction - dot(friction, normal) * normal;
        batch.tx = turned.x, batch.ty = turned.y, batch.tz = turned.z;
    }
    return any(bad);
}

MELD_INLINE void warm_start_kernel(std::span<const Batch> batches, BodyVelocity* velocities) {
    for (const Batch& batch : batches) {
        LaneVelocities a = load(velocities, batch.a), b = load(velocities, batch.b);
        apply_impulse(a, b, {batch.nx, batch.ny, batch.nz}, batch.normal_impulse, {batch.tx, batch.ty, batch.tz});
        store(velocities, batch.a, a);
        store(velocities, batch.b, b);
    }
}

template <bool kAdhesive>
MELD_INLINE void sweep_batches(std::span<Batch> batches, const Lanes* adhesion, float step_s, BodyVelocity* velocities,
                               const SweepRule& rule) {
    for (std::size_t n = 0; n < batches.size(); ++n) {
        Batch& batch = batches[n];
        LaneVelocities a = load(velocities, batch.a), b = load(velocities, batch.b);
        const Vector normal{batch.nx, batch.ny, batch.nz};
        const Lanes lightness = a.inverse_mass + b.inverse_mass;
        const Lanes surface_mass = mass_of(lightness + (a.inverse_surface_mass + b.inverse_surface_mass));

        const Vector apart = b.linear - a.linear;
        const Lanes parting = dot(apart, normal);
        const Vector slip = apart - cross(a.surface + b.surface, normal) - parting * normal;
        const Lanes now = batch.normal_impulse;
        Lanes pressed, held = lanes(0);
        if constexpr (kAdhesive) {
            held = adhesion[n] * step_s;
            pressed = max_lanes(now - wanted_change<true>(batch, parting, lightness, held > 0.0f, rule), -held);
        } else {
            pressed = max_lanes(now - wanted_change<false>(batch, parting, lightness, LaneMask{}, rule), lanes(0));
        }

        const Vector friction_now{batch.tx, batch.ty, batch.tz};
        const Vector wanted = friction_now - (surface_mass * rule.over_relaxation) * slip;
        constexpr float kNoImpulseSquared = 1e-36f;
        const Lanes inverse = 1.0f / sqrt_lanes(max_lanes(dot(wanted, wanted), lanes(kNoImpulseSquared)));
        const Lanes scale = min_lanes(batch.friction * (pressed + held) * inverse, lanes(1));
        const Vector friction = scale * wanted;

        apply_impulse(a, b, normal, pressed - now, friction - friction_now);
        batch.normal_impulse = pressed;
        batch.tx = friction.x, batch.ty = friction.y, batch.tz = friction.z;
        store(velocities, batch.a, a);
        store(velocities, batch.b, b);
    }
}

MELD_INLINE void sweep_kernel(std::span<Batch> batches, BodyVelocity* velocities, const SweepRule& rule) {
    sweep_batches<false>(batches, nullptr, 0, velocities, rule);
}
MELD_INLINE void sweep_adhesive_kernel(std::span<Batch> batches, const Lanes* adhesion, float step_s, BodyVelocity* velocities,
                                       const SweepRule& rule) {
    sweep_batches<true>(batches, adhesion, step_s, velocities, rule);
}

// The inverse moment of inertia of a sphere is its inverse surface mass times the square of its curvature.
MELD_INLINE void resist_turning_kernel(std::span<const Batch> batches, TurningLanes* beside, const Lanes* adhesion, float step_s,
                                       BodyVelocity* velocities, const SweepRule& rule) {
    for (std::size_t n = 0; n < batches.size(); ++n) {
        const Batch& batch = batches[n];
        TurningLanes& own = beside[n];
        Lanes pressed = batch.normal_impulse;
        if (adhesion != nullptr) pressed += adhesion[n] * step_s;
        if (!may_resist(own, pressed)) continue;
        LaneVelocities a = load(velocities, batch.a), b = load(velocities, batch.b);
        const Lanes a_ease = a.inverse_surface_mass * own.a_curvature, b_ease = b.inverse_surface_mass * own.b_curvature;
        const Vector change =
            resist(own, {batch.nx, batch.ny, batch.nz}, pressed, own.b_curvature * b.surface - own.a_curvature * a.surface,
                   a_ease * own.a_curvature + b_ease * own.b_curvature, rule);
        a.surface = a.surface - a_ease * change;
        b.surface = b.surface + b_ease * change;
        store(velocities, batch.a, a);
        store(velocities, batch.b, b);
    }
}

// The lanes that bounce, for bodies that separate at this speed.
MELD_INLINE LaneMask bouncing_lanes(const Batch& batch, const Lanes& restitution, const Lanes& parting, const Lanes& lightness,
                                    const BounceRule& rule) {
    return (restitution > 0.0f) & (parting < -rule.min_speed) & (lightness > 0.0f) & (batch.gap < rule.margin - rule.step_s * parting);
}

// What accelerates eight bodies, m/s^2.
MELD_INLINE Vector acceleration(const LaneVelocities& bodies, const std::uint32_t* slots, const BounceRule& rule) {
    const LaneMask mobile = bodies.inverse_mass > 0.0f;
    Vector sum{keep(mobile, lanes(rule.gravity[0])), keep(mobile, lanes(rule.gravity[1])), keep(mobile, lanes(rule.gravity[2]))};
    for (const Wrench* wrenches : rule.wrenches) {
        if (wrenches == nullptr) continue;
        for (int i = 0; i < kLanes; ++i) {
            if (!mobile[i]) continue;
            const float(&force)[3] = wrenches[slots[i]].force;
            sum.x[i] += bodies.inverse_mass[i] * force[0];
            sum.y[i] += bodies.inverse_mass[i] * force[1];
            sum.z[i] += bodies.inverse_mass[i] * force[2];
        }
    }
    return sum;
}

// The speed at which bodies separate after they have bounced, where they are now: before they touch. At the moment of impact, which is
// within the substep, they approach faster (or slower) than now by what accelerates them on the way, `pull` (along the normal), and lose it
// again on the way back; restitution is of the speed at impact. Velocities belong to the middle of the substep before, since positions move
// by those of its end, so the present ones are half a substep's acceleration further on. Without both, an elastic bounce would lose a
// height of substep times speed.
MELD_INLINE Lanes speed_after(const Lanes& parting, const Lanes& gap, const Lanes& pull, const Lanes& restitution, const BounceRule& rule) {
    const Lanes half = (0.5f * rule.step_s) * pull;
    const Lanes approach = max_lanes(-(parting + half), lanes(0));
    const Lanes gained = -2.0f * pull * max_lanes(gap, lanes(0));
    const Lanes impact_squared = max_lanes(approach * approach + gained, lanes(0));
    const Lanes here_squared = max_lanes(restitution * restitution * impact_squared - gained, lanes(0));
    return min_lanes(sqrt_lanes(here_squared), approach) - half;
}

MELD_INLINE void bounce_kernel(std::span<Batch> batches, std::span<Bounce> bounces, BodyVelocity* velocities, const BounceRule& rule) {
    for (std::size_t n = 0; n < batches.size(); ++n) {
        Batch& batch = batches[n];
        LaneVelocities a = load(velocities, batch.a), b = load(velocities, batch.b);
        const Vector normal{batch.nx, batch.ny, batch.nz};
        const Vector apart = b.linear - a.linear;
        const Lanes parting = dot(apart, normal);
        const Lanes lightness = a.inverse_mass + b.inverse_mass;
        const LaneMask bouncing = bouncing_lanes(batch, bounces[n].restitution, parting, lightness, rule);
        if (!any(bouncing)) continue;
        const Lanes pull = keep(bouncing, dot(acceleration(b, batch.b, rule) - acceleration(a, batch.a, rule), normal));
        const Lanes after = speed_after(parting, keep(bouncing, batch.gap), pull, bounces[n].restitution, rule);
        const Lanes along = keep(bouncing, mass_of(lightness) * max_lanes(after - parting, lanes(0)));
        // The impulse that stops the slip of the surfaces, as far as friction can.
        const Lanes surface_mass = mass_of(lightness + (a.inverse_surface_mass + b.inverse_surface_mass));
        const Vector slip = apart - cross(a.surface + b.surface, normal) - parting * normal;
        constexpr float kNoSlipSquared = 1e-30f;
        const Lanes speed = sqrt_lanes(max_lanes(dot(slip, slip), lanes(kNoSlipSquared)));
        const Lanes across = min_lanes(surface_mass, batch.friction * along / speed);
        apply_impulse(a, b, normal, along, -across * slip);
        store(velocities, batch.a, a);
        store(velocities, batch.b, b);
        bounces[n].impulse += along;
        // The impulse from before no longer presses.
        for (Lanes* kept : {&batch.normal_impulse, &batch.tx, &batch.ty, &batch.tz}) *kept = keep(~bouncing, *kept);
    }
}

MELD_INLINE void look_for_bounces_kernel(std::span<const Batch> batches, std::span<const Bounce> bounces, const BodyVelocity* velocities,
                                         const BounceRule& rule, bool& found) {
    for (std::size_t n = 0; !found && n < batches.size(); ++n) {
        const Batch& batch = batches[n];
        const LaneVelocities a = load(velocities, batch.a), b = load(velocities, batch.b);
        const Lanes parting = dot(b.linear - a.linear, {batch.nx, batch.ny, batch.nz});
        found = any(bouncing_lanes(batch, bounces[n].restitution, parting, a.inverse_mass + b.inverse_mass, rule));
    }
}

}  // namespace

namespace {
#if defined(__x86_64__)
bool refresh_pairs_baseline(std::span<Batch> batches, const Place* places, float max_overlap) {
    return refresh_pairs_kernel(batches, places, max_overlap);
}
__attribute__((target("avx2"))) bool refresh_pairs_avx2(std::span<Batch> batches, const Place* places, float max_overlap) {
    return refresh_pairs_kernel(batches, places, max_overlap);
}
#endif
}  // namespace

MELD_KERNEL_VARIANTS(warm_start, (std::span<const Batch> batches, BodyVelocity* velocities), (batches, velocities))
MELD_KERNEL_VARIANTS(sweep, (std::span<Batch> batches, BodyVelocity* velocities, const SweepRule& rule), (batches, velocities, rule))
MELD_KERNEL_VARIANTS(sweep_adhesive,
                     (std::span<Batch> batches, const Lanes* adhesion, float step_s, BodyVelocity* velocities, const SweepRule& rule),
                     (batches, adhesion, step_s, velocities, rule))

MELD_KERNEL_VARIANTS(resist_turning,
                     (std::span<const Batch> batches, TurningLanes* beside, const Lanes* adhesion, float step_s, BodyVelocity* velocities,
                      const SweepRule& rule),
                     (batches, beside, adhesion, step_s, velocities, rule))
MELD_KERNEL_VARIANTS(bounce, (std::span<Batch> batches, std::span<Bounce> bounces, BodyVelocity* velocities, const BounceRule& rule),
                     (batches, bounces, velocities, rule))
MELD_KERNEL_VARIANTS(look_for_bounces,
                     (std::span<const Batch> batches, std::span<const Bounce> bounces, const BodyVelocity* velocities,
                      const BounceRule& rule, bool& found),
                     (batches, bounces, velocities, rule, found))

SquareSums measure_residual(std::span<const Batch> batches, const BodyVelocity* velocities, const SweepRule& rule) {
    SquareSums sums;
    for (const Batch& batch : batches) {
        const LaneVelocities a = load(velocities, batch.a), b = load(velocities, batch.b);
        const Lanes parting = dot(b.linear - a.linear, {batch.nx, batch.ny, batch.nz});
        const Lanes wanted = wanted_change<false>(batch, parting, a.inverse_mass + b.inverse_mass, LaneMask{}, rule);
        const Lanes change = max_lanes(batch.normal_impulse - wanted, lanes(0)) - batch.normal_impulse;
        for (int i = 0; i < kLanes; ++i) {
            sums.change += static_cast<double>(change[i]) * static_cast<double>(change[i]);
            sums.impulse += static_cast<double>(batch.normal_impulse[i]) * static_cast<double>(batch.normal_impulse[i]);
        }
    }
    return sums;
}

bool refresh_pairs(std::span<Batch> batches, const Place* places, float max_overlap) {
#if defined(__x86_64__)
    if (simd_level() == SimdLevel::Avx2) return refresh_pairs_avx2(batches, places, max_overlap);
    return refresh_pairs_baseline(batches, places, max_overlap);
#else
    return refresh_pairs_kernel(batches, places, max_overlap);
#endif
}

}  // namespace meld::physics
