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

// Along the ray, the squared distance to the smaller cube is a convex function, of second degree between two of the planes in which the
// faces of that cube lie. So the first place where it is the radius squared is found piece by piece; and a ray that has begun to go away
// never comes back.
std::optional<float> enters_box(const Vec& half, float radius, const Vec& begin, const Vec& along, float within) {
    std::array<float, 3> way;
    float first = 0, last = within;
    for (int i = 0; i < 3; ++i) {
        way[static_cast<std::size_t>(i)] = std::abs(along[i]) < kLean ? kLean : along[i];
        const float slope = 1 / way[static_cast<std::size_t>(i)];
        const float one = (-half[i] - begin[i]) * slope, other = (half[i] - begin[i]) * slope;
        first = std::max(first, std::min(one, other));
        last = std::min(last, std::max(one, other));
    }
    if (first > last) return std::nullopt;
    if (radius <= 0) return first;
    // From here on ways are counted from where the ray meets the cube with sharp edges: those from far away are too long to be exact.
    const float rest = last - first;
    // The half edge of the smaller one, where the ray begins, its direction, and when it comes between the planes and leaves them.
    struct Axis {
        float inner, at, way, in, out;
    };
    std::array<Axis, 3> axes;
    for (std::size_t i = 0; i < 3; ++i) {
        Axis& axis = axes[i];
        axis.inner = half[static_cast<int>(i)] - radius;
        axis.way = way[i];
        axis.at = begin[static_cast<int>(i)] + first * axis.way;
        const float towards = std::copysign(axis.inner, axis.way);
        axis.in = (-towards - axis.at) / axis.way;
        axis.out = (towards - axis.at) / axis.way;
    }
    for (float t = 0; t <= rest;) {
        float a = 0, b = 0, c = -radius * radius, next = kFar;
        for (const Axis& axis : axes) {
            const bool before = t < axis.in, after = t >= axis.out;
            if (before || !after) next = std::min(next, before ? axis.in : axis.out);
            if (!before && !after) continue;
            const float beyond = axis.at - std::copysign(axis.inner, before ? -axis.way : axis.way);
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

// How far a place in the frame of a cylinder is out of a smaller one, away from the axis and along it.
Eigen::Vector2f beyond_cylinder(float wide, float high, const Vec& at) { return {at.head<2>().norm() - wide, std::abs(at.z()) - high}; }

// The ray goes on from where it meets the cylinder with a sharp rim, by steps no longer than the distance to the round one.
std::optional<float> enters_cylinder(const Vec& half, float radius, const Vec& begin, const Vec& along, float within) {
    constexpr int kSteps = 64;
    const float up = std::abs(along.z()) < kLean ? kLean : along.z();
    const float one = (-half.z() - begin.z()) / up, other = (half.z() - begin.z()) / up;
    float first = std::max(0.0F, std::min(one, other)), last = std::min(within, std::max(one, other));
    const float square = along.head<2>().squaredNorm();
    const float middle = square > kLean ? -begin.head<2>().dot(along.head<2>()) / square : 0;
    const float rest = half.x() * half.x() - (begin + middle * along).head<2>().squaredNorm();
    if (rest < 0) return std::nullopt;
    if (square > kLean) {
        const float wide = std::sqrt(rest / square);
        first = std::max(first, middle - wide), last = std::min(last, middle + wide);
    }
    if (first > last) return std::nullopt;
    if (radius <= 0) return first;
    const Vec from = begin + first * along;
    float t = 0;
    for (int i = 0; i < kSteps && t <= last - first; ++i) {
        const float gap = beyond_cylinder(half.x() - radius, half.z() - radius, from + t * along).cwiseMax(0).norm() - radius;
        if (gap <= kOn * radius) return first + t;
        t += gap;
    }
    return std::nullopt;
}

Vec normal_of_cylinder(const Vec& half, float radius, const Vec& at) {
    const Eigen::Vector2f out = beyond_cylinder(half.x() - radius, half.z() - radius, at);
    const float away = at.head<2>().norm(), side = std::copysign(1.0F, at.z());
    const Vec across = away > 0 ? Vec(at.x() / away, at.y() / away, 0) : Vec(Vec::UnitX()), up = side * Vec::UnitZ();
    if (radius > 0 && out.minCoeff() > 0) return (out.x() * across + out.y() * up).normalized();
    return out.x() > out.y() ? across : up;
}

// At a place from the middle.
Vec normal_of_box(const Vec& half, float radius, const Vec& from_middle) {
    if (radius > 0) {
        const Vec inner = half - Vec::Constant(radius);
        const Vec out = from_middle - from_middle.cwiseMax(-inner).cwiseMin(inner);
        const float length = out.norm();
        if (length > 0) return out / length;
    }
    int axis = 0;
    from_middle.cwiseAbs().cwiseQuotient(half).maxCoeff(&axis);
    return std::copysign(1.0F, from_middle[axis]) * Vec::Unit(axis);
}

}  // namespace

std::optional<float> RoundedCube::enters(const Vec& from, const Vec& along, float within) const {
    return enters_box(Vec::Constant(half), radius, from - middle, along, within);
}

Vec RoundedCube::normal(const Vec& at) const { return normal_of_box(Vec::Constant(half), radius, at - middle); }

RoundedBox RoundedBox::of(const RoundedBody& body, const Vec& middle) {
    return {middle, body.around(), body.rounding, body.turn.toRotationMatrix(), body.is_cylinder()};
}

std::optional<float> RoundedBox::enters(const Vec& from, const Vec& along, float within) const {
    const Vec begin = turn.transpose() * (from - middle), way = turn.transpose() * along;
    return cylinder ? enters_cylinder(half, radius, begin, way, within) : enters_box(half, radius, begin, way, within);
}

Vec RoundedBox::normal(const Vec& at) const {
    const Vec own = turn.transpose() * (at - middle);
    return turn * (cylinder ? normal_of_cylinder(half, radius, own) : normal_of_box(half, radius, own));
}

}  // namespace meld::render
