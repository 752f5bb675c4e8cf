// Vectors, rotations and body ids of the physics interface: double precision, SI units.
#pragma once

#include <cmath>
#include <cstdint>

namespace meld::physics {

struct Vec3 {
    double x = 0, y = 0, z = 0;
    bool operator==(const Vec3&) const = default;
};

constexpr Vec3 operator+(Vec3 a, Vec3 b) { return {a.x + b.x, a.y + b.y, a.z + b.z}; }
constexpr Vec3 operator-(Vec3 a, Vec3 b) { return {a.x - b.x, a.y - b.y, a.z - b.z}; }
constexpr Vec3 operator-(Vec3 a) { return {-a.x, -a.y, -a.z}; }
constexpr Vec3 operator*(double s, Vec3 a) { return {s * a.x, s * a.y, s * a.z}; }
constexpr double dot(Vec3 a, Vec3 b) { return a.x * b.x + a.y * b.y + a.z * b.z; }
constexpr Vec3 cross(Vec3 a, Vec3 b) { return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x}; }
inline double length(Vec3 a) { return std::sqrt(dot(a, a)); }
inline bool is_finite(Vec3 a) { return std::isfinite(a.x) && std::isfinite(a.y) && std::isfinite(a.z); }

// A unit quaternion: the rotation from the body's frame to the world's.
struct Quat {
    double w = 1, x = 0, y = 0, z = 0;
    bool operator==(const Quat&) const = default;
};

// v turned by q.
constexpr Vec3 rotate(Quat q, Vec3 v) {
    const Vec3 axis{q.x, q.y, q.z};
    const Vec3 t = 2 * cross(axis, v);
    return v + q.w * t + cross(axis, t);
}
constexpr Quat conjugate(Quat q) { return {q.w, -q.x, -q.y, -q.z}; }

// The caller's number of a body; the same on every process. The upper half of the range is reserved for obstacles.
using BodyId = std::uint32_t;
inline constexpr BodyId kMaxBodies = 0x80000000u;

// Where bodies are saved and loaded together: a block of space, by its key (block_grid.h). Engines without blocks have one home.
using Home = std::uint64_t;
// Whether a home that is loaded holds bodies of this subdomain or ghosts: bodies of another one, whose contacts are not needed.
enum class Holds { Own, Ghosts };

struct BodyPair {
    std::uint32_t first, second;
    auto operator<=>(const BodyPair&) const = default;
};

}  // namespace meld::physics
