#include "physics/collision/ray.h"

#include <algorithm>
#include <cmath>

namespace meld::physics {

namespace {

std::optional<double> first_on_sphere(Vec3 centre, double radius_m, const Ray& ray) {
    const Vec3 away = ray.from - centre;
    const double beyond = dot(away, away) - radius_m * radius_m, along = dot(away, ray.way);
    if (beyond <= 0) return 0;
    if (along >= 0) return std::nullopt;
    const double under_root = along * along - dot(ray.way, ray.way) * beyond;
    if (under_root < 0) return std::nullopt;
    // The smaller root, without cancellation.
    const double share = beyond / (std::sqrt(under_root) - along);
    return share <= 1 ? std::optional(share) : std::nullopt;
}

std::optional<double> first_on_parts(const BodyShape& shape, Vec3 centre, Quat turn, const Ray& ray) {
    std::optional<double> first;
    if (!first_on_sphere(centre, shape.radius_m(), ray)) return first;
    for (const ShapePart& part : shape.parts) {
        const std::optional<double> met = first_on(solid_of(part), centre + rotate(turn, part.at_m), product(turn, part.turn), ray);
        if (met && (!first || *met < *first)) first = met;
    }
    return first;
}

}  // namespace

std::optional<RayPart> part_within(const Ray& ray, Vec3 low, Vec3 high) {
    RayPart part;
    const auto narrow = [&](double from, double way, double least, double most) {
        if (way == 0) return from >= least && from <= most;
        const double a = (least - from) / way, b = (most - from) / way;
        part.enter = std::max(part.enter, std::min(a, b));
        part.leave = std::min(part.leave, std::max(a, b));
        return part.enter <= part.leave;
    };
    if (!narrow(ray.from.x, ray.way.x, low.x, high.x) || !narrow(ray.from.y, ray.way.y, low.y, high.y) ||
        !narrow(ray.from.z, ray.way.z, low.z, high.z))
        return std::nullopt;
    return part;
}

// The distance from a convex core is a convex function of the share, so Newton's method comes from outside without ever passing the
// surface.
std::optional<double> first_on(const BodyShape& shape, Vec3 centre, Quat turn, const Ray& ray) {
    if (shape.is_compound()) return first_on_parts(shape, centre, turn, ray);
    if (shape.is_sphere()) return first_on_sphere(centre, shape.rounding_m, ray);
    const std::optional<double> around = first_on_sphere(centre, shape.radius_m(), ray);
    if (!around) return std::nullopt;
    constexpr int kMaxSteps = 64;
    // A way that comes this near, as a share of the size, meets the body.
    constexpr double kNear = 1e-10;
    const double near = kNear * shape.radius_m();
    const Quat into = conjugate(turn);
    const Vec3 from = rotate(into, ray.from - centre), way = rotate(into, ray.way);
    double share = *around;
    for (int i = 0; i < kMaxSteps; ++i) {
        const Vec3 away = shape.from_core(from + share * way);
        const double distance = length(away), gap = distance - shape.rounding_m;
        if (gap <= near) return share;
        const double closing = -dot(away, way) / distance;
        if (!(closing > 0)) return std::nullopt;
        share += gap / closing;
        if (share > 1) return std::nullopt;
    }
    return std::nullopt;
}

double depth_along(const BodyShape& shape, Vec3 direction) {
    if (shape.is_sphere()) return shape.rounding_m;
    // From outside to the centre.
    const double radius = shape.radius_m();
    const std::optional<double> met = first_on(shape, {}, {}, {radius * direction, -radius * direction});
    return (1 - met.value_or(1)) * radius;
}

}  // namespace meld::physics
