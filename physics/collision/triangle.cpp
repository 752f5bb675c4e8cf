#include "physics/collision/triangle.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "runtime/base/assert.h"

namespace meld::physics {

namespace {

// A triangle this thin, as a share of its size squared, is taken for its edges.
constexpr double kThin = 1e-12;
// A sphere that meets the plane this near to the face, as a share of its radius, meets the face.
constexpr double kBesideShare = 1e-6;

Vec3 nearest_on_edge(Vec3 from, Vec3 to, Vec3 p) {
    const Vec3 along = to - from;
    const double squared = dot(along, along);
    return squared > 0 ? from + std::clamp(dot(p - from, along) / squared, 0.0, 1.0) * along : from;
}

Vec3 nearest_on_edges(const Triangle& t, Vec3 p) {
    Vec3 best = t.a;
    for (const Vec3 point : {nearest_on_edge(t.a, t.b, p), nearest_on_edge(t.b, t.c, p), nearest_on_edge(t.c, t.a, p)})
        if (length(p - point) < length(p - best)) best = point;
    return best;
}

}  // namespace

// C. Ericson, Real-Time Collision Detection (2005), 5.1.5: which region of corners, edges and face the point is in.
Vec3 nearest_in_face(const Triangle& t, Vec3 p) {
    // Names as there.
    const Vec3 ab = t.b - t.a, ac = t.c - t.a, ap = p - t.a;
    const double d1 = dot(ab, ap), d2 = dot(ac, ap);
    if (d1 <= 0 && d2 <= 0) return t.a;
    const Vec3 bp = p - t.b;
    const double d3 = dot(ab, bp), d4 = dot(ac, bp);
    if (d3 >= 0 && d4 <= d3) return t.b;
    const double vc = d1 * d4 - d3 * d2;
    if (vc <= 0 && d1 >= 0 && d3 <= 0) return t.a + (d1 / (d1 - d3)) * ab;
    const Vec3 cp = p - t.c;
    const double d5 = dot(ab, cp), d6 = dot(ac, cp);
    if (d6 >= 0 && d5 <= d6) return t.c;
    const double vb = d5 * d2 - d1 * d6;
    if (vb <= 0 && d2 >= 0 && d6 <= 0) return t.a + (d2 / (d2 - d6)) * ac;
    const double va = d3 * d6 - d5 * d4;
    if (va <= 0 && d4 >= d3 && d5 >= d6) return t.b + ((d4 - d3) / ((d4 - d3) + (d5 - d6))) * (t.c - t.b);
    const double scale = 1 / (va + vb + vc);
    return t.a + (vb * scale) * ab + (vc * scale) * ac;
}

namespace {

// The first share of the path at which a sphere touches a point, given the way from there to its centre, or a line, given the parts of both
// across it. Nothing if it touches at first, or never. The smaller root, computed without cancellation.
std::optional<double> first_share(Vec3 from_at, Vec3 path, double radius_m) {
    const double towards = -dot(from_at, path), beyond = dot(from_at, from_at) - radius_m * radius_m;
    if (!(towards > 0 && beyond > 0)) return std::nullopt;
    const double inside = towards * towards - dot(path, path) * beyond;
    if (inside < 0) return std::nullopt;
    const double share = beyond / (towards + std::sqrt(inside));
    return share <= 1 ? std::optional(share) : std::nullopt;
}

}  // namespace

std::optional<Vec3> normal_of(const Triangle& t) {
    const Vec3 ab = t.b - t.a, ac = t.c - t.a, n = cross(ab, ac);
    const double size = std::max(dot(ab, ab), dot(ac, ac)), area = length(n);
    return area > kThin * size ? std::optional((1 / area) * n) : std::nullopt;
}

Vec3 nearest_point(const Triangle& t, Vec3 p) { return normal_of(t) ? nearest_in_face(t, p) : nearest_on_edges(t, p); }

// By the volumes that the way makes with each edge. That of an edge differs between the two triangles that share it by its sign alone, so
// no way passes between them.
std::optional<double> share_at(const Triangle& t, const Ray& ray) {
    const Vec3 a = t.a - ray.from, b = t.b - ray.from, c = t.c - ray.from;
    const double u = dot(ray.way, cross(c, b)), v = dot(ray.way, cross(a, c)), w = dot(ray.way, cross(b, a)), all = u + v + w;
    const bool inside = (u >= 0 && v >= 0 && w >= 0) || (u <= 0 && v <= 0 && w <= 0);
    if (!inside || all == 0) return std::nullopt;
    const double share = (u * dot(a, ray.way) + v * dot(b, ray.way) + w * dot(c, ray.way)) / all / dot(ray.way, ray.way);
    return share >= 0 && share <= 1 ? std::optional(share) : std::nullopt;
}

// The distance to a triangle is convex along the path, so the first touch with its face, its edges or its corners is the only one.
std::optional<Impact> impact_on(const Triangle& t, Vec3 centre, double radius_m, Vec3 path) {
    MELD_EXPECT(radius_m > 0, "{} m", radius_m);
    if (length(centre - nearest_point(t, centre)) <= radius_m) return std::nullopt;
    std::optional<Impact> first;
    const auto touch = [&](double share, Vec3 point) {
        if (!first || share < first->share) first = Impact{share, point};
    };
    if (const auto normal = normal_of(t)) {
        const double height = dot(centre - t.a, *normal), side = height < 0 ? -1 : 1, closing = -side * dot(path, *normal);
        const double way = side * height - radius_m;
        if (way >= 0 && closing > 0 && way <= closing) {
            const double share = way / closing;
            const Vec3 at = centre + share * path - (side * radius_m) * *normal, nearest = nearest_in_face(t, at);
            // Beside the face, the sphere meets an edge or a corner, later.
            if (length(at - nearest) <= kBesideShare * radius_m) return Impact{share, nearest};
        }
    }
    for (const auto& [from, to] : {std::pair(t.a, t.b), std::pair(t.b, t.c), std::pair(t.c, t.a)}) {
        if (const auto share = first_share(centre - from, path, radius_m)) touch(*share, from);
        const Vec3 along = to - from;
        const double squared = dot(along, along);
        if (!(squared > 0)) continue;
        const auto across = [&](Vec3 v) { return v - (dot(v, along) / squared) * along; };
        const auto share = first_share(across(centre - from), across(path), radius_m);
        if (!share) continue;
        const double at = dot(centre + *share * path - from, along) / squared;
        if (at >= 0 && at <= 1) touch(*share, from + at * along);
    }
    return first;
}

}  // namespace meld::physics
