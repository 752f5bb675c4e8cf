// What follows the size of bodies unless a world says otherwise: times and speeds. A body of a diameter falls it in about
// sqrt(diameter / gravity), and everything that is a fixed share of this time is as exact for small bodies as for large ones.
#pragma once

#include <algorithm>
#include <cmath>

namespace meld {

inline constexpr double kEarthGravity_m_s2 = 9.81;

// Where gravity is weaker other forces move bodies, as fast as it would on earth.
inline double natural_gravity_m_s2(double gravity_m_s2) { return std::max(gravity_m_s2, kEarthGravity_m_s2); }

// A step that resolves the contacts of bodies from this diameter on: a 1/77 of the time that they take to fall so far. A contact then
// gives way by 2e-5 diameters for each body that rests on it.
inline double natural_step_s(double diameter_m, double gravity_m_s2) {
    constexpr double kStepOfAMetre_s = 1.0 / 240;
    return kStepOfAMetre_s * std::sqrt(diameter_m * (kEarthGravity_m_s2 / natural_gravity_m_s2(gravity_m_s2)));
}

// The speed that a body has gained when it has fallen half its diameter.
inline double natural_speed_m_s(double diameter_m, double gravity_m_s2) { return std::sqrt(diameter_m * gravity_m_s2); }

}  // namespace meld
