#include "physics/bodies/prescribed_motion.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "physics/bodies/symmetric.h"
#include "runtime/base/assert.h"

namespace meld::physics {

namespace {

// Of an angle in whole turns. By products of numbers alone, so that it has the same bits on all processors.
double sine_of_turns(double turns) {
    const Quat half = turned_by({}, {2 * std::numbers::pi * (turns - std::floor(turns)), 0, 0});
    return 2 * half.w * half.x;
}

// Turned about a vector by its length times a number, rad.
Quat turn_about(Vec3 axis, double factor) {
    const double size = length(axis), turns = size * factor / (2 * std::numbers::pi);
    return turns == 0 ? Quat{} : turned_by({}, ((turns - std::floor(turns)) * 2 * std::numbers::pi / size) * axis);
}

// The mean angular velocity that turns one attitude into the other, by less than half a turn.
Vec3 mean_spin(Quat from, Quat to, double time_s) {
    const Quat way = product(to, conjugate(from));
    const Vec3 part{way.x, way.y, way.z};
    const double sine = length(part);
    if (sine == 0) return {};
    const double angle = 2 * std::atan2(sine, std::abs(way.w));
    return ((way.w < 0 ? -angle : angle) / (sine * time_s)) * part;
}

Orientation single_of(Quat q) {
    return {static_cast<float>(q.w), static_cast<float>(q.x), static_cast<float>(q.y), static_cast<float>(q.z)};
}

// The composite that a body carries, or null.
Composite* carried_by(BodyId body, const BodyProperties& what, Composites& composites) {
    if ((what.flags & kMember) == 0) return nullptr;
    const std::uint32_t composite = composites.composite_of(body);
    if (composite == kNoComposite || composites.all()[composite].carrier != body) return nullptr;
    return &composites.all()[composite];
}

}  // namespace

PrescribedMotion::Place PrescribedMotion::at(const Place& start, double time_s) const {
    const double phase = phase_rad / (2 * std::numbers::pi);
    const double swung = sine_of_turns(frequency_hz * time_s + phase) - sine_of_turns(phase);
    const Quat turn = product(turn_about(spin_rad_s, time_s), turn_about(tilt_rad, swung));
    const Vec3 pivot = pivot_m.value_or(start.centre_m);
    return {pivot + rotate(turn, start.centre_m - pivot) + swung * swing_m, product(turn, start.turn)};
}

PrescribedMotion::Velocity PrescribedMotion::mean_velocity(const Place& from, const Place& to, double time_s) {
    return {(1 / time_s) * (to.centre_m - from.centre_m), mean_spin(from.turn, to.turn, time_s)};
}

double PrescribedMotion::greatest_speed_m_s(double from_pivot_m) const {
    const double rate = 2 * std::numbers::pi * frequency_hz;
    return rate * length(swing_m) + (rate * length(tilt_rad) + length(spin_rad_s)) * from_pivot_m;
}

// Two sines differ by at most 2, and a chord is no longer than its arc or the diameter.
double PrescribedMotion::range_m(double from_pivot_m) const {
    const double turned = spin_rad_s == Vec3{} ? std::min(length(tilt_rad), 1.0) : 1;
    return 2 * length(swing_m) + 2 * turned * from_pivot_m;
}

std::uint32_t PrescribedBodies::add(const PrescribedMotion& motion) {
    motions_.push_back(motion);
    return static_cast<std::uint32_t>(motions_.size() - 1);
}

void PrescribedBodies::prescribe(BodyId body, std::uint32_t motion, const PrescribedMotion::Place& start) {
    MELD_EXPECT(motion < motions_.size(), "motion {} of {}", motion, motions_.size());
    const auto at = std::ranges::lower_bound(bodies_, body, {}, &Moved::body);
    if (at != bodies_.end() && at->body == body)
        *at = {body, motion, start};
    else
        bodies_.insert(at, {body, motion, start});
}

bool PrescribedBodies::has(BodyId body) const { return std::ranges::binary_search(bodies_, body, {}, &Moved::body); }

template <class F>
void PrescribedBodies::each_here(const Bodies& bodies, const F& f) const {
    for (const Moved& moved : bodies_)
        if (bodies.has(moved.body)) f(bodies.slot(moved.body), moved.start, motions_[moved.motion]);
}

void PrescribedBodies::place(Bodies& bodies, Composites& composites, double time_s) const {
    each_here(bodies, [&](std::uint32_t slot, const PrescribedMotion::Place& start, const PrescribedMotion& motion) {
        const PrescribedMotion::Place now = motion.at(start, time_s);
        Place& place = bodies.place[slot];
        place = {now.centre_m.x, now.centre_m.y, now.centre_m.z, place.radius};
        bodies.orientation[slot] = single_of(now.turn);
        const BodyId body = bodies.properties[slot].id;
        Composite* const composite = carried_by(body, bodies.properties[slot], composites);
        if (composite == nullptr) return;
        // Its frame is the world's when it is made, in which the carrier may be turned.
        composite->motion.centre_m = now.centre_m;
        composite->motion.turn = product(now.turn, conjugate(unit(composites.member_of(body).turn)));
    });
}

void PrescribedBodies::set_velocities(Bodies& bodies, Composites& composites, double from_s, double to_s) const {
    each_here(bodies, [&](std::uint32_t slot, const PrescribedMotion::Place& start, const PrescribedMotion& motion) {
        const PrescribedMotion::Place from = motion.at(start, from_s), to = motion.at(start, to_s);
        const auto [velocity, spin] = PrescribedMotion::mean_velocity(from, to, to_s - from_s);
        set_single(bodies.velocity[slot].linear, velocity);
        set_single(bodies.velocity[slot].surface, bodies.place[slot].radius * spin);
        if (Composite* composite = carried_by(bodies.properties[slot].id, bodies.properties[slot], composites))
            composite->motion.velocity_m_s = velocity, composite->motion.spin_rad_s = spin;
    });
}

}  // namespace meld::physics
