// Contacts with obstacles that move, in the block engine. A contact's second body is an entry behind those of the bodies that nothing can
// move, of its own for each lane, since what of a turning obstacle touches a body has another velocity at each place.
#include <algorithm>
#include <cmath>
#include <numbers>
#include <numeric>
#include <vector>

#include "physics/solver/block_engine.h"

namespace meld::physics {

namespace {

// Where surfaces touch, a ball of radius r and angular velocity w adds r w x n to the velocity of its centre, and as the second body it
// takes it away (contact_kernels.cpp). So an entry that turns as the obstacle does has twice that in addition to what the obstacle has in
// the middle of the ball.
BodyVelocity velocity_for_ball(const Obstacles& obstacles, std::uint32_t obstacle, const Place& ball, Vec3 normal) {
    const Vec3 surface = ball.radius * obstacles.frame(obstacle).spin_rad_s();
    BodyVelocity entry{};
    set_single(entry.linear, obstacles.velocity_at(obstacle, centre_of(ball), -normal) + 2 * cross(surface, normal));
    set_single(entry.surface, surface);
    return entry;
}

// Arms of a body with a shape count from its middle for both (shape_contacts.h).
BodyVelocity velocity_for_shape(const Obstacles& obstacles, std::uint32_t obstacle, const Place& body, Vec3 normal) {
    BodyVelocity entry{};
    set_single(entry.linear, obstacles.velocity_at(obstacle, centre_of(body), -normal));
    set_single(entry.surface, body.radius * obstacles.frame(obstacle).spin_rad_s());
    return entry;
}

// Calls ball(batch, lane, obstacle) and shape(batch, lane, obstacle) for the lanes of a block that are about obstacles that move.
template <class OfBall, class OfShape>
void each_moving_lane(Contacts& contacts, ShapeContacts& shapes, const World& world, std::size_t block, const OfBall& ball,
                      const OfShape& shape) {
    const ObstacleLane* lane = contacts.obstacle_lanes(block);
    for (Batch& batch : contacts.obstacle_contacts(block))
        for (int i = 0; i < kLanes; ++i, ++lane)
            if (batch.a[i] < world.bodies.count() && world.obstacles.moves(lane->obstacle)) ball(batch, i, lane->obstacle);
    const ShapeLane* of_shape = shapes.lanes(block).data();
    for (ShapeBatch& batch : shapes.batches(block))
        for (int i = 0; i < kLanes; ++i, ++of_shape)
            if (batch.a[i] < world.bodies.count() && of_shape->obstacle != kNoSlot && world.obstacles.moves(of_shape->obstacle))
                shape(batch, i, of_shape->obstacle);
}

}  // namespace

void BlockEngine::place_obstacles(const StepTimes& times, int substep) {
    const double from_s = times.start_s(world_.tick, substep), to_s = times.start_s(world_.tick, substep + 1);
    for (MovingFrame& frame : world_.obstacles.frames()) frame.place(from_s), frame.set_velocity(from_s, to_s);
}

// What of an obstacle may be a radius away when it is listed is found in time.
void BlockEngine::begin_list_of_obstacles(double ahead_s) {
    list_tick_ = world_.tick;
    for (MovingFrame& frame : world_.obstacles.frames()) frame.begin_list(smallest_radius_m_, ahead_s);
}

void BlockEngine::restore_list_of_obstacles() {
    if (!world_.obstacles.any_moves()) return;
    const StepTimes times{last_dt_s_, std::max(1, static_cast<int>(std::lround(last_dt_s_ / last_substep_s_)))};
    for (MovingFrame& frame : world_.obstacles.frames()) {
        frame.place(times.start_s(list_tick_, 0));
        frame.begin_list(smallest_radius_m_, kStepsAhead * last_dt_s_);
    }
    place_obstacles(times, 0);
}

// The bodies of all subdomains together are those of the world, and one that says so is enough.
bool BlockEngine::has_obstacle_left_list() const {
    const Bodies& bodies = world_.bodies;
    return std::ranges::any_of(world_.obstacles.frames(), [&](const MovingFrame& frame) {
        double farthest_squared = 0;
        for (std::size_t slot = 0; !frame.has_end() && slot < bodies.count(); ++slot) {
            const Vec3 away = centre_of(bodies.place[slot]) - frame.centre_m();
            farthest_squared = std::max(farthest_squared, dot(away, away));
        }
        return frame.has_left_list(std::sqrt(farthest_squared));
    });
}

void BlockEngine::lay_out_obstacle_lanes() {
    if (!world_.obstacles.any_moves()) return;
    Bodies& bodies = world_.bodies;
    auto next = static_cast<std::uint32_t>(bodies.velocity.size());
    std::vector<double> radii;
    const auto number = [&](auto& batch, int i, std::uint32_t) {
        radii.push_back(bodies.place[batch.a[i]].radius);
        batch.b[i] = next++;
    };
    for (std::size_t block = 0; block < grid_.blocks().size(); ++block)
        each_moving_lane(contacts_, shape_contacts_, world_, block, number, number);
    bodies.velocity.resize(next), bodies.place.resize(next);
    if (!world_.shapes.empty()) shape_contacts_.add_turnings(next);
    for (std::size_t n = 0; n < radii.size(); ++n) {
        const std::size_t at = next - radii.size() + n;
        bodies.velocity[at] = {};
        // What turns against it counts with this radius.
        bodies.place[at] = {0, 0, 0, radii[n]};
    }
}

void BlockEngine::move_obstacle_lanes(std::uint32_t block) {
    const Obstacles& obstacles = world_.obstacles;
    if (!obstacles.any_moves()) return;
    Bodies& bodies = world_.bodies;
    const auto normal = [](const auto& batch, int i) { return vector_of_lane(batch.nx, batch.ny, batch.nz, i); };
    each_moving_lane(
        contacts_, shape_contacts_, world_, block,
        [&](const Batch& batch, int i, std::uint32_t obstacle) {
            bodies.velocity[batch.b[i]] = velocity_for_ball(obstacles, obstacle, bodies.place[batch.a[i]], normal(batch, i));
        },
        [&](const ShapeBatch& batch, int i, std::uint32_t obstacle) {
            bodies.velocity[batch.b[i]] = velocity_for_shape(obstacles, obstacle, bodies.place[batch.a[i]], normal(batch, i));
        });
}

void BlockEngine::move_all_obstacle_lanes(Workers& workers) {
    if (!world_.obstacles.any_moves()) return;
    std::vector<std::uint32_t> all(states_.size());
    std::iota(all.begin(), all.end(), 0u);
    for_blocks(all, workers, [&](int, std::uint32_t block) { move_obstacle_lanes(block); });
}

// A block whose bodies are all out of reach is seen from its middle.
bool BlockEngine::may_be_met(std::uint32_t index, const StepTimes& times) const {
    const Obstacles& obstacles = world_.obstacles;
    if (!obstacles.any_moves()) return false;
    const Bodies& bodies = world_.bodies;
    const Block& block = grid_.blocks()[index];
    const double half_m = grid_.shape().block_m() / 2, around_m = std::numbers::sqrt3 * half_m + skin_m_;
    const Vec3 middle = grid_.origin(block) + Vec3{half_m, half_m, half_m};
    for (std::size_t obstacle = 0; obstacle < obstacles.count(); ++obstacle) {
        if (!obstacles.moves(obstacle)) continue;
        const auto reach_m = [&](Vec3 at, double more_m) {
            const double speed_m_s = obstacles.frame(obstacle).greatest_speed_m_s(at);
            return margin_m_ + more_m + kStepsAhead * times.dt_s * speed_m_s;
        };
        double greatest_m = 0;
        for (std::uint32_t slot = block.first; slot < block.first + block.count; ++slot)
            greatest_m = std::max(greatest_m, bodies.place[slot].radius);
        const bool has_end = obstacles.frame(obstacle).has_end();
        if (has_end && !obstacles.may_reach(obstacle, middle, greatest_m, reach_m(middle, around_m))) continue;
        for (std::uint32_t slot = block.first; slot < block.first + block.count; ++slot) {
            const Vec3 at = centre_of(bodies.place[slot]);
            if ((bodies.properties[slot].flags & kFixed) == 0 &&
                obstacles.may_reach(obstacle, at, bodies.place[slot].radius, reach_m(at, 0)))
                return true;
        }
    }
    return false;
}

}  // namespace meld::physics
