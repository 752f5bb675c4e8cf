#include "physics/collision/mesh_surface.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

#include "runtime/base/assert.h"

namespace meld::physics {

namespace {

constexpr std::uint32_t kTrianglesOfLeaf = 4;
// Halving 2^32 triangles ends before this depth.
constexpr std::size_t kMaxDepth = 64;
// What is less above a tangent plane, as a share of the radius, is in it.
constexpr double kAbovePlaneShare = 1e-6;
// A sphere whose centre is this near to the surface, m, leaves it along the normal.
constexpr double kOnSurface = 1e-12;

double axis_of(Vec3 v, int axis) { return axis == 0 ? v.x : axis == 1 ? v.y : v.z; }
Vec3 lower_of(Vec3 a, Vec3 b) { return {std::min(a.x, b.x), std::min(a.y, b.y), std::min(a.z, b.z)}; }
Vec3 upper_of(Vec3 a, Vec3 b) { return {std::max(a.x, b.x), std::max(a.y, b.y), std::max(a.z, b.z)}; }

// Whether a point is below the tangent plane of a contact that touches the surface at `at`, or in it.
bool is_below(Vec3 point, Vec3 at, Vec3 normal, double radius_m) { return dot(point - at, normal) <= kAbovePlaneShare * radius_m; }

}  // namespace

MeshSurface::MeshSurface(const Mesh& mesh) : order_(mesh.triangles.size() / 3) {
    MELD_EXPECT(!order_.empty() && mesh.triangles.size() % 3 == 0, "{} indices", mesh.triangles.size());
    std::iota(order_.begin(), order_.end(), 0u);
    std::vector<Vec3> centres(order_.size());
    for (std::uint32_t i = 0; i < centres.size(); ++i) {
        const Triangle t = triangle(mesh, i);
        centres[i] = (1.0 / 3) * (t.a + t.b + t.c);
    }
    nodes_.reserve(order_.size());
    build(mesh, centres, 0, static_cast<std::uint32_t>(order_.size()));
}

// Halves the triangles along the longest side of the box of their centres; of equal centres the lower number is first.
void MeshSurface::build(const Mesh& mesh, std::span<const Vec3> centres, std::uint32_t first, std::uint32_t count) {
    constexpr double kFar = std::numeric_limits<double>::infinity();
    Bounds bounds{{kFar, kFar, kFar}, {-kFar, -kFar, -kFar}}, middle = bounds;
    for (std::uint32_t i = first; i < first + count; ++i) {
        const Triangle t = triangle(mesh, order_[i]);
        for (const Vec3 corner : {t.a, t.b, t.c}) bounds = {lower_of(bounds.low, corner), upper_of(bounds.high, corner)};
        middle = {lower_of(middle.low, centres[order_[i]]), upper_of(middle.high, centres[order_[i]])};
    }
    const std::size_t here = nodes_.size();
    nodes_.push_back({bounds, first, count});
    if (count <= kTrianglesOfLeaf) return;
    const Vec3 size = middle.high - middle.low;
    const int axis = size.x >= size.y && size.x >= size.z ? 0 : size.y >= size.z ? 1 : 2;
    const auto begin = order_.begin() + first;
    const std::uint32_t half = count / 2;
    std::nth_element(begin, begin + half, begin + count, [&](std::uint32_t a, std::uint32_t b) {
        return std::pair(axis_of(centres[a], axis), a) < std::pair(axis_of(centres[b], axis), b);
    });
    build(mesh, centres, first, half);
    nodes_[here].first = static_cast<std::uint32_t>(nodes_.size()), nodes_[here].count = 0;
    build(mesh, centres, first + half, count - half);
}

Triangle MeshSurface::triangle(const Mesh& mesh, std::uint32_t number) const {
    const std::uint32_t* corners = mesh.triangles.data() + 3 * static_cast<std::size_t>(number);
    return {mesh.points[corners[0]], mesh.points[corners[1]], mesh.points[corners[2]]};
}

template <class Wanted, class Visit>
void MeshSurface::each(const Mesh& mesh, const Wanted& wanted, const Visit& visit) const {
    MELD_EXPECT(mesh.triangles.size() == 3 * order_.size(), "{} indices and {} triangles", mesh.triangles.size(), order_.size());
    std::array<std::uint32_t, kMaxDepth> todo;
    std::size_t left = 0;
    todo[left++] = 0;
    while (left > 0) {
        const std::uint32_t at = todo[--left];
        const Node& node = nodes_[at];
        if (!wanted(node.bounds)) continue;
        for (std::uint32_t i = 0; i < node.count; ++i) visit(triangle(mesh, order_[node.first + i]));
        if (node.count > 0) continue;
        MELD_ASSERT(left + 2 <= kMaxDepth, "{} nodes", nodes_.size());
        todo[left++] = node.first;
        todo[left++] = at + 1;
    }
}

int MeshSurface::collide(const Mesh& mesh, Vec3 centre, double radius_m, double reach_m,
                         std::array<SurfaceContact, kMaxSurfaceContacts>& contacts) const {
    MELD_EXPECT(radius_m > 0 && reach_m >= 0, "radius {}, reach {}", radius_m, reach_m);
    std::array<Vec3, kMaxSurfaceContacts> points;
    std::size_t count = 0;
    // Repeatedly, the nearest point that is above the tangent planes of all contacts so far.
    while (count < contacts.size()) {
        double nearest = radius_m + reach_m;
        std::optional<Vec3> next;
        Vec3 normal;
        const auto near = [&](const Bounds& box) {
            const Vec3 apart = centre - upper_of(box.low, lower_of(box.high, centre));
            return dot(apart, apart) < nearest * nearest;
        };
        each(mesh, near, [&](const Triangle& t) {
            const Vec3 point = nearest_point(t, centre);
            const double distance = length(centre - point);
            if (distance >= nearest) return;
            for (std::size_t i = 0; i < count; ++i)
                if (is_below(point, points[i], contacts[i].normal, radius_m)) return;
            nearest = distance, next = point;
            normal = distance > kOnSurface ? (1 / distance) * (centre - point) : normal_of(t).value_or(Vec3{0, 0, 1});
        });
        if (!next) break;
        points[count] = *next;
        contacts[count++] = {normal, nearest - radius_m};
    }
    return static_cast<int>(count);
}

void MeshSurface::triangles_at(const Mesh& mesh, Vec3 low, Vec3 high, std::vector<Triangle>& found) const {
    const auto meets = [&](const Vec3& from, const Vec3& to) {
        return from.x <= high.x && from.y <= high.y && from.z <= high.z && to.x >= low.x && to.y >= low.y && to.z >= low.z;
    };
    each(
        mesh, [&](const Bounds& box) { return meets(box.low, box.high); },
        [&](const Triangle& t) {
            if (meets(lower_of(t.a, lower_of(t.b, t.c)), upper_of(t.a, upper_of(t.b, t.c)))) found.push_back(t);
        });
}

std::optional<double> MeshSurface::first_on(const Mesh& mesh, const Ray& ray) const {
    std::optional<double> first;
    const auto on_way = [&](const Bounds& box) {
        const auto part = part_within(ray, box.low, box.high);
        return part && (!first || part->enter <= *first);
    };
    each(mesh, on_way, [&](const Triangle& t) {
        const auto share = share_at(t, ray);
        if (share && (!first || *share < *first)) first = share;
    });
    return first;
}

std::optional<SurfaceContact> MeshSurface::meet(const Mesh& mesh, Vec3 centre, double radius_m, Vec3 path,
                                                std::span<const SurfaceContact> touched) const {
    std::optional<Impact> first;
    // Whether the path, up to the first impact so far, comes as near to the box as the radius: into the box that is wider by it.
    const auto on_path = [&](const Bounds& box) {
        double enter = 0, leave = first ? first->share : 1;
        for (int axis = 0; axis < 3; ++axis) {
            const double from = axis_of(centre, axis), way = axis_of(path, axis);
            const double low = axis_of(box.low, axis) - radius_m - from, high = axis_of(box.high, axis) + radius_m - from;
            if (way == 0) {
                if (low > 0 || high < 0) return false;
                continue;
            }
            enter = std::max(enter, std::min(low / way, high / way));
            leave = std::min(leave, std::max(low / way, high / way));
        }
        return enter <= leave;
    };
    each(mesh, on_path, [&](const Triangle& t) {
        const auto impact = impact_on(t, centre, radius_m, path);
        if (!impact || (first && impact->share >= first->share)) return;
        for (const SurfaceContact& contact : touched)
            if (is_below(impact->point, centre - (radius_m + contact.gap_m) * contact.normal, contact.normal, radius_m)) return;
        first = impact;
    });
    if (!first) return std::nullopt;
    const Vec3 normal = (1 / radius_m) * (centre + first->share * path - first->point);
    return SurfaceContact{normal, -first->share * dot(normal, path)};
}

}  // namespace meld::physics
