// The passes over contacts. A body of radius r that turns with angular velocity w has rim velocity u = r w; at a contact with
// normal n (from a to b) the surfaces move apart with v_b - v_a - (u_a + u_b) x n, so no lever arm is needed.
#include "physics/kernels.h"

namespace meld::physics {

namespace {

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

// The motions of eight bodies.
struct Movers {
    Vector velocity;
    Lanes inverse_mass;
    Vector rim;
    Lanes inverse_rim_mass;
};

constexpr int kQuadsOfMotion = 2;

MELD_INLINE Movers load(const Motion* motions, const std::uint32_t* slots) {
    const Quad* quads = reinterpret_cast<const Quad*>(motions);
    Lanes linear[4], angular[4];
    gather(quads, kQuadsOfMotion, 0, slots, linear);
    gather(quads, kQuadsOfMotion, 1, slots, angular);
    return {{linear[0], linear[1], linear[2]}, linear[3], {angular[0], angular[1], angular[2]}, angular[3]};
}

MELD_INLINE void store(Motion* motions, const std::uint32_t* slots, const Movers& movers) {
    Quad* quads = reinterpret_cast<Quad*>(motions);
    scatter(quads, kQuadsOfMotion, 0, slots, {movers.velocity.x, movers.velocity.y, movers.velocity.z, movers.inverse_mass});
    scatter(quads, kQuadsOfMotion, 1, slots, {movers.rim.x, movers.rim.y, movers.rim.z, movers.inverse_rim_mass});
}

// Impulse `along` the normal and `across` it, on b and reversed on a.
MELD_INLINE void push_apart(Movers& a, Movers& b, const Vector& normal, const Lanes& along, const Vector& across) {
    const Vector impulse = along * normal + across;
    const Vector twist = cross(normal, across);
    a.velocity = a.velocity - a.inverse_mass * impulse;
    b.velocity = b.velocity + b.inverse_mass * impulse;
    a.rim = a.rim - a.inverse_rim_mass * twist;
    b.rim = b.rim - b.inverse_rim_mass * twist;
}

MELD_INLINE bool refresh_pairs_kernel(std::span<Batch> batches, const Place* places, float deepest) {
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
        bad |= somebody & (gap < -deepest * radii);
        batch.gap = physics::select(somebody, gap, lanes(kNoContactGap));
        batch.nx = normal.x, batch.ny = normal.y, batch.nz = normal.z;
        const Vector friction{batch.tx, batch.ty, batch.tz};
        const Vector turned = friction - dot(friction, normal) * normal;
        batch.tx = turned.x, batch.ty = turned.y, batch.tz = turned.z;
    }
    return any(bad);
}

MELD_INLINE void warm_start_kernel(std::span<const Batch> batches, Motion* motions) {
    for (const Batch& batch : batches) {
        Movers a = load(motions, batch.a), b = load(motions, batch.b);
        push_apart(a, b, {batch.nx, batch.ny, batch.nz}, batch.normal_impulse, {batch.tx, batch.ty, batch.tz});
        store(motions, batch.a, a);
        store(motions, batch.b, b);
    }
}

// The inverse of a sum of inverse masses, 0 where it is 0: between two bodies that cannot move nothing changes, and the
// impulses wait until one of them wakes.
MELD_INLINE Lanes mass_of(const Lanes& lightness) {
    constexpr float kLightest = 1e-30f;
    return keep(lightness > 0.0f, 1.0f / max_lanes(lightness, lanes(kLightest)));
}

// The change of the normal impulse that a contact asks for, before the impulse is kept from pulling. `holds`: lanes with a
// latch, which pull a gap together as they push an overlap apart.
template <bool kAdhesive>
MELD_INLINE Lanes wanted_change(const Batch& batch, const Lanes& parting, const Lanes& lightness, LaneMask holds, const SweepRule& rule) {
    const Lanes gap = batch.gap;
    LaneMask pressed = gap <= 0.0f;
    Lanes bias =
        max_lanes(gap, lanes(0)) * rule.apart_rate + max_lanes(min_lanes(gap, lanes(0)) * rule.overlap_rate, lanes(-rule.push_speed));
    if constexpr (kAdhesive) {
        pressed |= holds;
        bias = physics::select(holds, min_lanes(max_lanes(gap * rule.overlap_rate, lanes(-rule.push_speed)), lanes(rule.push_speed)), bias);
    }
    const Lanes mass_scale = 1.0f + keep(pressed, lanes(rule.mass_scale - 1));
    const Lanes kept_back = keep(pressed & (lightness > 0.0f), rule.impulse_scale * batch.normal_impulse);
    return (mass_of(lightness) * mass_scale * rule.over_relaxation) * (parting + bias) + kept_back;
}

template <bool kAdhesive>
MELD_INLINE void sweep_batches(std::span<Batch> batches, const Lanes* adhesion, float step_s, Motion* motions, const SweepRule& rule) {
    for (std::size_t n = 0; n < batches.size(); ++n) {
        Batch& batch = batches[n];
        Movers a = load(motions, batch.a), b = load(motions, batch.b);
        const Vector normal{batch.nx, batch.ny, batch.nz};
        const Lanes lightness = a.inverse_mass + b.inverse_mass;
        const Lanes rim_mass = mass_of(lightness + (a.inverse_rim_mass + b.inverse_rim_mass));

        const Vector apart = b.velocity - a.velocity;
        const Lanes parting = dot(apart, normal);
        const Vector slip = apart - cross(a.rim + b.rim, normal) - parting * normal;
        const Lanes now = batch.normal_impulse;
        Lanes pressed, held = lanes(0);
        if constexpr (kAdhesive) {
            held = adhesion[n] * step_s;
            pressed = max_lanes(now - wanted_change<true>(batch, parting, lightness, held > 0.0f, rule), -held);
        } else {
            pressed = max_lanes(now - wanted_change<false>(batch, parting, lightness, LaneMask{}, rule), lanes(0));
        }

        const Vector friction_now{batch.tx, batch.ty, batch.tz};
        const Vector wanted = friction_now - (rim_mass * rule.over_relaxation) * slip;
        constexpr float kNoImpulseSquared = 1e-36f;
        const Lanes inverse = 1.0f / sqrt_lanes(max_lanes(dot(wanted, wanted), lanes(kNoImpulseSquared)));
        const Lanes scale = min_lanes(batch.friction * (pressed + held) * inverse, lanes(1));
        const Vector friction = scale * wanted;

        push_apart(a, b, normal, pressed - now, friction - friction_now);
        batch.normal_impulse = pressed;
        batch.tx = friction.x, batch.ty = friction.y, batch.tz = friction.z;
        store(motions, batch.a, a);
        store(motions, batch.b, b);
    }
}

MELD_INLINE void sweep_kernel(std::span<Batch> batches, Motion* motions, const SweepRule& rule) {
    sweep_batches<false>(batches, nullptr, 0, motions, rule);
}
MELD_INLINE void sweep_adhesive_kernel(std::span<Batch> batches, const Lanes* adhesion, float step_s, Motion* motions,
                                       const SweepRule& rule) {
    sweep_batches<true>(batches, adhesion, step_s, motions, rule);
}

}  // namespace

