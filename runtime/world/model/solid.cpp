// Questions to a mesh: a walk down a tree of boxes, and what one triangle answers.
#include "runtime/world/model/solid.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numeric>

#include "runtime/base/assert.h"

namespace meld::model {
namespace {

constexpr std::uint32_t kLeafTriangles = 4;
// The tree halves the number of triangles at each level.
constexpr std::size_t kMaxDepth = 40;
// Rows along each axis by which openness is measured, on a grid.
constexpr int kRowsPerSide = 48;

Vec3 minus(const Vec3& a, const Vec3& b) { return {a[0] - b[0], a[1] - b[1], a[2] - b[2]}; }
double dot(const Vec3& a, const Vec3& b) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }
Vec3 along(const Vec3& from, const Vec3& way, double share) {
    return {from[0] + way[0] * share, from[1] + way[1] * share, from[2] + way[2] * share};
}
double square_between(const Vec3& a, const Vec3& b) {
    const Vec3 way = minus(a, b);
    return dot(way, way);
}

double square_to_box(const Vec3& low, const Vec3& high, const Vec3& p) {
    double square = 0;
    for (std::size_t i = 0; i < 3; ++i) {
        const double outside = std::max({low[i] - p[i], p[i] - high[i], 0.0});
        square += outside * outside;
    }
    return square;
}

// The point of a triangle that is nearest to p, by the region of the triangle's plane in which p lies (C. Ericson, Real-Time Collision
// Detection, 2005, section 5.1.5).
Vec3 nearest_on(const Vec3& a, const Vec3& b, const Vec3& c, const Vec3& p) {
    const Vec3 ab = minus(b, a), ac = minus(c, a), ap = minus(p, a);
    const double d1 = dot(ab, ap), d2 = dot(ac, ap);
    if (d1 <= 0 && d2 <= 0) return a;
    const Vec3 bp = minus(p, b);
    const double d3 = dot(ab, bp), d4 = dot(ac, bp);
    if (d3 >= 0 && d4 <= d3) return b;
    const double vc = d1 * d4 - d3 * d2;
    if (vc <= 0 && d1 >= 0 && d3 <= 0) return along(a, ab, d1 / (d1 - d3));
    const Vec3 cp = minus(p, c);
    const double d5 = dot(ab, cp), d6 = dot(ac, cp);
    if (d6 >= 0 && d5 <= d6) return c;
    const double vb = d5 * d2 - d1 * d6;
    if (vb <= 0 && d2 >= 0 && d6 <= 0) return along(a, ac, d2 / (d2 - d6));
    const double va = d3 * d6 - d5 * d4;
    if (va <= 0 && d4 - d3 >= 0 && d5 - d6 >= 0) return along(b, minus(c, b), (d4 - d3) / ((d4 - d3) + (d5 - d6)));
    const double all = va + vb + vc;
    // A triangle without area that rounding brought here.
    if (!(all > 0)) return a;
    return along(along(a, ab, vb / all), ac, vc / all);
}

}  // namespace

Solid::Solid(Triangles triangles) : points_(std::move(triangles.points)), corners_(std::move(triangles.corners)) {
    MELD_CHECK(!corners_.empty(), "a solid of no triangles");
    build();
    count_open_edges();
    if (!closed()) count_odd_rows();
}

double Solid::longest_side() const { return std::max({high_[0] - low_[0], high_[1] - low_[1], high_[2] - low_[2]}); }

Solid::Node Solid::around(std::uint32_t begin, std::uint32_t end) const {
    constexpr double kInfinity = std::numeric_limits<double>::infinity();
    Node node{{kInfinity, kInfinity, kInfinity}, {-kInfinity, -kInfinity, -kInfinity}, begin, end, 0};
    for (std::uint32_t t = begin; t < end; ++t) {
        for (const std::uint32_t corner : corners_[t]) {
            for (std::size_t i = 0; i < 3; ++i) {
                node.low[i] = std::min(node.low[i], points_[corner][i]);
                node.high[i] = std::max(node.high[i], points_[corner][i]);
            }
        }
    }
    return node;
}

void Solid::build() {
    struct Task {
        std::uint32_t begin, end;
        std::uint32_t parent;  // Whose second part this is; 0 if it is a first part, which follows its parent.
    };
    std::vector<Task> tasks = {{0, static_cast<std::uint32_t>(corners_.size()), 0}};
    while (!tasks.empty()) {
        const Task task = tasks.back();
        tasks.pop_back();
        const auto number = static_cast<std::uint32_t>(nodes_.size());
        if (task.parent != 0) nodes_[task.parent - 1].second = number;
        const Node node = nodes_.emplace_back(around(task.begin, task.end));
        if (task.end - task.begin <= kLeafTriangles) continue;
        std::size_t axis = 0;
        for (std::size_t i = 1; i < 3; ++i)
            if (node.high[i] - node.low[i] > node.high[axis] - node.low[axis]) axis = i;
        const auto middle = [&](const std::array<std::uint32_t, 3>& c) {
            return points_[c[0]][axis] + points_[c[1]][axis] + points_[c[2]][axis];
        };
        // Of equal middles, the corners decide, so that the order is the same with every library.
        const auto before = [&](const auto& a, const auto& b) {
            const double middle_a = middle(a), middle_b = middle(b);
            return middle_a != middle_b ? middle_a < middle_b : a < b;
        };
        const std::uint32_t half = std::midpoint(task.begin, task.end);
        std::nth_element(corners_.begin() + task.begin, corners_.begin() + half, corners_.begin() + task.end, before);
        tasks.push_back({half, task.end, number + 1});
        tasks.push_back({task.begin, half, 0});
    }
    low_ = nodes_[0].low;
    high_ = nodes_[0].high;
}

