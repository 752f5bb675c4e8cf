#include "runtime/show/render/lines.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

namespace meld::render {

namespace {

// How dark lines are: around what is in front of something far behind it, between catoms, at the edges of one.
constexpr float kFront = 0.92F, kBetween = 0.7F, kCrease = 0.5F;
// So much further away, in catom diameters, is far behind.
constexpr float kBehind = 1.2F;
// The cosine of the angle between two sides that have a line between them.
constexpr float kSides = 0.9F;
// Lines between catoms begin to be drawn where a catom has so many pixels, and are as dark as others where it has so many.
constexpr float kFewPixels = 4, kManyPixels = 14;

}  // namespace

Lines::Lines(const Geometry& geometry, const Camera& camera, std::size_t side, float width)
    : geometry_(geometry),
      camera_(camera),
      side_(side),
      near_(std::clamp((camera.scale() - kFewPixels) / (kManyPixels - kFewPixels), 0.0F, 1.0F)) {
    const float reach = std::max(width / 2 * static_cast<float>(side), 1.0F);
    // Of each two opposite ones only one.
    for (const auto& [x, y] : {std::pair(1.0F, 0.0F), std::pair(0.7071F, 0.7071F), std::pair(0.0F, 1.0F), std::pair(-0.7071F, 0.7071F)})
        steps_.push_back({std::lround(reach * x), std::lround(reach * y)});
    margin_ = static_cast<std::size_t>(std::ceil((reach + 0.5F) / static_cast<float>(side)));
}

void Lines::at(std::size_t left, std::size_t top, std::size_t width, std::size_t height, std::vector<float>& out, Room& room) const {
    const std::size_t margin = margin_ * side_, row = width * side_ + 2 * margin, rows = height * side_ + 2 * margin;
    const auto place = [&](std::size_t first, std::size_t step) {
        return static_cast<float>(first) + (static_cast<float>(step) - static_cast<float>(margin) + 0.5F) / static_cast<float>(side_);
    };
    room.rays.clear();
    for (std::size_t y = 0; y < rows; ++y)
        for (std::size_t x = 0; x < row; ++x) {
            const Camera::Ray ray = camera_.ray(place(left, x), place(top, y));
            room.rays.push_back({ray.from, ray.along});
        }
    geometry_.hits(room.rays, room.hits);
    using Hit = std::optional<Geometry::Hit>;
    const auto darkness = [&](std::size_t x, std::size_t y) {
        const Hit& here = room.hits[y * row + x];
        float dark = 0;
        for (const Step& step : steps_) {
            const auto there = [&](std::ptrdiff_t sign) -> const Hit& {
                return room.hits[static_cast<std::size_t>(static_cast<std::ptrdiff_t>(y) + sign * step.y) * row +
                                 static_cast<std::size_t>(static_cast<std::ptrdiff_t>(x) + sign * step.x)];
            };
            const std::array<const Hit*, 2> both = {&there(1), &there(-1)};
            for (const Hit* other : both) {
                if (!*other && !here) continue;
                if (other->has_value() != here.has_value())
                    dark = std::max(dark, kFront);
                else if ((*other)->thing != here->thing)
                    dark = std::max(dark, near_ * kBetween);
                else if ((*other)->normal.dot(here->normal) < kSides)
                    dark = std::max(dark, near_ * kCrease);
            }
            // On a slope what is further on one side is nearer on the other; only an edge is not straight.
            if (here && *both[0] && *both[1] && std::abs((*both[0])->distance + (*both[1])->distance - 2 * here->distance) > kBehind)
                dark = kFront;
        }
        return dark;
    };
    out.clear();
    for (std::size_t y = 0; y < height; ++y)
        for (std::size_t x = 0; x < width; ++x)
            for (std::size_t i = 0; i < side_ * side_; ++i)
                out.push_back(darkness(margin + x * side_ + i % side_, margin + y * side_ + i / side_));
}

}  // namespace meld::render
