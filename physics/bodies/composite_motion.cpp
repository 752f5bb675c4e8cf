// The passes of a step over composites, and over their members.
#include <algorithm>

#include "physics/bodies/composites.h"
#include "physics/bodies/stage.h"
#include "runtime/base/assert.h"

namespace meld::physics {

namespace {

constexpr std::size_t kCompositesPerJob = 256;

Orientation orientation_of(Quat q) {
    return {static_cast<float>(q.w), static_cast<float>(q.x), static_cast<float>(q.y), static_cast<float>(q.z)};
}

// m v, of a tensor in the frame of a body turned by q.
Vec3 seen_from_world(const Symmetric& m, Quat q, Vec3 v) { return rotate(q, m * rotate(conjugate(q), v)); }

// The free motion of a rigid body keeps its angular momentum but for rounding: the spin is what it implies in each attitude, and turns
// the body by that of the middle of the step.
void turn_freely(const Composite& composite, CompositeMotion& motion, double step_s) {
    const Vec3 angular = seen_from_world(composite.inertia, motion.turn, motion.spin_rad_s);
    motion.turn = composite.turned_freely(motion.turn, motion.spin_rad_s, step_s);
    motion.spin_rad_s = seen_from_world(composite.inverse_inertia, motion.turn, angular);
}

bool rests(const Composite& composite) { return composite.rests(); }

}  // namespace

Quat Composite::turned_freely(Quat from, Vec3 spin_rad_s, double step_s) const {
    const Vec3 angular = seen_from_world(inertia, from, spin_rad_s);
    const Quat middle = turned_by(from, (0.5 * step_s) * spin_rad_s);
    return turned_by(from, step_s * seen_from_world(inverse_inertia, middle, angular));
}

template <class F>
void Composites::each_composite(Workers& workers, const F& f) {
    workers.run((composites_.size() + kCompositesPerJob - 1) / kCompositesPerJob, [&](int, std::size_t job) {
        const std::size_t end = std::min(composites_.size(), (job + 1) * kCompositesPerJob);
        for (std::size_t c = job * kCompositesPerJob; c < end; ++c)
            if (!composites_[c].rests()) f(composites_[c]);
    });
}

template <class LeftOut, class F>
void Composites::each_range(Workers& workers, const LeftOut& left_out, const F& f) const {
    workers.run(jobs_.empty() ? 0 : jobs_.size() - 1, [&](int, std::size_t job) {
        for (std::size_t r = jobs_[job]; r < jobs_[job + 1]; ++r) {
            const Composite& composite = composites_[ranges_[r].composite];
            if (left_out(composite)) continue;
            f(composite, std::span(members_).subspan(ranges_[r].first, ranges_[r].end - ranges_[r].first));
        }
    });
}

void Composites::accelerate(const Wrench* first_wrench, const Wrench* second_wrench, const Bodies& bodies, const MoveRule& rule,
                            Workers& workers) {
    const auto step_s = static_cast<double>(rule.step_s);
    const Vec3 gravity = widened(rule.gravity);
    each_composite(workers, [&](Composite& composite) {
        if (composite.carried()) return;
        CompositeMotion& motion = composite.motion;
        Vec3 force, torque;
        for (const Wrench* wrenches : {first_wrench, second_wrench}) {
            if (!wrenches) continue;
            for (const Member& member : members(composite)) {
                const Wrench& wrench = wrenches[member.slot];
                const Vec3 pull = widened(wrench.force);
                force = force + pull;
                torque = torque + (widened(wrench.torque) + cross(centre_of(bodies.place[member.slot]) - motion.centre_m, pull));
            }
        }
        composite.pushed_m_s2 = (1 / composite.mass_kg) * force;
        motion.velocity_m_s = static_cast<double>(rule.linear_kept) * (motion.velocity_m_s + step_s * (gravity + composite.pushed_m_s2));
        const Vec3 gained = seen_from_world(composite.inverse_inertia, motion.turn, torque);
        motion.spin_rad_s = static_cast<double>(rule.angular_kept) * (motion.spin_rad_s + step_s * gained);
    });
}

void Composites::move(Bodies& bodies, double step_s, Workers& workers) {
    each_composite(workers, [&](Composite& composite) {
        CompositeMotion& motion = composite.motion;
        motion.centre_m = motion.centre_m + step_s * motion.velocity_m_s;
        if (composite.carried())
            motion.turn = turned_by(motion.turn, step_s * motion.spin_rad_s);
        else
            turn_freely(composite, motion, step_s);
    });
    // The pass over bodies moves them and measures how fast and how far.
    each_range(workers, rests, [&](const Composite& composite, std::span<const Member> some) {
        const CompositeMotion& motion = composite.motion;
        for (const Member& member : some) {
            BodyVelocity& velocity = bodies.velocity[member.slot];
            const Place& place = bodies.place[member.slot];
            const Vec3 way = (motion.centre_m - centre_of(place)) + rotate(motion.turn, member.offset_m);
            set_single(velocity.linear, (1 / step_s) * way);
            set_single(velocity.surface, place.radius * motion.spin_rad_s);
        }
    });
}

void Composites::place_members(Bodies& bodies, Workers& workers) const {
    each_range(workers, rests, [&](const Composite& composite, std::span<const Member> some) {
        const CompositeMotion& motion = composite.motion;
        for (const Member& member : some) {
            const Vec3 arm = rotate(motion.turn, member.offset_m), where = motion.centre_m + arm;
            Place& place = bodies.place[member.slot];
            place.x = where.x, place.y = where.y, place.z = where.z;
            bodies.orientation[member.slot] = orientation_of(product(motion.turn, member.turn));
            set_single(bodies.velocity[member.slot].linear, composite.velocity_at(arm));
            set_single(bodies.velocity[member.slot].surface, place.radius * motion.spin_rad_s);
        }
    });
}

void Composites::set_velocities(Bodies& bodies, const Composite& composite, std::span<const Member> some) {
    for (const Member& member : some) {
        const Place& place = bodies.place[member.slot];
        set_single(bodies.velocity[member.slot].linear, composite.velocity_at(centre_of(place) - composite.motion.centre_m));
        set_single(bodies.velocity[member.slot].surface, place.radius * composite.motion.spin_rad_s);
    }
}

void Composites::set_velocities(Bodies& bodies, Workers& workers) const {
    each_range(workers, rests, [&](const Composite& composite, std::span<const Member> some) { set_velocities(bodies, composite, some); });
}

void Composites::set_all_velocities(Bodies& bodies, Workers& workers) const {
    const auto sleeps = [](const Composite& composite) { return composite.asleep != 0; };
    each_range(workers, sleeps, [&](const Composite& composite, std::span<const Member> some) { set_velocities(bodies, composite, some); });
}

}  // namespace meld::physics
