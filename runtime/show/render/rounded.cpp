#include "runtime/show/render/rounded.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

namespace meld::render {

namespace {

constexpr float kFar = std::numeric_limits<float>::infinity();
// A direction that is parallel to a face is taken to lean towards it so much, so that nothing is divided by zero.
constexpr float kLean = 1e-12F;
// So near to the surface, as a part of the radius squared, is on it.
constexpr float kOn = 1e-4F;

}  // namespace

// Along the ray, the squared distance to the smaller cube is a convex function, of second degree between two of the planes in which the
// faces of that cube lie. So the first place where it is the radius squared is found piece by piece; and a ray that has begun to go away
// never comes back.
std::optional<float> RoundedCube::enters(const Vec& from, const Vec& along, float within) const {
    const Vec begin = from - middle;
    std::array<float, 3> way;
    float first = 0, last = within;
    for (int i = 0; i < 3; ++i) {
        way[static_cast<std::size_t>(i)] = std::abs(along[i]) < kLean ? kLean : along[i];
        const float slope = 1 / way[static_cast<std::size_t>(i)];
        const float one = (-half - begin[i]) * slope, other = (half - begin[i]) * slope;
        first = std::max(first, std::min(one, other));
        last = std::min(last, std::max(one, other));
    }
    if (first > last) return std::nullopt;
    if (radius <= 0) return first;
    // From here on ways are counted from where the ray meets the cube with sharp edges: those from far away are too long to be exact.
    const float inner = half - radius, rest = last - first;
    struct Axis {
        float at, way, in, out;  // Where it begins, its direction, and when it comes between the planes and leaves them.
    };
    std::array<Axis, 3> axes;
    for (std::size_t i = 0; i < 3; ++i) {
        Axis& axis = axes[i];
        axis.way = way[i];
        axis.at = begin[static_cast<int>(i)] + first * axis.way;
        const float towards = std::copysign(inner, axis.way);
        axis.in = (-towards - axis.at) / axis.way;
        axis.out = (towards - axis.at) / axis.way;
    }
    for (float t = 0; t <= rest;) {
        float a = 0, b = 0, c = -radius * radius, next = kFar;
        for (const Axis& axis : axes) {
            const bool before = t < axis.in, after = t >= axis.out;
            if (before || !after) next = std::min(next, before ? axis.in : axis.out);
            if (!before && !after) continue;
            const float beyond = axis.at - std::copysign(inner, before ? -axis.way : axis.way);
            a += axis.way * axis.way;
            b += axis.way * beyond;
            c += beyond * beyond;
        }
        if ((a * t + 2 * b) * t + c <= kOn * radius * radius) return first + t;
        if (a * t + b >= 0) return std::nullopt;
        const float under = b * b - a * c;
        if (under >= 0) {
            const float meets = (-b - std::sqrt(under)) / a;
            if (meets <= std::min(next, rest)) return first + std::max(meets, t);
        }
        t = next;
    }
    return std::nullopt;
}

Vec RoundedCube::normal(const Vec& at) const {
    const Vec from_middle = at - middle;
    if (radius > 0) {
        const float inner = half - radius;
        const Vec out = from_middle - from_middle.cwiseMax(-inner).cwiseMin(inner);
        const float length = out.norm();
        if (length > 0) return out / length;
    }
    int axis = 0;
    from_middle.cwiseAbs().maxCoeff(&axis);
    return std::copysign(1.0F, from_middle[axis]) * Vec::Unit(axis);
}

}  // namespace meld::render
