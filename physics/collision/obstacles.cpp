// Obstacles: checked when added, converted to ODE geometries once per worker.
#include "physics/collision/obstacles.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <type_traits>

#include "physics/collision/ode_library.h"
#include "physics/collision/ode_shapes.h"
#include "physics/collision/surface_contacts.h"
#include "runtime/base/assert.h"

namespace meld::physics {

namespace {

struct Bounds {
    Vec3 low{-HUGE_VAL, -HUGE_VAL, -HUGE_VAL}, high{HUGE_VAL, HUGE_VAL, HUGE_VAL};
};

Result<Bounds> check(Plane& plane) {
    const double norm = length(plane.normal);
    if (!(norm > 0) || !std::isfinite(norm) || !std::isfinite(plane.offset_m))
        return fail("the plane has no direction", "Give it a normal that is not zero and finite numbers");
    plane = {(1 / norm) * plane.normal, plane.offset_m / norm};
    return Bounds{};
}

double norm_of(Quat q) { return std::sqrt(q.w * q.w + q.x * q.x + q.y * q.y + q.z * q.z); }

Result<Bounds> check(Box& box) {
    const Quat q = box.orientation;
    const double norm = norm_of(q);
    if (!is_finite(box.centre) || !is_finite(box.size_m) || !(norm > 0) || !std::isfinite(norm))
        return fail("the box has a number that is not finite, or no orientation");
    if (!(box.size_m.x > 0 && box.size_m.y > 0 && box.size_m.z > 0))
        return fail(fmt::format("the box is {} x {} x {} m, which is no box", box.size_m.x, box.size_m.y, box.size_m.z),
                    "Give it three positive sizes");
    box.orientation = {q.w / norm, q.x / norm, q.y / norm, q.z / norm};
    const double half_diagonal = length(box.size_m) / 2;
    const Vec3 around{half_diagonal, half_diagonal, half_diagonal};
    return Bounds{box.centre - around, box.centre + around};
}

Result<Bounds> check(Solid& solid) {
    const Quat q = solid.orientation;
    const double norm = norm_of(q);
    if (!is_finite(solid.centre) || !(norm > 0) || !std::isfinite(norm))
        return fail("an obstacle has a centre that is not finite, or no orientation");
    if (auto fine = physics::check(solid.shape); !fine) return tl::unexpected(fine.error());
    solid.orientation = {q.w / norm, q.x / norm, q.y / norm, q.z / norm};
    const double radius = solid.shape.radius_m();
    const Vec3 around{radius, radius, radius};
    return Bounds{solid.centre - around, solid.centre + around};
}

Result<Bounds> check(Terrain& terrain) {
    if (terrain.columns < 2 || terrain.rows < 2 || !(terrain.cell_m > 0) || !std::isfinite(terrain.cell_m) || !is_finite(terrain.origin))
        return fail("the terrain has no cell", "Give it at least 2 x 2 heights and a positive cell");
    const auto points = static_cast<std::size_t>(terrain.columns) * static_cast<std::size_t>(terrain.rows);
    if (terrain.heights_m.size() != points)
        return fail(fmt::format("the terrain has {} heights, not {} x {}", terrain.heights_m.size(), terrain.columns, terrain.rows));
    for (const double height : terrain.heights_m)
        if (!std::isfinite(height)) return fail("the terrain has a height that is not a number");
    const double highest = *std::max_element(terrain.heights_m.begin(), terrain.heights_m.end());
    const Vec3 size{(terrain.columns - 1) * terrain.cell_m, (terrain.rows - 1) * terrain.cell_m, highest};
    // A body that has sunk into the ground is in it, at any depth.
    return Bounds{{terrain.origin.x, terrain.origin.y, -HUGE_VAL}, terrain.origin + size};
}

Result<Bounds> check(Mesh& mesh) {
    if (mesh.triangles.empty() || mesh.triangles.size() % 3 != 0) return fail("the mesh has no triangles, or a part of one");
    Bounds bounds{{HUGE_VAL, HUGE_VAL, HUGE_VAL}, {-HUGE_VAL, -HUGE_VAL, -HUGE_VAL}};
    for (const Vec3 p : mesh.points) {
        if (!is_finite(p)) return fail("the mesh has a point that is not a number");
        bounds.low = {std::min(bounds.low.x, p.x), std::min(bounds.low.y, p.y), std::min(bounds.low.z, p.z)};
        bounds.high = {std::max(bounds.high.x, p.x), std::max(bounds.high.y, p.y), std::max(bounds.high.z, p.z)};
    }
    for (const std::uint32_t index : mesh.triangles)
        if (index >= mesh.points.size()) return fail(fmt::format("a triangle of the mesh names point {} of {}", index, mesh.points.size()));
    return bounds;
}

}  // namespace

// One worker's geometries, and the sphere that is moved about. Only those of boxes are used.
struct Obstacles::Geometries {
    OdeShapes shapes;
    dGeomID sphere = dCreateSphere(nullptr, 1);

