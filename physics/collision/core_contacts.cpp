#include "physics/collision/core_contacts.h"

#include <algorithm>
#include <cmath>
#include <span>

#include "physics/collision/core_geometry.h"
#include "physics/collision/cylinder_contacts.h"
#include "runtime/base/assert.h"

namespace meld::physics {

namespace {

// A share of the least thickness: another axis must be better by this to replace a face.
constexpr double kBetter = 0.01;
// Boxes whose axes differ by less than this, rad, have no axes of edges that say more than those of their faces.
constexpr double kAlike = 1e-3;
// Nearest points that change less than this, as a share of the least thickness, are found.
constexpr double kSettled = 1e-7;

double& part(Vec3& v, int i) { return i == 0 ? v.x : i == 1 ? v.y : v.z; }
double part(const Vec3& v, int i) { return i == 0 ? v.x : i == 1 ? v.y : v.z; }

// The point of a core's surface that is nearest to a point, both in the core's frame: the direction out of the core there, and how far
// along it the point is (negative: inside).
struct OnCore {
    Vec3 on, out;
    double distance;
};
OnCore nearest_on_cylinder(Vec3 half, Vec3 point) {
    const double away = std::hypot(point.x, point.y), inward = away > half.x ? half.x / away : 1;
    const Vec3 on{inward * point.x, inward * point.y, std::clamp(point.z, -half.z, half.z)};
    const Vec3 way = point - on;
    if (const double distance = length(way); distance > 0) return {on, (1 / distance) * way, distance};
    if (half.z - std::abs(point.z) <= half.x - away) {
        const double up = point.z < 0 ? -1 : 1;
        return {{point.x, point.y, up * half.z}, {0, 0, up}, std::abs(point.z) - half.z};
    }
    const Vec3 out = away > 0 ? (1 / away) * Vec3{point.x, point.y, 0} : Vec3{1, 0, 0};
    return {{half.x * out.x, half.x * out.y, point.z}, out, away - half.x};
}
OnCore nearest_on(Vec3 half, Vec3 point) {
    const Vec3 on{std::clamp(point.x, -half.x, half.x), std::clamp(point.y, -half.y, half.y), std::clamp(point.z, -half.z, half.z)};
    const Vec3 way = point - on;
    if (const double distance = length(way); distance > 0) return {on, (1 / distance) * way, distance};
    int axis = 0;
    for (int i = 1; i < 3; ++i)
        if (part(half, i) - std::abs(part(point, i)) < part(half, axis) - std::abs(part(point, axis))) axis = i;
    OnCore found{point, {}, std::abs(part(point, axis)) - part(half, axis)};
    part(found.out, axis) = part(point, axis) < 0 ? -1 : 1;
    part(found.on, axis) = part(found.out, axis) * part(half, axis);
    return found;
}

void collide_ball_and_core(const Core& ball, const Core& core, const Pose& pose, Vec3 from_core, bool ball_first, double reach,
                           Manifold& found) {
    const Vec3 ball_at = into(pose, from_core);
    const OnCore near = kind_of(core) == CoreKind::Cylinder ? nearest_on_cylinder(core.half_m, ball_at) : nearest_on(core.half_m, ball_at);
    const Vec3 out = out_of(pose, near.out);
    const double gap = near.distance - core.radius_m - ball.radius_m;
    found.normal = ball_first ? -out : out;
    // From the centre of the core; the ball is at from_core.
    const Vec3 at = out_of(pose, near.on) + (core.radius_m + 0.5 * gap) * out;
    add(found, ball_first ? at - from_core : at, gap, reach);
}

void collide_lines(const Core& a, const Pose& a_pose, const Core& b, const Pose& b_pose, Vec3 shift, double reach, Manifold& found) {
    if (collide_side_by_side(a, a_pose, b, b_pose, shift, reach, found)) return;
    const Vec3 u = a_pose.axes[2], v = b_pose.axes[2], across = cross(u, v);
    const double size = length(across);
    Vec3 otherwise = size > 1e-6 ? (1 / size) * across : any_across(u);
    if (dot(otherwise, shift) < 0) otherwise = -otherwise;
    add_nearest(a, b, nearest_of_lines({}, u, a.half_m.z, shift, v, b.half_m.z), otherwise, reach, found);
}

// A face of a core, or the whole of a line, as a ring of corners from the core's centre.
struct Ring {
    std::array<Vec3, 8> corners;
    int count = 0;
    void push(Vec3 corner) {
        if (count < 8) corners[static_cast<std::size_t>(count++)] = corner;
    }
    std::span<const Vec3> all() const { return std::span(corners).first(static_cast<std::size_t>(count)); }
};

// The face that looks most along a direction.
Ring face_along(const Core& core, const Pose& pose, Vec3 direction) {
    Ring ring;
    const Vec3 z = core.half_m.z * pose.axes[2];
    if (kind_of(core) == CoreKind::Line) {
        ring.push(z), ring.push(-z);
        return ring;
    }
    int axis = 0;
    double best = -1;
    for (int i = 0; i < 3; ++i)
        if (const double along = std::abs(dot(direction, pose.axes[static_cast<std::size_t>(i)])); along > best) axis = i, best = along;
    const auto edge = [&](int i) { return part(core.half_m, i) * pose.axes[static_cast<std::size_t>(i)]; };
    const Vec3 out = dot(direction, edge(axis)) < 0 ? -edge(axis) : edge(axis), p = edge((axis + 1) % 3), q = edge((axis + 2) % 3);
    ring.push(out + p + q), ring.push(out - p + q), ring.push(out - p - q), ring.push(out + p - q);
    return ring;
}

// Whether the face, or the line, that looks most along `-out` lies nearly across it.
bool lies_flat(const Core& core, const Pose& pose, Vec3 out) {
    if (kind_of(core) == CoreKind::Line) return std::abs(dot(out, pose.axes[2])) < kSlant;
    double most = 0;
    for (const Vec3& axis : pose.axes) most = std::max(most, std::abs(dot(out, axis)));
    return most > kFlat;
}

// Cuts off what lies beyond `limit` along coordinate `axis` times `sign`.
void clip(Ring& ring, int axis, double sign, double limit) {
    Ring kept;
    for (int i = 0; i < ring.count; ++i) {
        const Vec3 here = ring.corners[static_cast<std::size_t>(i)], next = ring.corners[static_cast<std::size_t>((i + 1) % ring.count)];
        const double from = sign * part(here, axis) - limit, to = sign * part(next, axis) - limit;
        if (from <= 0) kept.push(here);
        if ((from < 0 && to > 0) || (from > 0 && to < 0)) {
            Vec3 crossing = here + (from / (from - to)) * (next - here);
            part(crossing, axis) = sign * limit;
            kept.push(crossing);
        }
    }
    ring = kept;
}

// Two cores of which at least one is a box.
class Boxes {
  public:
    Boxes(const Core& a, const Pose& a_pose, const Core& b, const Pose& b_pose, double reach)
        : a_(a),
          b_(b),
          a_pose_(a_pose),
          b_pose_(b_pose),
          shift_(b_pose.centre - a_pose.centre),
          reach_(reach),
          radii_(a.radius_m + b.radius_m),
          a_box_(kind_of(a) == CoreKind::Box),
          b_box_(kind_of(b) == CoreKind::Box) {}

