#include "physics/collision/cylinder_contacts.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <span>
#include <vector>

#include "physics/collision/nearest_cores.h"

namespace meld::physics {

namespace {

// Shares of the least thickness: cores that overlap by less are taken to touch along the same axis as if they were apart; what replaces
// this axis where they overlap by more must be better by so much; points between flat faces may be this much farther apart than the nearest
// ones; and by so much cores are shrunk to find the normal between edges that overlap.
constexpr double kShallow = 0.02, kDeeper = 0.01, kNearlyFlat = 0.03, kShrunk = 0.1;
// A cap that leans by more, rad, has a point exactly where it is lowest. One that leans by less stands on places of its own, so that they
// keep their impulses, among so many on its rim: four quarters of it apart, or, under a load near the rim, three neighbours, which hold it
// as well as the whole rim to 1 % of the radius, and the opposite one. A point that ran around the rim as fast as a cap that hardly leans
// can roll would shake it.
constexpr double kLeans = 0.03;
constexpr int kPlaces = 24;
// Others replace them where none is deeper than what is left of this share of the lowest point: a load that they hold makes a cap lean, but
// by less. What differs by less than a share of the radius is the same: orientations are exact to 1e-7.
constexpr double kLower = 0.8, kSame = 1e-5;
// Cosine of the angle between edges that lie along each other.
constexpr double kAlong = 0.9985;
// Points of one manifold that are nearer to each other, as a share of the radius, are one.
constexpr double kOnePoint = 1e-4;
constexpr std::size_t kMaxCandidates = 16;
// What a core looks like along a direction: what of it could lie on a face there.
struct Facet {
    enum class Kind { Point, Edge, Disc, Rectangle };
    Kind kind = Kind::Point;
    Vec3 centre;
    // Out of a disc or a rectangle.
    Vec3 out = {};
    // Half of an edge, or the half sides of a rectangle; the axes of a disc, as long as its radius.
    Vec3 first = {}, second = {};
    double radius_m = 0;

    bool is_flat() const { return kind == Kind::Disc || kind == Kind::Rectangle; }
    // From a point along `normal`, how far it is to the plane of this facet.
    double way_to_plane(Vec3 from, Vec3 normal) const { return dot(out, centre - from) / dot(out, normal); }
};

Facet facet_of_box(const PlacedCore& core, Vec3 direction) {
    const auto& axes = *core.axes;
    const double half[3] = {core.half_m.x, core.half_m.y, core.half_m.z};
    double along[3];
    std::size_t most = 0, least = 0;
    for (std::size_t i = 0; i < 3; ++i) {
        along[i] = dot(direction, axes[i]);
        if (std::abs(along[i]) > std::abs(along[most])) most = i;
        if (std::abs(along[i]) < std::abs(along[least])) least = i;
    }
    const auto towards = [&](std::size_t i) { return (along[i] < 0 ? -half[i] : half[i]) * axes[i]; };
    if (std::abs(along[most]) > kFlat) {
        const std::size_t u = (most + 1) % 3, v = (most + 2) % 3;
        return {.kind = Facet::Kind::Rectangle,
                .centre = core.centre + towards(most),
                .out = (along[most] < 0 ? -1.0 : 1.0) * axes[most],
                .first = half[u] * axes[u],
                .second = half[v] * axes[v]};
    }
    if (std::abs(along[least]) > kSlant) return {.centre = core.support(direction)};
    return {.kind = Facet::Kind::Edge,
            .centre = core.centre + (towards((least + 1) % 3) + towards((least + 2) % 3)),
            .first = half[least] * axes[least]};
}

Facet facet_of(const PlacedCore& core, Vec3 direction) {
    if (core.kind == CoreKind::Box) return facet_of_box(core, direction);
    const auto& axes = *core.axes;
    const double along = dot(direction, axes[2]);
    const double up = along < 0 ? -core.half_m.z : core.half_m.z;
    if (core.kind == CoreKind::Cylinder && std::abs(along) > kFlat)
        return {.kind = Facet::Kind::Disc,
                .centre = core.centre + up * axes[2],
                .out = (along < 0 ? -1.0 : 1.0) * axes[2],
                .first = core.half_m.x * axes[0],
                .second = core.half_m.x * axes[1],
                .radius_m = core.half_m.x};
    const Vec3 farthest = core.support(direction);
    if (std::abs(along) > kSlant || core.kind == CoreKind::Point) return {.centre = farthest};
    return {.kind = Facet::Kind::Edge, .centre = farthest - up * axes[2], .first = core.half_m.z * axes[2]};
}

// A point in the plane of a disc.
struct Flat {
    double x, y;
};
double square_of(Flat p) { return p.x * p.x + p.y * p.y; }

// Where a cap stands on its rim: cosines and sines of the angles from the direction in which it leans.
using Rim = std::array<Flat, kMaxManifoldPoints>;
// 15 degrees: one place.
constexpr Rim kAtNeighbours = {{{1, 0}, {0.9659258262890683, 0.2588190451025207}, {0.9659258262890683, -0.2588190451025207}, {-1, 0}}};
constexpr Rim kAtQuarters = {{{1, 0}, {0, 1}, {0, -1}, {-1, 0}}};

// Points where others may lie on a disc, whose middle is the origin.
class Candidates {
  public:
    Candidates(double radius, const Rim& rim) : radius_(radius), rim_(rim) {}

