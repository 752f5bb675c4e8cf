#include "physics/solver/turning/turning_friction.h"

#include <algorithm>

#include "physics/solver/block_engine.h"
#include "runtime/base/assert.h"

namespace meld::physics {

namespace {

constexpr std::size_t kTurningBlocksPerJob = 4;

Vec3 torque_of(const TurningLanes& beside, int i) { return vector_of_lane(beside.x, beside.y, beside.z, i); }

// Entries without a size do not turn.
float curvature(const Bodies& bodies, std::uint32_t slot) {
    const double radius = bodies.place[slot].radius;
    return radius > 0 ? static_cast<float>(1 / radius) : 0.0f;
}

// One lane: the materials of both, and the entries that the solver moves.
void set_lane(TurningLanes& beside, int i, const Bodies& bodies, const Material& own, const Material& other, BodyPair moved) {
    beside.rolling[i] = common_rolling_m(own, other);
    beside.spinning[i] = common_spinning_m(own, other);
    beside.a_curvature[i] = curvature(bodies, moved.first);
    beside.b_curvature[i] = curvature(bodies, moved.second);
}

}  // namespace

void TurningFriction::lay_out(const Setup& setup, std::size_t blocks, Workers& workers) {
    const Bodies& bodies = setup.bodies;
    const Contacts& contacts = setup.contacts;
    const Lanes nothing = physics::lanes(0);
    lanes_.assign(contacts.pair_batch_count() + contacts.obstacle_batch_count() + setup.shapes.batch_count(),
                  {nothing, nothing, nothing, nothing, nothing, nothing, nothing});
    const auto of_body = [&](std::uint32_t slot) { return setup.materials[bodies.properties[slot].material]; };
    const auto of_obstacle = [&](std::uint32_t obstacle) { return setup.materials[setup.obstacles.material(obstacle)]; };
    // Calls set(batch, its number in the block, lane) for the lanes with bodies.
    const auto each = [&](const auto& batches, const auto& set) {
        for (std::size_t n = 0; n < batches.size(); ++n)
            for (int i = 0; i < kLanes; ++i)
                if (batches[n].a[i] < bodies.count()) set(batches[n], n, i);
    };
    workers.run((blocks + kTurningBlocksPerJob - 1) / kTurningBlocksPerJob, [&](int, std::size_t job) {
        for (std::size_t b = job * kTurningBlocksPerJob; b < std::min(blocks, (job + 1) * kTurningBlocksPerJob); ++b) {
            TurningLanes* beside = pairs(contacts, b);
            each(contacts.pairs(b), [&](const Batch& batch, std::size_t n, int i) {
                set_lane(beside[n], i, bodies, of_body(batch.a[i]), of_body(batch.b[i]), {batch.a[i], batch.b[i]});
            });
            beside = obstacles(contacts, b);
            each(contacts.obstacle_contacts(b), [&](const Batch& batch, std::size_t n, int i) {
                const ObstacleLane& lane = contacts.obstacle_lanes(b)[n * kLanes + static_cast<std::size_t>(i)];
                set_lane(beside[n], i, bodies, of_body(batch.a[i]), of_obstacle(lane.obstacle), {batch.a[i], batch.b[i]});
            });
            beside = of_shapes(contacts, setup.shapes, b);
            each(setup.shapes.batches(b), [&](const ShapeBatch& batch, std::size_t n, int i) {
                const ShapeLane& lane = setup.shapes.lanes(b)[n * kLanes + static_cast<std::size_t>(i)];
                const Material other = lane.obstacle == kNoSlot ? of_body(batch.b[i]) : of_obstacle(lane.obstacle);
                BodyPair moved{batch.a[i], batch.b[i]};
                if (batch.moved != kNoSlot) moved = setup.shapes.moved_in(batch, i);
                set_lane(beside[n], i, bodies, of_body(batch.a[i]), other, moved);
            });
        }
    });
}

void TurningFriction::begin_substep(const Contacts& contacts, const ShapeContacts& shapes, std::span<const std::uint32_t> blocks) {
    const auto clear = [](TurningLanes* beside, std::size_t count) {
        for (std::size_t n = 0; n < count; ++n) beside[n].x = beside[n].y = beside[n].z = physics::lanes(0);
    };
    for (const std::uint32_t block : blocks) {
        clear(pairs(contacts, block), contacts.pairs(block).size());
        clear(obstacles(contacts, block), contacts.obstacle_contacts(block).size());
        clear(of_shapes(contacts, shapes, block), shapes.batches(block).size());
    }
}

Vec3 TurningFriction::torque(const Contacts& contacts, std::uint32_t block, bool obstacle, std::uint32_t batch, int lane) const {
    if (empty()) return {};
    const std::size_t first =
        obstacle ? contacts.pair_batch_count() + contacts.first_obstacle_batch(block) : contacts.first_pair_batch(block);
    return torque_of(lanes_[first + batch], lane);
}

Vec3 TurningFriction::torque_of_shapes(const Contacts& contacts, const ShapeContacts& shapes, std::uint32_t block, std::uint32_t batch,
                                       int lane) const {
    if (empty()) return {};
    return torque_of(lanes_[contacts.pair_batch_count() + contacts.obstacle_batch_count() + shapes.first_batch(block) + batch], lane);
}

// The passes over contacts of bodies with shapes are theirs.
void ShapeContacts::resist_turning(std::uint32_t block, TurningLanes* beside, BodyVelocity* velocities, float step_s,
                                   const SweepRule& rule) const {
    if (empty()) return;
    resist_turning_of_shapes(batches(block), beside, held_.empty() ? nullptr : held_.data() + first_[block], step_s, moved_.data(),
                             velocities, turnings_.data(), rule);
}

// In the engine: before the contacts of a block push, so that a body whose friction has been warm-started is held where it stands.
void BlockEngine::resist_turning(std::uint32_t block, const SweepRule& rule, float step_s) {
    BodyVelocity* velocities = world_.bodies.velocity.data();
    const Lanes* held = contacts_.adhesion.empty() ? nullptr : contacts_.adhesion.data() + contacts_.first_pair_batch(block);
    TurningLanes *pairs = turning_.pairs(contacts_, block), *obstacles = turning_.obstacles(contacts_, block);
    physics::resist_turning(contacts_.plain_pairs(block), pairs, held, step_s, velocities, rule);
    physics::resist_turning(contacts_.plain_obstacles(block), obstacles, nullptr, step_s, velocities, rule);
    rows_.resist_turning(contacts_, block, pairs, obstacles, velocities, step_s, rule);
    shape_contacts_.resist_turning(block, turning_.of_shapes(contacts_, shape_contacts_, block), velocities, step_s, rule);
}

void BlockEngine::lay_out_turning_friction(Workers& workers) {
    if (turning_.empty() && world_.resists_turning())
        turning_.lay_out({world_.bodies, world_.obstacles, world_.materials, contacts_, shape_contacts_}, grid_.blocks().size(), workers);
}

}  // namespace meld::physics
