// Where an obstacle is that moves as the world says: its own frame, in which it always lies as it was given, within the world's.
#pragma once

#include <limits>

#include "physics/bodies/prescribed_motion.h"
#include "physics/bodies/types.h"

namespace meld::physics {

class MovingFrame {
  public:
    // `centre_m`, `radius_m`: of a ball around the obstacle before it moves. Infinite: of what has no end, which has this point.
    MovingFrame(const PrescribedMotion& motion, Vec3 centre_m, double radius_m);

    // Puts it where it is at a time, and gives it the mean velocity between two times; so all else is about these.
    void place(double time_s) { now_ = motion_.at({own_centre_m_, {}}, time_s); }
    void set_velocity(double from_s, double to_s);

    // Points and directions of the world in its own frame, and back.
    Vec3 into(Vec3 point) const { return own_centre_m_ + rotate(conjugate(now_.turn), point - now_.centre_m); }
    Vec3 turned_into(Vec3 way) const { return rotate(conjugate(now_.turn), way); }
    Vec3 out_of(Vec3 point) const { return now_.centre_m + turned_out_of(point - own_centre_m_); }
    Vec3 turned_out_of(Vec3 way) const { return rotate(now_.turn, way); }
    Quat turn() const { return now_.turn; }
    // Of what of it is at this place of the world, m/s.
    Vec3 velocity_at(Vec3 point) const { return velocity_.linear_m_s + cross(velocity_.spin_rad_s, point - now_.centre_m); }
    Vec3 spin_rad_s() const { return velocity_.spin_rad_s; }
    // At any time, of what of it a body at this place may meet.
    double greatest_speed_m_s(Vec3 body) const { return motion_.greatest_speed_m_s(lever_m(body)); }

    // A list of what may meet it begins here: it counts until the obstacle has gone so far that this is more than the list allows for,
    // which is at most `allowed_m`. In the step of `ahead_s` that follows, it goes on.
    void begin_list(double allowed_m, double ahead_s);
    // How much nearer it may come to a body at this place while the list counts.
    double way_of_list_m(Vec3 body) const { return allowed_m_ + ahead_s_ * greatest_speed_m_s(body); }
    // `bodies_m`: from its centre to the farthest body, asked only of what has no end.
    bool has_end() const { return radius_m_ < std::numeric_limits<double>::infinity(); }
    bool has_left_list(double bodies_m) const;
    Vec3 centre_m() const { return now_.centre_m; }

  private:
    // How far from the pivot a body at this place may meet it.
    double lever_m(Vec3 body) const;

    PrescribedMotion motion_;
    Vec3 own_centre_m_, pivot_m_;
    double radius_m_;
    PrescribedMotion::Place now_, listed_;
    PrescribedMotion::Velocity velocity_;
    double allowed_m_ = 0, ahead_s_ = 0;
};

}  // namespace meld::physics
