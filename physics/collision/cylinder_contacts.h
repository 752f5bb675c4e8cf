// Where a cylinder with a rounded rim touches a line, a box, another cylinder or a plane (core_contacts.h, which alone calls this).
//
// Flat on a face it stands on four points of its rim, one of which is the lowest, and the hint says which place on the body that is; on its
// side it lies on two; and where a rim meets an edge or another rim, the point is exactly the nearest one.
#pragma once

#include "physics/collision/core_contacts.h"

namespace meld::physics {

// One of the cores is a cylinder, and the other one is no point. Cost: 30 ns for two that are far apart, below a microsecond for faces and
// for sides, a few where rims meet.
void collide_cylinder(const Core& a, const Pose& a_pose, const Core& b, const Pose& b_pose, double reach_m, AxisHint& hint,
                      Manifold& found);

// As collide_with_plane; the caller has set the normal.
void collide_cylinder_with_plane(const Core& a, const Pose& a_pose, Vec3 normal, double offset_m, double reach_m, AxisHint& hint,
                                 Manifold& found);

}  // namespace meld::physics
