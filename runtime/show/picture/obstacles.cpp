#include "runtime/show/picture/obstacles.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <limits>
#include <optional>
#include <span>

#include "physics/bodies/moving_frame.h"
#include "runtime/show/picture/solid.h"
#include "runtime/world/description/motions.h"
#include "runtime/world/description/obstacles.h"
#include "runtime/world/shapes/surface.h"

namespace meld::picture {

namespace {

using render::Vec;
using world::ObstacleOptions;

Vec vec(const world::Vec3& at) { return {static_cast<float>(at[0]), static_cast<float>(at[1]), static_cast<float>(at[2])}; }

void add_quad(const Vec& a, const Vec& b, const Vec& c, const Vec& d, std::vector<render::Triangle>& out) {
    out.push_back({a, b, c});
    out.push_back({a, c, d});
}

// A square in a plane through `at`, as large as what stands on it and somewhat more, in steps, so that it rarely changes.
void add_piece(const render::Scene& scene, const Vec& normal, const Vec& at, std::vector<render::Triangle>& out) {
    constexpr float kFar = std::numeric_limits<float>::infinity();
    Eigen::Array3f low(kFar, kFar, kFar), high = -low;
    for (const Vec& place : scene.places) {
        low = low.min(place.array());
        high = high.max(place.array());
    }
    if (scene.places.empty()) low = high = at.array();
    const float half = std::exp2(std::ceil(std::log2((high - low).maxCoeff() + 8)));
    const Vec middle = ((low + high) / 2 / half * 8).round() * half / 8;
    const Vec centre = middle - normal.dot(middle - at) * normal;
    const Vec u = half * (std::abs(normal.z()) > 0.9F ? Vec::UnitX() : Vec::UnitZ()).cross(normal).normalized(), v = normal.cross(u);
    add_quad(centre - u - v, centre + u - v, centre + u + v, centre - u + v, out);
}

Vec vec(const physics::Vec3& at) { return vec(world::Vec3{at.x, at.y, at.z}); }

Eigen::Quaternionf turn_of(const physics::Quat& q) { return Eigen::Quaterniond(q.w, q.x, q.y, q.z).cast<float>(); }

void add_box(const Vec& centre, const Vec& half, const Eigen::Quaternionf& turn, std::vector<render::Triangle>& out) {
    const std::array<Vec, 3> ways = {turn * (half.x() * Vec::UnitX()), turn * (half.y() * Vec::UnitY()), turn * (half.z() * Vec::UnitZ())};
    for (std::size_t axis = 0; axis < 3; ++axis)
        for (const float side : {-1.0F, 1.0F}) {
            const Vec middle = centre + side * ways[axis], u = side * ways[(axis + 1) % 3], v = ways[(axis + 2) % 3];
            add_quad(middle - u - v, middle + u - v, middle + u + v, middle - u + v, out);
        }
}

// As catoms of this form are drawn; edges that are not round leave nothing between their lines.
void add_round(const Vec& centre, const physics::BodyShape& shape, const Eigen::Quaternionf& turn, std::vector<render::Triangle>& out) {
    render::Scene alone;
    alone.places = {centre};
    alone.rounded = {{vec(shape.core_m), static_cast<float>(shape.rounding_m), turn}};
    alone.colours = {render::kObstacle};
    const Solid skin = solid_of(alone);
    for (const auto& [a, b, c] : skin.faces) {
        const render::Triangle face = {skin.places[a], skin.places[b], skin.places[c]};
        if ((face[1] - face[0]).cross(face[2] - face[0]).squaredNorm() > 0) out.push_back(face);
    }
}

void add_solid(const physics::Solid& solid, std::vector<render::Triangle>& out) {
    const auto add = [&](const physics::BodyShape& shape, const physics::Vec3& at, const physics::Quat& turn) {
        if (shape.rounding_m == 0 && !shape.is_cylinder())
            add_box(vec(at), vec(shape.core_m), turn_of(turn), out);
        else
            add_round(vec(at), shape, turn_of(turn), out);
    };
    if (!solid.shape.is_compound()) return add(solid.shape, solid.centre, solid.orientation);
    for (const physics::ShapePart& part : solid.shape.parts)
        add(physics::solid_of(part), solid.centre + rotate(solid.orientation, part.at_m), product(solid.orientation, part.turn));
}

// Cells are split as the physics does it: from the corner of least row and column to that of greatest.
void add_terrain(const ObstacleOptions& o, std::vector<render::Triangle>& out) {
    const auto point = [&](std::size_t row, std::size_t column) {
        const world::Vec3 at = {o.centre[0] + o.cell * static_cast<double>(column), o.centre[1] + o.cell * static_cast<double>(row),
                                o.centre[2] + o.heights[row][column]};
        return vec(at);
    };
    for (std::size_t row = 0; row + 1 < o.heights.size(); ++row)
        for (std::size_t column = 0; column + 1 < o.heights[row].size(); ++column)
            add_quad(point(row, column), point(row, column + 1), point(row + 1, column + 1), point(row + 1, column), out);
}

void add_mesh(const ObstacleOptions& o, std::vector<render::Triangle>& out) {
    const std::optional<model::Triangles> surface = world::surface(o.shape);
    if (!surface) return;
    for (const auto& [a, b, c] : surface->corners)
        out.push_back({vec(surface->points[a]), vec(surface->points[b]), vec(surface->points[c])});
}

// Nothing for those that stand still. In diameters.
std::optional<physics::MovingFrame> frame_of(const ObstacleOptions& o, double time_s) {
    if (!o.motion.moves()) return std::nullopt;
    const physics::PrescribedMotion motion = world::motion_of(o, 1);
    physics::MovingFrame frame(motion, *motion.pivot_m, 0);
    frame.place(time_s);
    return frame;
}

physics::Vec3 wide(const Vec& at) {
    const Eigen::Vector3d to = at.cast<double>();
    return {to.x(), to.y(), to.z()};
}

Vec point_out_of(const physics::MovingFrame& frame, const Vec& at) { return vec(frame.out_of(wide(at))); }
Vec way_out_of(const physics::MovingFrame& frame, const Vec& way) { return vec(frame.turned_out_of(wide(way))); }

}  // namespace

void add_obstacles(const world::World& world, std::int64_t tick, render::Scene& scene) {
    const bool points = world.is_graph() && world.links;
    if (!world.is_free() && !points) return;
    if (!points && world.physics.ground) scene.ground = static_cast<float>(*world.physics.ground);
    for (const ObstacleOptions& o : points ? world.links->obstacles : world.physics.obstacles) {
        const std::optional<physics::MovingFrame> frame = frame_of(o, world::end_of_tick_s(world, tick));
        const std::size_t before = scene.obstacles.size();
        if (world::is_solid(o)) {
            add_solid(world::solid_of(o, 1, world.physics.compounds), scene.obstacles);
        } else if (o.kind == "terrain") {
            add_terrain(o, scene.obstacles);
        } else if (o.kind == "mesh") {
            add_mesh(o, scene.obstacles);
        } else {
            // Of a normal of any length, as the physics has it.
            const Vec normal = vec(o.normal).normalized();
            const float height = static_cast<float>(o.offset) / vec(o.normal).norm();
            if (frame)
                add_piece(scene, way_out_of(*frame, normal), point_out_of(*frame, height * normal), scene.obstacles);
            else if (normal.z() > 0.9999F && !scene.ground)
                scene.ground = height;
            else
                add_piece(scene, normal, height * normal, scene.obstacles);
            continue;
        }
        if (!frame) continue;
        for (render::Triangle& triangle : std::span(scene.obstacles).subspan(before))
            for (Vec& corner : triangle) corner = point_out_of(*frame, corner);
    }
}

std::vector<render::Triangle> floor_of(const render::Scene& scene) {
    std::vector<render::Triangle> out;
    if (scene.ground) add_piece(scene, Vec::UnitZ(), {0, 0, *scene.ground}, out);
    return out;
}

}  // namespace meld::picture
