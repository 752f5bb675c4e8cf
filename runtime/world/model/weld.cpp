// Joining equal points.
#include <algorithm>
#include <bit>
#include <limits>
#include <unordered_map>

#include "runtime/base/hash.h"
#include "runtime/world/model/triangles.h"

namespace meld::model {
namespace {

struct HashOfPoint {
    std::size_t operator()(const Vec3& point) const {
        std::uint64_t hash = 0;
        for (const double x : point) hash = hash_combine(hash, std::bit_cast<std::uint64_t>(x));
        return static_cast<std::size_t>(hash);
    }
};

}  // namespace

void weld(Triangles& triangles) {
    std::unordered_map<Vec3, std::uint32_t, HashOfPoint> known;
    std::vector<Vec3> points;
    const auto number_of = [&](Vec3 point) {
        // Adding 0 makes -0 and 0 the same bits.
        for (double& x : point) x += 0.0;
        const auto [at, added] = known.try_emplace(point, static_cast<std::uint32_t>(points.size()));
        if (added) points.push_back(point);
        return at->second;
    };
    constexpr std::uint32_t kUnused = std::numeric_limits<std::uint32_t>::max();
    std::vector<std::uint32_t> joined(triangles.points.size(), kUnused);
    for (auto& corners : triangles.corners) {
        for (std::uint32_t& corner : corners) {
            std::uint32_t& here = joined[corner];
            if (here == kUnused) here = number_of(triangles.points[corner]);
            corner = here;
        }
    }
    std::erase_if(triangles.corners, [](const auto& c) { return c[0] == c[1] || c[1] == c[2] || c[2] == c[0]; });
    triangles.points = std::move(points);
}

}  // namespace meld::model
