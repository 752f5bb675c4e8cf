// Spheres against a mesh: a surface without an inside, which holds from both sides, whichever way its triangles turn.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "physics/collision/ray.h"
#include "physics/collision/terrain.h"
#include "physics/collision/triangle.h"

namespace meld::physics {

// Triangles by three indices each.
struct Mesh {
    std::vector<Vec3> points = {};
    std::vector<std::uint32_t> triangles = {};
};

// A tree of boxes over the triangles of a mesh, which is given with each call and has not changed. All workers may use it at once.
class MeshSurface {
  public:
    explicit MeshSurface(const Mesh& mesh);

    // The contacts nearer than `reach_m`, the nearest first; returns their number. Points that lie below the tangent plane of a nearer
    // contact do not count: an even face gives one contact, also at the edges of its triangles. Cost: a few microseconds for each contact.
    int collide(const Mesh& mesh, Vec3 centre, double radius_m, double reach_m,
                std::array<SurfaceContact, kMaxSurfaceContacts>& contacts) const;
    // Adds the triangles whose own boxes meet a box.
    void triangles_at(const Mesh& mesh, Vec3 low, Vec3 high, std::vector<Triangle>& found) const;
    // As Obstacles::meet. Triangles that the sphere touches are not met, nor is what lies below the tangent planes of the given contacts.
    std::optional<SurfaceContact> meet(const Mesh& mesh, Vec3 centre, double radius_m, Vec3 path,
                                       std::span<const SurfaceContact> touched) const;
    // As Obstacles::first_on.
    std::optional<double> first_on(const Mesh& mesh, const Ray& ray) const;

  private:
    struct Bounds {
        Vec3 low, high;
    };
    // A leaf has `count` triangles from order_[first] on; the children of another node are the next one and `first`.
    struct Node {
        Bounds bounds;
        std::uint32_t first = 0, count = 0;
    };
    void build(const Mesh& mesh, std::span<const Vec3> centres, std::uint32_t first, std::uint32_t count);
    Triangle triangle(const Mesh& mesh, std::uint32_t number) const;
    // Calls visit(triangle) for the triangles of all boxes for which wanted(bounds) is true.
    template <class Wanted, class Visit>
    void each(const Mesh& mesh, const Wanted& wanted, const Visit& visit) const;

    std::vector<Node> nodes_;
    std::vector<std::uint32_t> order_;
};

}  // namespace meld::physics
