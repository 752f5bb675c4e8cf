// The nearest points of the triangles around a sphere.
#include "physics/collision/terrain.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "physics/collision/triangle.h"
#include "runtime/base/assert.h"

namespace meld::physics {

namespace {

Vec3 point_at(const Terrain& terrain, int column, int row) {
    MELD_EXPECT(column >= 0 && column < terrain.columns && row >= 0 && row < terrain.rows, "point {}, {}", column, row);
    const auto index = static_cast<std::size_t>(row) * static_cast<std::size_t>(terrain.columns) + static_cast<std::size_t>(column);
    return terrain.origin + Vec3{column * terrain.cell_m, row * terrain.cell_m, terrain.heights_m[index]};
}

// Counter-clockwise as seen from above.
std::array<Triangle, 2> triangles_of(const Terrain& terrain, int column, int row) {
    const Vec3 low = point_at(terrain, column, row), high = point_at(terrain, column + 1, row + 1);
    return {{{low, point_at(terrain, column + 1, row), high}, {low, high, point_at(terrain, column, row + 1)}}};
}

// Calls visit(triangle) for those that may be within `range_m` of the point.
template <class Visit>
void each_triangle_near(const Terrain& terrain, Vec3 point, double range_m, const Visit& visit) {
    const auto cell = [&](double at, int cells) {
        return static_cast<int>(std::clamp(std::floor(at / terrain.cell_m), 0.0, static_cast<double>(cells - 1)));
    };
    const Vec3 local = point - terrain.origin;
    const double width = (terrain.columns - 1) * terrain.cell_m, depth = (terrain.rows - 1) * terrain.cell_m;
    if (local.x < -range_m || local.y < -range_m || local.x > width + range_m || local.y > depth + range_m) return;
    const int first_column = cell(local.x - range_m, terrain.columns - 1), last_column = cell(local.x + range_m, terrain.columns - 1);
    const int first_row = cell(local.y - range_m, terrain.rows - 1), last_row = cell(local.y + range_m, terrain.rows - 1);
    for (int row = first_row; row <= last_row; ++row)
        for (int column = first_column; column <= last_column; ++column)
            for (const Triangle& triangle : triangles_of(terrain, column, row)) {
                const auto [low, high] = std::minmax({triangle.a.z, triangle.b.z, triangle.c.z});
                if (low - point.z <= range_m && point.z - high <= range_m) visit(triangle);
            }
}

// The height of the surface over a point of the grid, in cells from its first point.
double ground_at(const Terrain& terrain, double x, double y) {
    const int column = std::min(static_cast<int>(x), terrain.columns - 2), row = std::min(static_cast<int>(y), terrain.rows - 2);
    const double u = x - column, v = y - row;
    const auto [lower, upper] = triangles_of(terrain, column, row);
    const Vec3 p = lower.a;
    return u >= v ? p.z + u * (lower.b.z - p.z) + v * (lower.c.z - lower.b.z) : p.z + v * (upper.c.z - p.z) + u * (upper.b.z - upper.c.z);
}

// How far a point is above the surface, straight down; infinite beside the terrain.
double height_above(const Terrain& terrain, Vec3 point) {
    const double x = (point.x - terrain.origin.x) / terrain.cell_m, y = (point.y - terrain.origin.y) / terrain.cell_m;
    if (!(x >= 0 && y >= 0 && x <= terrain.columns - 1 && y <= terrain.rows - 1)) return std::numeric_limits<double>::infinity();
    return point.z - ground_at(terrain, x, y);
}

// The nearest point of the surface within the range, and the direction out of the ground there.
struct Nearest {
    Vec3 point, normal;
    double distance_m;
};

std::optional<Nearest> nearest_of(const Terrain& terrain, Vec3 point, double range_m) {
    const double above = height_above(terrain, point);
    // The surface is straight above, so a point in the ground need not look farther.
    const double range = above < 0 ? -above * (1 + 1e-9) : range_m;
    std::optional<Nearest> best;
    each_triangle_near(terrain, point, range, [&](const Triangle& triangle) {
        const Vec3 on_surface = nearest_in_face(triangle, point);
        const double distance = length(point - on_surface);
        if (distance > range || (best && distance >= std::abs(best->distance_m))) return;
        constexpr double kInSurface = 1e-12;
        const Vec3 normal = distance > kInSurface ? (1 / distance) * (above < 0 ? on_surface - point : point - on_surface)
                                                  : normal_of(triangle).value_or(Vec3{0, 0, 1});
        best = Nearest{on_surface, normal, above < 0 ? -distance : distance};
    });
    return best;
}

}  // namespace

void triangles_at(const Terrain& terrain, Vec3 low, Vec3 high, std::vector<Triangle>& found) {
    const Vec3 from = low - terrain.origin, to = high - terrain.origin;
    if (to.x < 0 || to.y < 0 || from.x > (terrain.columns - 1) * terrain.cell_m || from.y > (terrain.rows - 1) * terrain.cell_m) return;
    const auto cell = [&](double at, int cells) {
        return static_cast<int>(std::clamp(std::floor(at / terrain.cell_m), 0.0, static_cast<double>(cells - 1)));
    };
    for (int row = cell(from.y, terrain.rows - 1); row <= cell(to.y, terrain.rows - 1); ++row)
        for (int column = cell(from.x, terrain.columns - 1); column <= cell(to.x, terrain.columns - 1); ++column)
            for (const Triangle& triangle : triangles_of(terrain, column, row))
                if (std::max({triangle.a.z, triangle.b.z, triangle.c.z}) >= low.z) found.push_back(triangle);
}

double distance_to(const Terrain& terrain, Vec3 point, double range_m) {
    const auto nearest = nearest_of(terrain, point, range_m);
    return nearest ? nearest->distance_m : range_m;
}

int collide(const Terrain& terrain, Vec3 centre, double radius_m, double reach_m,
            std::array<SurfaceContact, kMaxSurfaceContacts>& contacts) {
    MELD_EXPECT(radius_m > 0 && reach_m >= 0, "radius {}, reach {}", radius_m, reach_m);
    const auto nearest = nearest_of(terrain, centre, radius_m + reach_m);
    if (!nearest || nearest->distance_m - radius_m >= reach_m) return 0;
    contacts[0] = {nearest->normal, nearest->distance_m - radius_m};
    // A body deep in the ground leaves it at the nearest point.
    if (nearest->distance_m < 0) return 1;
    std::array<Vec3, kMaxSurfaceContacts> points{nearest->point};
    int count = 1;
    // Repeatedly, the nearest point that is above the tangent planes of all contacts so far.
    while (count < kMaxSurfaceContacts) {
        constexpr double kAboveShare = 1e-6;
        double least = radius_m + reach_m;
        std::optional<Vec3> next;
        each_triangle_near(terrain, centre, least, [&](const Triangle& triangle) {
            const Vec3 point = nearest_in_face(triangle, centre);
            const double distance = length(centre - point);
            if (distance >= least) return;
            for (int i = 0; i < count; ++i) {
                const auto at = static_cast<std::size_t>(i);
                if (dot(point - points[at], contacts[at].normal) <= kAboveShare * radius_m) return;
            }
            least = distance, next = point;
        });
        if (!next) break;
        const auto at = static_cast<std::size_t>(count++);
        points[at] = *next;
        contacts[at] = {(1 / least) * (centre - *next), least - radius_m};
    }
    return count;
}

// Between two lines of the grid, or a line and the diagonal of a cell, the ground below a ray is even. So its height over the ground is
// found at all of them, one after the other.
std::optional<double> first_on(const Terrain& terrain, const Ray& ray) {
    const double width = (terrain.columns - 1) * terrain.cell_m, depth = (terrain.rows - 1) * terrain.cell_m;
    const Vec3 origin = terrain.origin;
    constexpr double kEver = std::numeric_limits<double>::infinity();
    const auto part = part_within(ray, {origin.x, origin.y, -kEver}, {origin.x + width, origin.y + depth, kEver});
    if (!part) return std::nullopt;
    const double x = (ray.from.x - origin.x) / terrain.cell_m, y = (ray.from.y - origin.y) / terrain.cell_m;
    const double along_x = ray.way.x / terrain.cell_m, along_y = ray.way.y / terrain.cell_m;
    const auto above = [&](double share) {
        const double column = std::clamp(x + share * along_x, 0.0, static_cast<double>(terrain.columns - 1));
        const double row = std::clamp(y + share * along_y, 0.0, static_cast<double>(terrain.rows - 1));
        return ray.from.z + share * ray.way.z - ground_at(terrain, column, row);
    };
    // The next whole number of x, y and x - y, and where it is.
    struct Lines {
        double from, way, next = 0;
        double share() const { return way == 0 ? kEver : (next - from) / way; }
    };
    std::array<Lines, 3> all{{{x, along_x}, {y, along_y}, {x - y, along_x - along_y}}};
    for (Lines& lines : all) {
        const double start = lines.from + part->enter * lines.way;
        lines.next = lines.way > 0 ? std::floor(start) + 1 : std::ceil(start) - 1;
    }
    double share = part->enter, height = above(share);
    if (height <= 0) return share;
    while (share < part->leave) {
        Lines& nearest = *std::ranges::min_element(all, {}, [](const Lines& lines) { return lines.share(); });
        const double then = std::clamp(nearest.share(), share, part->leave), height_then = above(then);
        nearest.next += nearest.way > 0 ? 1 : -1;
        if (height_then <= 0) return share + height / (height - height_then) * (then - share);
        if (nearest.way == 0) break;
        share = then, height = height_then;
    }
    return std::nullopt;
}

// Advances by the distance to the surface repeatedly, which never leads into it (conservative advancement).
std::optional<SurfaceContact> meet(const Terrain& terrain, Vec3 centre, double radius_m, Vec3 path) {
    constexpr int kMaxSteps = 256;
    constexpr double kNear = 1e-4;
    const double far = length(path), range = radius_m + std::max(radius_m, terrain.cell_m);
    double gone = 0;
    for (int i = 0; i < kMaxSteps; ++i) {
        const Vec3 at = centre + (gone / far) * path;
        const auto nearest = nearest_of(terrain, at, range);
        const double gap = (nearest ? nearest->distance_m : range) - radius_m;
        if (gap > kNear * radius_m) {
            gone += gap;
            if (gone > far) return std::nullopt;
            continue;
        }
        if (i == 0) return std::nullopt;
        return SurfaceContact{nearest->normal, gap - gone / far * dot(nearest->normal, path)};
    }
    return std::nullopt;
}

}  // namespace meld::physics
