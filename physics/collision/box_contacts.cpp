#include "physics/collision/box_contacts.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <span>
#include <utility>

#include "physics/collision/core_geometry.h"

namespace meld::physics {

namespace {

// A share of the least thickness: another axis must be better by this to replace a face.
constexpr double kBetterAxis = 0.01;
// Boxes whose axes differ by less than this, rad, have no axes of edges that say more than those of their faces.
constexpr double kAlike = 1e-3;
// Nearest points that change less than this, as a share of the least thickness, are found.
constexpr double kSettled = 1e-7;

// In the frame of a box: along the two axes of one of its faces, and across it.
struct FaceCorner {
    double u, v, up;
};
// A face that is being cut, or a line.
using FaceRing = CornerRing<FaceCorner>;

// Cuts off what lies beyond `limit` along a coordinate times `sign`.
template <double FaceCorner::* kAlong>
void clip_face(FaceRing& ring, double sign, double limit) {
    if (std::ranges::all_of(ring.all(), [&](const FaceCorner& corner) { return sign * corner.*kAlong <= limit; })) return;
    FaceRing kept;
    for (int i = 0; i < ring.count; ++i) {
        const FaceCorner here = ring.corners[static_cast<std::size_t>(i)],
                         next = ring.corners[static_cast<std::size_t>(i + 1 == ring.count ? 0 : i + 1)];
        const double from = sign * here.*kAlong - limit, to = sign * next.*kAlong - limit;
        if (from <= 0) kept.push(here);
        if ((from < 0 && to > 0) || (from > 0 && to < 0)) {
            const double share = from / (from - to);
            FaceCorner crossing{here.u + share * (next.u - here.u), here.v + share * (next.v - here.v),
                                here.up + share * (next.up - here.up)};
            crossing.*kAlong = sign * limit;
            kept.push(crossing);
        }
    }
    ring = kept;
}

// The same for a line, which is a ring of two corners, of which clipping would find each crossing twice. False: nothing is left.
template <double FaceCorner::* kAlong>
bool clip_line(FaceRing& ring, double sign, double limit) {
    FaceCorner &p = ring.corners[0], &q = ring.corners[1];
    const double from = sign * p.*kAlong - limit, to = sign * q.*kAlong - limit;
    if (from > 0 && to > 0) return false;
    const auto between = [](const FaceCorner& a, const FaceCorner& b, double share) {
        return FaceCorner{a.u + share * (b.u - a.u), a.v + share * (b.v - a.v), a.up + share * (b.up - a.up)};
    };
    if (from > 0) p = between(p, q, from / (from - to));
    if (to > 0) q = between(q, p, to / (to - from));
    return true;
}

// A point over a face, midway between the surfaces.
struct FacePoint {
    FaceCorner at;
    double gap_m;
};

// Of all points over a face with these half edges, those that reach farthest to its four corners, and the deepest one.
int keep_four(std::span<const FacePoint> all, double u_half, double v_half, std::array<int, kMaxManifoldPoints>& chosen) {
    int count = 0;
    if (all.size() <= kMaxManifoldPoints) {
        for (; count < static_cast<int>(all.size()); ++count) chosen[static_cast<std::size_t>(count)] = count;
        return count;
    }
    std::array<bool, 8> kept{};
    std::size_t deepest = 0;
    for (std::size_t i = 1; i < all.size(); ++i)
        if (all[i].gap_m < all[deepest].gap_m) deepest = i;
    constexpr double kClearly = 1e-3;
    double least = kNever;
    for (const auto& [u_sign, v_sign] : {std::pair(1, 1), std::pair(1, -1), std::pair(-1, -1), std::pair(-1, 1)}) {
        const double u_share = u_half > 0 ? u_sign / u_half : 0, v_share = v_half > 0 ? v_sign / v_half : 0;
        std::size_t best = 0;
        double farthest = -kNever;
        for (std::size_t i = 0; i < all.size(); ++i)
            if (const double far = u_share * all[i].at.u + v_share * all[i].at.v; far > farthest) best = i, farthest = far;
        kept[best] = true;
        least = std::min(least, all[best].gap_m);
    }
    if (all[deepest].gap_m < least - kClearly * std::abs(least) && !kept[deepest]) {
        std::size_t nearest = 0;
        double best = kNever;
        for (std::size_t i = 0; i < all.size(); ++i) {
            const FaceCorner &one = all[i].at, &other = all[deepest].at;
            const double away = length({one.u - other.u, one.v - other.v, one.up - other.up});
            if (kept[i] && away < best) nearest = i, best = away;
        }
        kept[nearest] = false, kept[deepest] = true;
    }
    for (std::size_t i = 0; i < all.size(); ++i)
        if (kept[i]) chosen[static_cast<std::size_t>(count++)] = static_cast<int>(i);
    return count;
}

// Two cores of which at least one is a box. Axes are those of the faces of a and of b, and the cross products of an edge of each.
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
          b_box_(kind_of(b) == CoreKind::Box),
          a_half_{a.half_m.x, a.half_m.y, a.half_m.z},
          b_half_{b.half_m.x, b.half_m.y, b.half_m.z} {}

