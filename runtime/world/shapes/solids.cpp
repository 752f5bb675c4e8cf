// Formulas of the solids. Distances of box, torus, cylinder and cone are the usual ones; those of ellipsoid and helix are found by Newton's
// method on a function that is convex in the search interval, so it always converges.
#include "runtime/world/shapes/solids.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace meld::world {
namespace {

constexpr int kNewtonSteps = 60;

double square(double v) { return v * v; }
double length(double a, double b) { return std::sqrt(a * a + b * b); }
double length(double a, double b, double c) { return std::sqrt(a * a + b * b + c * c); }
double around_z(const Vec3& p) { return length(p[0], p[1]); }
Box symmetric(Vec3 half) { return {{-half[0], -half[1], -half[2]}, half}; }

// The distance to a rectangle or a straight prism, given the distances beyond two of its perpendicular walls.
double beyond(double a, double b) { return std::min(std::max(a, b), 0.0) + length(std::max(a, 0.0), std::max(b, 0.0)); }

bool between(double value, double half) { return value >= -half && value < half; }

}  // namespace

bool contains(const BoxSolid& s, const Vec3& p) { return between(p[0], s.half[0]) && between(p[1], s.half[1]) && between(p[2], s.half[2]); }

double distance(const BoxSolid& s, const Vec3& p) {
    const double x = std::abs(p[0]) - s.half[0], y = std::abs(p[1]) - s.half[1], z = std::abs(p[2]) - s.half[2];
    return std::min(std::max({x, y, z}), 0.0) + length(std::max(x, 0.0), std::max(y, 0.0), std::max(z, 0.0));
}

Box bounds(const BoxSolid& s) { return symmetric(s.half); }

bool contains(const Ball& s, const Vec3& p) { return p[0] * p[0] + p[1] * p[1] + p[2] * p[2] <= s.radius * s.radius; }
double distance(const Ball& s, const Vec3& p) { return length(p[0], p[1], p[2]) - s.radius; }
Box bounds(const Ball& s) { return symmetric({s.radius, s.radius, s.radius}); }

bool contains(const Ellipsoid& s, const Vec3& p) {
    return square(p[0] / s.radius[0]) + square(p[1] / s.radius[1]) + square(p[2] / s.radius[2]) <= 1;
}

// The nearest point of the surface is (a^2 x / (t + a^2), ...) for the root t of g(t) = sum (a x / (t + a^2))^2 - 1 right of
// -min(a)^2, where g falls and is convex: Newton from the left climbs towards the root (D. Eberly, "Distance from a point to
// an ellipse, an ellipsoid, or a hyperellipsoid", 2013).
double distance(const Ellipsoid& s, const Vec3& p) {
    const std::size_t shortest = static_cast<std::size_t>(std::min_element(s.radius.begin(), s.radius.end()) - s.radius.begin());
    const double least = square(s.radius[shortest]);
    // In the plane across the shortest axis there is no root; slightly off the plane there is one, slightly away.
    Vec3 q = {std::abs(p[0]), std::abs(p[1]), std::abs(p[2])};
    q[shortest] = std::max(q[shortest], 1e-9 * s.radius[shortest]);
    double t = 0;
    for (std::size_t i = 0; i < 3; ++i) t = std::max(t, s.radius[i] * q[i] - square(s.radius[i]) + least);
    t -= least;
    for (int step = 0; step < kNewtonSteps; ++step) {
        double g = -1, slope = 0;
        for (std::size_t i = 0; i < 3; ++i) {
            const double term = square(s.radius[i] * q[i] / (t + square(s.radius[i])));
            g += term;
            slope -= 2 * term / (t + square(s.radius[i]));
        }
        const double next = t - g / slope;
        if (!(next > t)) break;
        t = next;
    }
    Vec3 away;
    for (std::size_t i = 0; i < 3; ++i) away[i] = q[i] * t / (t + square(s.radius[i]));
    return std::copysign(length(away[0], away[1], away[2]), t);
}

Box bounds(const Ellipsoid& s) { return symmetric(s.radius); }

bool contains(const Torus& s, const Vec3& p) { return square(around_z(p) - s.large) + square(p[2]) <= square(s.small); }
double distance(const Torus& s, const Vec3& p) { return length(around_z(p) - s.large, p[2]) - s.small; }
Box bounds(const Torus& s) { return symmetric({s.large + s.small, s.large + s.small, s.small}); }

bool contains(const Cylinder& s, const Vec3& p) { return between(p[2], s.half) && square(p[0]) + square(p[1]) <= square(s.radius); }
double distance(const Cylinder& s, const Vec3& p) { return beyond(around_z(p) - s.radius, std::abs(p[2]) - s.half); }
Box bounds(const Cylinder& s) { return symmetric({s.radius, s.radius, s.half}); }

bool contains(const Cone& s, const Vec3& p) {
    return between(p[2], s.half) && around_z(p) <= s.low + (s.high - s.low) * (p[2] + s.half) / (2 * s.half);
}

