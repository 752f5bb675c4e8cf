// Times and speeds that follow the size of bodies unless a world sets them. A body falls its own diameter in about sqrt(diameter /
// gravity), and everything that is a fixed share of this time is as exact for small bodies as for large ones.
#pragma once

#include <algorithm>
#include <cmath>

namespace meld {

inline constexpr double kEarthGravity_m_s2 = 9.81;

// Where gravity is weaker, other forces move bodies, as fast as they would on earth.
inline double natural_gravity_m_s2(double gravity_m_s2) { return std::max(gravity_m_s2, kEarthGravity_m_s2); }

// A step that resolves the contacts of bodies of this diameter and larger: 1/77 of the time in which they fall that far. A contact then
// gives way by 2e-5 diameters for each body that rests on it.
inline double natural_step_s(double diameter_m, double gravity_m_s2) {
    constexpr double kStepOfAMetre_s = 1.0 / 240;
    return kStepOfAMetre_s * std::sqrt(diameter_m * (kEarthGravity_m_s2 / natural_gravity_m_s2(gravity_m_s2)));
}

// The speed of a body that has fallen half its diameter.
inline double natural_speed_m_s(double diameter_m, double gravity_m_s2) { return std::sqrt(diameter_m * gravity_m_s2); }

}  // namespace meld
