#include "physics/joints/lone_joints.h"

#include <algorithm>
#include <array>
#include <limits>

#include "physics/bodies/lanes.h"
#include "runtime/base/prefetch.h"

namespace meld::physics {

// Four of each. Without AVX compilers align such vectors less than kernels with it expect.
struct alignas(32) QuadVec {
    DoubleQuad x = {}, y = {}, z = {};
};
struct alignas(32) QuadTurn {
    DoubleQuad w = {}, x = {}, y = {}, z = {};
};
struct alignas(32) QuadSymmetric {
    DoubleQuad xx = {}, xy = {}, xz = {}, yy = {}, yz = {}, zz = {};
};

struct alignas(32) LoneJoints::Batch {
    // The slots of the first bodies, then of the second ones.
    std::array<std::uint32_t, 2 * kAtOnce> slots = {};
    std::array<std::uint32_t, kAtOnce> joint = {}, assembly = {}, lowest = {};
    Chosen used = 0, simple = 0, alike = 0;
    // Whether these are simple has to be looked at again, for all at the same time, so that it does not depend on who shares the batch.
    Chosen unsure = 0;
    // Those whose places are known; bodies that sleep have no masses to go by.
    Chosen placed = 0;
    // Those whose `start`, `pushed` and `twisted` are here and not at their joints.
    Chosen held = 0;
    // Of the joints, in the frames of their bodies.
    QuadVec first_anchor, second_anchor, first_axis, second_axis, first_across;
    QuadTurn first_turn, second_turn;
    // From the first body to the second.
    QuadVec between;
    // The moment of inertia for each kg about any axis, or 0 if it is not the same about all; for balls, the square of the radius.
    alignas(32) DoubleQuad first_inertia = {}, second_inertia = {};
    alignas(32) DoubleQuad first_radius = {}, second_radius = {}, first_per_radius = {}, second_per_radius = {};
    alignas(32) DoubleQuad first_lightness = {}, second_lightness = {}, first_ease = {}, second_ease = {};
    // In the world: from the centres to the anchors, and the two axes that a hinge does not turn about. A ball has none.
    QuadVec first_arm, second_arm, across, along;
    // How far the halves of the anchor are apart, and tilts about the two axes.
    QuadVec apart;
    alignas(32) DoubleQuad across_tilt = {}, along_tilt = {};
    // The system: how pushes change the speeds of turning, the inverse for turning alone, and for pushes what is left.
    QuadVec of_across, of_along;
    alignas(32) DoubleQuad turning = {};
    QuadSymmetric pushing;
    // Impulses from which the next substep starts, and all of the step, as joints have them.
    QuadVec start;
    alignas(32) DoubleQuad start_across = {}, start_along = {};
    QuadVec pushed, twisted;
    // Whom the last pass of the substep has solved, and the velocities that it left: linear, then of surfaces. While nobody else changes
    // those, the next pass has nothing to do.
    Chosen solved = 0;
    Lanes left[6] = {};
};
// Velocities, and what a joint does to them: a push at its anchor and turns about its two axes.
struct alignas(32) LoneJoints::Motion {
    QuadVec first_velocity, first_spin, second_velocity, second_spin;
    // As the bodies have them, of the first ones and then the second.
    Lanes masses = {}, surface_masses = {};
    QuadVec push;
    alignas(32) DoubleQuad across = {}, along = {};
    // What the turns make together.
    QuadVec twist;
};

namespace {

MELD_INLINE QuadVec operator+(const QuadVec& a, const QuadVec& b) { return {a.x + b.x, a.y + b.y, a.z + b.z}; }
MELD_INLINE QuadVec operator-(const QuadVec& a, const QuadVec& b) { return {a.x - b.x, a.y - b.y, a.z - b.z}; }
MELD_INLINE QuadVec operator*(const DoubleQuad& s, const QuadVec& a) { return {s * a.x, s * a.y, s * a.z}; }
MELD_INLINE DoubleQuad dot(const QuadVec& a, const QuadVec& b) { return a.x * b.x + a.y * b.y + a.z * b.z; }
MELD_INLINE QuadVec cross(const QuadVec& a, const QuadVec& b) {
    return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}
MELD_INLINE QuadVec rotate(const QuadTurn& q, const QuadVec& v) {
    const QuadVec axis{q.x, q.y, q.z};
    const QuadVec half = cross(axis, v), t{half.x + half.x, half.y + half.y, half.z + half.z};
    return v + q.w * t + cross(axis, t);
}
MELD_INLINE void set_lane(QuadVec& to, std::size_t i, Vec3 v) { to.x[i] = v.x, to.y[i] = v.y, to.z[i] = v.z; }
MELD_INLINE void set_lane(QuadTurn& to, std::size_t i, Quat q) { to.w[i] = q.w, to.x[i] = q.x, to.y[i] = q.y, to.z[i] = q.z; }
MELD_INLINE Vec3 lane(const QuadVec& of, std::size_t i) { return {of.x[i], of.y[i], of.z[i]}; }
MELD_INLINE Quat lane(const QuadTurn& of, std::size_t i) { return {of.w[i], of.x[i], of.y[i], of.z[i]}; }

MELD_INLINE DoubleQuad wide(const Lanes& of, int half) { return __builtin_convertvector(half_of(of, half), DoubleQuad); }
MELD_INLINE QuadVec wide(const Lanes (&of)[4], int half) { return {wide(of[0], half), wide(of[1], half), wide(of[2], half)}; }
MELD_INLINE Lanes single(const DoubleQuad& first, const DoubleQuad& second) {
    return join(__builtin_convertvector(first, Quad), __builtin_convertvector(second, Quad));
}
MELD_INLINE DoubleQuad root(const DoubleQuad& square) {
    DoubleQuad result;
#pragma GCC unroll 4
    for (std::size_t i = 0; i < LoneJoints::kAtOnce; ++i) result[i] = __builtin_sqrt(square[i]);
    return result;
}
MELD_INLINE QuadTurn unit(const QuadTurn& q) {
    const DoubleQuad scale = 1 / root(q.w * q.w + q.x * q.x + q.y * q.y + q.z * q.z);
    return {scale * q.w, scale * q.x, scale * q.y, scale * q.z};
}

MELD_INLINE void read(const LoneJoints::Batch& b, const Quad* velocities, LoneJoints::Motion& m) {
    Lanes linear[4], surface[4];
    gather(velocities, 2, 0, b.slots.data(), linear);
    gather(velocities, 2, 1, b.slots.data(), surface);
    m.first_velocity = wide(linear, 0), m.second_velocity = wide(linear, 1);
    m.first_spin = b.first_per_radius * wide(surface, 0), m.second_spin = b.second_per_radius * wide(surface, 1);
    m.masses = linear[3], m.surface_masses = surface[3];
}
MELD_INLINE void unchanged_four_kernel(const LoneJoints::Batch& b, const Quad* velocities, LoneJoints::Chosen& unchanged) {
    Lanes linear[4], surface[4];
    gather(velocities, 2, 0, b.slots.data(), linear);
    gather(velocities, 2, 1, b.slots.data(), surface);
    LaneMask same = linear[0] == b.left[0];
    same &= linear[1] == b.left[1], same &= linear[2] == b.left[2];
    for (int k = 0; k < 3; ++k) same &= surface[k] == b.left[3 + k];
    unchanged = 0;
    for (std::size_t i = 0; i < LoneJoints::kAtOnce; ++i)
        if ((same[i] & same[LoneJoints::kAtOnce + i]) != 0) unchanged |= 1U << i;
}
MELD_INLINE void write(LoneJoints::Batch& b, const LoneJoints::Motion& m, Quad* velocities, const std::uint32_t* index) {
    const QuadVec one = b.first_radius * m.first_spin, other = b.second_radius * m.second_spin;
    const Lanes linear[4] = {single(m.first_velocity.x, m.second_velocity.x), single(m.first_velocity.y, m.second_velocity.y),
                             single(m.first_velocity.z, m.second_velocity.z), m.masses};
    const Lanes surface[4] = {single(one.x, other.x), single(one.y, other.y), single(one.z, other.z), m.surface_masses};
    scatter(velocities, 2, 0, index, linear);
    scatter(velocities, 2, 1, index, surface);
    for (int k = 0; k < 3; ++k) b.left[k] = linear[k], b.left[3 + k] = surface[k];
}

// As the pass over bodies turns them: by the tangent of half the angle.
MELD_INLINE QuadTurn turned_in_step(const QuadTurn& q, const QuadVec& half) {
    const QuadTurn turned{q.w - half.x * q.x - half.y * q.y - half.z * q.z, q.x + half.x * q.w + half.y * q.z - half.z * q.y,
                          q.y - half.x * q.z + half.y * q.w + half.z * q.x, q.z + half.x * q.y - half.y * q.x + half.z * q.w};
    return unit(turned);
}

struct Errors {
    QuadVec apart;
    DoubleQuad across, along;
};
// How far the joints are from where they should be, as errors_of has it.
MELD_INLINE Errors errors_at(const LoneJoints::Batch& batch, const QuadTurn& first, const QuadTurn& second, const QuadVec& between) {
    const QuadVec apart = between + (rotate(second, batch.second_anchor) - rotate(first, batch.first_anchor));
    const QuadVec axis = rotate(first, batch.first_axis), across = rotate(first, batch.first_across), along = cross(axis, across);
    const QuadVec tilt = cross(axis, rotate(second, batch.second_axis));
    return {apart, dot(across, tilt), dot(along, tilt)};
}

// Places, arms and the system.
MELD_INLINE void place_four_kernel(LoneJoints::Batch& b, const Quad* turns) {
    Lanes turn[4];
    gather(turns, 1, 0, b.slots.data(), turn);
    b.first_turn = unit(QuadTurn{wide(turn[0], 0), wide(turn[1], 0), wide(turn[2], 0), wide(turn[3], 0)});
    b.second_turn = unit(QuadTurn{wide(turn[0], 1), wide(turn[1], 1), wide(turn[2], 1), wide(turn[3], 1)});
    b.first_arm = rotate(b.first_turn, b.first_anchor), b.second_arm = rotate(b.second_turn, b.second_anchor);
    b.across = rotate(b.first_turn, b.first_across), b.along = cross(rotate(b.first_turn, b.first_axis), b.across);
    const Errors errors = errors_at(b, b.first_turn, b.second_turn, b.between);
    b.apart = errors.apart, b.across_tilt = errors.across, b.along_tilt = errors.along;
    const QuadVec arms = b.first_ease * b.first_arm + b.second_ease * b.second_arm;
    b.of_across = cross(b.across, arms), b.of_along = cross(b.along, arms);
    b.turning = 1 / (b.first_ease + b.second_ease);
    const DoubleQuad both = b.first_lightness + b.second_lightness + b.first_ease * dot(b.first_arm, b.first_arm) +
                            b.second_ease * dot(b.second_arm, b.second_arm);
    const auto entry = [&](DoubleQuad QuadVec::* r, DoubleQuad QuadVec::* c) MELD_INLINE_CALL {
        return b.first_ease * (b.first_arm.*r) * (b.first_arm.*c) + b.second_ease * (b.second_arm.*r) * (b.second_arm.*c) +
               b.turning * ((b.of_across.*r) * (b.of_across.*c) + (b.of_along.*r) * (b.of_along.*c));
    };
    const DoubleQuad xx = both - entry(&QuadVec::x, &QuadVec::x), yy = both - entry(&QuadVec::y, &QuadVec::y),
                     zz = both - entry(&QuadVec::z, &QuadVec::z), xy = -entry(&QuadVec::x, &QuadVec::y),
                     xz = -entry(&QuadVec::x, &QuadVec::z), yz = -entry(&QuadVec::y, &QuadVec::z);
    const DoubleQuad p = yy * zz - yz * yz, q = xz * yz - xy * zz, r = xy * yz - xz * yy;
    const DoubleQuad scale = 1 / (xx * p + xy * q + xz * r);
    b.pushing = {scale * p, scale * q, scale * r, scale * (xx * zz - xz * xz), scale * (xy * xz - xx * yz), scale * (xx * yy - xy * xy)};
}

MELD_INLINE void act(const LoneJoints::Batch& b, LoneJoints::Motion& m, const QuadVec& push, const DoubleQuad& across,
                     const DoubleQuad& along) {
    const QuadVec twist = across * b.across + along * b.along;
    m.first_velocity = m.first_velocity - b.first_lightness * push, m.second_velocity = m.second_velocity + b.second_lightness * push;
    m.first_spin = m.first_spin - b.first_ease * (cross(b.first_arm, push) + twist);
    m.second_spin = m.second_spin + b.second_ease * (cross(b.second_arm, push) + twist);
    m.push = m.push + push, m.twist = m.twist + twist;
    m.across += across, m.along += along;
}

// Acts so that the speeds change by these.
MELD_INLINE void solve_for(const LoneJoints::Batch& b, LoneJoints::Motion& m, const QuadVec& speed, const DoubleQuad& across,
                           const DoubleQuad& along) {
    const QuadVec right = speed - b.turning * (across * b.of_across + along * b.of_along);
    const QuadSymmetric& k = b.pushing;
    const QuadVec push{k.xx * right.x + k.xy * right.y + k.xz * right.z, k.xy * right.x + k.yy * right.y + k.yz * right.z,
                       k.xz * right.x + k.yz * right.y + k.zz * right.z};
    act(b, m, push, b.turning * (across - dot(b.of_across, push)), b.turning * (along - dot(b.of_along, push)));
}

// Acts so that the joints part no more, and what they are apart by is gone after 1 / rate.
MELD_INLINE void solve_straight(const LoneJoints::Batch& b, LoneJoints::Motion& m, const DoubleQuad& rate) {
    const QuadVec spin = m.second_spin - m.first_spin;
    const QuadVec speed = (m.second_velocity - m.first_velocity) + (cross(m.second_spin, b.second_arm) - cross(m.first_spin, b.first_arm));
    const QuadVec wanted{-speed.x - rate * b.apart.x, -speed.y - rate * b.apart.y, -speed.z - rate * b.apart.z};
    solve_for(b, m, wanted, -dot(b.across, spin) - rate * b.across_tilt, -dot(b.along, spin) - rate * b.along_tilt);
}

// Where a pass reads velocities and where it writes them: to the records at these places.
struct Records {
    const Quad* from;
    Quad* to;
    const std::uint32_t* index;
};

MELD_INLINE void finish(LoneJoints::Batch& b, const LoneJoints::Motion& m, const Records& records) {
    b.pushed = b.pushed + m.push, b.twisted = b.twisted + m.twist;
    write(b, m, records.to, records.index);
}

MELD_INLINE void start_four_kernel(LoneJoints::Batch& b, const Records& records) {
    LoneJoints::Motion m;
    read(b, records.from, m);
    act(b, m, b.start, b.start_across, b.start_along);
    finish(b, m, records);
}

MELD_INLINE void relax_four_kernel(LoneJoints::Batch& b, const Records& records) {
    LoneJoints::Motion m;
    read(b, records.from, m);
    solve_straight(b, m, DoubleQuad{});
    finish(b, m, records);
}

// Those that have nothing to do are as they were.
MELD_INLINE LoneJoints::Motion leave(LoneJoints::Chosen settled, const LoneJoints::Motion& before, const LoneJoints::Motion& after) {
    using Bits = long long __attribute__((vector_size(32)));
    Bits mask;
    for (std::size_t i = 0; i < LoneJoints::kAtOnce; ++i) mask[i] = (settled & 1U << i) != 0 ? -1 : 0;
    const auto of = [&](const DoubleQuad& a, const DoubleQuad& b) MELD_INLINE_CALL { return mask ? a : b; };
    const auto all = [&](const QuadVec& a, const QuadVec& b) MELD_INLINE_CALL { return QuadVec{of(a.x, b.x), of(a.y, b.y), of(a.z, b.z)}; };
    LoneJoints::Motion m = after;
    m.first_velocity = all(before.first_velocity, after.first_velocity), m.first_spin = all(before.first_spin, after.first_spin);
    m.second_velocity = all(before.second_velocity, after.second_velocity), m.second_spin = all(before.second_spin, after.second_spin);
    m.push = all({}, after.push), m.twist = all({}, after.twist);
    m.across = of(DoubleQuad{}, after.across), m.along = of(DoubleQuad{}, after.along);
    return m;
}

// First as if bodies moved along straight lines, then for where they will be.
MELD_INLINE void solve_four_kernel(LoneJoints::Batch& b, const Records& records, LoneJoints::Chosen settled, double step_s) {
    const double per_s = 1 / step_s, half = 0.5 * step_s;
    const DoubleQuad rate{per_s, per_s, per_s, per_s}, step{step_s, step_s, step_s, step_s}, halves{half, half, half, half};
    LoneJoints::Motion m;
    read(b, records.from, m);
    const LoneJoints::Motion before = m;
    solve_straight(b, m, rate);
    const Errors errors =
        errors_at(b, turned_in_step(b.first_turn, halves * m.first_spin), turned_in_step(b.second_turn, halves * m.second_spin),
                  b.between + step * (m.second_velocity - m.first_velocity));
    const DoubleQuad back = -rate;
    solve_for(b, m, back * errors.apart, back * errors.across, back * errors.along);
    if (settled != 0) m = leave(settled, before, m);
    b.start = b.start + m.push;
    b.start_across += m.across, b.start_along += m.along;
    finish(b, m, records);
}

MELD_KERNEL_VARIANTS(place_four, (LoneJoints::Batch & batch, const Quad* turns), (batch, turns))
MELD_KERNEL_VARIANTS(start_four, (LoneJoints::Batch & batch, const Records& records), (batch, records))
MELD_KERNEL_VARIANTS(relax_four, (LoneJoints::Batch & batch, const Records& records), (batch, records))
MELD_KERNEL_VARIANTS(solve_four, (LoneJoints::Batch & batch, const Records& records, LoneJoints::Chosen settled, double step_s),
                     (batch, records, settled, step_s))
MELD_KERNEL_VARIANTS(unchanged_four, (const LoneJoints::Batch& batch, const Quad* velocities, LoneJoints::Chosen& unchanged),
                     (batch, velocities, unchanged))

// Only the chosen joints act; the others may be the same ones again, or have no masses.
template <class Pass>
void write_chosen(const LoneJoints::Batch& batch, LoneJoints::Chosen chosen, Bodies& bodies, const Pass& pass) {
    const Quad* const from = reinterpret_cast<const Quad*>(bodies.velocity.data());
    if (chosen == (1U << LoneJoints::kAtOnce) - 1) {
        pass(Records{from, reinterpret_cast<Quad*>(bodies.velocity.data()), batch.slots.data()});
        return;
    }
    static constexpr std::array<std::uint32_t, 2 * LoneJoints::kAtOnce> kInOrder = {0, 1, 2, 3, 4, 5, 6, 7};
    std::array<BodyVelocity, 2 * LoneJoints::kAtOnce> written;
    pass(Records{from, reinterpret_cast<Quad*>(written.data()), kInOrder.data()});
    for (std::size_t i = 0; i < written.size(); ++i)
        if ((chosen & 1U << i % LoneJoints::kAtOnce) != 0) bodies.velocity[batch.slots[i]] = written[i];
}

bool turns_freely(const Joint& joint) {
    if (joint.kind == JointKind::Ball) return true;
    constexpr double kEndless = std::numeric_limits<double>::infinity();
    return joint.kind == JointKind::Hinge && joint.stand == JointStand::Free && joint.drive == JointDrive::Kind::Coast &&
           !joint.is_spring() && joint.lower == -kEndless && joint.upper == kEndless && joint.impulses[kDriveRow] == 0;
}

// The moment of inertia for each kg about any axis, or 0 if it is not the same about all; for a ball, the square of its radius.
double inertia_of(std::uint32_t slot, const Bodies& bodies, const BodyShapes& shapes) {
    const BodyProperties& what = bodies.properties[slot];
    const double radius = bodies.place[slot].radius;
    if ((what.flags & kShaped) == 0) return radius * radius;
    const BodyShapes::Kind& kind = shapes.kind(shapes.of(what.id));
    return kind.turns_alike ? kind.inertia_per_kg_m2.x : 0;
}
// 1 / moment of inertia; 0 if it is not the same about all axes, or nothing turns the body.
double ease_of(std::uint32_t slot, double inertia, const Bodies& bodies) {
    const BodyVelocity& velocity = bodies.velocity[slot];
    const bool shaped = (bodies.properties[slot].flags & kShaped) != 0;
    return inertia > 0 ? static_cast<double>(shaped ? velocity.inverse_mass : velocity.inverse_surface_mass) / inertia : 0;
}

}  // namespace

LoneJoints::LoneJoints() = default;
LoneJoints::~LoneJoints() = default;

std::size_t LoneJoints::batches() const { return batches_.size(); }
std::uint32_t LoneJoints::assembly(std::size_t batch, std::size_t i) const { return batches_[batch].assembly[i]; }
std::size_t LoneJoints::bytes() const { return batches_.capacity() * sizeof(Batch) + others_.capacity() * sizeof(std::uint32_t); }

void LoneJoints::lay_out(std::span<const Assembly> assemblies, std::span<const Joint> all, const Bodies& bodies, const BodyShapes& shapes) {
    batches_.clear(), others_.clear();
    for (std::uint32_t a = 0; a < assemblies.size(); ++a) {
        const bool alone = std::ranges::all_of(assemblies[a].members(),
                                               [](const Assembly::Member& m) { return m.movable && m.composite == kNoComposite; });
        if (assemblies[a].joints().size() != 1 || !alone) {
            others_.push_back(a);
            continue;
        }
        if (batches_.empty() || batches_.back().used == (1U << kAtOnce) - 1) batches_.emplace_back();
        Batch& batch = batches_.back();
        const auto i = static_cast<std::size_t>(__builtin_popcount(batch.used));
        batch.used |= 1U << i;
        // Those after it, until they are used, are the same again.
        for (std::size_t k = i; k < kAtOnce; ++k) {
            batch.joint[k] = assemblies[a].joints().front(), batch.assembly[k] = a;
            const Joint& joint = all[batch.joint[k]];
            set_lane(batch.first_anchor, k, joint.first_anchor), set_lane(batch.second_anchor, k, joint.second_anchor);
            set_lane(batch.first_axis, k, joint.first_axis), set_lane(batch.second_axis, k, joint.second_axis);
            set_lane(batch.first_across, k, joint.across);
        }
    }
    locate(assemblies, bodies, shapes);
}

void LoneJoints::locate(std::span<const Assembly> assemblies, const Bodies& bodies, const BodyShapes& shapes) {
    for (Batch& batch : batches_) {
        batch.placed = batch.solved = 0, batch.unsure = batch.used;
        for (std::size_t i = 0; i < kAtOnce; ++i) {
            const Assembly& assembly = assemblies[batch.assembly[i]];
            const std::uint32_t one = assembly.slot_of_first(), other = assembly.slot_of_second();
            batch.slots[i] = one, batch.slots[kAtOnce + i] = other;
            batch.lowest[i] = assembly.members().front().slot;
            batch.first_inertia[i] = inertia_of(one, bodies, shapes), batch.second_inertia[i] = inertia_of(other, bodies, shapes);
            batch.first_radius[i] = bodies.place[one].radius, batch.second_radius[i] = bodies.place[other].radius;
        }
        batch.first_per_radius = 1 / batch.first_radius, batch.second_per_radius = 1 / batch.second_radius;
    }
}

void LoneJoints::places_changed() {
    for (Batch& batch : batches_) batch.placed = batch.solved = 0, batch.unsure |= batch.used & ~batch.simple;
}

void LoneJoints::drives_changed() {
    for (Batch& batch : batches_) batch.unsure = batch.used;
}

void LoneJoints::place(Batch& batch, Chosen chosen, const Bodies& bodies) {
    batch.placed = chosen;
    batch.alike = 0;
    for (std::size_t i = 0; i < kAtOnce; ++i) {
        const std::uint32_t one = batch.slots[i], other = batch.slots[kAtOnce + i];
        batch.first_ease[i] = ease_of(one, batch.first_inertia[i], bodies),
        batch.second_ease[i] = ease_of(other, batch.second_inertia[i], bodies);
        batch.first_lightness[i] = static_cast<double>(bodies.velocity[one].inverse_mass);
        batch.second_lightness[i] = static_cast<double>(bodies.velocity[other].inverse_mass);
        if (batch.first_ease[i] > 0 && batch.second_ease[i] > 0) batch.alike |= 1U << i;
        set_lane(batch.between, i, centre_of(bodies.place[other]) - centre_of(bodies.place[one]));
    }
    place_four(batch, reinterpret_cast<const Quad*>(bodies.orientation.data()));
}

void LoneJoints::choose(Batch& batch, std::span<const Joint> all) {
    for (std::size_t i = 0; i < kAtOnce; ++i) {
        const Chosen bit = 1U << i;
        if ((batch.unsure & bit) == 0) continue;
        batch.simple = turns_freely(all[batch.joint[i]]) ? batch.simple | bit : batch.simple & ~bit;
    }
    batch.unsure = 0;
}

LoneJoints::Chosen LoneJoints::awake(const Batch& batch, const Bodies& bodies) {
    Chosen chosen = 0;
    for (std::size_t i = 0; i < kAtOnce; ++i)
        if (bodies.velocity[batch.lowest[i]].inverse_mass != 0) chosen |= 1U << i;
    return batch.simple & chosen;
}

void LoneJoints::give_back(Batch& batch, Chosen chosen, std::span<Joint> all) {
    for (std::size_t i = 0; i < kAtOnce; ++i) {
        if ((batch.held & chosen & 1U << i) == 0) continue;
        Joint& joint = all[batch.joint[i]];
        const Vec3 start = lane(batch.start, i);
        joint.impulses = {start.x, start.y, start.z, batch.start_across[i], batch.start_along[i], joint.impulses[kDriveRow]};
        joint.pushed = lane(batch.pushed, i), joint.twisted = lane(batch.twisted, i);
    }
    batch.held &= ~chosen;
}

LoneJoints::Chosen LoneJoints::prepare(Batch& batch, std::span<Joint> all, const Bodies& bodies) {
    if (batch.unsure != 0) choose(batch, all);
    Chosen chosen = awake(batch, bodies);
    if ((chosen & ~batch.placed) != 0) place(batch, chosen, bodies);
    if (chosen != 0) chosen &= batch.alike;
    if ((batch.held & ~chosen) != 0) give_back(batch, ~chosen, all);
    for (std::size_t i = 0; i < kAtOnce; ++i) {
        if ((chosen & ~batch.held & 1U << i) == 0) continue;
        const Joint& joint = all[batch.joint[i]];
        set_lane(batch.start, i, {joint.impulses[0], joint.impulses[1], joint.impulses[2]});
        batch.start_across[i] = joint.impulses[3], batch.start_along[i] = joint.impulses[4];
        set_lane(batch.pushed, i, joint.pushed), set_lane(batch.twisted, i, joint.twisted);
    }
    batch.held |= chosen;
    return chosen;
}

void LoneJoints::ask_for_next(std::size_t index, const Bodies& bodies) const {
    constexpr std::size_t kAhead = 4;
    if (index + kAhead >= batches_.size()) return;
    for (const std::uint32_t slot : batches_[index + kAhead].slots) ask_for(&bodies.velocity[slot]);
}

LoneJoints::Chosen LoneJoints::warm_start(std::size_t index, std::span<Joint> all, Bodies& bodies) {
    Batch& batch = batches_[index];
    ask_for_next(index, bodies);
    batch.unsure |= batch.used & ~batch.simple;
    const Chosen chosen = prepare(batch, all, bodies);
    if (chosen != 0) write_chosen(batch, chosen, bodies, [&](const Records& records) { start_four(batch, records); });
    batch.solved = 0;
    return batch.used & ~chosen;
}

LoneJoints::Chosen LoneJoints::run(std::size_t index, Assembly::Phase phase, std::span<Joint> all, Bodies& bodies, double step_s) {
    Batch& batch = batches_[index];
    ask_for_next(index, bodies);
    const Chosen chosen = prepare(batch, all, bodies);
    Chosen settled = 0;
    if (phase == Assembly::Phase::Solve && (chosen & batch.solved) != 0) {
        unchanged_four(batch, reinterpret_cast<const Quad*>(bodies.velocity.data()), settled);
        settled &= chosen & batch.solved;
    }
    if (settled == chosen) return batch.used & ~chosen;
    write_chosen(batch, chosen, bodies, [&](const Records& records) {
        phase == Assembly::Phase::Solve ? solve_four(batch, records, settled, step_s) : relax_four(batch, records);
    });
    batch.solved = phase == Assembly::Phase::Solve ? chosen : 0;
    return batch.used & ~chosen;
}

LoneJoints::Chosen LoneJoints::end_step(std::size_t index, std::span<Joint> all, const Bodies& bodies, double dt_s,
                                        std::span<std::optional<std::uint32_t>> breaks) {
    Batch& batch = batches_[index];
    const Chosen chosen = batch.held;
    if ((chosen & ~batch.placed) != 0) place(batch, chosen, bodies);
    give_back(batch, chosen, all);
    Motion motion;
    read(batch, reinterpret_cast<const Quad*>(bodies.velocity.data()), motion);
    const DoubleQuad speed = dot(rotate(batch.first_turn, batch.first_axis), motion.second_spin - motion.first_spin);
    for (std::size_t i = 0; i < kAtOnce; ++i) {
        if ((chosen & 1U << i) == 0) continue;
        Joint& joint = all[batch.joint[i]];
        // Its angle is the one that is nearest to where it should be.
        joint.place += dt_s * speed[i];
        joint.place = place_of(joint, {{}, lane(batch.first_turn, i)}, {{}, lane(batch.second_turn, i)});
        if (joint.end_step(lane(batch.between, i), dt_s) > 1) breaks[batch.assembly[i]] = batch.joint[i];
    }
    return batch.used & ~chosen;
}

void LoneJoints::forget_impulses() {
    for (Batch& batch : batches_) batch.start = {}, batch.start_across = batch.start_along = DoubleQuad{};
}

void LoneJoints::forget_step() {
    for (Batch& batch : batches_) batch.held = 0;
}

}  // namespace meld::physics
