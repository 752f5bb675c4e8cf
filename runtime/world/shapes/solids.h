// The solids of which shapes are composed. Each is centred on the origin unless it says otherwise; flat ends and faces are half open (low
// <= p < high), so that box(n, n, n) contains exactly n cells along each axis of a cubic lattice.
//
// contains(s, p): whether the point is in the solid.
// distance(s, p): below zero inside, above zero outside, zero on the surface; it changes by no more than one per unit of
//   way, so a ball around p of a smaller radius than |distance| does not reach the surface. For most solids it is the
//   distance to the surface itself; for a gyroid and a trumpet it is less.
// bounds(s): a box that contains the solid.
// Lengths are in catom diameters. All functions are deterministic and may be called by any thread.
#pragma once

#include "runtime/world/shapes/shape.h"

namespace meld::world {

struct BoxSolid {
    Vec3 half;
};

struct Ball {
    double radius;
};

struct Ellipsoid {
    Vec3 radius;
};

// A ring in the plane z = 0: a tube of radius `small` around a circle of radius `large`.
struct Torus {
    double large, small;
};

// Along z, height 2 * half.
struct Cylinder {
    double radius, half;
};

// Along z: radius `low` at z = -half, `high` at z = half.
struct Cone {
    double low, high, half;
};

// A tube of radius `tube` around (radius cos a, radius sin a, pitch a / 2 pi), cut flat at z = -half and half.
struct Helix {
    double radius, rise, half, tube;  // rise: pitch / 2 pi.
};

// The sheet |sin kx cos ky + sin ky cos kz + sin kz cos kx| <= limit in a cube. `limit` is sqrt(3) k thickness / 2: the sheet is at least
// as thick as requested, and at most half as thick again.
struct Gyroid {
    double half, wave, limit;
};

// A horn along x from its stem at the origin, x = 0, to the bell at x = length. At distance rho from the axis it contains the points with
// |rho - R(x)| <= (wall / 2) sqrt(1 + R'(x)^2), where R(x) = wall / 2 + (bell - wall) (e^(4x/length) - 1) / (e^4 - 1). So the wall is about
// `wall` thick, the stem is solid at its beginning, and the rim's radius is about `bell`. A wall of two diameters is connected on each
// lattice, also in the plane, where the horn is cut along its axis.
struct Trumpet {
    double length, bell, wall;
};
inline constexpr double kTrumpetFlare = 4;

bool contains(const BoxSolid& s, const Vec3& p);
bool contains(const Ball& s, const Vec3& p);
bool contains(const Ellipsoid& s, const Vec3& p);
bool contains(const Torus& s, const Vec3& p);
bool contains(const Cylinder& s, const Vec3& p);
bool contains(const Cone& s, const Vec3& p);
bool contains(const Helix& s, const Vec3& p);
bool contains(const Gyroid& s, const Vec3& p);
bool contains(const Trumpet& s, const Vec3& p);

double distance(const BoxSolid& s, const Vec3& p);
double distance(const Ball& s, const Vec3& p);
double distance(const Ellipsoid& s, const Vec3& p);
double distance(const Torus& s, const Vec3& p);
double distance(const Cylinder& s, const Vec3& p);
double distance(const Cone& s, const Vec3& p);
double distance(const Helix& s, const Vec3& p);
double distance(const Gyroid& s, const Vec3& p);
double distance(const Trumpet& s, const Vec3& p);

Box bounds(const BoxSolid& s);
Box bounds(const Ball& s);
Box bounds(const Ellipsoid& s);
Box bounds(const Torus& s);
Box bounds(const Cylinder& s);
Box bounds(const Cone& s);
Box bounds(const Helix& s);
Box bounds(const Gyroid& s);
Box bounds(const Trumpet& s);

}  // namespace meld::world