void Solid::count_open_edges() {
    std::vector<std::uint64_t> edges;
    edges.reserve(3 * corners_.size());
    for (const auto& c : corners_) {
        for (std::size_t i = 0; i < 3; ++i) {
            const auto [first, second] = std::minmax(c[i], c[(i + 1) % 3]);
            edges.push_back(std::uint64_t{first} << 32 | second);
        }
    }
    std::sort(edges.begin(), edges.end());
    for (std::size_t i = 0; i < edges.size();) {
        std::size_t end = i;
        while (end < edges.size() && edges[end] == edges[i]) ++end;
        ++openness_.edges;
        openness_.open_edges += (end - i) % 2;
        i = end;
    }
}

void Solid::count_odd_rows() {
    for (std::size_t axis = 0; axis < 3; ++axis) {
        const std::size_t u = (axis + 1) % 3, v = (axis + 2) % 3;
        for (int i = 0; i < kRowsPerSide * kRowsPerSide; ++i) {
            Vec3 start;
            start[axis] = std::nextafter(low_[axis], -std::numeric_limits<double>::infinity());
            start[u] = low_[u] + (high_[u] - low_[u]) * (i % kRowsPerSide + 0.5) / kRowsPerSide;
            start[v] = low_[v] + (high_[v] - low_[v]) * (i / kRowsPerSide + 0.5) / kRowsPerSide;
            ++openness_.rows;
            openness_.odd_rows += crossings(start, axis) % 2;
        }
    }
}

// In the plane across the row, the row is a point, and a triangle holds it if the half-line from there along u crosses an odd number of its
// edges.
bool Solid::crosses(std::uint32_t triangle, const Vec3& p, std::size_t axis) const {
    const std::size_t u = (axis + 1) % 3, v = (axis + 2) % 3;
    const auto& c = corners_[triangle];
    bool inside = false;
    for (std::size_t i = 0; i < 3; ++i) {
        const auto [first, second] = std::minmax(c[i], c[(i + 1) % 3]);
        const Vec3 &a = points_[first], &b = points_[second];
        if ((a[v] > p[v]) == (b[v] > p[v])) continue;
        const double there = a[u] + (b[u] - a[u]) * ((p[v] - a[v]) / (b[v] - a[v]));
        inside ^= p[u] < std::clamp(there, std::min(a[u], b[u]), std::max(a[u], b[u]));
    }
    if (!inside) return false;
    const Vec3 &a = points_[c[0]], &b = points_[c[1]], &d = points_[c[2]];
    const auto [least, most] = std::minmax({a[axis], b[axis], d[axis]});
    if (p[axis] < least) return true;
    if (p[axis] >= most) return false;
    const double bu = b[u] - a[u], bv = b[v] - a[v], du = d[u] - a[u], dv = d[v] - a[v], pu = p[u] - a[u], pv = p[v] - a[v];
    const double area = bu * dv - bv * du;
    const double height = area == 0
                              ? std::midpoint(least, most)
                              : a[axis] + ((pu * dv - pv * du) * (b[axis] - a[axis]) + (bu * pv - bv * pu) * (d[axis] - a[axis])) / area;
    return p[axis] < std::clamp(height, least, most);
}

std::uint32_t Solid::crossings(const Vec3& p, std::size_t axis) const {
    const std::size_t u = (axis + 1) % 3, v = (axis + 2) % 3;
    std::array<std::uint32_t, kMaxDepth> left;
    std::size_t count = 0;
    std::uint32_t crossed = 0;
    left[count++] = 0;
    while (count > 0) {
        const std::uint32_t number = left[--count];
        const Node& node = nodes_[number];
        if (p[axis] >= node.high[axis] || p[u] < node.low[u] || p[u] > node.high[u] || p[v] < node.low[v] || p[v] > node.high[v]) continue;
        if (node.second == 0) {
            for (std::uint32_t t = node.begin; t < node.end; ++t) crossed += crosses(t, p, axis);
        } else {
            left[count++] = node.second;
            left[count++] = number + 1;
        }
    }
    return crossed;
}

bool Solid::contains(const Vec3& point) const {
    for (std::size_t i = 0; i < 3; ++i)
        if (!(point[i] >= low_[i] && point[i] <= high_[i])) return false;
    const bool x = crossings(point, 0) % 2 != 0;
    if (closed()) return x;
    const bool y = crossings(point, 1) % 2 != 0;
    return x == y ? x : crossings(point, 2) % 2 != 0;
}

double Solid::distance_squared(std::uint32_t triangle, const Vec3& p) const {
    const auto& c = corners_[triangle];
    return square_between(nearest_on(points_[c[0]], points_[c[1]], points_[c[2]], p), p);
}

double Solid::distance(const Vec3& p) const {
    struct Left {
        std::uint32_t node;
        double square;
    };
    std::array<Left, kMaxDepth> left;
    std::size_t count = 0;
    double least = std::numeric_limits<double>::infinity();
    left[count++] = {0, square_to_box(low_, high_, p)};
    while (count > 0) {
        const Left here = left[--count];
        if (here.square >= least) continue;
        const Node& node = nodes_[here.node];
        if (node.second == 0) {
            for (std::uint32_t t = node.begin; t < node.end; ++t) least = std::min(least, distance_squared(t, p));
            continue;
        }
        Left first{here.node + 1, 0}, second{node.second, 0};
        for (Left* part : {&first, &second}) part->square = square_to_box(nodes_[part->node].low, nodes_[part->node].high, p);
        // The nearer part is looked at first.
        if (first.square < second.square) std::swap(first, second);
        left[count++] = first;
        left[count++] = second;
    }
    return contains(p) ? -std::sqrt(least) : std::sqrt(least);
}

}  // namespace meld::model
