// Obstacles: planes, boxes, terrain, meshes, and solids of all shapes that bodies have. For spheres on boxes each worker has its own ODE
// geometries, so dCollide runs on all workers without sharing anything that it writes; all others are computed here.
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string_view>
#include <variant>
#include <vector>

#include "physics/bodies/moving_frame.h"
#include "physics/bodies/types.h"
#include "physics/collision/core_contacts.h"
#include "physics/collision/mesh_surface.h"
#include "physics/collision/ray.h"
#include "physics/collision/terrain.h"
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

// A solid as bodies are, or a compound of several, which are one obstacle. The origin of the shape's frame is at `centre`.
struct Solid {
    BodyShape shape = {};
    Vec3 centre = {};
    Quat orientation = {};
};

using Shape = std::variant<Plane, Box, Terrain, Mesh, Solid>;

class Obstacles {
  public:
    Obstacles();
    ~Obstacles();
    Obstacles(Obstacles&&) noexcept;
    Obstacles& operator=(Obstacles&&) noexcept;

    // The error says what is wrong with the shape.
    Result<std::uint32_t> add(Shape shape, std::uint8_t material);
    std::size_t count() const { return entries_.size(); }
    // Of one that moves: before it does.
    const Shape& shape(std::size_t obstacle) const { return entries_[obstacle].shape; }
    // "plane", "box", "terrain" or "mesh"; of a solid "sphere", "capsule", "cylinder", "box" or "compound".
    std::string_view kind(std::size_t obstacle) const;
    std::uint8_t material(std::size_t obstacle) const { return entries_[obstacle].material; }
    // Its surface runs round it like a belt round its rollers, about this vector, right-handed: where the outward normal is n, what touches
    // it feels the velocity belt x n, m/s, which is always along the surface. Once for an obstacle, and not by 0.
    void set_belt(std::size_t obstacle, Vec3 belt_m_s);
    // Obstacles with belts are numbered from 1, in the order of set_belt; 0 for the others.
    std::size_t belt(std::size_t obstacle) const { return entries_[obstacle].belt; }
    // By number, from 0.
    std::span<const Vec3> belts() const { return belts_; }
    // It moves as is prescribed, about its middle unless the motion has a pivot: that of a plane is its point next to the origin, that of
    // a surface of triangles the middle of the box around them. Once for an obstacle.
    void set_motion(std::size_t obstacle, const PrescribedMotion& motion);
    bool moves(std::size_t obstacle) const { return entries_[obstacle].frame != 0; }
    bool any_moves() const { return !frames_.empty(); }
    // Of one that moves.
    const MovingFrame& frame(std::size_t obstacle) const { return frames_[entries_[obstacle].frame - 1]; }
    // Of those that move, in the order of set_motion.
    std::span<MovingFrame> frames() { return frames_; }
    std::span<const MovingFrame> frames() const { return frames_; }
    // Of the surface where it is touched, which has this normal out of the obstacle, m/s; of a belt too. 0 if it is at rest.
    Vec3 velocity_at(std::size_t obstacle, Vec3 point, Vec3 normal) const;
    // How much nearer it may come to a body while a list counts that was begun for it, m (MovingFrame).
    double way_of_list_m(std::size_t obstacle, Vec3 body) const {
        return entries_[obstacle].frame == 0 ? 0 : frame(obstacle).way_of_list_m(body);
    }
    // How many contacts with this obstacle a body can have.
    int parts(std::size_t obstacle) const;
    // Whether a sphere that touches it may meet another part of it ahead.
    bool can_be_met_again(std::size_t obstacle) const {
        return std::holds_alternative<Mesh>(entries_[obstacle].shape) || solids(obstacle) > 1;
    }
    // Whether a sphere may come as near as `reach_m`; may be true without need, but is never false by mistake.
    bool may_reach(std::size_t obstacle, Vec3 centre, double radius_m, double reach_m) const {
        return may_reach_own(entries_[obstacle], into(obstacle, centre), radius_m, reach_m);
    }
    // Of how many solids it consists: those of a compound, 1 for other boxes and solids, 0 for all others.
    std::size_t solids(std::size_t obstacle) const { return entries_[obstacle].parts.size(); }
    // As may_reach, of one solid of a compound. Of others, whose solid is 0, the whole obstacle.
    bool solid_may_reach(std::size_t obstacle, std::size_t solid, Vec3 centre, double radius_m, double reach_m) const {
        return solid_may_reach_own(entries_[obstacle], solid, into(obstacle, centre), radius_m, reach_m);
    }
    // How deep a sphere is in the obstacle, m, 0 if it does not touch it. A mesh has no inside.
    double depth(std::size_t obstacle, Vec3 centre, double radius_m) const {
        return depth_own(entries_[obstacle], into(obstacle, centre), radius_m);
    }
    // Where a sphere that moves along `path` meets the obstacle: the normal there, and as gap the component of the way along it, so that an
    // approach by that gap brings the sphere to the surface. Nothing if it passes by or touches already. Of a mesh, other parts than
    // those of the contacts `touched` may be met. Cost: a few tens of nanoseconds, for terrain and meshes some microseconds.
    std::optional<SurfaceContact> meet(std::size_t obstacle, Vec3 centre, double radius_m, Vec3 path,
                                       std::span<const SurfaceContact> touched = {}) const;
    // Where a ray meets it, as a share of its way: 0 if it begins inside; a mesh is met from both sides.
    std::optional<double> first_on(std::size_t obstacle, const Ray& ray) const;

