#include "runtime/world/description/obstacles.h"

#include <fmt/format.h>

#include <numbers>
#include <optional>
#include <utility>

#include "runtime/base/assert.h"
#include "runtime/world/description/compounds.h"
#include "runtime/world/shapes/surface.h"

namespace meld::world {

namespace {

physics::Vec3 times(double factor, const Vec3& v) { return {factor * v[0], factor * v[1], factor * v[2]}; }

physics::Quat turn_of(const ObstacleOptions& o) {
    if (o.turned != Vec3{}) return physics::turned_by({}, times(std::numbers::pi / 180, o.turned));
    const double half = o.degrees * std::numbers::pi / 360;
    return {std::cos(half), 0, 0, std::sin(half)};
}

bool is_sharp_box(const ObstacleOptions& o) { return o.kind == "box" && o.form.rounding.value_or(0) == 0; }

}  // namespace

bool is_solid(const ObstacleOptions& o) { return o.form.compound || (o.kind != "plane" && o.kind != "terrain" && o.kind != "mesh"); }

physics::Solid solid_of(const ObstacleOptions& o, double diameter, std::span<const CompoundForm> compounds) {
    physics::Solid solid{{}, times(diameter, o.centre), turn_of(o)};
    if (o.form.compound) {
        physics::PlacedCompound made = placed_compound(compounds[*o.form.compound], diameter, *o.form.compound);
        solid.centre = solid.centre + rotate(solid.orientation, made.centre_m);
        solid.shape = std::move(made.shape);
    } else if (o.kind == "box") {
        solid.shape = physics::box_shape(times(diameter, o.size), diameter * o.form.rounding.value_or(0));
    } else {
        const BodyForm::Core core = o.form.core(o.diameter / 2);
        solid.shape = {times(diameter, core.half), diameter * core.rounding};
    }
    return solid;
}

physics::Shape shape_of(const ObstacleOptions& o, double diameter_m, std::span<const CompoundForm> compounds) {
    const auto to_metres = [&](const Vec3& v) { return times(diameter_m, v); };
    // A sharp box has a way of its own, which is faster for spheres.
    if (is_sharp_box(o)) return physics::Box{to_metres(o.centre), to_metres(o.size), turn_of(o)};
    if (is_solid(o)) return solid_of(o, diameter_m, compounds);
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
        if (const auto added = all.add(shape_of(o, 1, {}), 0); !added)
            return fail(fmt::format("{}: {}", o.place, added.error().problem), added.error().suggestion);
    return all;
}

}  // namespace meld::world