// In the plane of the axis and the point the cone is half a trapezium: the nearest of its slanted side and its two ends.
double distance(const Cone& s, const Vec3& p) {
    const double rho = around_z(p);
    const double end = length(std::max(rho - (p[2] < 0 ? s.low : s.high), 0.0), std::abs(p[2]) - s.half);
    const double wide = s.high - s.low, tall = 2 * s.half;
    const double along = std::clamp(((rho - s.low) * wide + (p[2] + s.half) * tall) / (wide * wide + tall * tall), 0.0, 1.0);
    const double side = length(rho - s.low - along * wide, p[2] + s.half - along * tall);
    const bool inside = std::abs(p[2]) < s.half && rho < s.low + wide * (p[2] + s.half) / tall;
    return inside ? -std::min(side, end) : std::min(side, end);
}

Box bounds(const Cone& s) {
    const double radius = std::max(s.low, s.high);
    return symmetric({radius, radius, s.half});
}

bool contains(const Helix& s, const Vec3& p) { return between(p[2], s.half) && distance(s, p) <= 0; }

// Half the derivative of the squared distance to the curve, at angle x from the point's own height, is
// f(x) = r rho sin(x - turn) + rise^2 x, where `turn` in [0, pi] (by symmetry) is the angle from there to the point's
// direction. The nearest point lies in [0, turn], where f is convex and goes from below zero to above: Newton from the
// right comes down to the root. The ends are cut flat, so the curve may be taken to be endless.
double distance(const Helix& s, const Vec3& p) {
    const double rho = around_z(p);
    const double turn = std::abs(std::remainder(std::atan2(p[1], p[0]) - p[2] / s.rise, 2 * std::numbers::pi));
    const double pull = s.radius * rho, rise_squared = square(s.rise);
    double x = turn;
    for (int step = 0; step < kNewtonSteps; ++step) {
        const double slope = pull * std::cos(x - turn) + rise_squared;
        const double next = x - (pull * std::sin(x - turn) + rise_squared * x) / slope;
        if (!(next < x) || !(slope > 0)) break;
        x = std::max(next, 0.0);
    }
    const double across = rho * rho + s.radius * s.radius - 2 * pull * std::cos(x - turn);
    const double to_curve = std::sqrt(std::max(across, 0.0) + rise_squared * x * x);
    return std::max(to_curve - s.tube, std::abs(p[2]) - s.half);
}

Box bounds(const Helix& s) { return symmetric({s.radius + s.tube, s.radius + s.tube, s.half}); }

namespace {

double gyroid_level(const Gyroid& s, const Vec3& p) {
    const double x = s.wave * p[0], y = s.wave * p[1], z = s.wave * p[2];
    return std::abs(std::sin(x) * std::cos(y) + std::sin(y) * std::cos(z) + std::sin(z) * std::cos(x));
}

}  // namespace

bool contains(const Gyroid& s, const Vec3& p) { return contains(BoxSolid{{s.half, s.half, s.half}}, p) && gyroid_level(s, p) <= s.limit; }

// No partial derivative of the level exceeds the wave number, so its gradient is at most sqrt(3) times that.
double distance(const Gyroid& s, const Vec3& p) {
    return std::max((gyroid_level(s, p) - s.limit) / (std::numbers::sqrt3 * s.wave), distance(BoxSolid{{s.half, s.half, s.half}}, p));
}

Box bounds(const Gyroid& s) { return symmetric({s.half, s.half, s.half}); }

namespace {

// The middle of the wall and its slope at x.
struct Flare {
    double radius, slope;
};

Flare flare(const Trumpet& s, double x) {
    const double grown = std::exp(kTrumpetFlare * x / s.length);
    const double scale = (s.bell - s.wall) / (std::exp(kTrumpetFlare) - 1);
    return {s.wall / 2 + scale * (grown - 1), scale * grown * kTrumpetFlare / s.length};
}

// The distance of a point from the wall's surfaces, measured perpendicularly to the axis.
double from_wall(const Trumpet& s, const Vec3& p) {
    const Flare middle = flare(s, std::clamp(p[0], 0.0, s.length));
    return std::abs(length(p[1], p[2]) - middle.radius) - s.wall / 2 * std::sqrt(1 + square(middle.slope));
}

}  // namespace

bool contains(const Trumpet& s, const Vec3& p) { return p[0] >= 0 && p[0] < s.length && from_wall(s, p) <= 0; }

// Along x, from_wall changes by at most R' + (wall / 2) R'', both greatest at the rim, where R'' is 4 R' / length.
double distance(const Trumpet& s, const Vec3& p) {
    const double slope = flare(s, s.length).slope;
    const double steepest = slope * (1 + s.wall / 2 * kTrumpetFlare / s.length);
    return std::max({from_wall(s, p) / std::sqrt(1 + square(steepest)), -p[0], p[0] - s.length});
}

Box bounds(const Trumpet& s) {
    const Flare rim = flare(s, s.length);
    const double radius = rim.radius + s.wall / 2 * std::sqrt(1 + square(rim.slope));
    return {{0, -radius, -radius}, {s.length, radius, radius}};
}

}  // namespace meld::world