namespace {
#if defined(__x86_64__)
bool refresh_pairs_baseline(std::span<Batch> batches, const Place* places, float deepest) {
    return refresh_pairs_kernel(batches, places, deepest);
}
__attribute__((target("avx2"))) bool refresh_pairs_avx2(std::span<Batch> batches, const Place* places, float deepest) {
    return refresh_pairs_kernel(batches, places, deepest);
}
#endif
}  // namespace

MELD_KERNEL_VARIANTS(warm_start, (std::span<const Batch> batches, Motion* motions), (batches, motions))
MELD_KERNEL_VARIANTS(sweep, (std::span<Batch> batches, Motion* motions, const SweepRule& rule), (batches, motions, rule))
MELD_KERNEL_VARIANTS(sweep_adhesive,
                     (std::span<Batch> batches, const Lanes* adhesion, float step_s, Motion* motions, const SweepRule& rule),
                     (batches, adhesion, step_s, motions, rule))

SquareSums measure_residual(std::span<const Batch> batches, const Motion* motions, const SweepRule& rule) {
    SquareSums sums;
    for (const Batch& batch : batches) {
        const Movers a = load(motions, batch.a), b = load(motions, batch.b);
        const Lanes parting = dot(b.velocity - a.velocity, {batch.nx, batch.ny, batch.nz});
        const Lanes wanted = wanted_change<false>(batch, parting, a.inverse_mass + b.inverse_mass, LaneMask{}, rule);
        const Lanes change = max_lanes(batch.normal_impulse - wanted, lanes(0)) - batch.normal_impulse;
        for (int i = 0; i < kLanes; ++i) {
            sums.change += static_cast<double>(change[i]) * static_cast<double>(change[i]);
            sums.impulse += static_cast<double>(batch.normal_impulse[i]) * static_cast<double>(batch.normal_impulse[i]);
        }
    }
    return sums;
}

void note_approach(std::span<const Batch> batches, std::span<Bounce> bounces, const Motion* motions, float least_speed) {
    for (std::size_t n = 0; n < batches.size(); ++n) {
        const Batch& batch = batches[n];
        const Movers a = load(motions, batch.a), b = load(motions, batch.b);
        const Lanes parting = dot(b.velocity - a.velocity, {batch.nx, batch.ny, batch.nz});
        bounces[n].speed = physics::select(parting < -least_speed, -bounces[n].restitution * parting, lanes(0));
        bounces[n].peak = lanes(0);
    }
}

void note_peak(std::span<const Batch> batches, std::span<Bounce> bounces) {
    for (std::size_t n = 0; n < batches.size(); ++n) bounces[n].peak = max_lanes(bounces[n].peak, batches[n].normal_impulse);
}

void bounce(std::span<Batch> batches, std::span<const Bounce> bounces, Motion* motions) {
    for (std::size_t n = 0; n < batches.size(); ++n) {
        Batch& batch = batches[n];
        const LaneMask bouncing = (bounces[n].speed > 0.0f) & (bounces[n].peak > 0.0f);
        if (!any(bouncing)) continue;
        Movers a = load(motions, batch.a), b = load(motions, batch.b);
        const Vector normal{batch.nx, batch.ny, batch.nz};
        const Lanes lightness = a.inverse_mass + b.inverse_mass;
        const LaneMask acts = bouncing & (lightness > 0.0f);
        const Lanes mass = 1.0f / physics::select(acts, lightness, lanes(1));
        const Lanes parting = dot(b.velocity - a.velocity, normal);
        const Lanes now = batch.normal_impulse;
        const Lanes pressed = physics::select(acts, max_lanes(now - mass * (parting - bounces[n].speed), lanes(0)), now);
        push_apart(a, b, normal, pressed - now, {lanes(0), lanes(0), lanes(0)});
        batch.normal_impulse = pressed;
        store(motions, batch.a, a);
        store(motions, batch.b, b);
    }
}

bool refresh_pairs(std::span<Batch> batches, const Place* places, float deepest) {
#if defined(__x86_64__)
    if (simd_level() == SimdLevel::Avx2) return refresh_pairs_avx2(batches, places, deepest);
    return refresh_pairs_baseline(batches, places, deepest);
#else
    return refresh_pairs_kernel(batches, places, deepest);
#endif
}

}  // namespace meld::physics
