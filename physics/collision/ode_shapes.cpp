// Makes ODE geometries.
#include "physics/collision/ode_shapes.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <type_traits>

#include "physics/bodies/symmetric.h"

namespace meld::physics {

OdeShapes::~OdeShapes() {
    for (const dGeomID geom : geoms_) dGeomDestroy(geom);
    for (const dHeightfieldDataID data : heights_) dGeomHeightfieldDataDestroy(data);
}

std::size_t OdeShapes::add(const Shape& shape) {
    const std::size_t before = geoms_.size();
    std::visit(
        [this](const auto& one) {
            if constexpr (std::is_same_v<decltype(one), const Solid&>)
                make_parts(one);
            else
                keep(make(one));
        },
        shape);
    return geoms_.size() - before;
}

dGeomID OdeShapes::keep(dGeomID geom) {
    // A geometry computes its box when first asked; asking now means that no thread writes to it later.
    std::array<dReal, 6> box;
    dGeomGetAABB(geom, box.data());
    geoms_.push_back(geom);
    homes_.push_back(home_of(geom));
    return geom;
}

void OdeShapes::move(std::size_t index, const MovingFrame& frame) {
    const auto& [at, turn, offset_m] = homes_[index];
    if (dGeomGetClass(geoms_[index]) == dPlaneClass) {
        const Vec3 normal = frame.turned_out_of(at);
        return dGeomPlaneSetParams(geoms_[index], normal.x, normal.y, normal.z, dot(normal, frame.out_of(offset_m * at)));
    }
    const Vec3 now = frame.out_of(at);
    const Quat turned = product(frame.turn(), turn);
    const dQuaternion q = {turned.w, turned.x, turned.y, turned.z};
    dGeomSetPosition(geoms_[index], now.x, now.y, now.z);
    dGeomSetQuaternion(geoms_[index], q);
}

void OdeShapes::follow(const Obstacles& obstacles, std::span<const std::uint32_t> first_of_obstacle) {
    for (std::size_t i = 0; obstacles.any_moves() && i < obstacles.count(); ++i) {
        const std::size_t end = i + 1 < obstacles.count() ? first_of_obstacle[i + 1] : count();
        for (std::size_t geom = first_of_obstacle[i]; obstacles.moves(i) && geom < end; ++geom) move(geom, obstacles.frame(i));
    }
}

OdeShapes::Home OdeShapes::home_of(dGeomID geom) {
    if (dGeomGetClass(geom) == dPlaneClass) {
        dVector4 p;
        dGeomPlaneGetParams(geom, p);
        return {{p[0], p[1], p[2]}, {}, p[3]};
    }
    const dReal* at = dGeomGetPosition(geom);
    dQuaternion q;
    dGeomGetQuaternion(geom, q);
    return {{at[0], at[1], at[2]}, {q[0], q[1], q[2], q[3]}, 0};
}

void OdeShapes::make_parts(const Solid& solid) {
    const auto put = [&](const BodyShape& shape, Vec3 at, Quat turn) {
        const dGeomID geom = make_form(shape, nullptr);
        dGeomSetPosition(geom, at.x, at.y, at.z);
        const dQuaternion q = {turn.w, turn.x, turn.y, turn.z};
        dGeomSetQuaternion(geom, q);
        keep(geom);
    };
    if (!solid.shape.is_compound()) put(solid.shape, solid.centre, solid.orientation);
    for (const ShapePart& part : solid.shape.parts)
        put(solid_of(part), solid.centre + rotate(solid.orientation, part.at_m), product(solid.orientation, part.turn));
}

dGeomID make_form(const BodyShape& shape, dSpaceID space) {
    if (shape.is_sphere()) return dCreateSphere(space, shape.rounding_m);
    if (shape.is_cylinder()) return dCreateCylinder(space, shape.core_m.x + shape.rounding_m, 2 * (shape.core_m.z + shape.rounding_m));
    if (shape.core_m.x == 0) return dCreateCapsule(space, shape.rounding_m, 2 * shape.core_m.z);
    const Vec3 rounding{shape.rounding_m, shape.rounding_m, shape.rounding_m};
    const Vec3 edges = 2 * (shape.core_m + rounding);
    return dCreateBox(space, edges.x, edges.y, edges.z);
}

dGeomID OdeShapes::make(const Plane& plane) {
    return dCreatePlane(nullptr, plane.normal.x, plane.normal.y, plane.normal.z, plane.offset_m);
}

dGeomID OdeShapes::make(const Box& box) {
    const dGeomID geom = dCreateBox(nullptr, box.size_m.x, box.size_m.y, box.size_m.z);
    dGeomSetPosition(geom, box.centre.x, box.centre.y, box.centre.z);
    const dQuaternion q = {box.orientation.w, box.orientation.x, box.orientation.y, box.orientation.z};
    dGeomSetQuaternion(geom, q);
    return geom;
}

// ODE's heights rise along y; a quarter turn about x makes its y our z and its z our -y.
dGeomID OdeShapes::make(const Terrain& terrain) {
    auto& turned = *points_.emplace_back(std::make_unique<std::vector<double>>());
    for (int row = terrain.rows - 1; row >= 0; --row)
        for (int column = 0; column < terrain.columns; ++column)
            turned.push_back(terrain.heights_m[static_cast<std::size_t>(row) * static_cast<std::size_t>(terrain.columns) +
                                               static_cast<std::size_t>(column)]);
    const double width = (terrain.columns - 1) * terrain.cell_m, depth = (terrain.rows - 1) * terrain.cell_m;
    const dHeightfieldDataID data = heights_.emplace_back(dGeomHeightfieldDataCreate());
    dGeomHeightfieldDataBuildDouble(data, turned.data(), 0, width, depth, terrain.columns, terrain.rows, 1, 0, 10 * terrain.cell_m, 0);
    const auto [least, most] = std::minmax_element(terrain.heights_m.begin(), terrain.heights_m.end());
    dGeomHeightfieldDataSetBounds(data, *least, *most);
    const dGeomID geom = dCreateHeightfield(nullptr, data, 1);
    dGeomSetPosition(geom, terrain.origin.x + width / 2, terrain.origin.y + depth / 2, terrain.origin.z);
    const dQuaternion quarter = {std::sqrt(0.5), std::sqrt(0.5), 0, 0};
    dGeomSetQuaternion(geom, quarter);
    return geom;
}

dGeomID OdeShapes::make(const Mesh& mesh) {
    // ODE leaves out boxes with a side of no length, as a flat mesh has.
    constexpr double kThinnest = 1e-9;
    std::array<double, 3> low, high;
    low.fill(HUGE_VAL), high.fill(-HUGE_VAL);
    for (const Vec3 p : mesh.points) {
        const double at[3] = {p.x, p.y, p.z};
        for (std::size_t i = 0; i < 3; ++i) low[i] = std::min(low[i], at[i]), high[i] = std::max(high[i], at[i]);
    }
    const dGeomID geom = dCreateBox(nullptr, std::max(high[0] - low[0], kThinnest), std::max(high[1] - low[1], kThinnest),
                                    std::max(high[2] - low[2], kThinnest));
    dGeomSetPosition(geom, (low[0] + high[0]) / 2, (low[1] + high[1]) / 2, (low[2] + high[2]) / 2);
    return geom;
}

}  // namespace meld::physics
