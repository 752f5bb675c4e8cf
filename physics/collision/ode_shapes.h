// Obstacles as ODE geometries.
#pragma once

#include <ode/ode.h>

#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "physics/collision/obstacles.h"

namespace meld::physics {

// Geometries and the data they point at, freed together. Meshes are boxes around them: their triangles are for MeshSurface, since ODE's
// hold from one side only. The calling thread has entered ODE.
class OdeShapes {
  public:
    OdeShapes() = default;
    ~OdeShapes();
    OdeShapes(const OdeShapes&) = delete;
    OdeShapes& operator=(const OdeShapes&) = delete;

    // Geometries without a space, in their places: one, or those of the parts of a compound; returns their number.
    std::size_t add(const Shape& shape);
    // Of all shapes, one behind another.
    std::size_t count() const { return geoms_.size(); }
    dGeomID operator[](std::size_t index) const { return geoms_[index]; }
    // Puts those of obstacles that move where they are. `first_of_obstacle`: by obstacle, its first geometry.
    void follow(const Obstacles& obstacles, std::span<const std::uint32_t> first_of_obstacle);

  private:
    // Where a geometry was made; of a plane its normal, and its offset along it.
    struct Home {
        Vec3 at;
        Quat turn;
        double offset_m;
    };
    static Home home_of(dGeomID geom);
    void move(std::size_t index, const MovingFrame& frame);
    dGeomID keep(dGeomID geom);
    dGeomID make(const Plane& plane);
    dGeomID make(const Box& box);
    dGeomID make(const Terrain& terrain);
    dGeomID make(const Mesh& mesh);

    void make_parts(const Solid& solid);

    std::vector<dGeomID> geoms_;
    std::vector<Home> homes_;
    std::vector<dHeightfieldDataID> heights_;
    // ODE keeps pointers to these.
    std::vector<std::unique_ptr<std::vector<double>>> points_;
};

// A geometry of a shape that is no compound, in a space or without one. Boxes and cylinders have sharp edges.
dGeomID make_form(const BodyShape& shape, dSpaceID space);

}  // namespace meld::physics
