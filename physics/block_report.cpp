// What the block engine tells: touch events, contacts, errors, sizes.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "physics/block_engine.h"
#include "physics/chunks.h"
#include "physics/kernels.h"

namespace meld::physics {

namespace {

template <class T>
std::size_t bytes_of(const T& array) {
    return array.capacity() * sizeof(array[0]);
}

Vec3 vector_of(Lanes x, Lanes y, Lanes z, int i) {
    return {static_cast<double>(x[i]), static_cast<double>(y[i]), static_cast<double>(z[i])};
}

}  // namespace

void BlockEngine::find_events(Workers& workers) {
    const StageClock clock(world_.times.events);
    const double diameter = 2 * smallest_radius_m_;
    const auto near = static_cast<float>(world_.settings.touch_share * diameter),
               far = static_cast<float>(world_.settings.part_share * diameter);
    const Bodies& bodies = world_.bodies;
    std::vector<Chunks<TouchEvent>> found(static_cast<std::size_t>(workers.threads()));
    const auto compare = [&](const Batch& batch, std::uint8_t& touching, const auto& report) {
        // What bounces off may be stopped a little before the surface.
        const LaneMask are_near = (batch.gap < near) | (batch.normal_impulse > 0.0f), are_far = batch.gap >= far;
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
        std::size_t n = contacts_.first_pair_batch(block);
        for (const Batch& batch : contacts_.pairs(block))
            compare(batch, contacts_.touching[n++], [&](int i, bool began) {
                events.push_back({touch_of(bodies.nature[batch.a[i]].id, bodies.nature[batch.b[i]].id), began});
            });
        n = contacts_.pair_batch_count() + contacts_.first_obstacle_batch(block);
        const ObstacleLane* lane = contacts_.obstacle_lanes(block).data();
        for (const Batch& batch : contacts_.obstacle_contacts(block)) {
            compare(batch, contacts_.touching[n++],
                    [&](int i, bool began) { events.push_back({touch_of(bodies.nature[batch.a[i]].id, obstacle_code(lane[i])), began}); });
            lane += kLanes;
        }
    });
    std::size_t count = world_.events.size();
    for (const auto& events : found) count += events.size();
    world_.events.reserve(count);
    for (auto& events : found) events.consume([&](const TouchEvent& event) { world_.events.push_back(event); });
    std::sort(world_.events.begin(), world_.events.end());
}

void BlockEngine::each_contact(const ContactVisitor& visit) const {
    const Bodies& bodies = world_.bodies;
    const double per_second = last_substep_s_ > 0 ? 1 / last_substep_s_ : 0;
    const auto report = [&](const Batch& batch, int i, Touch touch, double sign) {
        visit({touch, sign * vector_of(batch.nx, batch.ny, batch.nz, i), static_cast<double>(batch.gap[i]),
                            per_second * static_cast<double>(batch.normal_impulse[i]),
                            (sign * per_second) * vector_of(batch.tx, batch.ty, batch.tz, i)});
    };
    for (std::size_t block = 0; block < states_.size(); ++block) {
        std::size_t n = contacts_.first_pair_batch(block);
        for (const Batch& batch : contacts_.pairs(block)) {
            for (int i = 0; i < kLanes; ++i)
                if (contacts_.touching[n] >> i & 1) {
                    const BodyId a = bodies.nature[batch.a[i]].id, b = bodies.nature[batch.b[i]].id;
                    report(batch, i, touch_of(a, b), a < b ? 1 : -1);
                }
            ++n;
        }
        n = contacts_.pair_batch_count() + contacts_.first_obstacle_batch(block);
        const ObstacleLane* lane = contacts_.obstacle_lanes(block).data();
        for (const Batch& batch : contacts_.obstacle_contacts(block)) {
            for (int i = 0; i < kLanes; ++i)
                if (contacts_.touching[n] >> i & 1) report(batch, i, touch_of(bodies.nature[batch.a[i]].id, obstacle_code(lane[i])), 1);
            ++n, lane += kLanes;
        }
    }
}

StepReport BlockEngine::report() const {
    StepReport report{.bodies = world_.bodies.count(),
                      .blocks = grid_.blocks().size(),
                      .candidates = contacts_.candidate_count(),
                      .rebuilt = rebuilt_in_step_};
    for (const std::uint32_t block : awake_)
        if (states_[block].owned) report.awake_bodies += grid_.blocks()[block].count;
    return report;
}

std::size_t BlockEngine::bytes() const {
    return grid_.bytes() + contacts_.bytes() + bytes_of(states_) + bytes_of(pulls_) + bytes_of(awake_) + bytes_of(active_);
}

double BlockEngine::residual() {
    const Rules rules = rules_for(world_.settings, {last_substep_s_ > 0 ? last_substep_s_ : 1, 1});
    SquareSums sums;
    for (const std::uint32_t block : active_)
        for (const std::span<Batch> batches : {contacts_.pairs(block), contacts_.obstacle_contacts(block)}) {
            const SquareSums more = measure_residual(batches, world_.bodies.motion.data(), rules.solve);
            sums.change += more.change, sums.impulse += more.impulse;
        }
    return sums.impulse > 0 ? std::sqrt(sums.change / sums.impulse) : 0;
}

tl::unexpected<Error> BlockEngine::too_deep(std::uint32_t block) {
    const Bodies& bodies = world_.bodies;
    const double share = world_.settings.deepest_overlap_share;
    for (const Batch& batch : contacts_.pairs(block))
        for (int i = 0; i < kLanes; ++i) {
            if (batch.a[i] >= bodies.count()) continue;
            const double radii = bodies.place[batch.a[i]].radius + bodies.place[batch.b[i]].radius, gap = static_cast<double>(batch.gap[i]);
            if (gap >= -share * radii) continue;
            const auto [first, second] = std::minmax(bodies.nature[batch.a[i]].id, bodies.nature[batch.b[i]].id);
            return world_.wrong(fmt::format("bodies {} and {} overlap by {:.3g} m, more than {:.0f} % of their radii together", first,
                                            second, -gap, 100 * share),
                                "Move one of them away, or take a shorter step if they ran into each other");
        }
    return world_.wrong("two bodies overlap too much", "Take a shorter step");
}

}  // namespace meld::physics
