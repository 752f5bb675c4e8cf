// The nearest points of two convex cores, from nothing but the points that reach farthest along directions.
#pragma once

#include "physics/collision/core_geometry.h"

namespace meld::physics {

// A core in its place, seen from the centre of the first body of a pair. Of a triangle, `axes` are its corners, seen from its own centre.
struct PlacedCore {
    CoreKind kind;
    Vec3 half_m, centre;
    const std::array<Vec3, 3>* axes;

    // The point that reaches farthest along a direction of any length.
    Vec3 support(Vec3 direction) const;
    // The same core with all faces moved inwards; lines and points stay.
    PlacedCore shrunk(double by_m) const;
};

// How far two cores are apart along a unit vector, which points from a to b; negative: they overlap.
inline double separation(const PlacedCore& a, const PlacedCore& b, Vec3 direction) {
    return dot(direction, b.support(-direction) - a.support(direction));
}

enum class Nearness { Apart, Far, Overlapping };
// E. Gilbert, D. Johnson, S. Keerthi: "A fast procedure for computing the distance between complex objects in three-dimensional space",
// 1988. Far: they are farther apart than `farthest_m`, and `ends` says nothing. Cost: below three microseconds.
Nearness nearest_of_cores(const PlacedCore& a, const PlacedCore& b, double farthest_m, LineEnds& ends);

// The direction along which two cores that overlap do so least, from a to b, found by trying directions around `start`.
Vec3 least_overlap(const PlacedCore& a, const PlacedCore& b, Vec3 start);

}  // namespace meld::physics
