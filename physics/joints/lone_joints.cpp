#include "physics/joints/lone_joints.h"

#include <algorithm>
#include <array>
#include <limits>

#include "physics/bodies/lanes.h"

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
    std::array<std::uint32_t, kAtOnce> joint = {}, assembly = {}, first = {}, second = {}, lowest = {};
    Chosen used = 0, simple = 0, alike = 0;
    // Those whose places are known; bodies that sleep have no masses to go by.
    Chosen placed = 0;
    // Which are simple is decided once for all in a substep, so that it does not depend on who shares the batch.
    bool known = false;
    // Of the joints, in the frames of their bodies.
    QuadVec first_anchor, second_anchor, first_axis, second_axis, first_across;
    QuadTurn first_turn, second_turn;
    // From the first body to the second.
    QuadVec between;
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
};
// Velocities, and what a joint does to them: a push at its anchor and turns about its two axes.
struct alignas(32) LoneJoints::Motion {
    QuadVec first_velocity, first_spin, second_velocity, second_spin;
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

// As the pass over bodies turns them: by the tangent of half the angle.
MELD_INLINE QuadTurn turned_in_step(const QuadTurn& q, const QuadVec& half) {
    const QuadTurn turned{q.w - half.x * q.x - half.y * q.y - half.z * q.z, q.x + half.x * q.w + half.y * q.z - half.z * q.y,
                          q.y - half.x * q.z + half.y * q.w + half.z * q.x, q.z + half.x * q.y - half.y * q.x + half.z * q.w};
    const DoubleQuad square = turned.w * turned.w + turned.x * turned.x + turned.y * turned.y + turned.z * turned.z;
    DoubleQuad size;
#pragma GCC unroll 4
    for (std::size_t i = 0; i < LoneJoints::kAtOnce; ++i) size[i] = __builtin_sqrt(square[i]);
    const DoubleQuad scale = 1 / size;
    return {scale * turned.w, scale * turned.x, scale * turned.y, scale * turned.z};
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
MELD_INLINE void place_four_kernel(LoneJoints::Batch& b) {
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

MELD_INLINE void start_four_kernel(const LoneJoints::Batch& b, LoneJoints::Motion& m) {
    const QuadVec push = m.push;
    const DoubleQuad across = m.across, along = m.along;
    m.push = {}, m.across = DoubleQuad{}, m.along = DoubleQuad{};
    act(b, m, push, across, along);
}

MELD_INLINE void relax_four_kernel(const LoneJoints::Batch& b, LoneJoints::Motion& m) { solve_straight(b, m, DoubleQuad{}); }

// First as if bodies moved along straight lines, then for where they will be.
MELD_INLINE void solve_four_kernel(const LoneJoints::Batch& b, LoneJoints::Motion& m, double step_s) {
    const double per_s = 1 / step_s, half = 0.5 * step_s;
    const DoubleQuad rate{per_s, per_s, per_s, per_s}, step{step_s, step_s, step_s, step_s}, halves{half, half, half, half};
    solve_straight(b, m, rate);
    const Errors errors =
        errors_at(b, turned_in_step(b.first_turn, halves * m.first_spin), turned_in_step(b.second_turn, halves * m.second_spin),
                  b.between + step * (m.second_velocity - m.first_velocity));
    const DoubleQuad back = -rate;
    solve_for(b, m, back * errors.apart, back * errors.across, back * errors.along);
}

MELD_KERNEL_VARIANTS(place_four, (LoneJoints::Batch & batch), (batch))
MELD_KERNEL_VARIANTS(start_four, (const LoneJoints::Batch& batch, LoneJoints::Motion& motion), (batch, motion))
MELD_KERNEL_VARIANTS(relax_four, (const LoneJoints::Batch& batch, LoneJoints::Motion& motion), (batch, motion))
MELD_KERNEL_VARIANTS(solve_four, (const LoneJoints::Batch& batch, LoneJoints::Motion& motion, double step_s), (batch, motion, step_s))

bool turns_freely(const Joint& joint) {
    if (joint.kind == JointKind::Ball) return true;
    constexpr double kEndless = std::numeric_limits<double>::infinity();
    return joint.kind == JointKind::Hinge && joint.stand == JointStand::Free && joint.drive == JointDrive::Kind::Coast &&
           !joint.is_spring() && joint.lower == -kEndless && joint.upper == kEndless && joint.impulses[kDriveRow] == 0;
}

// 1 / moment of inertia of a body that is turned alike about all axes; 0 if it is not.
double ease_of(std::uint32_t slot, const Bodies& bodies, const BodyShapes& shapes) {
    const BodyProperties& what = bodies.properties[slot];
    const BodyVelocity& velocity = bodies.velocity[slot];
    if ((what.flags & kShaped) == 0) {
        const double radius = bodies.place[slot].radius;
        return static_cast<double>(velocity.inverse_surface_mass) / (radius * radius);
    }
    const BodyShapes::Kind& kind = shapes.kind(shapes.of(what.id));
    return kind.turns_alike ? static_cast<double>(velocity.inverse_mass) / kind.inertia_per_kg_m2.x : 0;
}

}  // namespace

LoneJoints::LoneJoints() = default;
LoneJoints::~LoneJoints() = default;

std::size_t LoneJoints::batches() const { return batches_.size(); }
std::uint32_t LoneJoints::assembly(std::size_t batch, std::size_t i) const { return batches_[batch].assembly[i]; }
std::size_t LoneJoints::bytes() const { return batches_.capacity() * sizeof(Batch) + others_.capacity() * sizeof(std::uint32_t); }

void LoneJoints::lay_out(std::span<const Assembly> assemblies) {
    batches_.clear(), others_.clear();
    for (std::uint32_t a = 0; a < assemblies.size(); ++a) {
        const bool bodies = std::ranges::all_of(assemblies[a].members(),
                                                [](const Assembly::Member& m) { return m.movable && m.composite == kNoComposite; });
        if (assemblies[a].joints().size() != 1 || !bodies) {
            others_.push_back(a);
            continue;
        }
        if (batches_.empty() || batches_.back().used == (1U << kAtOnce) - 1) batches_.emplace_back();
        Batch& batch = batches_.back();
        const auto i = static_cast<std::size_t>(__builtin_popcount(batch.used));
        batch.used |= 1U << i;
        // Those after it, until they are used, are the same again.
        for (std::size_t k = i; k < kAtOnce; ++k) batch.joint[k] = assemblies[a].joints().front(), batch.assembly[k] = a;
    }
    locate(assemblies);
}

void LoneJoints::locate(std::span<const Assembly> assemblies) {
    for (Batch& batch : batches_) {
        batch.placed = 0, batch.known = false;
        for (std::size_t i = 0; i < kAtOnce; ++i) {
            const Assembly& assembly = assemblies[batch.assembly[i]];
            batch.first[i] = assembly.slot_of_first(), batch.second[i] = assembly.slot_of_second();
            batch.lowest[i] = assembly.members().front().slot;
        }
    }
}

void LoneJoints::places_changed() {
    for (Batch& batch : batches_) batch.placed = 0, batch.known = false;
}

void LoneJoints::place(Batch& batch, Chosen chosen, std::span<Joint> all, const Bodies& bodies, const BodyShapes& shapes) const {
    batch.placed = chosen;
    batch.alike = 0;
    for (std::size_t i = 0; i < kAtOnce; ++i) {
        const std::uint32_t one = batch.first[i], other = batch.second[i];
        batch.first_ease[i] = ease_of(one, bodies, shapes), batch.second_ease[i] = ease_of(other, bodies, shapes);
        batch.first_lightness[i] = static_cast<double>(bodies.velocity[one].inverse_mass);
        batch.second_lightness[i] = static_cast<double>(bodies.velocity[other].inverse_mass);
        Joint& joint = all[batch.joint[i]];
        if (batch.first_ease[i] > 0 && batch.second_ease[i] > 0 && joint.kind != JointKind::Slider) batch.alike |= 1U << i;
        const JointPose first = joint_pose(bodies, one), second = joint_pose(bodies, other);
        if ((chosen & batch.alike & 1U << i) != 0) joint.place = place_of(joint, first, second);
        set_lane(batch.first_turn, i, first.turn), set_lane(batch.second_turn, i, second.turn);
        set_lane(batch.between, i, second.centre_m - first.centre_m);
        set_lane(batch.first_anchor, i, joint.first_anchor), set_lane(batch.second_anchor, i, joint.second_anchor);
        set_lane(batch.first_axis, i, joint.first_axis), set_lane(batch.second_axis, i, joint.second_axis);
        set_lane(batch.first_across, i, joint.across);
    }
    place_four(batch);
}

void LoneJoints::choose(Batch& batch, std::span<const Joint> all) {
    batch.simple = 0;
    batch.known = true;
    for (std::size_t i = 0; i < kAtOnce; ++i)
        if ((batch.used & 1U << i) != 0 && turns_freely(all[batch.joint[i]])) batch.simple |= 1U << i;
}

LoneJoints::Chosen LoneJoints::awake(const Batch& batch, const Bodies& bodies) {
    Chosen chosen = 0;
    for (std::size_t i = 0; i < kAtOnce; ++i)
        if (bodies.velocity[batch.lowest[i]].inverse_mass != 0) chosen |= 1U << i;
    return batch.simple & chosen;
}

LoneJoints::Motion LoneJoints::read(const Batch& batch, const Bodies& bodies) {
    Motion motion;
    for (std::size_t i = 0; i < kAtOnce; ++i) {
        const BodyVelocity &one = bodies.velocity[batch.first[i]], &other = bodies.velocity[batch.second[i]];
        set_lane(motion.first_velocity, i, widened(one.linear)), set_lane(motion.second_velocity, i, widened(other.linear));
        set_lane(motion.first_spin, i, (1 / bodies.place[batch.first[i]].radius) * widened(one.surface));
        set_lane(motion.second_spin, i, (1 / bodies.place[batch.second[i]].radius) * widened(other.surface));
    }
    return motion;
}

void LoneJoints::write(const Batch& batch, Chosen chosen, const Motion& motion, std::span<Joint> all, Bodies& bodies) {
    for (std::size_t i = 0; i < kAtOnce; ++i) {
        if ((chosen & 1U << i) == 0) continue;
        BodyVelocity &one = bodies.velocity[batch.first[i]], &other = bodies.velocity[batch.second[i]];
        set_single(one.linear, lane(motion.first_velocity, i)), set_single(other.linear, lane(motion.second_velocity, i));
        set_single(one.surface, bodies.place[batch.first[i]].radius * lane(motion.first_spin, i));
        set_single(other.surface, bodies.place[batch.second[i]].radius * lane(motion.second_spin, i));
        Joint& joint = all[batch.joint[i]];
        joint.pushed = joint.pushed + lane(motion.push, i), joint.twisted = joint.twisted + lane(motion.twist, i);
    }
}

LoneJoints::Chosen LoneJoints::warm_start(std::size_t index, std::span<Joint> all, Bodies& bodies, const BodyShapes& shapes) {
    Batch& batch = batches_[index];
    choose(batch, all);
    Chosen chosen = awake(batch, bodies);
    if (chosen == 0) return batch.used;
    if ((chosen & ~batch.placed) != 0) place(batch, chosen, all, bodies, shapes);
    if ((chosen &= batch.alike) == 0) return batch.used;
    Motion motion = read(batch, bodies);
    for (std::size_t i = 0; i < kAtOnce; ++i) {
        const auto& impulses = all[batch.joint[i]].impulses;
        set_lane(motion.push, i, {impulses[0], impulses[1], impulses[2]});
        motion.across[i] = impulses[3], motion.along[i] = impulses[4];
    }
    start_four(batch, motion);
    write(batch, chosen, motion, all, bodies);
    return batch.used & ~chosen;
}

LoneJoints::Chosen LoneJoints::run(std::size_t index, Assembly::Phase phase, std::span<Joint> all, Bodies& bodies, const BodyShapes& shapes,
                                   double step_s) {
    Batch& batch = batches_[index];
    if (!batch.known) choose(batch, all);
    Chosen chosen = awake(batch, bodies);
    if (chosen == 0) return batch.used;
    if ((chosen & ~batch.placed) != 0) place(batch, chosen, all, bodies, shapes);
    if ((chosen &= batch.alike) == 0) return batch.used;
    Motion motion = read(batch, bodies);
    if (phase == Assembly::Phase::Solve)
        solve_four(batch, motion, step_s);
    else
        relax_four(batch, motion);
    write(batch, chosen, motion, all, bodies);
    if (phase == Assembly::Phase::Relax) return batch.used & ~chosen;
    for (std::size_t i = 0; i < kAtOnce; ++i) {
        if ((chosen & 1U << i) == 0) continue;
        auto& impulses = all[batch.joint[i]].impulses;
        const Vec3 push = lane(motion.push, i);
        impulses[0] += push.x, impulses[1] += push.y, impulses[2] += push.z;
        impulses[3] += motion.across[i], impulses[4] += motion.along[i];
    }
    return batch.used & ~chosen;
}

}  // namespace meld::physics