    Geometries() = default;
    Geometries(const Geometries&) = delete;
    Geometries& operator=(const Geometries&) = delete;
    ~Geometries() { dGeomDestroy(sphere); }
};

Obstacles::Obstacles() = default;
Obstacles::~Obstacles() = default;
Obstacles::Obstacles(Obstacles&&) noexcept = default;
Obstacles& Obstacles::operator=(Obstacles&&) noexcept = default;

Result<std::uint32_t> Obstacles::add(Shape shape, std::uint8_t material) {
    auto bounds = std::visit([](auto& one) { return check(one); }, shape);
    if (!bounds) return tl::unexpected(bounds.error());
    Entry& entry = entries_.emplace_back(std::move(shape), material, bounds->low, bounds->high);
    entry.parts = parts_of(entry.shape);
    if (const Mesh* mesh = std::get_if<Mesh>(&entry.shape)) entry.surface.emplace(*mesh);
    return static_cast<std::uint32_t>(entries_.size() - 1);
}

void Obstacles::set_belt(std::size_t obstacle, Vec3 belt_m_s) {
    MELD_EXPECT(obstacle < count() && entries_[obstacle].belt == 0, "obstacle {} of {}", obstacle, count());
    belts_.push_back(belt_m_s);
    entries_[obstacle].belt = belts_.size();
}

std::vector<Obstacles::Entry::Part> Obstacles::parts_of(const Shape& shape) {
    std::vector<Entry::Part> parts;
    const auto add = [&](const BodyShape& own, Vec3 centre, Quat turn) {
        parts.push_back({own, centre, turn, {{own.core_m, own.rounding_m}, pose_of(centre, turn)}});
    };
    if (const Box* box = std::get_if<Box>(&shape)) add({0.5 * box->size_m, 0}, box->centre, box->orientation);
    const Solid* solid = std::get_if<Solid>(&shape);
    if (solid == nullptr) return parts;
    if (!solid->shape.is_compound()) add(solid->shape, solid->centre, solid->orientation);
    for (const ShapePart& part : solid->shape.parts)
        add(physics::solid_of(part), solid->centre + rotate(solid->orientation, part.at_m), product(solid->orientation, part.turn));
    return parts;
}

int Obstacles::parts(std::size_t obstacle) const { return is_surface(obstacle) || solids(obstacle) > 1 ? kMaxSurfaceContacts : 1; }

namespace {

// Whether a point may be nearer than `reach_m` to a solid that is no compound.
bool reaches(const BodyShape& solid, Vec3 place, Quat turn, Vec3 at, double reach_m) {
    const double reach = reach_m + solid.rounding_m;
    const Vec3 outside = solid.from_core(rotate(conjugate(turn), at - place));
    return dot(outside, outside) < reach * reach;
}

}  // namespace

bool Obstacles::may_reach_own(const Entry& entry, Vec3 centre, double radius_m, double reach_m) {
    const double reach = radius_m + reach_m;
    if (const Plane* plane = std::get_if<Plane>(&entry.shape)) return dot(plane->normal, centre) - plane->offset_m < reach;
    const auto apart = [](double low, double high, double at) { return std::max({low - at, at - high, 0.0}); };
    if (apart(entry.low.x, entry.high.x, centre.x) > reach || apart(entry.low.y, entry.high.y, centre.y) > reach ||
        apart(entry.low.z, entry.high.z, centre.z) > reach)
        return false;
    if (const Box* box = std::get_if<Box>(&entry.shape)) {
        const Vec3 local = rotate(conjugate(box->orientation), centre - box->centre);
        const Vec3 outside{apart(-box->size_m.x / 2, box->size_m.x / 2, local.x), apart(-box->size_m.y / 2, box->size_m.y / 2, local.y),
                           apart(-box->size_m.z / 2, box->size_m.z / 2, local.z)};
        return dot(outside, outside) < reach * reach;
    }
    if (!std::holds_alternative<Solid>(entry.shape)) return true;
    return std::ranges::any_of(entry.parts,
                               [&](const Entry::Part& part) { return reaches(part.shape, part.centre, part.turn, centre, reach); });
}

bool Obstacles::solid_may_reach_own(const Entry& entry, std::size_t solid, Vec3 centre, double radius_m, double reach_m) {
    if (entry.parts.size() <= 1) return may_reach_own(entry, centre, radius_m, reach_m);
    const Entry::Part& part = entry.parts[solid];
    return reaches(part.shape, part.centre, part.turn, centre, radius_m + reach_m);
}

namespace {

double depth_in(const Plane& plane, Vec3 centre, double radius_m) { return radius_m + plane.offset_m - dot(plane.normal, centre); }

double depth_in(const Box& box, Vec3 centre, double radius_m) {
    const Vec3 local = rotate(conjugate(box.orientation), centre - box.centre), outside = BodyShape{0.5 * box.size_m, 0}.from_core(local);
    if (outside != Vec3{}) return radius_m - length(outside);
    return radius_m +
           std::min({box.size_m.x / 2 - std::abs(local.x), box.size_m.y / 2 - std::abs(local.y), box.size_m.z / 2 - std::abs(local.z)});
}

double depth_in(const Terrain& terrain, Vec3 centre, double radius_m) { return radius_m - distance_to(terrain, centre, radius_m); }

double depth_in(const Mesh&, Vec3, double) { return 0; }

std::optional<SurfaceContact> meeting(const Plane& plane, Vec3 centre, double radius_m, Vec3 path) {
    const double gap = -depth_in(plane, centre, radius_m);
    if (gap < 0 || gap + dot(plane.normal, path) > 0) return std::nullopt;
    return SurfaceContact{plane.normal, gap};
}

// Where a sphere on its path meets a solid that is no compound. Advances by the distance to it repeatedly, which never leads into it
// (conservative advancement).
std::optional<SurfaceContact> meeting(const BodyShape& solid, Vec3 place, Quat turn, Vec3 centre, double radius_m, Vec3 path) {
    constexpr int kMaxSteps = 64;
    // A path that comes this near, as a share of the radius, touches.
    constexpr double kNear = 1e-4;
    const Quat into = conjugate(turn);
    const Vec3 start = rotate(into, centre - place), way = rotate(into, path);
    const double far = length(way);
    double gone = 0;
    for (int i = 0; i < kMaxSteps; ++i) {
        const Vec3 outside = solid.from_core(start + (gone / far) * way);
        const double distance = length(outside), gap = distance - solid.rounding_m - radius_m;
        if (gap > kNear * radius_m) {
            gone += gap;
            if (gone > far) return std::nullopt;
            continue;
        }
        if (i == 0) return std::nullopt;
        const Vec3 normal = (1 / distance) * outside;
        return SurfaceContact{rotate(turn, normal), gap - gone / far * dot(normal, way)};
    }
    return std::nullopt;
}

std::optional<double> met_by(const Plane& plane, const Ray& ray) {
    const double above = dot(plane.normal, ray.from) - plane.offset_m, along = dot(plane.normal, ray.way);
    if (above <= 0) return 0;
    return above + along <= 0 ? std::optional(std::min(1.0, above / -along)) : std::nullopt;
}

std::optional<double> met_by(const Box& box, const Ray& ray) {
    const Quat into = conjugate(box.orientation);
    const Vec3 half = 0.5 * box.size_m;
    const auto inside = part_within({rotate(into, ray.from - box.centre), rotate(into, ray.way)}, -half, half);
    return inside ? std::optional(inside->enter) : std::nullopt;
}

std::optional<SurfaceContact> meeting(const Terrain& terrain, Vec3 centre, double radius_m, Vec3 path) {
    return physics::meet(terrain, centre, radius_m, path);
}

}  // namespace

std::string_view Obstacles::kind(std::size_t obstacle) const {
    constexpr std::string_view kKinds[] = {"plane", "box", "terrain", "mesh"};
    const Shape& shape = entries_[obstacle].shape;
    const Solid* solid = std::get_if<Solid>(&shape);
    if (solid == nullptr) return kKinds[shape.index()];
    const BodyShape& form = solid->shape;
    return form.is_compound()   ? "compound"
           : form.is_sphere()   ? "sphere"
           : form.is_cylinder() ? "cylinder"
           : form.core_m.y > 0  ? "box"
                                : "capsule";
}

double Obstacles::depth_own(const Entry& entry, Vec3 centre, double radius_m) {
    return std::max(0.0, std::visit(
                             [&](const auto& shape) -> double {
                                 if constexpr (!std::is_same_v<decltype(shape), const Solid&>) return depth_in(shape, centre, radius_m);
                                 std::array<SurfaceContact, kMaxSurfaceContacts> contacts;
                                 return collide_sphere(entry, centre, radius_m, 0, contacts) == 0 ? 0 : -contacts[0].gap_m;
                             },
                             entry.shape));
}

// The contacts with solids, the deepest first.
int Obstacles::collide_sphere(const Entry& entry, Vec3 centre, double radius_m, double reach_m,
                              std::array<SurfaceContact, kMaxSurfaceContacts>& contacts) {
    const Core sphere{{}, radius_m};
    const Pose pose = pose_of(centre, {});
    int count = 0;
    for (const Entry::Part& part : entry.parts) {
        Manifold found;
        AxisHint hint = kNoAxis;
        physics::collide(sphere, pose, part.placed.core, part.placed.pose, reach_m, hint, found);
        if (found.count == 0 || !(found.points[0].gap_m < reach_m)) continue;
        const SurfaceContact contact{-found.normal, found.points[0].gap_m};
        int at = std::min(count, kMaxSurfaceContacts - 1);
        if (count == kMaxSurfaceContacts && !(contact.gap_m < contacts[static_cast<std::size_t>(at)].gap_m)) continue;
        for (; at > 0 && contact.gap_m < contacts[static_cast<std::size_t>(at - 1)].gap_m; --at)
            contacts[static_cast<std::size_t>(at)] = contacts[static_cast<std::size_t>(at - 1)];
        contacts[static_cast<std::size_t>(at)] = contact;
        count = std::min(count + 1, kMaxSurfaceContacts);
    }
    return count;
}

// Of the solids that the sphere does not touch, the one that it meets first.
std::optional<SurfaceContact> Obstacles::meet_solids(const Entry& entry, Vec3 centre, double radius_m, Vec3 path) {
    std::optional<SurfaceContact> first;
    double least = 0;
    for (const Entry::Part& part : entry.parts) {
        const auto met = meeting(part.shape, part.centre, part.turn, centre, radius_m, path);
        if (!met) continue;
        const double gone = met->gap_m / -dot(met->normal, path);
        if (!first || gone < least) first = met, least = gone;
    }
    return first;
}

void Obstacles::collide_solid_own(const Entry& entry, std::size_t solid, const Core& core, const Pose& pose, double reach_m, AxisHint& hint,
                                  Manifold& found) {
    if (const Plane* plane = std::get_if<Plane>(&entry.shape))
        return collide_with_plane(core, pose, plane->normal, plane->offset_m, reach_m, hint, found);
    MELD_CHECK(solid < entry.parts.size(), "solid {} of {}", solid, entry.parts.size());
    const PlacedSolid& other = entry.parts[solid].placed;
    physics::collide(core, pose, other.core, other.pose, reach_m, hint, found);
}

std::optional<SurfaceContact> Obstacles::meet_own(const Entry& entry, Vec3 centre, double radius_m, Vec3 path,
                                                  std::span<const SurfaceContact> touched) {
    return std::visit(
        [&](const auto& shape) -> std::optional<SurfaceContact> {
            if constexpr (std::is_same_v<decltype(shape), const Mesh&>)
                return entry.surface->meet(shape, centre, radius_m, path, touched);
            else if constexpr (std::is_same_v<decltype(shape), const Box&> || std::is_same_v<decltype(shape), const Solid&>)
                return meet_solids(entry, centre, radius_m, path);
            else
                return meeting(shape, centre, radius_m, path);
        },
        entry.shape);
}

int Obstacles::collide_shape_own(const Entry& entry, const Core& core, const Pose& pose, double reach_m, AxisHint& hint,
                                 std::array<Manifold, kMaxSurfaceContacts>& found) {
    thread_local std::vector<Triangle> triangles;
    triangles.clear();
    const Vec3 reach{reach_m, reach_m, reach_m};
    const Around box = around(core, pose);
    if (const Terrain* terrain = std::get_if<Terrain>(&entry.shape)) {
        triangles_at(*terrain, box.low - reach, box.high + reach, triangles);
        return collide_with_surface(core, pose, triangles, SurfaceSide::Outer, reach_m, hint, found);
    }
    const Mesh* mesh = std::get_if<Mesh>(&entry.shape);
    MELD_EXPECT(mesh != nullptr, "an obstacle has no triangles");
    entry.surface->triangles_at(*mesh, box.low - reach, box.high + reach, triangles);
    return collide_with_surface(core, pose, triangles, SurfaceSide::Both, reach_m, hint, found);
}

std::optional<double> Obstacles::first_on_own(const Entry& entry, const Ray& ray) {
    if (const Plane* plane = std::get_if<Plane>(&entry.shape)) return met_by(*plane, ray);
    if (!part_within(ray, entry.low, entry.high)) return std::nullopt;
    if (const Box* box = std::get_if<Box>(&entry.shape)) return met_by(*box, ray);
    if (const Terrain* terrain = std::get_if<Terrain>(&entry.shape)) return physics::first_on(*terrain, ray);
    if (const Solid* solid = std::get_if<Solid>(&entry.shape))
        return physics::first_on(solid->shape, solid->centre, solid->orientation, ray);
    return entry.surface->first_on(std::get<Mesh>(entry.shape), ray);
}

void Obstacles::prepare(int threads) {
    const auto by_ode = [](const Entry& entry) { return std::holds_alternative<Box>(entry.shape); };
    if (std::none_of(entries_.begin(), entries_.end(), by_ode)) return;
    enter_ode_thread();
    while (geometries_.size() < static_cast<std::size_t>(threads)) geometries_.push_back(std::make_unique<Geometries>());
    for (const auto& own : geometries_)
        while (own->shapes.count() < entries_.size()) {
            const Entry& entry = entries_[own->shapes.count()];
            own->shapes.add(by_ode(entry) ? entry.shape : Shape(Plane{}));
        }
}

int Obstacles::collide_own(int worker, std::size_t obstacle, Vec3 centre, double radius_m, double reach_m,
                           std::array<SurfaceContact, kMaxSurfaceContacts>& contacts) {
    MELD_EXPECT(obstacle < entries_.size() && radius_m > 0 && reach_m >= 0, "obstacle {} of {}", obstacle, entries_.size());
    if (const Plane* plane = std::get_if<Plane>(&entries_[obstacle].shape)) {
        contacts[0] = {plane->normal, dot(plane->normal, centre) - plane->offset_m - radius_m};
        return contacts[0].gap_m < reach_m ? 1 : 0;
    }
    if (const Terrain* terrain = std::get_if<Terrain>(&entries_[obstacle].shape))
        return physics::collide(*terrain, centre, radius_m, reach_m, contacts);
    if (const Mesh* mesh = std::get_if<Mesh>(&entries_[obstacle].shape))
        return entries_[obstacle].surface->collide(*mesh, centre, radius_m, reach_m, contacts);
    if (std::holds_alternative<Solid>(entries_[obstacle].shape))
        return collide_sphere(entries_[obstacle], centre, radius_m, reach_m, contacts);
    MELD_EXPECT(static_cast<std::size_t>(worker) < geometries_.size(), "worker {} of {}: call prepare first", worker, geometries_.size());
    enter_ode_thread();
    const Geometries& own = *geometries_[static_cast<std::size_t>(worker)];
    // ODE reports overlaps only, so the sphere is enlarged by the distance to look ahead.
    dGeomSphereSetRadius(own.sphere, radius_m + reach_m);
    dGeomSetPosition(own.sphere, centre.x, centre.y, centre.z);
    std::array<dContactGeom, kMaxSurfaceContacts> found;
    const int count = dCollide(own.sphere, own.shapes[obstacle], kMaxSurfaceContacts, found.data(), sizeof(dContactGeom));
    for (int i = 0; i < count; ++i) {
        const dContactGeom& contact = found[static_cast<std::size_t>(i)];
        contacts[static_cast<std::size_t>(i)] = {{contact.normal[0], contact.normal[1], contact.normal[2]}, reach_m - contact.depth};
    }
    return count;
}

}  // namespace meld::physics
