// Triangles of models, through the combinations that keep them triangles.
#include "runtime/world/shapes/surface.h"

#include <algorithm>
#include <utility>

#include "runtime/world/shapes/shape_tree.h"

namespace meld::world {
namespace {

template <class Change>
std::optional<model::Triangles> changed(const Shape& shape, const Change& change) {
    std::optional<model::Triangles> all = surface(shape);
    if (all) std::for_each(all->points.begin(), all->points.end(), change);
    return all;
}

struct Surface {
    std::optional<model::Triangles> operator()(const Modelled& s) const {
        model::Triangles all{s.solid->points(), s.solid->corners()};
        for (Vec3& p : all.points)
            for (std::size_t i = 0; i < 3; ++i) p[i] = (p[i] - s.centre[i]) / s.units;
        return all;
    }
    std::optional<model::Triangles> operator()(const Moved& s) const {
        return changed(s.solid, [&s](Vec3& p) {
            for (std::size_t i = 0; i < 3; ++i) p[i] += s.by[i];
        });
    }
    std::optional<model::Triangles> operator()(const Rotated& s) const {
        return changed(s.solid, [&s](Vec3& p) { p = turned(p, s); });
    }
    std::optional<model::Triangles> operator()(const Scaled& s) const {
        return changed(s.solid, [&s](Vec3& p) {
            for (double& x : p) x *= s.factor;
        });
    }
    template <class Other>
    std::optional<model::Triangles> operator()(const Other&) const {
        return std::nullopt;
    }
};

// Six times the volume inside, below zero if the triangles are clockwise as seen from outside.
double volume(const model::Triangles& all) {
    double sum = 0;
    for (const auto& [i, j, k] : all.corners) {
        const Vec3 &a = all.points[i], &b = all.points[j], &c = all.points[k];
        sum += a[0] * (b[1] * c[2] - b[2] * c[1]) + a[1] * (b[2] * c[0] - b[0] * c[2]) + a[2] * (b[0] * c[1] - b[1] * c[0]);
    }
    return sum;
}

}  // namespace

std::optional<model::Triangles> surface(const Shape& shape) {
    if (!shape.root()) return std::nullopt;
    std::optional<model::Triangles> all = std::visit(Surface{}, shape.root()->solid);
    if (all && volume(*all) < 0)
        for (auto& corners : all->corners) std::swap(corners[1], corners[2]);
    return all;
}

}  // namespace meld::world
