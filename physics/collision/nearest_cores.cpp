#include "physics/collision/nearest_cores.h"

#include <array>
#include <cmath>
#include <span>

namespace meld::physics {

namespace {

// A point of the difference of two cores, and the points of the cores that make it.
struct Corner {
    Vec3 from, p, q;
};

// Up to four corners, the newest one last, and the point of their hull that is nearest to the origin.
struct Simplex {
    std::array<Corner, 4> corners;
    std::array<double, 4> shares{};
    int count = 0;

    Vec3 nearest() const { return mixed(&Corner::from); }
    Vec3 mixed(Vec3 Corner::* what) const {
        Vec3 sum;
        for (std::size_t i = 0; i < static_cast<std::size_t>(count); ++i) sum = sum + shares[i] * (corners[i].*what);
        return sum;
    }
};

// The shares of corners at the point of their plane, or line, that is nearest to the origin. False if it is not between them all.
bool shares_of(std::span<const Corner* const> some, std::array<double, 4>& shares) {
    constexpr double kFlatTriangle = 1e-14;
    shares = {1};
    if (some.size() == 1) return true;
    const Vec3 origin = some[0]->from, u = some[1]->from - origin;
    if (some.size() == 2) {
        const double square = dot(u, u);
        if (!(square > 0)) return false;
        shares[1] = -dot(origin, u) / square;
        shares[0] = 1 - shares[1];
        return shares[0] > 0 && shares[1] > 0;
    }
    const Vec3 v = some[2]->from - origin;
    if (some.size() == 3) {
        const double uu = dot(u, u), uv = dot(u, v), vv = dot(v, v), det = uu * vv - uv * uv;
        if (!(det > kFlatTriangle * uu * vv)) return false;
        const double along_u = -dot(origin, u), along_v = -dot(origin, v);
        shares[1] = (along_u * vv - along_v * uv) / det;
        shares[2] = (along_v * uu - along_u * uv) / det;
        shares[0] = 1 - shares[1] - shares[2];
        return shares[0] > 0 && shares[1] > 0 && shares[2] > 0;
    }
    const Vec3 w = some[3]->from - origin, across = cross(u, v);
    const double det = dot(across, w);
    if (!(std::abs(det) > kFlatTriangle * length(u) * length(v) * length(w))) return false;
    shares[1] = -dot(origin, cross(v, w)) / det;
    shares[2] = -dot(origin, cross(w, u)) / det;
    shares[3] = -dot(origin, across) / det;
    shares[0] = 1 - shares[1] - shares[2] - shares[3];
    return shares[0] > 0 && shares[1] > 0 && shares[2] > 0 && shares[3] > 0;
}

// Keeps those corners that span the nearest point, which the newest one is among. Four: they contain the origin.
void reduce(Simplex& simplex) {
    const int others = simplex.count - 1;
    Simplex best;
    double least = kNever;
    for (int chosen = 0; chosen < 1 << others; ++chosen) {
        std::array<const Corner*, 4> some{&simplex.corners[static_cast<std::size_t>(others)]};
        std::size_t count = 1;
        for (int i = 0; i < others; ++i)
            if ((chosen >> i & 1) != 0) some[count++] = &simplex.corners[static_cast<std::size_t>(i)];
        Simplex tried;
        if (!shares_of(std::span(some).first(count), tried.shares)) continue;
        for (std::size_t i = 0; i < count; ++i) tried.corners[i] = *some[i];
        tried.count = static_cast<int>(count);
        const Vec3 at = tried.nearest();
        if (const double square = count == 4 ? 0 : dot(at, at); square < least) best = tried, least = square;
    }
    simplex = best;
}

}  // namespace

Vec3 PlacedCore::support(Vec3 direction) const {
    const auto& [x, y, z] = *axes;
    const Vec3 up = centre + (dot(direction, z) < 0 ? -half_m.z : half_m.z) * z;
    if (kind == CoreKind::Cylinder) {
        const double along_x = dot(direction, x), along_y = dot(direction, y), across = std::sqrt(along_x * along_x + along_y * along_y);
        return across > 0 ? up + ((half_m.x * along_x / across) * x + (half_m.x * along_y / across) * y) : up;
    }
    if (kind == CoreKind::Triangle) {
        const double along_x = dot(direction, x), along_y = dot(direction, y), along_z = dot(direction, z);
        return centre + (along_x >= along_y && along_x >= along_z ? x : along_y >= along_z ? y : z);
    }
    if (kind != CoreKind::Box) return up;
    return up + ((dot(direction, x) < 0 ? -half_m.x : half_m.x) * x + (dot(direction, y) < 0 ? -half_m.y : half_m.y) * y);
}

PlacedCore PlacedCore::shrunk(double by_m) const {
    PlacedCore smaller = *this;
    if (kind < CoreKind::Cylinder || kind == CoreKind::Triangle) return smaller;
    smaller.half_m.x -= by_m, smaller.half_m.z -= by_m;
    if (kind == CoreKind::Box) smaller.half_m.y -= by_m;
    return smaller;
}

Nearness nearest_of_cores(const PlacedCore& a, const PlacedCore& b, double farthest_m, LineEnds& ends) {
    constexpr int kMaxCorners = 64;
    // Shares of the squared distance: one that is known so well is found.
    constexpr double kKnown = 1e-12, kTouching = 1e-24;
    const auto corner = [&](Vec3 direction) {
        const Vec3 p = a.support(direction), q = b.support(-direction);
        return Corner{q - p, p, q};
    };
    const Vec3 start = b.centre - a.centre;
    Simplex simplex;
    simplex.corners[0] = corner(dot(start, start) > 0 ? start : Vec3{0, 0, 1});
    simplex.shares[0] = 1, simplex.count = 1;
    Vec3 way = simplex.nearest();
    const double size = dot(a.half_m, a.half_m) + dot(b.half_m, b.half_m);
    for (int i = 0; i < kMaxCorners; ++i) {
        const double square = dot(way, way);
        if (!(square > kTouching * size)) return Nearness::Overlapping;
        const Corner next = corner(way);
        const double bound = dot(way, next.from);
        if (bound > farthest_m * std::sqrt(square)) return Nearness::Far;
        if (square - bound <= kKnown * square) break;
        Simplex wider = simplex;
        wider.corners[static_cast<std::size_t>(wider.count++)] = next;
        reduce(wider);
        if (wider.count == 4) return Nearness::Overlapping;
        const Vec3 nearer = wider.nearest();
        if (!(dot(nearer, nearer) < square)) break;
        simplex = wider;
        way = nearer;
    }
    ends = {simplex.mixed(&Corner::p), simplex.mixed(&Corner::q)};
    return Nearness::Apart;
}

Vec3 least_overlap(const PlacedCore& a, const PlacedCore& b, Vec3 start) {
    constexpr int kDirections = 8, kMaxRounds = 100;
    constexpr double kFirst = 0.4, kLast = 1e-4;
    Vec3 best = start;
    double most = separation(a, b, best);
    double step = kFirst;
    for (int round = 0; round < kMaxRounds && step > kLast; ++round) {
        const Vec3 u = any_across(best), v = cross(best, u);
        Vec3 better = best;
        for (int i = 0; i < kDirections; ++i) {
            const double angle = i * (M_PI / 4);
            const Vec3 leant = best + step * (std::cos(angle) * u + std::sin(angle) * v);
            const Vec3 tried = (1 / length(leant)) * leant;
            if (const double apart = separation(a, b, tried); apart > most) better = tried, most = apart;
        }
        if (better == best) step *= 0.5;
        best = better;
    }
    return best;
}

}  // namespace meld::physics