    // Not a part of its caller, whose other ways would then save registers that only this one needs.
    [[gnu::noinline]] void collide(AxisHint& hint, Manifold& found);

  private:
    static constexpr int kFaces = 3, kEdges = 6, kAxes = 15;
    bool has(int axis) const {
        if (axis < kFaces) return a_box_;
        if (axis < kEdges) return b_box_;
        if (alike_) return false;
        return (a_box_ || (axis - kEdges) / 3 == 2) && (b_box_ || (axis - kEdges) % 3 == 2);
    }
    void compare_axes();
    // Whether the shadows of the cores on an axis of faces are farther apart than they may be.
    bool far_along(int axis) const;
    // The distance of a core from the box around the other one along its axes, given how far their shadows on these are apart.
    static double beyond_box(double x, double y, double z) {
        const double p = std::max(x, 0.0), q = std::max(y, 0.0), r = std::max(z, 0.0);
        return std::sqrt(p * p + q * q + r * r);
    }
    // How far apart the cores' shadows on an axis are: a lower bound of their distance, and of their overlap the whole if nothing is less.
    double separation(int axis) const;
    Vec3 direction(int axis) const;
    bool by_face(int axis, double separated, bool apart, Manifold& found) const;
    bool by_edges(int axis, double separated, bool apart, Manifold& found) const;
    LineEnds support_edges(int axis) const;
    void by_nearest(int edge_axis, Vec3 otherwise, Manifold& found) const;
    bool by_turns(Vec3 otherwise, Manifold& found) const;
    static void keep_four(std::span<const ManifoldPoint> all, Vec3 first, Vec3 second, Manifold& found);

