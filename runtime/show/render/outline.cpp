#include "runtime/show/render/outline.h"

#include <algorithm>

namespace meld::render {

namespace {

// Planes through an edge of the picture lean between these slopes, by how much of the picture is kept free.
constexpr int kSlopes = 8;

}  // namespace

Outline::Outline(const View& view, float aspect) {
    const Camera camera(view, static_cast<std::size_t>(1000 * aspect), 1000, {});
    const Vec right = camera.right(), forward = camera.forward(), up = right.cross(forward);
    for (const auto& [across, share] : {std::pair(right, aspect), std::pair(up, 1.0F)})
        for (int i = 0; i <= (camera.parallel() ? 0 : kSlopes); ++i) {
            const float slope = camera.tangent() * share * static_cast<float>(i) / kSlopes;
            for (const float side : {-1.0F, 1.0F}) extremes_.push_back({(side * across - slope * forward).normalized()});
        }
    for (const float side : {-1.0F, 1.0F}) extremes_.push_back({side * forward});
}

Outline Outline::from_all_sides() {
    Outline out;
    for (int axis = 0; axis < 3; ++axis)
        for (const float side : {-1.0F, 1.0F}) out.extremes_.push_back({side * Vec::Unit(axis)});
    out.as_ball_ = true;
    return out;
}

void Outline::include(const Scene& scene) {
    const auto take = [&](const Vec& place, float radius) {
        for (Extreme& extreme : extremes_) {
            const float reach = place.dot(extreme.direction) + radius;
            if (extreme.radius >= 0 && reach <= extreme.reach) continue;
            extreme.reach = reach;
            extreme.at = place;
            extreme.radius = radius;
        }
    };
    for (std::size_t i = 0; i < scene.places.size(); ++i) take(scene.places[i], scene.reach(i));
    for (const Stroke& stroke : scene.strokes)
        for (const Vec* end : {&stroke.from, &stroke.to}) take(*end, stroke.radius);
}

Scene Outline::scene() const {
    Scene out;
    if (extremes_.front().radius < 0) return out;
    if (!as_ball_) {
        for (const Extreme& extreme : extremes_) {
            out.places.push_back(extreme.at);
            out.diameters.push_back(2 * extreme.radius);
        }
    } else {
        // Along each axis the lower side, then the upper one.
        Vec low, high;
        for (int axis = 0; axis < 3; ++axis) {
            low[axis] = -extremes_[static_cast<std::size_t>(2 * axis)].reach;
            high[axis] = extremes_[static_cast<std::size_t>(2 * axis + 1)].reach;
        }
        out.places.emplace_back((low + high) / 2);
        out.diameters.push_back((high - low).norm());
    }
    out.colours.resize(out.places.size());
    return out;
}

}  // namespace meld::render
