#include "physics/collision/surface_contacts.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <vector>

#include "physics/collision/core_geometry.h"
#include "physics/collision/nearest_cores.h"

namespace meld::physics {

namespace {

// Normals that differ by less than this angle, as its cosine, are those of one manifold.
constexpr double kOneDirection = 0.995;
// Shares of the body's size: points nearer to each other are one; a point this much beside a triangle is over it; and by how much a corner
// may lead on towards the body where the surface ends there all the same.
constexpr double kOnePlace = 1e-6, kBeside = 1e-9, kLeadsOn = 1e-4;
// Share of the body's size: of points with one direction that are this near to each other, the deepest is enough.
constexpr double kNearPlace = 0.02;
// Shares of half the least thickness: what has sunk in deeper along a triangle's normal may have come from elsewhere; the normal at an edge
// is found with a core whose faces are this much farther inside; and a point that is deeper by this replaces another one.
constexpr double kSunk = 0.02, kCoreShrunk = 0.1, kDeeperBy = 1e-3;
// Share of half the least thickness: points of one direction that are this much higher than the deepest may carry, too.
constexpr double kMayCarry = 0.01;
// A point that has sunk in by less than this share along another triangle's normal has come from there.
constexpr double kShallower = 0.5;
// As a cosine: the way to what has sunk in may differ so much from the normal.
constexpr double kRoughlyAlong = 0.3;
// Lines that lie along an edge.
constexpr double kAlongEdge = 0.9985;
// So many corners stand for a cap.
constexpr int kCapCorners = 16, kMaxRing = kCapCorners + 6;

// A ring of corners, or the two ends of a line, from the body's middle.
struct Outline {
    std::array<Vec3, kMaxRing> corners;
    int count = 0;
    void push(Vec3 corner) {
        if (count < kMaxRing) corners[static_cast<std::size_t>(count++)] = corner;
    }
    std::span<const Vec3> all() const { return std::span(corners).first(static_cast<std::size_t>(count)); }
};

// Cuts off what lies beyond a plane.
void cut(Outline& outline, Vec3 normal, double offset) {
    Outline kept;
    const bool line = outline.count == 2;
    for (int i = 0; i < outline.count; ++i) {
        const Vec3 here = outline.corners[static_cast<std::size_t>(i)],
                   next = outline.corners[static_cast<std::size_t>((i + 1) % outline.count)];
        const double from = dot(normal, here) - offset, to = dot(normal, next) - offset;
        if (from <= 0) kept.push(here);
        if ((line && i == 1) || !((from < 0 && to > 0) || (from > 0 && to < 0))) continue;
        kept.push(here + (from / (from - to)) * (next - here));
    }
    outline = kept;
}

// A triangle from the body's middle, its normal on the side where the body is, and the number of its plane.
struct Facing {
    std::array<Vec3, 3> corners;
    Vec3 normal;
    double offset = 0;
    std::size_t plane = 0;

