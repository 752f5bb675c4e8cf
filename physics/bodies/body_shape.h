// Shapes of bodies other than spheres: a core, which is a box, a cylinder or a line along z, and everything within a distance of it, so
// edges and corners are round; and compounds of several such solids that are held together. And which body has which shape.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <map>
#include <string>
#include <vector>

#include "physics/bodies/symmetric.h"
#include "physics/bodies/types.h"
#include "runtime/base/bytes.h"
#include "runtime/base/error.h"

namespace meld::physics {

// One solid of a compound.
struct ShapePart {
    // As those of a BodyShape.
    Vec3 core_m = {};
    double rounding_m = 0;
    // Its middle from the body's centre of mass, and how it is turned, in the body's frame.
    Vec3 at_m = {};
    Quat turn = {};
    // Of the body's mass; the shares of all parts are 1 together.
    double share = 1;
    bool operator==(const ShapePart&) const = default;
};
inline constexpr std::size_t kMaxShapeParts = 64;

// A solid body, uniformly filled; or a compound of several, each uniformly filled. Where parts overlap, both count.
struct BodyShape {
    // Half of the core's edges along the body's axes: three positive numbers are a box, (x, 0, z) is a cylinder along z of radius x,
    // (0, 0, z) is a capsule, zeros are a sphere.
    Vec3 core_m = {};
    // From the core to the surface.
    double rounding_m = 0;
    // Of a compound, whose own core and rounding are zeros.
    std::vector<ShapePart> parts = {};
    // The caller's number of a compound, which means nothing here.
    std::uint32_t name = 0;
    bool operator==(const BodyShape&) const = default;

    bool is_compound() const { return !parts.empty(); }
    bool is_cylinder() const { return core_m.x > 0 && core_m.y == 0; }
    bool is_sphere() const { return core_m == Vec3{} && !is_compound(); }
    std::size_t solids() const { return is_compound() ? parts.size() : 1; }
    // Of the sphere around it.
    double radius_m() const;
    // Half of the least thickness of it, or of any of its parts.
    double least_m() const;
    // Of a compound, the sums over its parts.
    double volume_m3() const;
    double surface_m2() const;
    // From its middle to its surface in a direction of length 1; of a compound, to where the ray leaves the last part, 0 if it meets none.
    double way_out_m(Vec3 direction) const;
    // The moments of inertia about its principal axes, each divided by the mass, and how those are turned in its frame: of a compound
    // alone they may be other axes than its own.
    struct Inertia {
        Vec3 per_kg_m2;
        Quat axes = {};
    };
    Inertia inertia() const;
    Vec3 inertia_per_kg_m2() const { return inertia().per_kg_m2; }
    // From the nearest point of the core to a point in the body's frame. Not of compounds.
    Vec3 from_core(Vec3 p) const;
};
// A part as a body of its own.
inline BodyShape solid_of(const ShapePart& part) { return {part.core_m, part.rounding_m}; }
// The radius of the sphere around the body's centre that holds the part in every attitude.
double reach_m(const ShapePart& part);

// A box with these edges, whose own edges are rounded by a radius; a cylinder along z with a rounded rim; a capsule along z whose ends are
// half balls.
BodyShape box_shape(Vec3 edges_m, double rounding_m);
BodyShape cylinder_shape(double radius_m, double height_m, double rounding_m);
BodyShape capsule_shape(double radius_m, double length_m);
// Parts in a frame with any origin, whose shares are in proportion to each other: the compound that they make, and where its centre of mass
// is in that frame.
struct PlacedCompound {
    BodyShape shape;
    Vec3 centre_m;
};
PlacedCompound compound_of(std::vector<ShapePart> parts);
// Errors: what is impossible about it.
Result<void> check(const BodyShape& shape);
// For snapshots and other processes.
void write_shape(const BodyShape& shape, ByteWriter& out);
BodyShape read_shape(ByteReader& in);

// The shapes of the bodies of a scene, by their numbers.
class BodyShapes {
  public:
    // 0: a sphere.
    using Index = std::uint16_t;
    // A shape with what follows from it.
    struct Kind {
        BodyShape shape;
        double radius_m = 0, least_m = 0;
        // About the principal axes.
        Vec3 inertia_per_kg_m2 = {};
        // How easily it is turned about its axes: radius^2 / inertia_per_kg. For a sphere that is 1 / inertia factor.
        Vec3 turning = {};
        bool turns_alike = true;
        // How the principal axes are turned in the body's frame, if they are.
        bool has_other_axes = false;
        Quat axes = {};

        // How the principal axes of a body are turned that is turned so itself.
        Quat principal(Quat turn) const { return has_other_axes ? product(turn, axes) : turn; }
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
    template <class Key>
    Result<Index> index_in(std::map<Key, Index>& known, const Key& key, const BodyShape& shape);
    std::vector<Index> of_;
    std::vector<Kind> kinds_;
    std::map<std::array<double, 4>, Index> known_;
    // Of compounds, by their bytes.
    std::map<std::string, Index> known_compounds_;
};

}  // namespace meld::physics
