#include "physics/bodies/body_shape.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <string>

#include "physics/bodies/compound_shape.h"

namespace meld::physics {

namespace {

constexpr std::size_t kMaxKinds = 65535;
constexpr double kPi = std::numbers::pi;

// The integral of x^2 over the shape whose core reaches from -a to a along x, and b and c across: the core, its six faces as slabs, its
// edges as quarters of cylinders and its corners as eighths of a ball.
double second_moment(double a, double b, double c, double r) {
    const double core = 8 * a * b * c * a * a / 3;
    const double ends = 8 * b * c * (std::pow(a + r, 3) - std::pow(a, 3)) / 3;
    const double sides = 8 * a * r * (b + c) * a * a / 3;
    const double round = kPi * r * r * a * a + 8 * a * r * r * r / 3 + kPi * std::pow(r, 4) / 4;
    const double across = 2 * (b + c) * round, along = 2 * a * kPi * r * r * a * a / 3;
    const double corners = 4 * kPi * std::pow(r, 3) * a * a / 3 + kPi * a * std::pow(r, 4) + 4 * kPi * std::pow(r, 5) / 15;
    return core + ends + sides + across + along + corners;
}

// Of a cylinder with a rounded rim, from its middle plane upwards: the integrals of rho^2, rho^4 and z^2 rho^2, where rho is its radius at
// height z. On the rounded part, at s above the core, that is R + sqrt(r^2 - s^2).
struct Profile {
    double square, fourth, high;
};
Profile profile_of(double R, double h, double r) {
    const double r2 = r * r, r3 = r2 * r, r4 = r3 * r, r5 = r4 * r;
    // Of the powers of sqrt(r^2 - s^2), of these times s, and times s^2.
    const double p0 = r, p1 = kPi * r2 / 4, p2 = 2 * r3 / 3, p3 = 3 * kPi * r4 / 16, p4 = 8 * r5 / 15;
    const double s0 = r2 / 2, s1 = r3 / 3, s2 = r4 / 4, t0 = r3 / 3, t1 = kPi * r4 / 16, t2 = 2 * r5 / 15;
    const double R2 = R * R, R4 = R2 * R2, wide = (R + r) * (R + r), round = R2 * p0 + 2 * R * p1 + p2;
    return {.square = h * wide + round,
            .fourth = h * wide * wide + R4 * p0 + 4 * R2 * R * p1 + 6 * R2 * p2 + 4 * R * p3 + p4,
            .high = h * h * h / 3 * wide + h * h * round + 2 * h * (R2 * s0 + 2 * R * s1 + s2) + R2 * t0 + 2 * R * t1 + t2};
}

}  // namespace

double BodyShape::radius_m() const {
    if (!is_compound()) return length(core_m) + rounding_m;
    double radius = 0;
    for (const ShapePart& part : parts) radius = std::max(radius, reach_m(part));
    return radius;
}

double BodyShape::least_m() const {
    if (is_compound()) {
        double least = std::numeric_limits<double>::infinity();
        for (const ShapePart& part : parts) least = std::min(least, solid_of(part).least_m());
        return least;
    }
    return (is_cylinder() ? std::min(core_m.x, core_m.z) : std::min({core_m.x, core_m.y, core_m.z})) + rounding_m;
}

double BodyShape::volume_m3() const {
    double sum = 0;
    for (const ShapePart& part : parts) sum += solid_of(part).volume_m3();
    if (is_compound()) return sum;
    if (is_cylinder()) return 2 * kPi * profile_of(core_m.x, core_m.z, rounding_m).square;
    const auto [a, b, c] = core_m;
    const double r = rounding_m;
    return 8 * a * b * c + 8 * r * (a * b + b * c + c * a) + 2 * kPi * r * r * (a + b + c) + 4 * kPi * r * r * r / 3;
}

double BodyShape::surface_m2() const {
    double sum = 0;
    for (const ShapePart& part : parts) sum += solid_of(part).surface_m2();
    if (is_compound()) return sum;
    const auto [a, b, c] = core_m;
    const double r = rounding_m;
    if (is_cylinder()) return 2 * kPi * a * a + 4 * kPi * c * (a + r) + 2 * kPi * r * (kPi * a + 2 * r);
    return 8 * (a * b + b * c + c * a) + 4 * kPi * r * (a + b + c) + 4 * kPi * r * r;
}

// Along the ray, the distance from the core is convex: Newton's method from outside comes nearer from one side.
double BodyShape::way_out_m(Vec3 direction) const {
    if (is_compound()) return way_out_of_parts(*this, direction);
    if (is_sphere()) return rounding_m;
    constexpr int kMaxSteps = 60;
    const bool box = core_m.y > 0;
    const double across = box ? std::abs(direction.x) : std::hypot(direction.x, direction.y);
    const double speeds[3] = {across, box ? std::abs(direction.y) : 0, std::abs(direction.z)}, half[3] = {core_m.x, core_m.y, core_m.z};
    double way = radius_m();
    for (int step = 0; step < kMaxSteps; ++step) {
        double square = 0, growth = 0;
        for (int k = 0; k < 3; ++k) {
            const double beyond = std::max(0.0, speeds[k] * way - half[k]);
            square += beyond * beyond, growth += beyond * speeds[k];
        }
        const double distance = std::sqrt(square), next = way - (distance - rounding_m) * distance / growth;
        if (!(distance > rounding_m) || !(next < way)) break;
        way = next;
    }
    return way;
}

Vec3 BodyShape::from_core(Vec3 p) const {
    const auto beyond = [](double at, double half) { return at - std::clamp(at, -half, half); };
    const Vec3 half = core_m;
    if (!is_cylinder()) return {beyond(p.x, half.x), beyond(p.y, half.y), beyond(p.z, half.z)};
    const double radius = std::sqrt(p.x * p.x + p.y * p.y), outside = radius > half.x ? 1 - half.x / radius : 0;
    return {outside * p.x, outside * p.y, beyond(p.z, half.z)};
}

BodyShape::Inertia BodyShape::inertia() const {
    if (is_compound()) return inertia_of_parts(*this);
    const auto [a, b, c] = core_m;
    if (is_cylinder()) {
        const Profile half = profile_of(a, c, rounding_m);
        const double along = half.fourth / (2 * half.square), across = along / 2 + half.high / half.square;
        return {{across, across, along}};
    }
    const double x = second_moment(a, b, c, rounding_m), y = second_moment(b, c, a, rounding_m), z = second_moment(c, a, b, rounding_m);
    return {(1 / volume_m3()) * Vec3{y + z, x + z, x + y}};
}

BodyShape box_shape(Vec3 edges_m, double rounding_m) { return {0.5 * edges_m - Vec3{rounding_m, rounding_m, rounding_m}, rounding_m}; }
BodyShape cylinder_shape(double radius_m, double height_m, double rounding_m) {
    return {{radius_m - rounding_m, 0, height_m / 2 - rounding_m}, rounding_m};
}
BodyShape capsule_shape(double radius_m, double length_m) { return {{0, 0, length_m / 2 - radius_m}, radius_m}; }

Result<void> check(const BodyShape& shape) {
    if (shape.is_compound()) return check_compound(shape);
    const auto [x, y, z] = shape.core_m;
    const double r = shape.rounding_m;
    const bool box = x > 0 && y > 0 && z > 0, cylinder = x > 0 && y == 0 && z > 0, line = x == 0 && y == 0 && z >= 0;
    if (!is_finite(shape.core_m) || !std::isfinite(r) || !(r >= 0) || !(box || cylinder || line) || (line && !(r > 0)))
        return fail(
            fmt::format("a shape has a core of half edges {}, {} and {} m and is rounded by {} m (which is no solid)", x, y, z, r),
            "Give a box three positive half edges, a cylinder (its radius, 0, half its height), both without the rounding, and a capsule "
            "(0, 0, half its length without its ends) and a positive rounding");
    return check_thickness(shape);
}

Result<BodyShapes::Index> BodyShapes::index_of(const BodyShape& shape) {
    if (shape.is_compound()) {
        ByteWriter bytes;
        write_shape(shape, bytes);
        const std::string key(reinterpret_cast<const char*>(bytes.view().data()), bytes.size());
        return index_in(known_compounds_, key, shape);
    }
    return index_in(known_, std::array<double, 4>{shape.core_m.x, shape.core_m.y, shape.core_m.z, shape.rounding_m}, shape);
}

template <class Key>
Result<BodyShapes::Index> BodyShapes::index_in(std::map<Key, Index>& known, const Key& key, const BodyShape& shape) {
    if (const auto found = known.find(key); found != known.end()) return found->second;
    if (kinds_.size() == kMaxKinds) return fail(fmt::format("there are already {} different shapes", kMaxKinds), "Let bodies share shapes");
    const BodyShape::Inertia inertia = shape.inertia();
    Kind kind{.shape = shape,
              .radius_m = shape.radius_m(),
              .least_m = shape.least_m(),
              .inertia_per_kg_m2 = inertia.per_kg_m2,
              .has_other_axes = inertia.axes != Quat{},
              .axes = inertia.axes};
    const double square = kind.radius_m * kind.radius_m;
    const auto [x, y, z] = kind.inertia_per_kg_m2;
    kind.turning = {square / x, square / y, square / z};
    kind.turns_alike = x == y && y == z;
    kinds_.push_back(kind);
    return known[key] = static_cast<Index>(kinds_.size());
}

Result<void> BodyShapes::set(BodyId body, const BodyShape& shape) {
    const auto index = index_of(shape);
    if (!index) return tl::unexpected(index.error());
    if (body >= of_.size()) of_.resize(std::max<std::size_t>(body + std::size_t{1}, 2 * of_.size()), 0);
    of_[body] = *index;
    return {};
}

}  // namespace meld::physics