    void add(Flat p) {
        for (const Flat& other : all())
            if (square_of({p.x - other.x, p.y - other.y}) < kOnePoint * kOnePoint * radius_ * radius_) return;
        if (count_ < kMaxCandidates) points_[count_++] = p;
    }
    std::span<const Flat> all() const { return std::span(points_).first(count_); }

    // Those of its rim, from a middle, that `inside` holds.
    template <class Inside>
    void add_rim(Flat middle, double radius, const Inside& inside) {
        for (const Flat& way : rim_)
            if (const Flat p{middle.x + radius * way.x, middle.y + radius * way.y}; inside(p)) add(p);
    }
    // What of a straight line is on the disc: its ends.
    void add_stretch(Flat p, Flat q) {
        const double x = q.x - p.x, y = q.y - p.y, square = x * x + y * y;
        const double middle = p.x * x + p.y * y, under = middle * middle - square * (square_of(p) - radius_ * radius_);
        if (!(square > kOnePoint * kOnePoint * radius_ * radius_)) {
            if (square_of(p) <= radius_ * radius_) add(p);
            return;
        }
        if (under < 0) return;
        const double root = std::sqrt(under), from = std::max((-middle - root) / square, 0.0),
                     to = std::min((-middle + root) / square, 1.0);
        if (from > to) return;
        add({p.x + from * x, p.y + from * y});
        add({p.x + to * x, p.y + to * y});
    }
    void add_polygon(std::span<const Flat> corners) {
        add_rim({0, 0}, radius_, [&](Flat p) {
            bool left = false, right = false;
            for (std::size_t i = 0; i < corners.size(); ++i) {
                const Flat &from = corners[i], &to = corners[(i + 1) % corners.size()];
                const double side = (to.x - from.x) * (p.y - from.y) - (to.y - from.y) * (p.x - from.x);
                left = left || side > 0, right = right || side < 0;
            }
            return !(left && right);
        });
        for (std::size_t i = 0; i < corners.size(); ++i) add_stretch(corners[i], corners[(i + 1) % corners.size()]);
    }
    // The middle of another disc, and its radius.
    void add_disc(Flat middle, double radius) {
        // Discs of one size nearly above each other hold each other's rims.
        constexpr double kNearly = 0.02;
        const auto held = [](Flat centre, double reach) {
            return [=](Flat p) { return square_of({p.x - centre.x, p.y - centre.y}) <= reach * reach; };
        };
        add_rim({0, 0}, radius_, held(middle, (1 + kNearly) * radius));
        if (count_ == kMaxManifoldPoints) return;
        count_ = 0;
        add_rim(middle, radius, held({0, 0}, (1 + kNearly) * radius_));
        if (count_ == kMaxManifoldPoints) return;
        count_ = 0;
        add_rim({0, 0}, radius_, held(middle, radius));
        add_rim(middle, radius, held({0, 0}, radius_));
        const double apart = std::sqrt(square_of(middle));
        if (!(apart > std::abs(radius_ - radius)) || apart > radius_ + radius) return;
        const double along = (apart * apart + radius_ * radius_ - radius * radius) / (2 * apart);
        const double across = std::sqrt(std::max(radius_ * radius_ - along * along, 0.0));
        const Flat u{middle.x / apart, middle.y / apart};
        add({along * u.x - across * u.y, along * u.y + across * u.x});
        add({along * u.x + across * u.y, along * u.y - across * u.x});
    }

