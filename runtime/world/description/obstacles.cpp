#include "runtime/world/description/obstacles.h"

#include <fmt/format.h>

#include <numbers>
#include <optional>

#include "runtime/base/assert.h"
#include "runtime/world/shapes/surface.h"

namespace meld::world {

physics::Shape shape_of(const ObstacleOptions& o, double diameter_m) {
    const auto to_metres = [&](const Vec3& v) { return physics::Vec3{diameter_m * v[0], diameter_m * v[1], diameter_m * v[2]}; };
    if (o.kind == "box") {
        const double half = o.degrees * std::numbers::pi / 360;
        return physics::Box{to_metres(o.centre), to_metres(o.size), {std::cos(half), 0, 0, std::sin(half)}};
    }
    if (o.kind == "terrain") {
        physics::Terrain terrain{
            to_metres(o.centre), diameter_m * o.cell, static_cast<int>(o.heights[0].size()), static_cast<int>(o.heights.size()), {}};
        for (const std::vector<double>& row : o.heights)
            for (const double height : row) terrain.heights_m.push_back(diameter_m * height);
        return terrain;
    }
    if (o.kind == "mesh") {
        const std::optional<model::Triangles> surface = world::surface(o.shape);
        MELD_CHECK(surface.has_value(), "{} has no triangles", o.shape.text());
        physics::Mesh mesh;
        for (const Vec3& point : surface->points) mesh.points.push_back(to_metres(point));
        for (const auto& corners : surface->corners) mesh.triangles.insert(mesh.triangles.end(), corners.begin(), corners.end());
        return mesh;
    }
    return physics::Plane{{o.normal[0], o.normal[1], o.normal[2]}, diameter_m * o.offset};
}

Result<physics::Obstacles> obstacles_of_points(const RangeOptions& links) {
    physics::Obstacles all;
    for (const ObstacleOptions& o : links.obstacles)
        if (const auto added = all.add(shape_of(o, 1), 0); !added)
            return fail(fmt::format("{}: {}", o.place, added.error().problem), added.error().suggestion);
    return all;
}

}  // namespace meld::world
