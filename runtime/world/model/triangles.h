// The surface of a model: triangles between points that they share.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

namespace meld::model {

using Vec3 = std::array<double, 3>;

struct Triangles {
    std::vector<Vec3> points;
    std::vector<std::array<std::uint32_t, 3>> corners;  // Of each triangle, indices of points.
};

// More would take gigabytes on every process.
inline constexpr std::uint64_t kMaxTriangles = 10'000'000;

// Makes points at equal coordinates one, and leaves out triangles with fewer than three different corners: formats like STL list the
// corners of each triangle anew. Points keep the order of their first use. Cost: about 0.3 us a triangle.
void weld(Triangles& triangles);

}  // namespace meld::model
