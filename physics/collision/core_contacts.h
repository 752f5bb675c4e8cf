// Where two rounded shapes touch, or a shape and a plane: one normal and up to four points, from the shapes' cores.
//
// Flat faces are clipped against each other, so a box or a cylinder stands on four points and a capsule lies on two. Where the cores are
// apart and an edge or a corner comes nearest, the points are exactly the nearest ones.
#pragma once

#include <array>
#include <cstdint>

#include "physics/bodies/body_shape.h"
#include "physics/bodies/types.h"

namespace meld::physics {

// The core of a shape (bodies/body_shape.h) and how far its surface is from it.
struct Core {
    Vec3 half_m = {};
    double radius_m = 0;
};

// The place of a body, and the unit axes of its frame as seen from the world.
struct Pose {
    Vec3 centre;
    std::array<Vec3, 3> axes;
};
Pose pose_of(Vec3 centre, Quat turn);

// One of the solids of a shape, and where it is; of a shape that is no compound, the body itself.
struct PlacedSolid {
    Core core;
    Pose pose;
};
PlacedSolid solid_of(const BodyShape& shape, const Pose& body, std::size_t part);
Pose pose_of_part(const ShapePart& part, const Pose& body);
inline Vec3 centre_of(const ShapePart& part, const Pose& body) {
    return body.centre + (part.at_m.x * body.axes[0] + part.at_m.y * body.axes[1] + part.at_m.z * body.axes[2]);
}

inline constexpr int kMaxManifoldPoints = 4;

struct ManifoldPoint {
    // Midway between the two surfaces, from the centre of the first body.
    Vec3 at;
    // Between the surfaces along the normal; negative: they overlap.
    double gap_m;
};

struct Manifold {
    // From the first body to the second.
    Vec3 normal;
    int count = 0;
    // Points on the rim of a cap that stands on something: they may be elsewhere on it than before, and carry the same.
    bool on_rim = false;
    // Without points: how far apart the surfaces are found to be, perhaps along one axis of a face. They have no points as long as this,
    // less the ways that points of one body go as the other one sees them, is above the reach. 0: not known.
    double apart_m = 0;
    std::array<ManifoldPoint, kMaxManifoldPoints> points;
};

// Along which axis two boxes, or a box and a line, touched the last time: it is kept while another is hardly better. Of a cylinder, where
// on its rim the points are that it stands on: they stay while they hardly differ from the lowest ones.
//
// With kApartAxis it is one that kept two boxes apart. It is tried first and never changes what is found. So it need not be saved, and it
// does not matter whether bodies that are far apart were compared at all.
using AxisHint = std::uint8_t;
inline constexpr AxisHint kApartAxis = 0x80, kNoAxis = 0xff;
constexpr AxisHint lasting(AxisHint hint) { return (hint & kApartAxis) != 0 ? kNoAxis : hint; }

// The points of two bodies nearer to each other than `reach_m`, none if they are farther apart. Cost: 20 ns for two boxes that `hint`
// shows to be apart, below a microsecond for two faces.
void collide(const Core& a, const Pose& a_pose, const Core& b, const Pose& b_pose, double reach_m, AxisHint& hint, Manifold& found);

// The same with the half space of points where dot(normal, p) <= offset_m.
void collide_with_plane(const Core& a, const Pose& a_pose, Vec3 normal, double offset_m, double reach_m, AxisHint& hint, Manifold& found);

// Whether two bodies are nearer to each other than `within_m`.
struct Attitude {
    Vec3 centre;
    Quat turn;
};
bool nearer(const BodyShape& a, const Attitude& a_place, const BodyShape& b, const Attitude& b_place, double within_m);

}  // namespace meld::physics