  private:
    double radius_;
    const Rim& rim_;
    std::array<Flat, kMaxCandidates> points_;
    std::size_t count_ = 0;
};

// Points of both surfaces, above each other along the normal.
struct Between {
    Flat flat;
    Vec3 on_a;
    double apart_m;
};

// Of more than four, those that reach farthest to four sides, none of which is one of the axes, so that there are no ties; and the
// nearest one.
void keep_four_of(std::array<Between, kMaxCandidates>& all, std::size_t& count) {
    if (count <= kMaxManifoldPoints) return;
    const std::span<const Between> some = std::span(all).first(count);
    const auto reaches = [&](const Flat& side, std::size_t i) { return side.x * some[i].flat.x + side.y * some[i].flat.y; };
    std::array<bool, kMaxCandidates> kept{};
    std::size_t nearest = 0;
    for (std::size_t i = 1; i < count; ++i)
        if (some[i].apart_m < some[nearest].apart_m) nearest = i;
    kept[nearest] = true;
    std::size_t number = 1;
    // Half of the square root of 3, and a half: 30 degrees from the axes.
    constexpr double kWide = 0.8660254037844386, kNarrow = 0.5;
    for (const Flat side : {Flat{kWide, kNarrow}, Flat{-kWide, -kNarrow}, Flat{-kNarrow, kWide}, Flat{kNarrow, -kWide}}) {
        std::size_t best = 0;
        for (std::size_t i = 1; i < count; ++i)
            if (reaches(side, i) > reaches(side, best)) best = i;
        if (kept[best] || number == kMaxManifoldPoints) continue;
        kept[best] = true, ++number;
    }
    std::size_t left = 0;
    for (std::size_t i = 0; i < count; ++i)
        if (kept[i]) all[left++] = all[i];
    count = left;
}

// The axes of a disc of which the first points to where it leans towards a plane that looks along `out`, and where on its rim it stands.
// The hint is the place of that on the body, if it leans but a little. `gap_m` is how far the disc's middle is from the plane, less the
// radii.
struct Standing {
    std::array<Vec3, 2> axes;
    const Rim& rim;
};
Standing standing_of(const Facet& disc, Vec3 out, double gap_m, AxisHint& hint) {
    constexpr double kTurn = 2 * M_PI;
    const Vec3 level = -(out - dot(out, disc.out) * disc.out), x = (1 / disc.radius_m) * disc.first, y = (1 / disc.radius_m) * disc.second;
    const double leans = length(level), along_x = dot(level, x), along_y = dot(level, y);
    // The angle in places, of which the whole number is kept.
    const auto place = [&] {
        const double turn = std::atan2(along_y, along_x) / kTurn;
        return static_cast<AxisHint>(std::lround((turn + 1) * kPlaces) % kPlaces);
    };
    if (leans > kLeans) {
        hint = place();
        const Vec3 first = (1 / leans) * level;
        return {{first, cross(disc.out, first)}, kAtQuarters};
    }
    // Quarters come first, then the same places with neighbours.
    if (hint >= 2 * kPlaces) hint = 0;
    const auto rim = [&]() -> const Rim& { return hint < kPlaces ? kAtQuarters : kAtNeighbours; };
    const auto middle = [&] {
        const double angle = kTurn / kPlaces * (hint % kPlaces);
        return Flat{std::cos(angle), std::sin(angle)};
    };
    Flat first = middle();
    // How far the lowest one of the places is above the lowest point of the rim.
    const double along = along_x * first.x + along_y * first.y, beside = std::abs(along_y * first.x - along_x * first.y);
    const auto low = [&](const Flat& way) { return way.x * along + way.y * beside; };
    const double above = leans - std::max({low(rim()[0]), low(rim()[1]), low(rim()[3])});
    const double deep = leans - gap_m / disc.radius_m;
    if (above > kLower * std::max(deep, 0.0) + kSame)
        hint = static_cast<AxisHint>(place() + (hint < kPlaces ? kPlaces : 0)), first = middle();
    const Vec3 ahead = first.x * x + first.y * y;
    return {{ahead, cross(disc.out, ahead)}, rim()};
}

// Two cores in the same frame.
class Cylinders {
  public:
    Cylinders(const Core& a, const Pose& a_pose, const Core& b, const Pose& b_pose, double reach, AxisHint& hint)
        : a_{kind_of(a), a.half_m, {}, &a_pose.axes},
          b_{kind_of(b), b.half_m, b_pose.centre - a_pose.centre, &b_pose.axes},
          a_core_(a),
          b_core_(b),
          a_pose_(a_pose),
          b_pose_(b_pose),
          hint_(hint),
          reach_(reach),
          radii_(a.radius_m + b.radius_m),
          least_(std::min(thickness(a_), thickness(b_))) {}

