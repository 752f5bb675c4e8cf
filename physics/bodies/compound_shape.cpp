#include "physics/bodies/compound_shape.h"

#include <fmt/format.h>

#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

namespace meld::physics {

namespace {

// Deviations of sums from what they are to be, as shares of what they consist of.
constexpr double kRounding = 1e-9;

// The principal moments of a tensor and their axes. Axes that are principal but for rounding stay as they are.
BodyShape::Inertia principal(const Symmetric& m) {
    const double most = 1e-14 * (m.xx + m.yy + m.zz);
    if (std::abs(m.xy) <= most && std::abs(m.xz) <= most && std::abs(m.yz) <= most) return {{m.xx, m.yy, m.zz}};
    Eigen::Matrix3d tensor;
    tensor << m.xx, m.xy, m.xz, m.xy, m.yy, m.yz, m.xz, m.yz, m.zz;
    const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver(tensor);
    Eigen::Matrix3d axes = solver.eigenvectors();
    if (axes.determinant() < 0) axes.col(2) *= -1;
    const Eigen::Quaterniond turn = Eigen::Quaterniond(axes).normalized();
    const Eigen::Vector3d moments = solver.eigenvalues();
    return {{moments.x(), moments.y(), moments.z()}, {turn.w(), turn.x(), turn.y(), turn.z()}};
}

// How far along a ray from `from` a solid is left, by Newton's method from beyond it: the distance from a convex core is a convex function
// of the way. 0: the ray does not meet it.
double last_on(const BodyShape& solid, Vec3 from, Vec3 direction, double beyond_m) {
    constexpr int kMaxSteps = 60;
    constexpr double kNear = 1e-12;
    double way = beyond_m;
    for (int step = 0; step < kMaxSteps && way > 0; ++step) {
        const Vec3 away = solid.from_core(from + way * direction);
        const double distance = length(away), gap = distance - solid.rounding_m;
        if (gap <= kNear * beyond_m) return way;
        const double growth = dot(away, direction) / distance;
        if (!(growth > 0)) return 0;
        way -= gap / growth;
    }
    return 0;
}

}  // namespace

double reach_m(const ShapePart& part) {
    const Vec3 half = part.core_m, own = rotate(conjugate(part.turn), part.at_m);
    // A box, or a line, by its corner that is farthest from the centre; a cylinder by the place on its rim.
    if (half.x > 0 && half.y == 0) return std::hypot(std::hypot(own.x, own.y) + half.x, std::abs(own.z) + half.z) + part.rounding_m;
    return length(Vec3{std::abs(own.x) + half.x, std::abs(own.y) + half.y, std::abs(own.z) + half.z}) + part.rounding_m;
}

BodyShape::Inertia inertia_of_parts(const BodyShape& shape) {
    Symmetric sum;
    for (const ShapePart& part : shape.parts) {
        const Vec3 own = part.share * solid_of(part).inertia().per_kg_m2;
        sum += inertia_about(part.share, turned({own.x, 0, 0, own.y, 0, own.z}, part.turn), part.at_m);
    }
    return principal(sum);
}

double way_out_of_parts(const BodyShape& shape, Vec3 direction) {
    const double beyond_m = shape.radius_m();
    double way = 0;
    for (const ShapePart& part : shape.parts) {
        const Quat into = conjugate(part.turn);
        way = std::max(way, last_on(solid_of(part), rotate(into, -part.at_m), rotate(into, direction), beyond_m));
    }
    return way;
}

PlacedCompound compound_of(std::vector<ShapePart> parts) {
    double all = 0;
    for (const ShapePart& part : parts) all += part.share;
    Vec3 centre;
    for (ShapePart& part : parts) part.share /= all, centre = centre + part.share * part.at_m;
    for (ShapePart& part : parts) part.at_m = part.at_m - centre, part.turn = part.turn == Quat{} ? part.turn : unit(part.turn);
    return {BodyShape{.parts = std::move(parts)}, centre};
}

Result<void> check_thickness(const BodyShape& shape) {
    constexpr double kMostSlender = 1e3;
    if (shape.radius_m() > kMostSlender * shape.least_m())
        return fail(fmt::format("a shape is {:.3g} m thick and {:.3g} m long", 2 * shape.least_m(), 2 * shape.radius_m()),
                    fmt::format("Make it at most {:.0f} times as long as thick", kMostSlender));
    return {};
}

Result<void> check_compound(const BodyShape& shape) {
    if (shape.parts.size() > kMaxShapeParts)
        return fail(fmt::format("a compound has {} parts", shape.parts.size()), fmt::format("Use at most {}", kMaxShapeParts));
    if (shape.core_m != Vec3{} || shape.rounding_m != 0)
        return fail("a compound has a core of its own besides its parts", "Make it one of its parts");
    double all = 0;
    Vec3 centre;
    for (const ShapePart& part : shape.parts) {
        if (auto fine = check(solid_of(part)); !fine) return fine;
        const Quat q = part.turn;
        const double norm = q.w * q.w + q.x * q.x + q.y * q.y + q.z * q.z;
        if (!is_finite(part.at_m) || !(std::abs(norm - 1) <= kRounding) || !(part.share > 0) || !std::isfinite(part.share))
            return fail("a part of a compound has no place, no rotation or no mass",
                        "Give it a finite place, a unit quaternion and a share");
        all += part.share, centre = centre + part.share * part.at_m;
    }
    if (!(std::abs(all - 1) <= kRounding) || !(length(centre) <= kRounding * shape.radius_m()))
        return fail("the parts of a compound do not balance about its centre", "Use what compound_of makes of them");
    return check_thickness(shape);
}

// A compound is known by a rounding that is minus the number of its parts.
void write_shape(const BodyShape& shape, ByteWriter& out) {
    out.write(shape.core_m), out.write(shape.is_compound() ? -static_cast<double>(shape.parts.size()) : shape.rounding_m);
    if (!shape.is_compound()) return;
    out.write(shape.name);
    for (const ShapePart& part : shape.parts) out.write(part);
}

BodyShape read_shape(ByteReader& in) {
    BodyShape shape{in.read<Vec3>(), in.read<double>()};
    if (!(shape.rounding_m < 0) || shape.rounding_m < -static_cast<double>(kMaxShapeParts)) return shape;
    const auto parts = static_cast<std::size_t>(-shape.rounding_m);
    shape.rounding_m = 0;
    shape.name = in.read<std::uint32_t>();
    for (std::size_t i = 0; i < parts && !in.failed(); ++i) shape.parts.push_back(in.read<ShapePart>());
    return shape;
}

}  // namespace meld::physics
