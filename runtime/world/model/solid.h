// The inside of a triangle mesh: whether a point is in it, and how far its surface is.
//
// A point is inside if the row from it to infinity along x crosses the surface an odd number of times. All is computed from the corners in
// double precision and in one order, so the answers are the same on any processor. In the plane across the row, whether the row passes on
// one side of an edge is decided by a function of the edge alone, which both triangles beside it share: however coordinates are rounded, a
// row crosses a closed surface an even number of times, and no vote between rows is needed.
//
// Where the surface is open, with edges that only one triangle has, rows along x, y and z may disagree, and the majority decides.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "runtime/world/model/triangles.h"

namespace meld::model {

// Immutable; any thread may use it. Takes some 150 bytes a triangle.
class Solid {
  public:
    // The triangles are welded, and there is at least one. Cost: about 1 us a triangle.
    explicit Solid(Triangles triangles);

    const Vec3& low() const { return low_; }
    const Vec3& high() const { return high_; }
    double longest_side() const;
    std::size_t triangles() const { return corners_.size(); }

    // Flat faces are half open along each axis, low <= p < high. Cost: some 100 ns, and more where many triangles are behind each other.
    bool contains(const Vec3& point) const;
    // From a point to the surface, below zero inside. Cost: about 1 us.
    double distance(const Vec3& point) const;

    // How open the surface is.
    struct Openness {
        std::size_t edges = 0, open_edges = 0;  // An edge is open if an odd number of triangles meets there.
        std::size_t rows = 0, odd_rows = 0;     // Of rows spread over the model along each axis: with an odd number of crossings.
    };
    bool closed() const { return openness_.open_edges == 0; }
    const Openness& openness() const { return openness_; }

    const std::vector<Vec3>& points() const { return points_; }
    const std::vector<std::array<std::uint32_t, 3>>& corners() const { return corners_; }

  private:
    // A box of the tree. Inner ones are followed by their first part; leaves have triangles.
    struct Node {
        Vec3 low, high;
        std::uint32_t begin = 0, end = 0;  // Triangles of a leaf.
        std::uint32_t second = 0;          // The second part of an inner node; 0: it is a leaf.
    };
    void build();
    void count_open_edges();
    void count_odd_rows();
    Node around(std::uint32_t begin, std::uint32_t end) const;
    // How often the row from the point along the axis crosses the surface.
    std::uint32_t crossings(const Vec3& point, std::size_t axis) const;
    bool crosses(std::uint32_t triangle, const Vec3& point, std::size_t axis) const;
    double distance_squared(std::uint32_t triangle, const Vec3& point) const;

    std::vector<Vec3> points_;
    std::vector<std::array<std::uint32_t, 3>> corners_;  // In the order of the leaves.
    std::vector<Node> nodes_;
    Vec3 low_{}, high_{};
    Openness openness_;
};

}  // namespace meld::model
