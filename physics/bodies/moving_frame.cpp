#include "physics/bodies/moving_frame.h"

#include <algorithm>

#include "physics/bodies/symmetric.h"

namespace meld::physics {

MovingFrame::MovingFrame(const PrescribedMotion& motion, Vec3 centre_m, double radius_m)
    : motion_(motion),
      own_centre_m_(centre_m),
      pivot_m_(motion.pivot_m.value_or(centre_m)),
      radius_m_(radius_m),
      now_{centre_m, {}},
      listed_(now_) {}

void MovingFrame::set_velocity(double from_s, double to_s) {
    const PrescribedMotion::Place start{own_centre_m_, {}};
    velocity_ = PrescribedMotion::mean_velocity(motion_.at(start, from_s), motion_.at(start, to_s), to_s - from_s);
}

// The pivot itself swings by up to twice its way.
double MovingFrame::lever_m(Vec3 body) const {
    if (has_end()) return length(own_centre_m_ - pivot_m_) + radius_m_;
    return length(body - pivot_m_) + 2 * length(motion_.swing_m);
}

// What swings a little never leaves the list.
void MovingFrame::begin_list(double allowed_m, double ahead_s) {
    listed_ = now_;
    ahead_s_ = ahead_s;
    const bool turns = motion_.spin_rad_s != Vec3{} || motion_.tilt_rad != Vec3{};
    allowed_m_ = has_end() || !turns ? std::min(allowed_m, motion_.range_m(turns ? lever_m({}) : 0)) : allowed_m;
}

// The chord of a turn by an angle about the centre is twice the sine of half of it, times the distance.
bool MovingFrame::has_left_list(double bodies_m) const {
    const Quat turned = product(now_.turn, conjugate(listed_.turn));
    const double chord = 2 * length({turned.x, turned.y, turned.z});
    return length(now_.centre_m - listed_.centre_m) + chord * (has_end() ? radius_m_ : bodies_m) > allowed_m_ * (1 + 1e-9);
}

}  // namespace meld::physics
