// What moves as the world says, whatever touches it (kinematic bodies): shakers, turntables, tilting tables, which are fixed bodies here,
// or obstacles (moving_frame.h). Places are functions of time, so nothing but the time is saved, and all processes have the same ones.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "physics/bodies/bodies.h"
#include "physics/bodies/composites.h"
#include "physics/bodies/types.h"

namespace meld::physics {

// All of it together: at time t a body has turned by the tilt, then by the steady spin, both about the pivot, and is shifted by the swing.
// A swing follows the sine of 2 pi f t + phase, and begins where the body is placed.
struct PrescribedMotion {
    // Along this vector, by its length to both sides, m.
    Vec3 swing_m = {};
    // About this vector, by its length to both sides, rad.
    Vec3 tilt_rad = {};
    double frequency_hz = 0, phase_rad = 0;
    Vec3 spin_rad_s = {};
    // None: each body turns about its own centre.
    std::optional<Vec3> pivot_m = {};

    struct Place {
        Vec3 centre_m;
        Quat turn;
    };
    // Where a body is at this time that is at `start` at time 0. Some tens of nanoseconds.
    Place at(const Place& start, double time_s) const;
    // The velocity of the centre, m/s, and the angular velocity, rad/s, that bring it from one place to another one within a time.
    struct Velocity {
        Vec3 linear_m_s = {}, spin_rad_s = {};
    };
    static Velocity mean_velocity(const Place& from, const Place& to, double time_s);
    // Of a point at this distance from the pivot, of which each is an upper bound at all times: its speed, m/s, and how far it comes from
    // any place where it has been, m.
    double greatest_speed_m_s(double from_pivot_m) const;
    double range_m(double from_pivot_m) const;
};

// Which bodies have which motions. All subdomains know all of them, whether the bodies are here or not.
class PrescribedBodies {
  public:
    // Returns the number of the motion.
    std::uint32_t add(const PrescribedMotion& motion);
    std::size_t motion_count() const { return motions_.size(); }
    // The body is fixed. The last motion of a body counts. Cost: at most the number of such bodies.
    void prescribe(BodyId body, std::uint32_t motion, const PrescribedMotion::Place& start);
    bool empty() const { return bodies_.empty(); }
    bool has(BodyId body) const;

    // Puts those that are here where they are at a time, and with them the composites that they carry, whose members follow later.
    void place(Bodies& bodies, Composites& composites, double time_s) const;
    // The velocities that bring them in the mean from their places at one time to those at another.
    void set_velocities(Bodies& bodies, Composites& composites, double from_s, double to_s) const;

    // Calls f(slot) for those that are here.
    template <class F>
    void each_slot(const Bodies& bodies, const F& f) const {
        for (const Moved& moved : bodies_)
            if (bodies.has(moved.body)) f(bodies.slot(moved.body));
    }

  private:
    struct Moved {
        BodyId body;
        std::uint32_t motion;
        PrescribedMotion::Place start;
    };
    // Calls f(slot, where it started, its motion) for those that are here.
    template <class F>
    void each_here(const Bodies& bodies, const F& f) const;

    std::vector<PrescribedMotion> motions_;
    // Sorted.
    std::vector<Moved> bodies_;
};

}  // namespace meld::physics