    // Whether it is made of triangles: terrain or a mesh.
    bool is_surface(std::size_t obstacle) const {
        const Shape& shape = entries_[obstacle].shape;
        return std::holds_alternative<Terrain>(shape) || std::holds_alternative<Mesh>(shape);
    }
    // Where a body that is no sphere touches a plane, or one of the solids of another obstacle that is no surface, nearer than `reach_m`
    // (core_contacts.h). Points are seen from the body's centre.
    void collide_solid(std::size_t obstacle, std::size_t solid, const Core& core, const Pose& pose, double reach_m, AxisHint& hint,
                       Manifold& found) const;
    // Where a body that is no sphere touches such a surface, nearer than `reach_m` (surface_contacts.h); returns the number of manifolds.
    int collide_shape(std::size_t obstacle, const Core& core, const Pose& pose, double reach_m, AxisHint& hint,
                      std::array<Manifold, kMaxSurfaceContacts>& found) const;

    // Makes the geometries of workers 0 .. threads - 1; call it from one thread.
    void prepare(int threads);
    // The contacts nearer than `reach_m`; returns their number. `worker` is the calling worker.
    int collide(int worker, std::size_t obstacle, Vec3 centre, double radius_m, double reach_m,
                std::array<SurfaceContact, kMaxSurfaceContacts>& contacts);

  private:
    struct Entry {
        Shape shape;
        std::uint8_t material;
        Vec3 low, high;
        // Of a mesh.
        std::optional<MeshSurface> surface;
        // Of a box or a solid: each solid, its own rotation, and where it is.
        struct Part {
            BodyShape shape;
            Vec3 centre;
            Quat turn;
            PlacedSolid placed;
        };
        std::vector<Part> parts = {};
        std::size_t belt = 0;
        // Those that move are numbered from 1.
        std::size_t frame = 0;
    };
    static std::vector<Entry::Part> parts_of(const Shape& shape);
    // A point as the obstacle sees it. All that follows is about what stands still (obstacles.cpp); moving_obstacles.cpp takes it from the
    // world into the frame of the obstacle, and the results back.
    Vec3 into(std::size_t obstacle, Vec3 point) const { return moves(obstacle) ? frame(obstacle).into(point) : point; }
    static bool may_reach_own(const Entry& entry, Vec3 centre, double radius_m, double reach_m);
    static bool solid_may_reach_own(const Entry& entry, std::size_t solid, Vec3 centre, double radius_m, double reach_m);
    static double depth_own(const Entry& entry, Vec3 centre, double radius_m);
    static std::optional<SurfaceContact> meet_own(const Entry& entry, Vec3 centre, double radius_m, Vec3 path,
                                                  std::span<const SurfaceContact> touched);
    static std::optional<double> first_on_own(const Entry& entry, const Ray& ray);
    static void collide_solid_own(const Entry& entry, std::size_t solid, const Core& core, const Pose& pose, double reach_m, AxisHint& hint,
                                  Manifold& found);
    static int collide_shape_own(const Entry& entry, const Core& core, const Pose& pose, double reach_m, AxisHint& hint,
                                 std::array<Manifold, kMaxSurfaceContacts>& found);
    int collide_own(int worker, std::size_t obstacle, Vec3 centre, double radius_m, double reach_m,
                    std::array<SurfaceContact, kMaxSurfaceContacts>& contacts);
    static int collide_sphere(const Entry& entry, Vec3 centre, double radius_m, double reach_m,
                              std::array<SurfaceContact, kMaxSurfaceContacts>& contacts);
    static std::optional<SurfaceContact> meet_solids(const Entry& entry, Vec3 centre, double radius_m, Vec3 path);
    struct Geometries;
    std::vector<Entry> entries_;
    std::vector<Vec3> belts_;
    std::vector<MovingFrame> frames_;
    std::vector<std::unique_ptr<Geometries>> geometries_;
};

}  // namespace meld::physics
