// Where two spheres on straight paths touch first.
#pragma once

#include <optional>

#include "physics/terrain.h"
#include "physics/types.h"

namespace meld::physics {

// For the second sphere, `apart_m` from the first (centre to centre) and on its way along `path_m` relative to it: the normal from the
// first to the second where they touch, and the gap along it, which the path closes just there. Nothing if they overlap or do not meet.
std::optional<SurfaceContact> meet(Vec3 apart_m, double radii_m, Vec3 path_m);

}  // namespace meld::physics
