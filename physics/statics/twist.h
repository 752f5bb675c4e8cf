// Small displacements of rigid bodies (a translation, then a rotation) and what acts on them (a force, then a torque), as six numbers.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "physics/statics/connection_load.h"

namespace meld::physics {

using Vector6 = Eigen::Matrix<double, 6, 1>;
using Matrix6 = Eigen::Matrix<double, 6, 6>;
using Twists = std::vector<Vector6>;

inline Vector6 six(Vec3 first, Vec3 second) { return (Vector6() << first.x, first.y, first.z, second.x, second.y, second.z).finished(); }
inline Vec3 first_of(const Vector6& v) { return {v[0], v[1], v[2]}; }
inline Vec3 second_of(const Vector6& v) { return {v[3], v[4], v[5]}; }

// Of a body that moves by v about a point: how it moves about the point at `arm` from there.
inline Vector6 displaced(const Vector6& v, Vec3 arm) { return six(first_of(v) + cross(second_of(v), arm), second_of(v)); }
// The same as a matrix. Its transpose takes what acts about that point to the former one.
inline Matrix6 displacement(Vec3 arm) {
    Matrix6 m = Matrix6::Identity();
    m(0, 4) = arm.z, m(0, 5) = -arm.y;
    m(1, 3) = -arm.z, m(1, 5) = arm.x;
    m(2, 3) = arm.y, m(2, 4) = -arm.x;
    return m;
}
// What acts about the point at `arm`, about the former one.
inline Vector6 acting_from(const Vector6& f, Vec3 arm) { return six(first_of(f), second_of(f) + cross(arm, first_of(f))); }

}  // namespace meld::physics
