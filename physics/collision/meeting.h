// Where two spheres on straight paths touch first.
#pragma once

#include <optional>

#include "physics/bodies/types.h"
#include "physics/collision/terrain.h"

namespace meld::physics {

// For a second sphere at `apart_m` from the first (centre to centre) that moves along `path_m` relative to it: the normal from the first to
// the second where they touch, and the gap along it, which the path just closes. Nothing if they overlap or do not meet.
std::optional<SurfaceContact> meet(Vec3 apart_m, double radii_m, Vec3 path_m);

}  // namespace meld::physics
