// What the block engine reports: touch events, contacts, errors, sizes.
#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <cmath>

#include "physics/bodies/chunks.h"
#include "physics/solver/block_engine.h"
#include "physics/solver/kernels.h"
#include "runtime/base/assert.h"

namespace meld::physics {

namespace {

template <class T>
std::size_t bytes_of(const T& array) {
    return array.capacity() * sizeof(array[0]);
}

Lanes impulse_of(std::span<const Bounce> bounces, std::size_t batch) { return bounces.empty() ? lanes(0) : bounces[batch].impulse; }

}  // namespace

void BlockEngine::find_events(Workers& workers) {
    const StageClock clock(world_.times.events);
    MELD_EXPECT(fresh_ || active_.empty(), "gaps are not those of the present positions");
    const double diameter = 2 * smallest_radius_m_;
    const auto near = static_cast<float>(world_.settings.touch_share * diameter),
               far = static_cast<float>(world_.settings.separation_share * diameter);
    const Bodies& bodies = world_.bodies;
    std::vector<Chunks<TouchEvent>> found(static_cast<std::size_t>(workers.threads()));
    const auto compare = [&](const Batch& batch, const Lanes& bounced, std::uint8_t& touching, const auto& report) {
        // A body that bounces turns round a little before the surface.
        const LaneMask are_near = (batch.gap < near) | (batch.normal_impulse > 0.0f) | (bounced > 0.0f), are_far = batch.gap >= far;
        int now = 0;
        for (int i = 0; i < kLanes; ++i) now |= (are_near[i] != 0 || (are_far[i] == 0 && (touching >> i & 1) != 0) ? 1 : 0) << i;
        for (int changed = now ^ touching; changed != 0; changed &= changed - 1) {
            const int i = std::countr_zero(static_cast<unsigned>(changed));
            report(i, (now >> i & 1) != 0);
        }
        touching = static_cast<std::uint8_t>(now);
    };
    for_blocks(active_, workers, [&](int worker, std::uint32_t block) {
        auto& events = found[static_cast<std::size_t>(worker)];
        std::uint8_t* touching = contacts_.pair_touches(block);
        const auto pairs = std::as_const(contacts_).pairs(block);
        const auto pair_bounces = std::as_const(contacts_).pair_bounces(block);
        for (std::size_t n = 0; n < pairs.size(); ++n) {
            const Batch& batch = pairs[n];
            compare(batch, impulse_of(pair_bounces, n), *touching++, [&](int i, bool began) {
                events.push_back({touch_of(bodies.properties[batch.a[i]].id, bodies.properties[batch.b[i]].id), began});
            });
        }
        touching = contacts_.obstacle_touches(block);
        const ObstacleLane* lane = contacts_.obstacle_lanes(block);
        const auto obstacles = std::as_const(contacts_).obstacle_contacts(block);
        const auto obstacle_bounces = std::as_const(contacts_).obstacle_bounces(block);
        for (std::size_t n = 0; n < obstacles.size(); ++n) {
            const Batch& batch = obstacles[n];
            compare(batch, impulse_of(obstacle_bounces, n), *touching++, [&](int i, bool began) {
                events.push_back({touch_of(bodies.properties[batch.a[i]].id, obstacle_code(lane[i])), began});
            });
            lane += kLanes;
        }
        if (!shape_contacts_.empty()) find_shape_events(block, near, far, events);
    });
    std::size_t count = world_.events.size();
    for (const auto& events : found) count += events.size();
    world_.events.reserve(count);
    for (auto& events : found) events.consume([&](const TouchEvent& event) { world_.events.push_back(event); });
    std::sort(world_.events.begin(), world_.events.end());
}

template <class Pair, class Obstacle>
void BlockEngine::each_touch(std::size_t block, const Pair& pair, const Obstacle& obstacle) const {
    const auto each_lane = [](std::span<const Batch> batches, const std::uint8_t* touching, const auto& visit) {
        for (std::size_t n = 0; n < batches.size(); ++n)
            for (unsigned lanes = touching[n]; lanes != 0; lanes &= lanes - 1) visit(n, std::countr_zero(lanes));
    };
    const auto pairs = contacts_.pairs(block), obstacles = contacts_.obstacle_contacts(block);
    const auto pair_bounces = contacts_.pair_bounces(block), obstacle_bounces = contacts_.obstacle_bounces(block);
    const double per_substep = last_substep_s_ > 0 ? 1 / last_substep_s_ : 0, per_step = last_dt_s_ > 0 ? 1 / last_dt_s_ : 0;
    const auto force = [&](const Batch& batch, const Lanes& bounced, int i) {
        return per_substep * static_cast<double>(batch.normal_impulse[i]) + per_step * static_cast<double>(bounced[i]);
    };
    const ObstacleLane* what = contacts_.obstacle_lanes(block);
    each_lane(pairs, contacts_.pair_touches(block),
              [&](std::size_t n, int i) { pair(pairs[n], i, force(pairs[n], impulse_of(pair_bounces, n), i)); });
    each_lane(obstacles, contacts_.obstacle_touches(block), [&](std::size_t n, int i) {
        obstacle(obstacles[n], i, force(obstacles[n], impulse_of(obstacle_bounces, n), i), what[kLanes * n + static_cast<std::size_t>(i)]);
    });
}

void BlockEngine::each_contact(const ContactVisitor& visit) const {
    const Bodies& bodies = world_.bodies;
    const double per_second = last_substep_s_ > 0 ? 1 / last_substep_s_ : 0;
    const auto report = [&](const Batch& batch, int i, double force_n, Touch touch, double sign) {
        visit({touch, sign * vector_of_lane(batch.nx, batch.ny, batch.nz, i), static_cast<double>(batch.gap[i]), force_n,
               (sign * per_second) * vector_of_lane(batch.tx, batch.ty, batch.tz, i)});
    };
    for (std::size_t block = 0; block < states_.size(); ++block) {
        report_shape_contacts(block, visit);
        each_touch(
            block,
            [&](const Batch& batch, int i, double force_n) {
                const BodyId a = bodies.properties[batch.a[i]].id, b = bodies.properties[batch.b[i]].id;
                report(batch, i, force_n, touch_of(a, b), a < b ? 1 : -1);
            },
            [&](const Batch& batch, int i, double force_n, ObstacleLane what) {
                report(batch, i, force_n, touch_of(bodies.properties[batch.a[i]].id, obstacle_code(what)), 1);
            });
    }
}

// Blocks of one colour share no body, so no two workers add to one sum.
void BlockEngine::add_normal_forces(std::span<ExactSum> of_slot, Workers& workers) const {
    MELD_EXPECT(of_slot.size() == world_.bodies.count(), "{} sums of {} bodies", of_slot.size(), world_.bodies.count());
    // Also in sleeping blocks, whose contacts press as before.
    std::array<std::vector<std::uint32_t>, kColours> coloured;
    for (std::uint32_t block = 0; block < states_.size(); ++block)
        coloured[static_cast<std::size_t>(colour_of(unpack(grid_.blocks()[block].key)))].push_back(block);
    const auto press = [&](std::uint32_t slot, double force_n) {
        if (force_n > 0) of_slot[slot].add(force_n);
    };
    for (const std::vector<std::uint32_t>& blocks : coloured)
        for_blocks(blocks, workers, [&](int, std::uint32_t block) {
            each_touch(
                block, [&](const Batch& batch, int i, double force_n) { press(batch.a[i], force_n), press(batch.b[i], force_n); },
                [&](const Batch& batch, int i, double force_n, ObstacleLane) { press(batch.a[i], force_n); });
            each_shape_touch(block, [&](const ShapeBatch& batch, int i, const ShapeLane& lane, double force_n) {
                press(batch.a[i], force_n);
                if (lane.obstacle == kNoSlot) press(batch.b[i], force_n);
            });
        });
}

StepReport BlockEngine::report() const {
    StepReport report{.bodies = world_.bodies.count(),
                      .blocks = grid_.blocks().size(),
                      .candidates = contacts_.candidate_count() + shape_contacts_.candidate_count(),
                      .rebuilt = rebuilt_in_step_,
                      .recomposed = recomposed_in_step_};
    for (const std::uint32_t block : awake_)
        if (states_[block].owned) report.awake_bodies += grid_.blocks()[block].count;
    return report;
}

std::size_t BlockEngine::bytes() const {
    return grid_.bytes() + contacts_.bytes() + shape_contacts_.bytes() + rows_.bytes() + world_.composites.bytes() + world_.joints.bytes() +
           world_.composites.joined().bytes() + world_.loads.bytes() + load_contacts_.bytes() + turning_.bytes() + all_links_.bytes() +
           bytes_of(states_) + bytes_of(feature_wrenches_) + bytes_of(awake_) + bytes_of(active_);
}

double BlockEngine::residual() {
    const Rules rules = rules_for(world_.settings, {last_substep_s_ > 0 ? last_substep_s_ : 1, 1}, 2 * smallest_radius_m_);
    SquareSums sums;
    for (const std::uint32_t block : active_)
        for (const std::span<Batch> batches : {contacts_.plain_pairs(block), contacts_.plain_obstacles(block)}) {
            const SquareSums more = measure_residual(batches, world_.bodies.velocity.data(), rules.solve);
            sums.change += more.change, sums.impulse += more.impulse;
        }
    return sums.impulse > 0 ? std::sqrt(sums.change / sums.impulse) : 0;
}

tl::unexpected<Error> BlockEngine::too_deep(std::uint32_t block) {
    const Bodies& bodies = world_.bodies;
    const double share = world_.settings.max_overlap_share;
    for (const Batch& batch : contacts_.pairs(block))
        for (int i = 0; i < kLanes; ++i) {
            if (batch.a[i] >= bodies.count()) continue;
            const double radii = bodies.place[batch.a[i]].radius + bodies.place[batch.b[i]].radius, gap = static_cast<double>(batch.gap[i]);
            if (gap >= -share * radii) continue;
            return world_.too_deep(bodies.properties[batch.a[i]].id, bodies.properties[batch.b[i]].id, -gap);
        }
    return world_.wrong("two bodies overlap too much", "Take a shorter step");
}

}  // namespace meld::physics
