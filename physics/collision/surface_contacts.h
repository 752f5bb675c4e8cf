// Where a box, a cylinder or a capsule touches a surface of triangles: terrain or a mesh.
//
// Where a face of the body lies over triangles, or a corner of it over one, they touch along the normal of the triangle. An edge or a
// corner of the surface counts if no triangle beside it leads on towards the body; so nothing catches at the edges inside of an even face,
// and a body stands there on the same points as on a plane.
#pragma once

#include <array>
#include <span>

#include "physics/collision/core_contacts.h"
#include "physics/collision/terrain.h"
#include "physics/collision/triangle.h"

namespace meld::physics {

// The box around a body, as seen from the world.
struct Around {
    Vec3 low, high;
};
Around around(const Core& core, const Pose& pose);

// Which sides of triangles hold: that from which the corners are counter-clockwise, with everything behind it solid; or the one where the
// body's middle is.
enum class SurfaceSide : std::uint8_t { Outer, Both };

// The points nearer than `reach_m`, a manifold for each direction, the one with the deepest point first; returns their number. Directions
// that differ by a few degrees are one; of more than there is room for, those that reach deepest count. `triangles` are all that may be
// within the reach of the box around the body. Cost: some hundred nanoseconds a triangle, a few microseconds where edges meet.
int collide_with_surface(const Core& core, const Pose& pose, std::span<const Triangle> triangles, SurfaceSide side, double reach_m,
                         AxisHint& hint, std::array<Manifold, kMaxSurfaceContacts>& found);

}  // namespace meld::physics
