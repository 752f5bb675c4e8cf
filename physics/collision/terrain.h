// Spheres against terrain: two triangles per cell, split from the corner of least row and column to the corner of greatest row and column.
// Below the surface is ground, to any depth.
#pragma once

#include <array>
#include <optional>
#include <vector>

#include "physics/bodies/types.h"
#include "physics/collision/ray.h"
#include "physics/collision/triangle.h"

namespace meld::physics {

// Heights over a grid of columns x rows points that begins at `origin`, x running fastest. Below `origin.z + height` is ground.
struct Terrain {
    Vec3 origin = {};
    double cell_m = 1;
    int columns = 2;
    int rows = 2;
    std::vector<double> heights_m = {};
};

// Where a sphere touches an obstacle: the direction out of the obstacle, and the gap between the surfaces (negative: overlap).
struct SurfaceContact {
    Vec3 normal;
    double gap_m;
};

// A sphere meets a plane or a box in at most one point that matters, but uneven ground in several.
inline constexpr int kMaxSurfaceContacts = 4;

// From a point to the surface, m, negative below it; `range_m` if it is farther. Cost: grows with the number of cells within the range.
double distance_to(const Terrain& terrain, Vec3 point, double range_m);
// The contacts nearer than `reach_m`, the nearest first; returns their number. Points that lie below the tangent plane of a nearer contact
// do not count: even ground gives one contact, also at the edges of triangles.
int collide(const Terrain& terrain, Vec3 centre, double radius_m, double reach_m,
            std::array<SurfaceContact, kMaxSurfaceContacts>& contacts);
// Adds the triangles over, in or under a box, if they are not below it: what is in the ground is so at any depth.
void triangles_at(const Terrain& terrain, Vec3 low, Vec3 high, std::vector<Triangle>& found);
// As Obstacles::first_on. Cost: in proportion to the cells that the ray passes over.
std::optional<double> first_on(const Terrain& terrain, const Ray& ray);
// As Obstacles::meet.
std::optional<SurfaceContact> meet(const Terrain& terrain, Vec3 centre, double radius_m, Vec3 path);

}  // namespace meld::physics