    void collide(AxisHint& hint, Manifold& found);

  private:
    static constexpr int kFaces = 3, kEdges = 6;
    struct Separated {
        double by = -kNever;
        int axis = -1;
    };
    bool has_face(int axis) const { return axis < kFaces ? a_box_ : axis < kEdges && b_box_; }
    bool has_edges(int i, int j) const { return !alike_ && (a_box_ || i == 2) && (b_box_ || j == 2); }
    void compare_axes();
    // How far apart the shadows of the cores on an axis of faces are, without compare_axes.
    double apart_along(int axis) const;
    // The distance of a core from the box around the other one along its axes, given how far their shadows on these are apart.
    static double beyond_box(const double (&apart)[3]) {
        const double p = std::max(apart[0], 0.0), q = std::max(apart[1], 0.0), r = std::max(apart[2], 0.0);
        return std::sqrt(p * p + q * q + r * r);
    }
    // How far apart the cores' shadows on an axis are: a lower bound of their distance, and of their overlap the whole if nothing is less.
    double separation_of_face(int axis) const;
    // The best of the axes of edges that separate by more than `over`, or the first one that separates by more than `enough`.
    Separated separation_of_edges(double over, double enough) const;
    Vec3 direction(int axis) const;
    bool by_face(int axis, double separated, bool apart, Manifold& found) const;
    bool by_edges(const Separated& edges, bool apart, Manifold& found) const;
    LineEnds support_edges(int axis) const;
    void by_nearest(int edge_axis, Vec3 otherwise, Manifold& found) const;
    bool by_turns(Vec3 otherwise, Manifold& found) const;

