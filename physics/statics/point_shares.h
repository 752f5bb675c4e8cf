// How points share a force that acts at a place between them.
#pragma once

#include <array>
#include <span>

#include "physics/bodies/types.h"
#include "physics/collision/core_contacts.h"

namespace meld::physics {

using PointShares = std::array<double, kMaxManifoldPoints>;

// `arms`: of one to four points from the place. The shares add up to 1 and none is negative; the mean of the arms that they make is as near
// to 0 as can be, so where the place is between the points, the torque is that of the force at the place. Of several such shares, the most
// even ones. Cost: a microsecond.
PointShares shares_of(std::span<const Vec3> arms);

}  // namespace meld::physics
