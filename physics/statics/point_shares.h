// How points share a force that acts at a place between them.
#pragma once

#include <span>

#include "physics/bodies/types.h"

namespace meld::physics {

// `arms`: of the points from the place, one or more; `shares`: as many, which are set. They add up to 1 and none is negative; the mean of
// the arms that they make is as near to 0 as can be, so where the place is between the points, the torque is that of the force there. Of
// several such shares, the most even ones. The method is that of active sets for least squares without negative numbers (C. Lawson,
// R. Hanson: "Solving Least Squares Problems", 1974, chapter 23). Cost: one small system where all points get a share, which takes as long
// as the points are many; at most four such systems for each point where some get none.
void shares_of(std::span<const Vec3> arms, std::span<double> shares);

}  // namespace meld::physics