    const Core &a_, &b_;
    const Pose &a_pose_, &b_pose_;
    Vec3 shift_;
    double reach_, radii_, least_ = 0;
    bool a_box_, b_box_, alike_ = false;
    double a_half_[3], b_half_[3];
    // The way from a to b along the axes of each, and the axes of b along those of a, and without signs.
    double a_shift_[3], b_shift_[3], turn_[3][3], size_[3][3];
};

void Boxes::compare_axes() {
    alike_ = a_box_ && b_box_;
    for (std::size_t i = 0; i < 3; ++i) {
        a_shift_[i] = dot(shift_, a_pose_.axes[i]), b_shift_[i] = dot(shift_, b_pose_.axes[i]);
        for (std::size_t j = 0; j < 3; ++j) {
            turn_[i][j] = dot(a_pose_.axes[i], b_pose_.axes[j]);
            size_[i][j] = std::abs(turn_[i][j]);
            alike_ = alike_ && (size_[i][j] < kAlike || size_[i][j] > 0.5);
        }
    }
    least_ = kNever;
    if (a_box_) least_ = std::min({a_half_[0], a_half_[1], a_half_[2]});
    if (b_box_) least_ = std::min({least_, b_half_[0], b_half_[1], b_half_[2]});
}

double Boxes::apart_along(int axis) const {
    const Vec3 along = axis < kFaces ? a_pose_.axes[static_cast<std::size_t>(axis)] : b_pose_.axes[static_cast<std::size_t>(axis - kFaces)];
    const auto shadow = [&](const Core& core, const Pose& pose) {
        return core.half_m.x * std::abs(dot(along, pose.axes[0])) + core.half_m.y * std::abs(dot(along, pose.axes[1])) +
               core.half_m.z * std::abs(dot(along, pose.axes[2]));
    };
    return std::abs(dot(along, shift_)) - shadow(a_, a_pose_) - shadow(b_, b_pose_);
}

double Boxes::separation_of_face(int axis) const {
    if (axis < kFaces) {
        const auto& row = size_[axis];
        return std::abs(a_shift_[axis]) - a_half_[axis] - (b_half_[0] * row[0] + b_half_[1] * row[1] + b_half_[2] * row[2]);
    }
    const int j = axis - kFaces;
    return std::abs(b_shift_[j]) - b_half_[j] - (a_half_[0] * size_[0][j] + a_half_[1] * size_[1][j] + a_half_[2] * size_[2][j]);
}

Boxes::Separated Boxes::separation_of_edges(double over, double enough) const {
    constexpr double kParallel = 1e-6;
    Separated best{over, -1};
    for (int i = 0; i < 3; ++i)
        for (int j = 0; j < 3; ++j) {
            if (!has_edges(i, j)) continue;
            const int i1 = (i + 1) % 3, i2 = (i + 2) % 3, j1 = (j + 1) % 3, j2 = (j + 2) % 3;
            const double square = 1 - turn_[i][j] * turn_[i][j];
            const double shift = std::abs(a_shift_[i2] * turn_[i1][j] - a_shift_[i1] * turn_[i2][j]);
            const double of_a = a_half_[i1] * size_[i2][j] + a_half_[i2] * size_[i1][j];
            const double of_b = b_half_[j1] * size_[i][j2] + b_half_[j2] * size_[i][j1];
            // By how much, times the length of the cross product, which is at most 1.
            const double apart = shift - of_a - of_b;
            if (square < kParallel || (apart <= 0 && apart <= best.by)) continue;
            const double by = apart / std::sqrt(square);
            if (by > best.by) best = {by, kEdges + 3 * i + j};
            if (by > enough) return best;
        }
    return best;
}

// A unit vector from the first body to the second.
Vec3 Boxes::direction(int axis) const {
    if (axis < kFaces) {
        const Vec3 along = a_pose_.axes[static_cast<std::size_t>(axis)];
        return a_shift_[axis] < 0 ? -along : along;
    }
    if (axis < kEdges) {
        const Vec3 along = b_pose_.axes[static_cast<std::size_t>(axis - kFaces)];
        return b_shift_[axis - kFaces] < 0 ? -along : along;
    }
    const Vec3 along =
        cross(a_pose_.axes[static_cast<std::size_t>((axis - kEdges) / 3)], b_pose_.axes[static_cast<std::size_t>((axis - kEdges) % 3)]);
    return (dot(along, shift_) < 0 ? -1 : 1) / length(along) * along;
}

// Clips the face of the other core against the sides of this one. False if it lies beside this face, so that an edge or a corner is
// nearer.
bool Boxes::by_face(int axis, double separated, bool apart, Manifold& found) const {
    const bool of_a = axis < kFaces;
    const Core& other = of_a ? b_ : a_;
    const Pose& own_pose = of_a ? a_pose_ : b_pose_;
    const int up = of_a ? axis : axis - kFaces, first = (up + 1) % 3, second = (up + 2) % 3;
    const double *own_half = of_a ? a_half_ : b_half_, *other_half = of_a ? b_half_ : a_half_;
    // The other core's axis j along this one's axis i.
    const auto turn = [&](int i, int j) { return of_a ? turn_[i][j] : turn_[j][i]; };
    // In this core's frame.
    const auto towards = [&](int i) { return of_a ? a_shift_[i] : -b_shift_[i]; };
    const double sign = towards(up) < 0 || (!of_a && towards(up) == 0) ? -1 : 1;
    const auto edge = [&](int j) {
        return FaceCorner{other_half[j] * turn(first, j), other_half[j] * turn(second, j), other_half[j] * turn(up, j)};
    };
    const auto corner = [&](double out_sign, FaceCorner out, double p_sign, FaceCorner p, double q_sign, FaceCorner q) {
        return FaceCorner{towards(first) + out_sign * out.u + p_sign * p.u + q_sign * q.u,
                          towards(second) + out_sign * out.v + p_sign * p.v + q_sign * q.v,
                          towards(up) + out_sign * out.up + p_sign * p.up + q_sign * q.up};
    };
    FaceRing ring;
    bool flat;
    if (!(of_a ? b_box_ : a_box_)) {
        const FaceCorner z = edge(2);
        ring.push(corner(1, z, 0, z, 0, z)), ring.push(corner(-1, z, 0, z, 0, z));
        flat = std::abs(turn(up, 2)) < kSlant;
        if (!clip_line<&FaceCorner::u>(ring, 1, own_half[first]) || !clip_line<&FaceCorner::u>(ring, -1, own_half[first]) ||
            !clip_line<&FaceCorner::v>(ring, 1, own_half[second]) || !clip_line<&FaceCorner::v>(ring, -1, own_half[second]))
            return false;
    } else {
        // The face that looks most back.
        int facing = 0;
        for (int j = 1; j < 3; ++j)
            if (std::abs(turn(up, j)) > std::abs(turn(up, facing))) facing = j;
        flat = std::abs(turn(up, facing)) > kFlat;
        const double back = sign * turn(up, facing) > 0 ? -1 : 1;
        const FaceCorner out = edge(facing), p = edge((facing + 1) % 3), q = edge((facing + 2) % 3);
        ring.push(corner(back, out, 1, p, 1, q)), ring.push(corner(back, out, -1, p, 1, q));
        ring.push(corner(back, out, -1, p, -1, q)), ring.push(corner(back, out, 1, p, -1, q));
        clip_face<&FaceCorner::u>(ring, 1, own_half[first]), clip_face<&FaceCorner::u>(ring, -1, own_half[first]);
        clip_face<&FaceCorner::v>(ring, 1, own_half[second]), clip_face<&FaceCorner::v>(ring, -1, own_half[second]);
    }
    std::array<FacePoint, 8> points;
    std::size_t count = 0;
    double nearest = kNever;
    for (FaceCorner at : ring.all()) {
        const double above = sign * at.up - own_half[up], gap = above - radii_;
        nearest = std::min(nearest, above);
        if (gap > reach_) continue;
        at.up -= sign * (other.radius_m + 0.5 * gap);
        points[count++] = {at, gap};
    }
    if (ring.count == 0 || (apart && nearest > separated + kOverFace * least_ && !flat)) return false;
    found.normal = direction(axis);
    std::array<int, kMaxManifoldPoints> chosen;
    found.count = keep_four(std::span(points).first(count), own_half[first], own_half[second], chosen);
    for (std::size_t k = 0; k < static_cast<std::size_t>(found.count); ++k) {
        const FacePoint& point = points[static_cast<std::size_t>(chosen[k])];
        const Vec3 at =
            point.at.u * own_pose.axes[static_cast<std::size_t>(first)] +
            (point.at.v * own_pose.axes[static_cast<std::size_t>(second)] + point.at.up * own_pose.axes[static_cast<std::size_t>(up)]);
        found.points[k] = {of_a ? at : shift_ + at, point.gap_m};
    }
    return true;
}

LineEnds Boxes::support_edges(int axis) const {
    const int i = (axis - kEdges) / 3, j = (axis - kEdges) % 3;
    const Vec3 normal = direction(axis);
    Vec3 p, q = shift_;
    for (int k = 0; k < 3; ++k) {
        const Vec3 &a = a_pose_.axes[static_cast<std::size_t>(k)], &b = b_pose_.axes[static_cast<std::size_t>(k)];
        if (k != i) p = p + (dot(a, normal) < 0 ? -a_half_[k] : a_half_[k]) * a;
        if (k != j) q = q + (dot(b, normal) < 0 ? b_half_[k] : -b_half_[k]) * b;
    }
    return nearest_of_lines(p, a_pose_.axes[static_cast<std::size_t>(i)], a_half_[i], q, b_pose_.axes[static_cast<std::size_t>(j)],
                            b_half_[j]);
}

bool Boxes::by_edges(const Separated& edges, bool apart, Manifold& found) const {
    const LineEnds ends = support_edges(edges.axis);
    if (apart && length(ends.q - ends.p) > edges.by + kOverFace * least_) return false;
    found.normal = direction(edges.axis);
    const double gap = edges.by - radii_;
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
    // No points: the shadows on an axis of a face are this far apart, and that axis, or none, is tried first the next time.
    const auto are_apart = [&](double faces_m, AxisHint axis) { found.apart_m = faces_m - radii_, hint = axis; };
    const auto first_next = [](int axis) { return static_cast<AxisHint>(axis | kApartAxis); };
    // Clearly farther, so that the comparison of all axes would find it too.
    constexpr double kClearly = 1 + 1e-9;
    if (const int last = hint & ~kApartAxis; has_face(last))
        if (const double apart = apart_along(last); apart > kClearly * farthest) return are_apart(apart, first_next(last));
    compare_axes();
    double of_faces[2][3] = {{-kNever, -kNever, -kNever}, {-kNever, -kNever, -kNever}}, face = -kNever;
    int face_axis = 0;
    for (int axis = 0; axis < kEdges; ++axis) {
        if (!has_face(axis)) continue;
        const double apart = of_faces[axis / 3][axis % 3] = separation_of_face(axis);
        if (apart > farthest) return are_apart(apart, first_next(axis));
        if (apart > face) face = apart, face_axis = axis;
        if (axis % 3 == 2 && beyond_box(of_faces[axis / 3]) > farthest) return are_apart(face, kNoAxis);
    }
    const Separated edges = separation_of_edges(face, farthest);
    if (edges.by > farthest) return are_apart(face, kNoAxis);
    const double better = kBetterAxis * least_;
    if (has_face(hint) && of_faces[hint / 3][hint % 3] >= face - better) face_axis = hint;
    const bool by_edge = edges.axis >= 0 && edges.by > face + better && std::abs(dot(direction(edges.axis), direction(face_axis))) < kFlat;
    const int axis = by_edge ? edges.axis : face_axis;
    hint = static_cast<AxisHint>(axis);
    const bool disjoint = std::max(face, edges.by) > kApart * least_;
    if (!(by_edge ? by_edges(edges, disjoint, found) : by_face(axis, of_faces[axis / 3][axis % 3], disjoint, found))) {
        // Of cores that overlap beside the face that is nearest, the deepest point of the other core stands for all.
        if (!disjoint || !by_turns(direction(axis), found)) {
            const Separated best = separation_of_edges(-kNever, kNever);
            if (disjoint)
                by_nearest(best.axis, direction(axis), found);
            else if (best.axis >= 0)
                by_edges(best, false, found);
        }
    }
    if (found.count == 0) are_apart(face, kNoAxis);
}

}  // namespace

void collide_boxes(const Core& a, const Pose& a_pose, const Core& b, const Pose& b_pose, double reach_m, AxisHint& hint, Manifold& found) {
    Boxes(a, a_pose, b, b_pose, reach_m).collide(hint, found);
}

}  // namespace meld::physics
