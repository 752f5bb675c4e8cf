// What contacts of ODE know of the surfaces that touch, beside friction along them.
#pragma once

#include <ode/ode.h>

#include <cmath>

#include "physics/bodies/material.h"
#include "physics/bodies/types.h"

namespace meld::physics {

// Friction against rolling and spinning is torques about the normal and two directions across it. With axes that differ, friction along
// both must be said, too.
inline void resist_turning(dSurfaceParameters& surface, const Material& one, const Material& other) {
    if (!one.resists_turning() && !other.resists_turning()) return;
    surface.mode |= dContactRolling | dContactAxisDep;
    surface.mu2 = surface.mu;
    surface.rho = surface.rho2 = static_cast<double>(common_rolling_m(one, other));
    surface.rhoN = static_cast<double>(common_spinning_m(one, other));
}

// The surface of an obstacle, where it has this velocity, takes along the body, which is ODE's first. ODE's normal leads out of the
// obstacle.
inline void move_surface(dContact& contact, Vec3 velocity_m_s) {
    const Vec3 normal{contact.geom.normal[0], contact.geom.normal[1], contact.geom.normal[2]};
    constexpr double kRounding = 1e-12;
    double out_m_s = dot(velocity_m_s, normal);
    if (std::abs(out_m_s) <= kRounding * length(velocity_m_s)) out_m_s = 0;
    if (out_m_s != 0) contact.surface.mode |= dContactMotionN, contact.surface.motionN = out_m_s;
    const Vec3 along = velocity_m_s - out_m_s * normal;
    const double speed = length(along);
    if (speed == 0) return;
    contact.surface.mode |= dContactFDir1 | dContactMotion1;
    contact.surface.motion1 = speed;
    contact.fdir1[0] = along.x / speed, contact.fdir1[1] = along.y / speed, contact.fdir1[2] = along.z / speed;
}

}  // namespace meld::physics