    void collide(Manifold& found);

  private:
    static double thickness(const PlacedCore& core) {
        if (core.kind < CoreKind::Cylinder) return kNever;
        const double ends = std::min(core.half_m.x, core.half_m.z);
        return core.kind == CoreKind::Box ? std::min(ends, core.half_m.y) : ends;
    }
    struct Along {
        Vec3 normal;
        double apart_m = -kNever;
    };
    // The axis of a face along which they are farthest apart; the rest, where these are too far apart, is not looked at.
    Along best_face(double farthest) const;
    // Along what two sides, or a side and a line, would meet between their ends.
    bool sides(Along& best, LineEnds& ends) const;
    bool by_sides(const Along& side, const LineEnds& ends, Manifold& found) const;
    // Where facets lie on each other, unless the nearest points there are farther apart than `limit`.
    bool by_facets(Vec3 normal, double limit, Manifold& found) const;
    static Candidates on_disc(const Facet& disc, const Facet& other, Vec3 normal, const Standing& standing);
    bool along_edge(const Facet& edge, const Facet& other, bool edge_of_a, Vec3 normal, double limit, Manifold& found) const;
    bool along_edges(const Facet& a, const Facet& b, Vec3 normal, double limit, Manifold& found) const;
    bool take(std::span<const Between> points, Vec3 normal, double limit, Manifold& found) const;
    std::vector<Along> starts() const;
    void by_overlap(const Along& face, Manifold& found) const;
    void one_point(Vec3 normal, Manifold& found) const;

