// Where bodies with shapes are and how easily they are turned, and how far they have gone since their contacts were listed.
#include <algorithm>
#include <cmath>

#include "physics/solver/shapes/shape_contacts.h"
#include "runtime/base/assert.h"

namespace meld::physics {

namespace {

constexpr std::size_t kTurnedPerJob = 4096;
// The distances that motions are told for, in radii of the greatest body: of a point from the centre of another body, and, as a share of
// that, of two centres.
constexpr double kFarthestInRadii = 3.6, kFarthestCentres = 2.6 / 3.6;

}  // namespace

void ShapeContacts::turn(const Setup& setup, std::uint32_t first, std::uint32_t count) {
    for (std::uint32_t slot = first; slot < first + count; ++slot) {
        const Pose before = poses_[slot];
        turn_body(setup, slot);
        note_motion(setup, slot, before);
    }
}

void ShapeContacts::turn_body(const Setup& setup, std::uint32_t slot) {
    const Bodies& bodies = setup.bodies;
    const BodyProperties& what = bodies.properties[slot];
    Turning& turning = turnings_[slot];
    const Quat turn = widened(bodies.orientation[slot]);
    poses_[slot] = pose_of(centre_of(bodies.place[slot]), turn);
    const BodyShapes::Index index = (what.flags & kShaped) == 0 ? BodyShapes::Index{0} : setup.shapes.of(what.id);
    const BodyShapes::Kind* const kind = index == 0 ? nullptr : &setup.shapes.kind(index);
    if (kind == nullptr || kind->turns_alike) {
        const float all = static_cast<float>(kind == nullptr ? 1 / static_cast<double>(what.inertia_factor) : kind->turning.x);
        turning = {.entries = {all, 0, 0, all, 0, all, 0, 0}};
        return;
    }
    const Vec3 t = kind->turning;
    std::array<Vec3, 3> axes = poses_[slot].axes;
    if (kind->has_other_axes) axes = pose_of({}, kind->principal(turn)).axes;
    Symmetric sum;
    const double weights[3] = {t.x, t.y, t.z};
    for (std::size_t k = 0; k < 3; ++k) {
        const Vec3 axis = axes[k];
        const Vec3 weighted = weights[k] * axis;
        sum +=
            {weighted.x * axis.x, weighted.x * axis.y, weighted.x * axis.z, weighted.y * axis.y, weighted.y * axis.z, weighted.z * axis.z};
    }
    const double entries[] = {sum.xx, sum.xy, sum.xz, sum.yy, sum.yz, sum.zz};
    for (int k = 0; k < 6; ++k) turning.entries[k] = static_cast<float>(entries[k]);
    turning.entries[6] = turning.entries[7] = 0;
}

void ShapeContacts::turn_all(const Setup& setup, Workers& workers) {
    const std::size_t count = setup.bodies.count(), with_motionless = setup.bodies.velocity.size();
    MELD_EXPECT(with_motionless >= count, "{} of {} entries", with_motionless, count);
    turnings_.assign(with_motionless, Turning{});
    poses_.resize(count);
    moved_m_.resize(count);
    // Of points of another body, as long as the two are compared again before they have come nearer by as much as they were apart.
    double greatest = 0;
    for (std::size_t slot = 0; slot < count; ++slot) greatest = std::max(greatest, setup.bodies.place[slot].radius);
    farthest_m_ = kFarthestInRadii * greatest;
    workers.run((count + kTurnedPerJob - 1) / kTurnedPerJob, [&](int, std::size_t job) {
        const std::size_t begin = job * kTurnedPerJob;
        for (std::size_t slot = begin; slot < std::min(count, begin + kTurnedPerJob); ++slot) {
            turn_body(setup, static_cast<std::uint32_t>(slot));
            moved_m_[slot] = 0;
        }
    });
}

// A point is its body's centre and shares of its axes, whose squares together are at most the square of its distance. So it goes no
// farther than the centre and the root of the sum of the squares of what the axes change by, times the distance. A solid of a compound is
// also moved as the body turns.
void ShapeContacts::note_motion(const Setup& setup, std::uint32_t slot, const Pose& before) {
    const Pose& now = poses_[slot];
    double turned = 0;
    for (std::size_t k = 0; k < 3; ++k) {
        const Vec3 change = now.axes[k] - before.axes[k];
        turned += dot(change, change);
    }
    const BodyShapes::Index index = setup.shapes.of(setup.bodies.properties[slot].id);
    const bool compound = index != 0 && setup.shapes.kind(index).shape.is_compound();
    const double distance_m = farthest_m_ + (compound ? setup.bodies.place[slot].radius : 0);
    moved_m_[slot] += length(now.centre - before.centre) + std::sqrt(turned) * distance_m;
}

// As a body sees it, points of the other one that are not farther than `farthest_m_` from its centre go as far as both bodies' sums say.
float ShapeContacts::apart_until(std::uint32_t a, std::uint32_t b, const Manifold& found) const {
    constexpr double kRounding = 1e-6;
    const double between = length(poses_[b].centre - poses_[a].centre), sum = moved_m_[a] + moved_m_[b];
    const double apart = std::min(found.apart_m, kFarthestCentres * farthest_m_ - between);
    return static_cast<float>(apart + sum - kRounding * (farthest_m_ + sum));
}

// Clearly, so that a comparison of the bodies would find it too.
bool ShapeContacts::spheres_are_apart(const Bodies& bodies, std::uint32_t a, std::uint32_t b, double reach_m) {
    constexpr double kClearly = 1 + 1e-9;
    const Place &one = bodies.place[a], &other = bodies.place[b];
    const double x = other.x - one.x, y = other.y - one.y, z = other.z - one.z;
    const double reach = kClearly * (one.radius + other.radius + reach_m);
    return x * x + y * y + z * z > reach * reach;
}

// What latches hold, what composites move, and where an obstacle that moves is touched is found anew in each step.
bool ShapeContacts::are_same(const Setup& setup, const ShapeBatch& batch, int i, const ShapeLane& lane, double ahead_m) const {
    if (lane.obstacle != kNoSlot && setup.obstacles.moves(lane.obstacle)) return false;
    return lane.points != 0 && static_cast<double>(batch.same_m[i]) >= ahead_m && batch.moved == kNoSlot && held_.empty();
}

}  // namespace meld::physics
