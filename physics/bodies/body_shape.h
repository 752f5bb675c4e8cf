// Shapes of bodies other than spheres: a core, which is a box, a cylinder or a line along z, and everything within a distance of it, so
// edges and corners are round. And which body has which shape.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <map>
#include <vector>

#include "physics/bodies/types.h"
#include "runtime/base/error.h"

namespace meld::physics {

// A solid body, uniformly filled.
struct BodyShape {
    // Half of the core's edges along the body's axes: three positive numbers are a box, (x, 0, z) is a cylinder along z of radius x,
    // (0, 0, z) is a capsule, zeros are a sphere.
    Vec3 core_m = {};
    // From the core to the surface.
    double rounding_m = 0;
    bool operator==(const BodyShape&) const = default;

    bool is_cylinder() const { return core_m.x > 0 && core_m.y == 0; }
    bool is_sphere() const { return core_m == Vec3{}; }
    // Of the sphere around it.
    double radius_m() const { return length(core_m) + rounding_m; }
    // Half of its least thickness.
    double least_m() const;
    double volume_m3() const;
    double surface_m2() const;
    // From its middle to its surface in a direction of length 1.
    double way_out_m(Vec3 direction) const;
    // The moments of inertia about its axes, each divided by the mass.
    Vec3 inertia_per_kg_m2() const;
};

// A box with these edges, whose own edges are rounded by a radius; a cylinder along z with a rounded rim; a capsule along z whose ends are
// half balls.
BodyShape box_shape(Vec3 edges_m, double rounding_m);
BodyShape cylinder_shape(double radius_m, double height_m, double rounding_m);
BodyShape capsule_shape(double radius_m, double length_m);
// Errors: what is impossible about it.
Result<void> check(const BodyShape& shape);

// The shapes of the bodies of a scene, by their numbers.
class BodyShapes {
  public:
    // 0: a sphere.
    using Index = std::uint16_t;
    // A shape with what follows from it.
    struct Kind {
        BodyShape shape;
        double radius_m = 0, least_m = 0;
        Vec3 inertia_per_kg_m2 = {};
        // How easily it is turned about its axes: radius^2 / inertia_per_kg. For a sphere that is 1 / inertia factor.
        Vec3 turning = {};
        bool turns_alike = true;
    };

    // Whether all bodies are spheres and have always been.
    bool empty() const { return kinds_.empty(); }
    // Errors: there are too many different shapes.
    Result<void> set(BodyId body, const BodyShape& shape);
    void forget(BodyId body) {
        if (body < of_.size()) of_[body] = 0;
    }
    Index of(BodyId body) const { return body < of_.size() ? of_[body] : Index{0}; }
    // Of a body that is no sphere.
    const Kind& kind(Index index) const { return kinds_[index - std::size_t{1}]; }
    const BodyShape& shape(BodyId body) const { return kind(of(body)).shape; }

    std::size_t bytes() const { return of_.capacity() * sizeof(Index) + kinds_.capacity() * sizeof(Kind); }

  private:
    Result<Index> index_of(const BodyShape& shape);
    std::vector<Index> of_;
    std::vector<Kind> kinds_;
    std::map<std::array<double, 4>, Index> known_;
};

}  // namespace meld::physics