    PlacedCore a_, b_;
    const Core &a_core_, &b_core_;
    const Pose &a_pose_, &b_pose_;
    AxisHint& hint_;
    double reach_, radii_, least_;
};

Cylinders::Along Cylinders::best_face(double farthest) const {
    Along best;
    for (const PlacedCore* core : {&a_, &b_}) {
        if (core->kind < CoreKind::Cylinder) continue;
        for (std::size_t i = core->kind == CoreKind::Box ? 0 : 2; i < 3; ++i) {
            const Vec3 axis = (*core->axes)[i], normal = dot(axis, b_.centre) < 0 ? -axis : axis;
            // Faces that lie on each other are as far apart along either axis.
            if (const double apart = separation(a_, b_, normal); apart > best.apart_m + 0.5 * kOverFace * least_) best = {normal, apart};
            if (best.apart_m > farthest) return best;
        }
    }
    return best;
}

bool Cylinders::sides(Along& best, LineEnds& ends) const {
    if (a_.kind == CoreKind::Box || b_.kind == CoreKind::Box) return false;
    const Vec3 u = (*a_.axes)[2], v = (*b_.axes)[2];
    ends = nearest_of_lines({}, u, a_.half_m.z, b_.centre, v, b_.half_m.z);
    const Vec3 way = ends.q - ends.p;
    const double distance = length(way), inner = 1 - kOnePoint;
    if (!(distance > kApart * least_)) return false;
    best = {(1 / distance) * way, distance - a_.half_m.x - b_.half_m.x};
    const bool parallel = std::abs(dot(u, v)) > kAlong;
    return parallel || (std::abs(dot(ends.p, u)) < inner * a_.half_m.z && std::abs(dot(ends.q - b_.centre, v)) < inner * b_.half_m.z);
}

// Between its ends a side is that of a line as thick.
bool Cylinders::by_sides(const Along& side, const LineEnds& ends, Manifold& found) const {
    const Core a{{0, 0, a_.half_m.z}, a_.half_m.x + a_core_.radius_m}, b{{0, 0, b_.half_m.z}, b_.half_m.x + b_core_.radius_m};
    if (std::abs(dot((*a_.axes)[2], (*b_.axes)[2])) > kAlong) return collide_side_by_side(a, a_pose_, b, b_pose_, b_.centre, reach_, found);
    add_nearest(a, b, ends, side.normal, reach_, found);
    return true;
}

bool Cylinders::take(std::span<const Between> points, Vec3 normal, double limit, Manifold& found) const {
    if (points.empty()) return false;
    if (std::ranges::min(points, {}, &Between::apart_m).apart_m > limit) return false;
    found.normal = normal;
    for (const Between& point : points) {
        const double gap = point.apart_m - radii_;
        add(found, point.on_a + (a_core_.radius_m + 0.5 * gap) * normal, gap, reach_);
    }
    return true;
}

// The other facet as the disc sees it along the normal.
Candidates Cylinders::on_disc(const Facet& disc, const Facet& other, Vec3 normal, const Standing& standing) {
    Candidates candidates(disc.radius_m, standing.rim);
    const auto seen = [&](Vec3 at) {
        const Vec3 there = at + disc.way_to_plane(at, normal) * normal - disc.centre;
        return Flat{dot(there, standing.axes[0]), dot(there, standing.axes[1])};
    };
    const auto& [kind, centre, out, first, second, radius] = other;
    if (kind == Facet::Kind::Disc)
        candidates.add_disc(seen(centre), radius);
    else if (kind == Facet::Kind::Rectangle)
        candidates.add_polygon(std::array{seen(centre + first + second), seen(centre - first + second), seen(centre - first - second),
                                          seen(centre + first - second)});
    else
        candidates.add_stretch(seen(centre + first), seen(centre - first));
    return candidates;
}

// On a rectangle.
bool Cylinders::along_edge(const Facet& edge, const Facet& other, bool edge_of_a, Vec3 normal, double limit, Manifold& found) const {
    double from = -1, to = 1;
    const auto seen = [&](double share) {
        const Vec3 at = edge.centre + share * edge.first;
        return at + other.way_to_plane(at, normal) * normal - other.centre;
    };
    for (const Vec3 side : {other.first, other.second}) {
        const double square = dot(side, side), middle = dot(seen(0), side), slope = dot(seen(1), side) - middle;
        if (std::abs(slope) < kOnePoint * square) {
            if (std::abs(middle) > square) return false;
            continue;
        }
        const double one = (-square - middle) / slope, two = (square - middle) / slope;
        from = std::max(from, std::min(one, two)), to = std::min(to, std::max(one, two));
    }
    if (from > to) return false;
    std::array<Between, 2> points;
    std::size_t count = 0;
    for (const double share : {from, to}) {
        const Vec3 at = edge.centre + share * edge.first;
        const double way = other.way_to_plane(at, normal);
        points[count++] = edge_of_a ? Between{{}, at, way} : Between{{}, at + way * normal, -way};
    }
    const bool one_point = edge.kind == Facet::Kind::Point || (to - from) * length(edge.first) < kOnePoint * least_;
    return take(std::span(points).first(one_point ? 1 : 2), normal, limit, found);
}

// Edges along each other: at the ends of their common stretch.
bool Cylinders::along_edges(const Facet& a, const Facet& b, Vec3 normal, double limit, Manifold& found) const {
    const double a_half = length(a.first), b_half = length(b.first);
    const Vec3 u = (1 / a_half) * a.first, v = (1 / b_half) * b.first;
    const double mixed = dot(u, v);
    if (std::abs(mixed) < kAlong) return false;
    const Vec3 shift = b.centre - a.centre;
    const double middle = dot(shift, u), half = b_half * std::abs(mixed);
    const double low = std::max(-a_half, middle - half), high = std::min(a_half, middle + half);
    if (high - low < kShrunk * least_) return false;
    std::array<Between, 2> points;
    std::size_t count = 0;
    for (const double s : {low, high}) {
        const Vec3 on_a = s * u, on_b = shift + (s - middle) / mixed * v;
        points[count++] = {{}, a.centre + on_a, dot(on_b - on_a, normal)};
    }
    return take(points, normal, limit, found);
}

bool Cylinders::by_facets(Vec3 normal, double limit, Manifold& found) const {
    const Facet a = facet_of(a_, normal), b = facet_of(b_, -normal);
    const bool disc_of_a = a.kind == Facet::Kind::Disc;
    if (!disc_of_a && b.kind != Facet::Kind::Disc) {
        if (a.kind == Facet::Kind::Rectangle) return along_edge(b, a, false, normal, limit, found);
        if (b.kind == Facet::Kind::Rectangle) return along_edge(a, b, true, normal, limit, found);
        return a.kind == Facet::Kind::Edge && b.kind == Facet::Kind::Edge && along_edges(a, b, normal, limit, found);
    }
    const Facet &disc = disc_of_a ? a : b, &other = disc_of_a ? b : a;
    const Standing standing =
        standing_of(disc,
                    other.is_flat() ? other.out
                    : disc_of_a     ? -normal
                                    : normal,
                    other.is_flat() ? (disc_of_a ? 1 : -1) * other.way_to_plane(disc.centre, normal) - radii_ : 0, hint_);
    const Candidates candidates = on_disc(disc, other, normal, standing);
    std::array<Between, kMaxCandidates> points;
    std::size_t count = 0;
    for (const Flat& flat : candidates.all()) {
        const Vec3 at = disc.centre + (flat.x * standing.axes[0] + flat.y * standing.axes[1]);
        double way = 0;
        if (other.is_flat()) {
            way = other.way_to_plane(at, normal);
        } else {
            // The point of the edge that is seen there.
            const double square = dot(other.first, other.first), leant = dot(other.first, normal);
            const double across = square - leant * leant;
            const Vec3 there = at - other.centre;
            const double share = across > 0 ? (dot(there, other.first) - leant * dot(there, normal)) / across : 0;
            way = dot(other.centre + share * other.first - at, normal);
        }
        points[count++] = disc_of_a ? Between{flat, at, way} : Between{flat, at + way * normal, -way};
    }
    keep_four_of(points, count);
    found.on_rim = true;
    return take(std::span(points).first(count), normal, limit, found);
}

// Where nothing better is known: between what reaches farthest along the normal.
void Cylinders::one_point(Vec3 normal, Manifold& found) const {
    const Facet a = facet_of(a_, normal), b = facet_of(b_, -normal);
    const auto nearest_on = [&](const Facet& edge, Vec3 at) {
        if (edge.kind != Facet::Kind::Edge) return edge.centre;
        return edge.centre + std::clamp(dot(at - edge.centre, edge.first) / dot(edge.first, edge.first), -1.0, 1.0) * edge.first;
    };
    LineEnds ends{a.centre, b.centre};
    if (a.kind == Facet::Kind::Edge && b.kind == Facet::Kind::Edge) {
        const double a_half = length(a.first), b_half = length(b.first);
        ends = nearest_of_lines(a.centre, (1 / a_half) * a.first, a_half, b.centre, (1 / b_half) * b.first, b_half);
    } else {
        ends.p = nearest_on(a, ends.q);
        ends.q = nearest_on(b, ends.p);
    }
    const double gap = separation(a_, b_, normal) - radii_;
    found.normal = normal;
    add(found, 0.5 * (ends.p + ends.q + (a_core_.radius_m - b_core_.radius_m) * normal), gap, reach_);
}

// Where least_overlap() may begin: the axes of faces, those across both axes, and those between the centres.
std::vector<Cylinders::Along> Cylinders::starts() const {
    std::vector<Along> all;
    const auto offer = [&](Vec3 way) {
        const double size = length(way);
        if (!(size > kApart * least_)) return;
        const Vec3 normal = (dot(way, b_.centre) < 0 ? -1 : 1) / size * way;
        all.push_back({normal, separation(a_, b_, normal)});
    };
    offer(b_.centre);
    for (const PlacedCore* core : {&a_, &b_}) {
        const Vec3 along = (*core->axes)[2];
        if (core->kind == CoreKind::Cylinder) offer(b_.centre - dot(b_.centre, along) * along);
        for (std::size_t i = core->kind == CoreKind::Box ? 0 : 2; i < 3; ++i) {
            offer((*core->axes)[i]);
            if (const PlacedCore& other = core == &a_ ? b_ : a_; other.kind != CoreKind::Box)
                offer(least_ * cross((*core->axes)[i], (*other.axes)[2]));
        }
    }
    return all;
}

void Cylinders::by_overlap(const Along& face, Manifold& found) const {
    Along best = face;
    const auto offer = [&](Vec3 normal) {
        const double apart = separation(a_, b_, normal);
        if (apart > best.apart_m + kDeeper * least_) best = {normal, apart};
    };
    // Edges and rims that overlap but a little do so along the shortest way between the same ones of smaller cores.
    LineEnds ends;
    const double shrunk = kShrunk * least_;
    if (nearest_of_cores(a_.shrunk(shrunk), b_.shrunk(shrunk), kNever, ends) == Nearness::Apart) {
        const Vec3 way = ends.q - ends.p;
        offer((1 / length(way)) * way);
    }
    if (best.apart_m < -kShallow * least_) {
        constexpr std::size_t kTried = 4;
        std::vector<Along> all = starts();
        all.push_back(best);
        std::ranges::stable_sort(all, std::ranges::greater{}, &Along::apart_m);
        for (const Along& start : std::span(all).first(std::min(kTried, all.size()))) offer(least_overlap(a_, b_, start.normal));
    }
    if (by_facets(best.normal, best.apart_m + kNearlyFlat * least_, found)) return;
    one_point(best.normal, found);
}

void Cylinders::collide(Manifold& found) {
    const double farthest = reach_ + radii_;
    if (const double apart = length(b_.centre); apart > 0 && separation(a_, b_, (1 / apart) * b_.centre) > farthest) return;
    const Along face = best_face(farthest);
    if (face.apart_m > farthest) return;
    const double shallow = -kShallow * least_;
    if (face.apart_m > shallow && by_facets(face.normal, face.apart_m + kOverFace * least_, found)) return;
    Along side;
    LineEnds ends;
    if (sides(side, ends) && side.apart_m > shallow && side.apart_m >= face.apart_m) {
        if (side.apart_m > farthest || by_sides(side, ends, found)) return;
    }
    switch (nearest_of_cores(a_, b_, farthest, ends)) {
        case Nearness::Far:
            return;
        case Nearness::Overlapping:
            return by_overlap(face, found);
        case Nearness::Apart:
            break;
    }
    const Vec3 way = ends.q - ends.p;
    const double distance = length(way);
    if (!(distance > kApart * least_)) return by_overlap(face, found);
    const Vec3 normal = (1 / distance) * way;
    const double flat = distance + kNearlyFlat * least_;
    // A little beside a face that it nearly lies on, or along an edge.
    if (dot(normal, face.normal) > kFlat && by_facets(face.normal, flat, found)) return;
    if (by_facets(normal, flat, found)) return;
    add_nearest(a_core_, b_core_, ends, normal, reach_, found);
}

}  // namespace

void collide_cylinder(const Core& a, const Pose& a_pose, const Core& b, const Pose& b_pose, double reach_m, AxisHint& hint,
                      Manifold& found) {
    Cylinders(a, a_pose, b, b_pose, reach_m, hint).collide(found);
}

void collide_cylinder_with_plane(const Core& a, const Pose& a_pose, Vec3 normal, double offset_m, double reach_m, AxisHint& hint,
                                 Manifold& found) {
    // Half of the square root of 2: whether a cap or the side looks more at the plane.
    constexpr double kDiagonal = 0.7071067811865476;
    const PlacedCore core{CoreKind::Cylinder, a.half_m, {}, &a_pose.axes};
    const double height = dot(normal, a_pose.centre) - offset_m - a.radius_m;
    const auto offer = [&](Vec3 at) {
        const double gap = height + dot(normal, at);
        add(found, at - (a.radius_m + 0.5 * gap) * normal, gap, reach_m);
    };
    const Vec3 z = a_pose.axes[2];
    const double along = dot(normal, z);
    if (std::abs(along) < kDiagonal) {
        const Vec3 lowest = core.support(-normal), end = (along > 0 ? -a.half_m.z : a.half_m.z) * z;
        offer(lowest), offer(lowest - 2 * end);
        return;
    }
    const Vec3 down = along > 0 ? -z : z;
    const Facet cap{.kind = Facet::Kind::Disc,
                    .centre = a.half_m.z * down,
                    .out = down,
                    .first = a.half_m.x * a_pose.axes[0],
                    .second = a.half_m.x * a_pose.axes[1],
                    .radius_m = a.half_m.x};
    found.on_rim = true;
    const auto& [axes, rim] = standing_of(cap, normal, height + dot(normal, cap.centre), hint);
    for (const Flat& way : rim) offer(cap.centre + a.half_m.x * (way.x * axes[0] + way.y * axes[1]));
}

}  // namespace meld::physics