    // The normal, in the triangle's plane, out of the edge from a corner to the next.
    Vec3 out_of_edge(std::size_t i) const {
        const Vec3 along = corners[(i + 1) % 3] - corners[i], out = cross(along, normal);
        return dot(out, corners[(i + 2) % 3] - corners[i]) > 0 ? -out : out;
    }
    bool is_under(Vec3 point, double beside) const {
        for (std::size_t i = 0; i < 3; ++i) {
            const Vec3 out = out_of_edge(i);
            if (dot(out, point - corners[i]) > beside * length(out)) return false;
        }
        return true;
    }
};

// The points that a body has over a plane, and which of them are over a triangle of it.
struct PlanePoints {
    Vec3 normal;
    double offset = 0;
    Manifold points;
    AxisHint hint = kNoAxis;
    std::array<bool, kMaxManifoldPoints> held{};
    // All points are held, so what else is in this plane does not matter.
    bool complete() const {
        return points.count > 0 && std::all_of(held.begin(), held.begin() + points.count, [](bool is) { return is; });
    }
};

struct Candidate {
    Vec3 at, normal;
    double gap;
    // Of a plane that is complete, its number and one; otherwise 0.
    std::size_t plane;
    // There was no room for it among the points of its direction.
    bool left_over = false;
};

// From a triangle to the core of a body: the way, of length 1, and the point where it begins. Not there: it is too far.
struct Way {
    Vec3 from, out;
    bool overlaps = false, there = false;
};

// What is kept of a body for as long as its points are searched for, in memory that is there already.
struct Scratch {
    std::vector<Facing> facing;
    std::vector<PlanePoints> planes;
    std::vector<Candidate> candidates, group, rest, order;
};

class SurfaceContacts {
  public:
    SurfaceContacts(const Core& core, const Pose& pose, SurfaceSide side, double reach, Scratch& scratch)
        : core_(core),
          pose_{{}, pose.axes},
          world_(pose.centre),
          side_(side),
          reach_(reach),
          scratch_(scratch),
          facing_(scratch.facing),
          planes_(scratch.planes),
          candidates_(scratch.candidates) {
        facing_.clear(), planes_.clear(), candidates_.clear();
        placed_ = {kind_of(core), core.half_m, {}, &pose_.axes};
        least_ = core.radius_m + (kind_of(core) == CoreKind::Box        ? std::min({core.half_m.x, core.half_m.y, core.half_m.z})
                                  : kind_of(core) == CoreKind::Cylinder ? std::min(core.half_m.x, core.half_m.z)
                                                                        : 0);
        size_ = length(core.half_m) + core.radius_m;
        // What is rounded needs not be shrunk to have a normal at its edges.
        shrunk_by_ = kind_of(core) >= CoreKind::Cylinder ? std::max(0.0, kCoreShrunk * least_ - core.radius_m) : 0;
        shrunk_ = placed_.shrunk(shrunk_by_);
    }

    void add(const Triangle& triangle, AxisHint hint);
    void find_points();
    int take(AxisHint& hint, std::array<Manifold, kMaxSurfaceContacts>& found);

  private:
    double lowest(Vec3 normal) const { return dot(normal, placed_.support(-normal)) - core_.radius_m; }
    std::size_t plane_of(Vec3 normal, double offset, AxisHint hint);
    bool lies_flat_on(Vec3 out) const;
    // What of the body, if it lies flat across a direction that leads to it, is nearest there.
    Outline outline_towards(Vec3 out) const;
    PlacedCore placed(const Facing& facing, std::array<Vec3, 3>& corners) const;
    // To the shrunk core.
    Way way_from(const Facing& facing) const;
    bool leads_on(const Way& way) const;
    // Of a mesh, which may end anywhere: whether a body that is behind a triangle passes by its edges.
    bool passes_by(const Facing& facing, double gap) const;
    // Whether a point of the body's surface that is behind a triangle is less deep behind another one.
    bool is_of_another(Vec3 point, double gap, std::size_t plane) const;
    bool add_face(const Facing& facing);
    void add_edge(const Facing& facing, const Way& way);
    void add_point(Vec3 at, Vec3 normal, double gap, std::size_t plane = 0);
    void choose(std::vector<Candidate>& group, Manifold& found, std::vector<Candidate>& rest) const;

