// What bodies meet that is not a sphere: planes, boxes, terrain and meshes. Planes and terrain are computed here; for the others
// each worker has its own ODE geometries, so that dCollide runs on all workers without sharing anything that it writes.
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <optional>
#include <string_view>
#include <variant>
#include <vector>

#include "physics/terrain.h"
#include "physics/types.h"
#include "runtime/base/error.h"

namespace meld::physics {

// The points with dot(normal, p) <= offset_m are inside.
struct Plane {
    Vec3 normal{0, 0, 1};
    double offset_m = 0;
};

struct Box {
    Vec3 centre = {};
    Vec3 size_m{1, 1, 1};
    Quat orientation = {};
};

// Triangles by three indices each, counter-clockwise as seen from outside.
struct Mesh {
    std::vector<Vec3> points = {};
    std::vector<std::uint32_t> triangles = {};
};

using Shape = std::variant<Plane, Box, Terrain, Mesh>;

class Obstacles {
  public:
    Obstacles();
    ~Obstacles();
    Obstacles(Obstacles&&) noexcept;
    Obstacles& operator=(Obstacles&&) noexcept;

    // The error says what is wrong with the shape.
    Result<std::uint32_t> add(Shape shape, std::uint8_t material);
    std::size_t count() const { return entries_.size(); }
    const Shape& shape(std::size_t obstacle) const { return entries_[obstacle].shape; }
    // "plane", "box", "terrain" or "mesh".
    std::string_view kind(std::size_t obstacle) const;
    std::uint8_t material(std::size_t obstacle) const { return entries_[obstacle].material; }
    // How many contacts with this obstacle a body can have.
    int parts(std::size_t obstacle) const;
    // Whether `meet` finds it: all but meshes.
    bool can_be_met(std::size_t obstacle) const { return !std::holds_alternative<Mesh>(entries_[obstacle].shape); }
    // Whether a sphere may come as near as `reach_m`; true too often rather than too seldom.
    bool may_reach(std::size_t obstacle, Vec3 centre, double radius_m, double reach_m) const;
    // How far a sphere has sunk into the obstacle, m, 0 if it does not touch it. A mesh has no inside.
    double depth(std::size_t obstacle, Vec3 centre, double radius_m) const;
    // Where a sphere that goes along `path` meets the obstacle: the normal there, and of the way to there what lies along it,
    // so that whoever lets it approach by that gap lets it come to the surface. Nothing if it goes past, or touches already; meshes are
    // not met ahead. Cost: a few tens of nanoseconds, for terrain some microseconds.
    std::optional<SurfaceContact> meet(std::size_t obstacle, Vec3 centre, double radius_m, Vec3 path) const;

    // Makes the geometries of workers 0 .. threads - 1; one thread calls it.
    void prepare(int threads);
    // The contacts nearer than `reach_m`; returns their number. `worker` is the calling worker.
    int collide(int worker, std::size_t obstacle, Vec3 centre, double radius_m, double reach_m,
                std::array<SurfaceContact, kMaxSurfaceContacts>& contacts);

  private:
    struct Entry {
        Shape shape;
        std::uint8_t material;
        Vec3 low, high;
    };
    struct Geometries;
    std::vector<Entry> entries_;
    std::vector<std::unique_ptr<Geometries>> geometries_;
};

}  // namespace meld::physics