    const Core &a_, &b_;
    const Pose &a_pose_, &b_pose_;
    Vec3 shift_, a_shift_, b_shift_;
    double reach_, radii_, least_ = 0;
    bool a_box_, b_box_, alike_ = false;
    double turn_[3][3], size_[3][3];
};

void Boxes::compare_axes() {
    a_shift_ = into(a_pose_, shift_), b_shift_ = into(b_pose_, shift_);
    alike_ = a_box_ && b_box_;
    for (int i = 0; i < 3; ++i)
        for (int j = 0; j < 3; ++j) {
            turn_[i][j] = dot(a_pose_.axes[static_cast<std::size_t>(i)], b_pose_.axes[static_cast<std::size_t>(j)]);
            size_[i][j] = std::abs(turn_[i][j]);
            alike_ = alike_ && (size_[i][j] < kAlike || size_[i][j] > 0.5);
        }
    least_ = kNever;
    for (const Core* core : {&a_, &b_})
        if (kind_of(*core) == CoreKind::Box) least_ = std::min({least_, core->half_m.x, core->half_m.y, core->half_m.z});
}

bool Boxes::far_along(int axis) const {
    const Vec3 along = axis < kFaces ? a_pose_.axes[static_cast<std::size_t>(axis)] : b_pose_.axes[static_cast<std::size_t>(axis - kFaces)];
    const auto shadow = [&](const Core& core, const Pose& pose) {
        return core.half_m.x * std::abs(dot(along, pose.axes[0])) + core.half_m.y * std::abs(dot(along, pose.axes[1])) +
               core.half_m.z * std::abs(dot(along, pose.axes[2]));
    };
    return std::abs(dot(along, shift_)) - shadow(a_, a_pose_) - shadow(b_, b_pose_) > reach_ + radii_;
}

double Boxes::separation(int axis) const {
    const Vec3 &a = a_.half_m, &b = b_.half_m;
    if (axis < kFaces) {
        const auto& row = size_[axis];
        return std::abs(part(a_shift_, axis)) - part(a, axis) - (b.x * row[0] + b.y * row[1] + b.z * row[2]);
    }
    if (axis < kEdges) {
        const int j = axis - kFaces;
        return std::abs(part(b_shift_, j)) - part(b, j) - (a.x * size_[0][j] + a.y * size_[1][j] + a.z * size_[2][j]);
    }
    // The cross product of an edge of each.
    constexpr double kParallel = 1e-6;
    const int i = (axis - kEdges) / 3, j = (axis - kEdges) % 3, i1 = (i + 1) % 3, i2 = (i + 2) % 3, j1 = (j + 1) % 3, j2 = (j + 2) % 3;
    const double square = 1 - turn_[i][j] * turn_[i][j];
    if (square < kParallel) return -kNever;
    const double apart = std::abs(part(a_shift_, i2) * turn_[i1][j] - part(a_shift_, i1) * turn_[i2][j]);
    const double of_a = part(a, i1) * size_[i2][j] + part(a, i2) * size_[i1][j];
    const double of_b = part(b, j1) * size_[i][j2] + part(b, j2) * size_[i][j1];
    return (apart - of_a - of_b) / std::sqrt(square);
}

// A unit vector from the first body to the second.
Vec3 Boxes::direction(int axis) const {
    Vec3 along;
    if (axis < kFaces)
        along = a_pose_.axes[static_cast<std::size_t>(axis)];
    else if (axis < kEdges)
        along = b_pose_.axes[static_cast<std::size_t>(axis - kFaces)];
    else {
        along =
            cross(a_pose_.axes[static_cast<std::size_t>((axis - kEdges) / 3)], b_pose_.axes[static_cast<std::size_t>((axis - kEdges) % 3)]);
        along = (1 / length(along)) * along;
    }
    return dot(along, shift_) < 0 ? -along : along;
}

// Of all points, those that reach farthest to the four sides, and the deepest one.
void Boxes::keep_four(std::span<const ManifoldPoint> all, Vec3 first, Vec3 second, Manifold& found) {
    if (all.size() <= kMaxManifoldPoints) {
        for (const ManifoldPoint& point : all) found.points[static_cast<std::size_t>(found.count++)] = point;
        return;
    }
    std::array<bool, 8> kept{};
    std::size_t deepest = 0;
    for (std::size_t i = 1; i < all.size(); ++i)
        if (all[i].gap_m < all[deepest].gap_m) deepest = i;
    const auto farthest = [&](Vec3 side) {
        std::size_t best = 0;
        for (std::size_t i = 1; i < all.size(); ++i)
            if (dot(all[i].at - all[best].at, side) > 0) best = i;
        return best;
    };
    constexpr double kClearly = 1e-3;
    double least = kNever;
    for (const Vec3 side : {first + second, first - second, -first - second, second - first}) {
        const std::size_t i = farthest(side);
        kept[i] = true;
        least = std::min(least, all[i].gap_m);
    }
    if (all[deepest].gap_m < least - kClearly * std::abs(least) && !kept[deepest]) {
        std::size_t nearest = 0;
        double best = kNever;
        for (std::size_t i = 0; i < all.size(); ++i)
            if (const double away = length(all[i].at - all[deepest].at); kept[i] && away < best) nearest = i, best = away;
        kept[nearest] = false, kept[deepest] = true;
    }
    for (std::size_t i = 0; i < all.size(); ++i)
        if (kept[i]) found.points[static_cast<std::size_t>(found.count++)] = all[i];
}

// Clips the face of the other core against the sides of this one. False if it lies beside this face, so that an edge or a corner is
// nearer.
bool Boxes::by_face(int axis, double separated, bool apart, Manifold& found) const {
    const bool of_a = axis < kFaces;
    const Core &own = of_a ? a_ : b_, &other = of_a ? b_ : a_;
    const Pose &own_pose = of_a ? a_pose_ : b_pose_, &other_pose = of_a ? b_pose_ : a_pose_;
    const int up = of_a ? axis : axis - kFaces, first = (up + 1) % 3, second = (up + 2) % 3;
    const Vec3 normal = direction(axis), out = of_a ? normal : -normal, towards = of_a ? shift_ : -shift_;
    // In this core's frame, but along `out`.
    const double sign = dot(out, own_pose.axes[static_cast<std::size_t>(up)]) < 0 ? -1 : 1;
    Ring ring;
    const auto face = face_along(other, other_pose, -out);
    for (const Vec3 corner : face.all()) ring.push(into(own_pose, towards + corner));
    if (other.half_m.x == 0) {
        // A line: a ring of two corners, of which clipping would find each crossing twice.
        Vec3 &p = ring.corners[0], &q = ring.corners[1];
        for (const int side : {first, second})
            for (const double way : {1.0, -1.0}) {
                const double limit = part(own.half_m, side), from = way * part(p, side) - limit, to = way * part(q, side) - limit;
                if (from > 0 && to > 0) return false;
                if (from > 0) p = p + (from / (from - to)) * (q - p);
                if (to > 0) q = q + (to / (to - from)) * (p - q);
            }
    } else {
        for (const int side : {first, second})
            for (const double way : {1.0, -1.0}) clip(ring, side, way, part(own.half_m, side));
    }
    std::array<ManifoldPoint, 8> points;
    std::size_t count = 0;
    double nearest = kNever;
    for (const Vec3 corner : ring.all()) {
        const double above = sign * part(corner, up) - part(own.half_m, up), gap = above - radii_;
        nearest = std::min(nearest, above);
        if (gap > reach_) continue;
        Vec3 at = corner;
        part(at, up) -= sign * (other.radius_m + 0.5 * gap);
        at = out_of(own_pose, at);
        points[count++] = {of_a ? at : shift_ + at, gap};
    }
    if (ring.count == 0 || (apart && nearest > separated + kOverFace * least_ && !lies_flat(other, other_pose, out))) return false;
    found.normal = normal;
    const auto side = [&](int i) {
        return part(own.half_m, i) > 0 ? (1 / part(own.half_m, i)) * own_pose.axes[static_cast<std::size_t>(i)] : Vec3{};
    };
    keep_four(std::span(points).first(count), side(first), side(second), found);
    return true;
}

LineEnds Boxes::support_edges(int axis) const {
    const int i = (axis - kEdges) / 3, j = (axis - kEdges) % 3;
    const Vec3 normal = direction(axis);
    Vec3 p, q = shift_;
    for (int k = 0; k < 3; ++k) {
        const Vec3 &a = a_pose_.axes[static_cast<std::size_t>(k)], &b = b_pose_.axes[static_cast<std::size_t>(k)];
        if (k != i) p = p + (dot(a, normal) < 0 ? -part(a_.half_m, k) : part(a_.half_m, k)) * a;
        if (k != j) q = q + (dot(b, normal) < 0 ? part(b_.half_m, k) : -part(b_.half_m, k)) * b;
    }
    return nearest_of_lines(p, a_pose_.axes[static_cast<std::size_t>(i)], part(a_.half_m, i), q, b_pose_.axes[static_cast<std::size_t>(j)],
                            part(b_.half_m, j));
}

bool Boxes::by_edges(int axis, double separated, bool apart, Manifold& found) const {
    const LineEnds ends = support_edges(axis);
    if (apart && length(ends.q - ends.p) > separated + kOverFace * least_) return false;
    found.normal = direction(axis);
    const double gap = separated - radii_;
    add(found, 0.5 * (ends.p + ends.q + (a_.radius_m - b_.radius_m) * found.normal), gap, reach_);
    return true;
}

// Goes to and fro between the cores, each time to the nearest point of the other: from a corner, or between edges that are parallel, this
// ends at once.
bool Boxes::by_turns(Vec3 otherwise, Manifold& found) const {
    constexpr int kTurns = 6;
    Vec3 p, q = shift_;
    double before = kNever;
    for (int i = 0; i < kTurns; ++i) {
        p = out_of(a_pose_, nearest_on(a_.half_m, into(a_pose_, q)).on);
        q = shift_ + out_of(b_pose_, nearest_on(b_.half_m, into(b_pose_, p - shift_)).on);
        const double distance = length(q - p);
        if (before - distance < kSettled * least_) {
            add_nearest(a_, b_, {p, q}, otherwise, reach_, found);
            return true;
        }
        before = distance;
    }
    return false;
}

// Of cores that are apart, the nearest points: a corner and what is nearest to it, or points within two edges.
void Boxes::by_nearest(int edge_axis, Vec3 otherwise, Manifold& found) const {
    LineEnds best{};
    double least = kNever;
    const auto offer = [&](const LineEnds& ends) {
        if (const double distance = length(ends.q - ends.p); distance < least) best = ends, least = distance;
    };
    const auto corners = [](const Core& core, const auto& visit) {
        const bool box = core.half_m.x > 0;
        for (int bits = box ? 0 : 3; bits < 8; bits += box ? 1 : 4)
            visit(Vec3{(bits & 1) != 0 ? core.half_m.x : -core.half_m.x, (bits & 2) != 0 ? core.half_m.y : -core.half_m.y,
                       (bits & 4) != 0 ? core.half_m.z : -core.half_m.z});
    };
    corners(b_, [&](Vec3 corner) {
        const Vec3 q = shift_ + out_of(b_pose_, corner);
        offer({out_of(a_pose_, nearest_on(a_.half_m, into(a_pose_, q)).on), q});
    });
    corners(a_, [&](Vec3 corner) {
        const Vec3 p = out_of(a_pose_, corner);
        offer({p, shift_ + out_of(b_pose_, nearest_on(b_.half_m, into(b_pose_, p - shift_)).on)});
    });
    if (edge_axis >= 0) offer(support_edges(edge_axis));
    add_nearest(a_, b_, best, otherwise, reach_, found);
}

void Boxes::collide(AxisHint& hint, Manifold& found) {
    const double farthest = reach_ + radii_;
    if (hint < kEdges && has(hint) && far_along(hint)) return;
    compare_axes();
    double face = -kNever, edge = -kNever, of_faces[kEdges];
    int face_axis = 0, edge_axis = -1;
    for (int axis = 0; axis < kAxes; ++axis) {
        if (axis == kFaces && a_box_ && beyond_box(of_faces[0], of_faces[1], of_faces[2]) > farthest) return;
        if (axis == kEdges && b_box_ && beyond_box(of_faces[3], of_faces[4], of_faces[5]) > farthest) return;
        if (!has(axis)) continue;
        const double apart = separation(axis);
        if (apart > farthest) {
            hint = static_cast<AxisHint>(axis);
            return;
        }
        if (axis < kEdges) {
            of_faces[axis] = apart;
            if (apart > face) face = apart, face_axis = axis;
        } else if (apart > edge) {
            edge = apart, edge_axis = axis;
        }
    }
    const double apart = std::max(face, edge);
    const double better = kBetter * least_;
    if (hint < kEdges && has(hint) && of_faces[hint] >= face - better) face_axis = hint;
    const bool by_edge = edge_axis >= 0 && edge > face + better && std::abs(dot(direction(edge_axis), direction(face_axis))) < kFlat;
    const int axis = by_edge ? edge_axis : face_axis;
    hint = static_cast<AxisHint>(axis);
    const bool disjoint = apart > kApart * least_;
    if (by_edge ? by_edges(axis, edge, disjoint, found) : by_face(axis, of_faces[axis], disjoint, found)) return;
    if (disjoint) {
        if (!by_turns(direction(axis), found)) by_nearest(edge_axis, direction(axis), found);
        return;
    }
    // The cores overlap beside the face that is nearest: the deepest point of the other core stands for all.
    if (edge_axis >= 0) by_edges(edge_axis, edge, false, found);
}

}  // namespace

// C. Ericson: "Real-Time Collision Detection", section 5.1.9.
LineEnds nearest_of_lines(Vec3 a_middle, Vec3 a_along, double a, Vec3 b_middle, Vec3 b_along, double b) {
    const Vec3 between = a_middle - b_middle;
    const double mixed = dot(a_along, b_along), on_a = dot(a_along, between), on_b = dot(b_along, between), area = 1 - mixed * mixed;
    double s = area > 1e-12 ? std::clamp((mixed * on_b - on_a) / area, -a, a) : 0;
    double t = mixed * s + on_b;
    if (std::abs(t) > b) {
        t = std::clamp(t, -b, b);
        s = std::clamp(mixed * t - on_a, -a, a);
    }
    return {a_middle + s * a_along, b_middle + t * b_along};
}

bool collide_side_by_side(const Core& a, const Pose& a_pose, const Core& b, const Pose& b_pose, Vec3 shift, double reach, Manifold& found) {
    constexpr double kParallel = 0.9985, kShort = 0.1;
    const Vec3 u = a_pose.axes[2], v = b_pose.axes[2];
    const double mixed = dot(u, v), middle = dot(shift, u), half = b.half_m.z * std::abs(mixed);
    const double low = std::max(-a.half_m.z, middle - half), high = std::min(a.half_m.z, middle + half);
    const double radii = a.radius_m + b.radius_m;
    if (std::abs(mixed) < kParallel || high - low < kShort * radii) return false;
    const auto ends = [&](double s) {
        const double t = std::clamp((s - middle) / mixed, -b.half_m.z, b.half_m.z);
        return LineEnds{s * u, shift + t * v};
    };
    const LineEnds first = ends(low), last = ends(high);
    const Vec3 across = (first.q - first.p) + (last.q - last.p), sideways = across - dot(across, u) * u;
    const double wide = length(sideways);
    found.normal = wide > kApart * radii ? (1 / wide) * sideways : any_across(u);
    for (const LineEnds& both : {first, last}) {
        const double gap = dot(both.q - both.p, found.normal) - radii;
        add(found, both.p + (a.radius_m + 0.5 * gap) * found.normal, gap, reach);
    }
    return true;
}

void add_nearest(const Core& a, const Core& b, const LineEnds& ends, Vec3 otherwise, double reach, Manifold& found) {
    const Vec3 way = ends.q - ends.p;
    const double distance = length(way), radii = a.radius_m + b.radius_m;
    found.normal = distance > 0 ? (1 / distance) * way : otherwise;
    add(found, ends.p + (a.radius_m + 0.5 * (distance - radii)) * found.normal, distance - radii, reach);
}

Pose pose_of(Vec3 centre, Quat turn) { return {centre, {rotate(turn, {1, 0, 0}), rotate(turn, {0, 1, 0}), rotate(turn, {0, 0, 1})}}; }

void collide(const Core& a, const Pose& a_pose, const Core& b, const Pose& b_pose, double reach_m, AxisHint& hint, Manifold& found) {
    found.count = 0, found.on_rim = false;
    const CoreKind first = kind_of(a), second = kind_of(b);
    const Vec3 shift = b_pose.centre - a_pose.centre;
    if (first == CoreKind::Box && second == CoreKind::Box) return Boxes(a, a_pose, b, b_pose, reach_m).collide(hint, found);
    if (first >= CoreKind::Cylinder || second >= CoreKind::Cylinder) {
        if (second == CoreKind::Point) return collide_ball_and_core(b, a, a_pose, shift, false, reach_m, found);
        if (first == CoreKind::Point) return collide_ball_and_core(a, b, b_pose, -shift, true, reach_m, found);
        if (first == CoreKind::Cylinder || second == CoreKind::Cylinder)
            return collide_cylinder(a, a_pose, b, b_pose, reach_m, hint, found);
        return Boxes(a, a_pose, b, b_pose, reach_m).collide(hint, found);
    }
    if (first == CoreKind::Line && second == CoreKind::Line) return collide_lines(a, a_pose, b, b_pose, shift, reach_m, found);
    if (first == CoreKind::Line) return collide_ball_and_core(b, a, a_pose, shift, false, reach_m, found);
    collide_ball_and_core(a, b, b_pose, -shift, true, reach_m, found);
}

void collide_with_plane(const Core& a, const Pose& a_pose, Vec3 normal, double offset_m, double reach_m, AxisHint& hint, Manifold& found) {
    found.count = 0, found.on_rim = false;
    found.normal = -normal;
    if (kind_of(a) == CoreKind::Cylinder) return collide_cylinder_with_plane(a, a_pose, normal, offset_m, reach_m, hint, found);
    const double height = dot(normal, a_pose.centre) - offset_m - a.radius_m;
    Ring ring;
    if (kind_of(a) == CoreKind::Point)
        ring.push({});
    else
        ring = face_along(a, a_pose, -normal);
    for (const Vec3 corner : ring.all()) {
        const double gap = height + dot(normal, corner);
        add(found, corner - (a.radius_m + 0.5 * gap) * normal, gap, reach_m);
    }
}

Pose pose_of_part(const ShapePart& part, const Pose& body) {
    Pose pose{centre_of(part, body), body.axes};
    if (part.turn == Quat{}) return pose;
    const auto seen = [&](Vec3 axis) {
        const Vec3 own = rotate(part.turn, axis);
        return own.x * body.axes[0] + (own.y * body.axes[1] + own.z * body.axes[2]);
    };
    pose.axes = {seen({1, 0, 0}), seen({0, 1, 0}), seen({0, 0, 1})};
    return pose;
}

PlacedSolid solid_of(const BodyShape& shape, const Pose& body, std::size_t part) {
    if (!shape.is_compound()) return {{shape.core_m, shape.rounding_m}, body};
    const ShapePart& solid = shape.parts[part];
    return {{solid.core_m, solid.rounding_m}, pose_of_part(solid, body)};
}

bool nearer(const BodyShape& a, const Attitude& a_place, const BodyShape& b, const Attitude& b_place, double within_m) {
    const Pose a_pose = pose_of(a_place.centre, a_place.turn), b_pose = pose_of(b_place.centre, b_place.turn);
    for (std::size_t i = 0; i < a.solids(); ++i)
        for (std::size_t j = 0; j < b.solids(); ++j) {
            const PlacedSolid one = solid_of(a, a_pose, i), other = solid_of(b, b_pose, j);
            Manifold found;
            AxisHint hint = kNoAxis;
            collide(one.core, one.pose, other.core, other.pose, within_m, hint, found);
            if (found.count > 0) return true;
        }
    return false;
}

}  // namespace meld::physics