    const Core& core_;
    const Pose pose_;
    const Vec3 world_;
    const SurfaceSide side_;
    const double reach_;
    double least_ = 0, size_ = 0, shrunk_by_ = 0;
    PlacedCore placed_, shrunk_;
    Scratch& scratch_;
    std::vector<Facing>& facing_;
    std::vector<PlanePoints>& planes_;
    std::vector<Candidate>& candidates_;
};

void SurfaceContacts::add(const Triangle& triangle, AxisHint hint) {
    const std::optional<Vec3> normal = normal_of(triangle);
    if (!normal) return;
    Facing facing{{triangle.a - world_, triangle.b - world_, triangle.c - world_}, *normal};
    facing.offset = dot(*normal, facing.corners[0]);
    if (side_ == SurfaceSide::Both && facing.offset > 0) facing.normal = -facing.normal, facing.offset = -facing.offset;
    if (lowest(facing.normal) - facing.offset > reach_) return;
    facing.plane = plane_of(facing.normal, facing.offset, hint);
    facing_.push_back(facing);
}

std::size_t SurfaceContacts::plane_of(Vec3 normal, double offset, AxisHint hint) {
    constexpr double kSameWay = 1e-9, kSameHeight = 1e-8;
    for (std::size_t i = 0; i < planes_.size(); ++i) {
        const Vec3 apart = planes_[i].normal - normal;
        if (dot(apart, apart) < kSameWay * kSameWay && std::abs(planes_[i].offset - offset) < kSameHeight * size_) return i;
    }
    PlanePoints& plane = planes_.emplace_back();
    plane.normal = normal, plane.offset = offset, plane.hint = hint;
    collide_with_plane(core_, pose_, normal, offset, reach_, plane.hint, plane.points);
    return planes_.size() - 1;
}

bool SurfaceContacts::lies_flat_on(Vec3 out) const {
    const double along = std::abs(dot(out, pose_.axes[2]));
    if (placed_.kind == CoreKind::Line) return along < kSlant;
    if (placed_.kind == CoreKind::Cylinder) return along < kSlant || along > kFlat;
    return along > kFlat || std::abs(dot(out, pose_.axes[0])) > kFlat || std::abs(dot(out, pose_.axes[1])) > kFlat;
}

Outline SurfaceContacts::outline_towards(Vec3 out) const {
    Outline outline;
    const Vec3& half = core_.half_m;
    const auto& [x, y, z] = pose_.axes;
    const double along = dot(out, z);
    if (placed_.kind == CoreKind::Box) {
        const Vec3 edges[3] = {half.x * x, half.y * y, half.z * z};
        std::size_t most = 0;
        for (std::size_t i = 1; i < 3; ++i)
            if (std::abs(dot(out, pose_.axes[i])) > std::abs(dot(out, pose_.axes[most]))) most = i;
        const Vec3 face = dot(out, edges[most]) > 0 ? -edges[most] : edges[most], p = edges[(most + 1) % 3], q = edges[(most + 2) % 3];
        outline.push(face + p + q), outline.push(face - p + q), outline.push(face - p - q), outline.push(face + p - q);
        return outline;
    }
    if (placed_.kind == CoreKind::Cylinder && std::abs(along) > kFlat) {
        const Vec3 face = (along > 0 ? -half.z : half.z) * z;
        for (int i = 0; i < kCapCorners; ++i) {
            const double angle = 2 * M_PI / kCapCorners * i;
            outline.push(face + (half.x * std::cos(angle)) * x + (half.x * std::sin(angle)) * y);
        }
        return outline;
    }
    Vec3 side;
    if (placed_.kind == CoreKind::Cylinder) {
        const Vec3 across = out - along * z;
        side = (-half.x / length(across)) * across;
    }
    outline.push(side + half.z * z), outline.push(side - half.z * z);
    return outline;
}

PlacedCore SurfaceContacts::placed(const Facing& facing, std::array<Vec3, 3>& corners) const {
    const Vec3 middle = (1.0 / 3) * (facing.corners[0] + facing.corners[1] + facing.corners[2]);
    for (std::size_t i = 0; i < 3; ++i) corners[i] = facing.corners[i] - middle;
    return {CoreKind::Triangle, {}, middle, &corners};
}

Way SurfaceContacts::way_from(const Facing& facing) const {
    std::array<Vec3, 3> corners;
    const PlacedCore triangle = placed(facing, corners);
    LineEnds ends;
    switch (nearest_of_cores(shrunk_, triangle, reach_ + core_.radius_m + shrunk_by_, ends)) {
        case Nearness::Far:
            return {};
        case Nearness::Overlapping: {
            const Vec3 out = -least_overlap(placed_, triangle, -facing.normal);
            return {triangle.support(out), out, true, true};
        }
        case Nearness::Apart:
            break;
    }
    const Vec3 way = ends.p - ends.q;
    return {ends.q, (1 / length(way)) * way, false, true};
}

// Whether the surface goes on from where a way begins, towards where it leads.
bool SurfaceContacts::leads_on(const Way& way) const {
    for (const Facing& facing : facing_) {
        const auto leads = [&](Vec3 corner) {
            const Vec3 along = corner - way.from;
            return dot(way.out, along) > kLeadsOn * std::max(size_, length(along));
        };
        if (std::ranges::none_of(facing.corners, leads)) continue;
        const Vec3 apart = nearest_point({facing.corners[0], facing.corners[1], facing.corners[2]}, way.from) - way.from;
        if (dot(apart, apart) < kOnePlace * kOnePlace * size_ * size_) return true;
    }
    return false;
}

bool SurfaceContacts::passes_by(const Facing& facing, double gap) const {
    if (side_ == SurfaceSide::Outer || gap > -kSunk * least_) return false;
    const Way way = way_from(facing);
    return !way.there || (!way.overlaps && dot(way.out, facing.normal) < kRoughlyAlong);
}

bool SurfaceContacts::is_of_another(Vec3 point, double gap, std::size_t plane) const {
    if (gap > -kSunk * least_) return false;
    return std::ranges::any_of(facing_, [&](const Facing& other) {
        if (other.plane == plane) return false;
        const double depth = other.offset - dot(other.normal, point);
        return depth > -kBeside * size_ && depth < -kShallower * gap && other.is_under(point, kBeside * size_);
    });
}

void SurfaceContacts::add_point(Vec3 at, Vec3 normal, double gap, std::size_t plane) {
    if (gap > reach_) return;
    for (Candidate& other : candidates_) {
        const Vec3 apart = other.at - at;
        const double away = dot(apart, apart);
        if (away > kNearPlace * kNearPlace * size_ * size_ || dot(other.normal, normal) < kOneDirection) continue;
        const bool same = away <= kOnePlace * kOnePlace * size_ * size_;
        if (!same && plane != 0) continue;
        if (same && plane != 0 && other.plane == 0) other.plane = plane;
        if (!same && other.plane == 0 && gap < other.gap) other.at = at, other.normal = normal, other.gap = gap;
        if (same || other.plane == 0 || gap >= other.gap) return;
    }
    candidates_.push_back({at, normal, gap, plane});
}

// What of the body is over a triangle, if there is something.
bool SurfaceContacts::add_face(const Facing& facing) {
    if (passes_by(facing, lowest(facing.normal) - facing.offset)) return false;
    const auto add = [&](Vec3 corner) {
        const double gap = dot(facing.normal, corner) - facing.offset - core_.radius_m;
        const Vec3 surface = corner - core_.radius_m * facing.normal;
        if (is_of_another(surface, gap, facing.plane)) return false;
        add_point(surface - (0.5 * gap) * facing.normal, facing.normal, gap);
        return true;
    };
    if (!lies_flat_on(facing.normal)) {
        const Vec3 corner = placed_.support(-facing.normal);
        return facing.is_under(corner, kBeside * size_) && add(corner);
    }
    Outline over = outline_towards(facing.normal);
    for (std::size_t i = 0; i < 3 && over.count > 0; ++i) {
        const Vec3 out = facing.out_of_edge(i);
        cut(over, out, dot(out, facing.corners[i]));
    }
    bool any = false;
    for (const Vec3 corner : over.all()) any = add(corner) || any;
    return any;
}

// An edge or a corner of the surface. A face of the body that lies on it has several points there.
void SurfaceContacts::add_edge(const Facing& facing, const Way& way) {
    if (leads_on(way)) return;
    const bool flat = lies_flat_on(way.out);
    if (flat) {
        const Outline under = outline_towards(way.out);
        if (under.count == 2) {
            const Vec3 line = under.corners[1] - under.corners[0], along = (1 / length(line)) * line;
            const Vec3 across = way.out - dot(way.out, along) * along, out = (1 / length(across)) * across;
            for (std::size_t i = 0; i < 3; ++i) {
                const Vec3 p = facing.corners[i], q = facing.corners[(i + 1) % 3];
                if (std::abs(dot(q - p, along)) < kAlongEdge * length(q - p)) continue;
                Outline edge;
                edge.push(p), edge.push(q);
                cut(edge, along, dot(along, under.corners[1]));
                cut(edge, -along, -dot(along, under.corners[0]));
                for (const Vec3 corner : edge.all()) {
                    const double gap = dot(out, under.corners[0] - corner) - core_.radius_m;
                    // Another edge of the triangle is elsewhere.
                    const Vec3 beside = corner - way.from, off = beside - dot(beside, along) * along;
                    if (dot(off, off) < kOnePlace * size_ * size_) add_point(corner + (0.5 * gap) * out, out, gap);
                }
                if (edge.count > 0) return;
            }
        } else {
            const Vec3 face = cross(under.corners[1] - under.corners[0], under.corners[2] - under.corners[1]);
            const Vec3 out = (dot(face, way.out) < 0 ? -1 / length(face) : 1 / length(face)) * face;
            Outline over;
            for (const Vec3 corner : facing.corners) over.push(corner);
            Vec3 middle;
            for (const Vec3 corner : under.all()) middle = middle + (1.0 / under.count) * corner;
            for (int i = 0; i < under.count && over.count > 0; ++i) {
                const Vec3 from = under.corners[static_cast<std::size_t>(i)],
                           to = under.corners[static_cast<std::size_t>((i + 1) % under.count)];
                Vec3 beyond = cross(to - from, out);
                if (dot(beyond, middle - from) > 0) beyond = -beyond;
                cut(over, beyond, dot(beyond, from));
            }
            for (const Vec3 corner : over.all()) {
                const double gap = dot(out, under.corners[0] - corner) - core_.radius_m;
                add_point(corner + (0.5 * gap) * out, out, gap);
            }
            if (over.count > 0) return;
        }
    }
    const double gap = lowest(way.out) - dot(way.out, way.from);
    add_point(way.from + (0.5 * gap) * way.out, way.out, gap);
}

void SurfaceContacts::find_points() {
    for (const Facing& facing : facing_) {
        PlanePoints& plane = planes_[facing.plane];
        if (passes_by(facing, lowest(facing.normal) - facing.offset)) continue;
        for (std::size_t p = 0; p < static_cast<std::size_t>(plane.points.count); ++p) {
            const auto& [at, gap] = plane.points.points[p];
            plane.held[p] = plane.held[p] ||
                            (facing.is_under(at, kBeside * size_) && !is_of_another(at + (0.5 * gap) * facing.normal, gap, facing.plane));
        }
    }
    for (std::size_t n = 0; n < planes_.size(); ++n) {
        const PlanePoints& plane = planes_[n];
        for (std::size_t p = 0; p < static_cast<std::size_t>(plane.points.count); ++p)
            if (plane.held[p])
                add_point(plane.points.points[p].at, plane.normal, plane.points.points[p].gap_m, plane.complete() ? n + 1 : 0);
    }
    for (const Facing& facing : facing_) {
        if (planes_[facing.plane].complete() || add_face(facing)) continue;
        const Way way = way_from(facing);
        if (!way.there || (side_ == SurfaceSide::Outer && dot(way.out, facing.normal) < -kSlant)) continue;
        add_edge(facing, way);
    }
}

// Up to four of the points of a group: those of a plane on which the body stands, otherwise those that may carry and lie outermost. What
// may carry as well goes to `rest`.
void SurfaceContacts::choose(std::vector<Candidate>& group, Manifold& found, std::vector<Candidate>& rest) const {
    const double deepest = std::ranges::min_element(group, {}, &Candidate::gap)->gap;
    double held = kNever;
    std::size_t plane = 0;
    for (const Candidate& one : group)
        if (one.plane != 0 && one.gap < held) held = one.gap, plane = one.plane;
    std::vector<Candidate>& order = scratch_.order;
    order.assign(group.begin(), group.end());
    if (plane != 0 && deepest >= held - kDeeperBy * least_) {
        found.on_rim = planes_[plane - 1].points.on_rim;
        std::ranges::stable_partition(order, [&](const Candidate& one) { return one.plane == plane; });
    } else if (group.size() > static_cast<std::size_t>(kMaxManifoldPoints)) {
        const Vec3 normal = group.front().normal;
        std::size_t most = 0;
        for (std::size_t i = 1; i < 3; ++i)
            if (std::abs(dot(normal, pose_.axes[i])) > std::abs(dot(normal, pose_.axes[most]))) most = i;
        const Vec3 u = pose_.axes[(most + 1) % 3], v = pose_.axes[(most + 2) % 3];
        const auto carries = [&](const Candidate& one) { return one.gap <= deepest + kMayCarry * least_; };
        const auto end = std::ranges::stable_partition(order, carries).begin();
        auto next = order.begin();
        for (const auto last : {end, order.end()})
            for (const Vec3 way : {u + v, v - u, -u - v, u - v})
                if (next < last && next - order.begin() < kMaxManifoldPoints) {
                    const auto along = [&](const Candidate& one) { return dot(way, one.at); };
                    std::iter_swap(next, std::ranges::max_element(next, last, {}, along));
                    ++next;
                }
    }
    const std::size_t count = std::min<std::size_t>(order.size(), kMaxManifoldPoints);
    const std::span<const Candidate> chosen = std::span(order).first(count);
    Vec3 normal = chosen.front().normal;
    if (!std::ranges::all_of(chosen, [&](const Candidate& one) { return one.normal == normal; })) {
        normal = {};
        for (const Candidate& one : chosen) normal = normal + one.normal;
        normal = (1 / length(normal)) * normal;
    }
    found.normal = -normal;
    for (const Candidate& one : chosen) found.points[static_cast<std::size_t>(found.count++)] = {one.at, one.gap};
    for (std::size_t i = count; i < order.size(); ++i)
        if (order[i].gap <= deepest + kMayCarry * least_) rest.push_back(order[i]), rest.back().left_over = true;
}

int SurfaceContacts::take(AxisHint& hint, std::array<Manifold, kMaxSurfaceContacts>& found) {
    int count = 0;
    while (count < kMaxSurfaceContacts && !candidates_.empty()) {
        // Other directions come before more points of one.
        const Candidate deepest =
            *std::ranges::min_element(candidates_, {}, [](const Candidate& one) { return std::pair(one.left_over, one.gap); });
        std::vector<Candidate>&group = scratch_.group, &rest = scratch_.rest;
        group.clear(), rest.clear();
        for (const Candidate& one : candidates_)
            (one.left_over == deepest.left_over && dot(one.normal, deepest.normal) > kOneDirection ? group : rest).push_back(one);
        Manifold& manifold = found[static_cast<std::size_t>(count++)];
        manifold.count = 0, manifold.on_rim = false;
        choose(group, manifold, rest);
        candidates_.swap(rest);
    }
    // Where on its rim a cylinder stands is remembered of the plane that holds it most.
    const PlanePoints* holds = nullptr;
    for (const PlanePoints& plane : planes_) {
        const auto of = [](const PlanePoints& one) { return std::count(one.held.begin(), one.held.end(), true); };
        if (of(plane) > 0 && (holds == nullptr || of(plane) > of(*holds))) holds = &plane;
    }
    if (holds != nullptr) hint = holds->hint;
    return count;
}

}  // namespace

Around around(const Core& core, const Pose& pose) {
    const auto reach = [&](auto part) {
        const double x = std::abs(part(pose.axes[0])), y = std::abs(part(pose.axes[1])), z = std::abs(part(pose.axes[2]));
        const double across =
            kind_of(core) == CoreKind::Cylinder ? core.half_m.x * std::hypot(x, y) : core.half_m.x * x + core.half_m.y * y;
        return across + core.half_m.z * z + core.radius_m;
    };
    const Vec3 half{reach([](Vec3 v) { return v.x; }), reach([](Vec3 v) { return v.y; }), reach([](Vec3 v) { return v.z; })};
    return {pose.centre - half, pose.centre + half};
}

int collide_with_surface(const Core& core, const Pose& pose, std::span<const Triangle> triangles, SurfaceSide side, double reach_m,
                         AxisHint& hint, std::array<Manifold, kMaxSurfaceContacts>& found) {
    thread_local Scratch scratch;
    SurfaceContacts contacts(core, pose, side, reach_m, scratch);
    for (const Triangle& triangle : triangles) contacts.add(triangle, hint);
    contacts.find_points();
    return contacts.take(hint, found);
}

}  // namespace meld::physics
