// Magnets, plates and latches along the candidate pairs. Forces are added to per-body sums in colour order, so no two threads add to one
// body and the order of additions depends only on the world; latches act through the contacts, between bodies with
// shapes through points that share their force.
#include <algorithm>
#include <array>
#include <span>
#include <utility>
#include <vector>

#include "physics/bodies/actuation.h"
#include "physics/solver/block_engine.h"
#include "physics/solver/feature_wrenches.h"
#include "physics/statics/point_shares.h"
#include "runtime/base/assert.h"

namespace meld::physics {

void BlockEngine::begin_actuation(double dt_s, Workers& workers) {
    const bool latches = std::any_of(world_.tables.begin(), world_.tables.end(), [](const auto& table) {
        return std::any_of(table.begin(), table.end(), [](const Feature& feature) { return holds(feature.kind); });
    });
    if (latches) contacts_.need_adhesion();
    if (latches) shape_contacts_.need_holds();
    for (const std::uint32_t slot : begin_feature_wrenches(world_, feature_wrenches_, dt_s, workers)) body_changed(slot, false);
}

void BlockEngine::actuate_block(std::uint32_t block) {
    const std::span<Batch> batches = contacts_.pairs(block);
    const auto range = static_cast<float>(world_.feature_range_m());
    const auto& features = world_.bodies.features;
    const auto d = [](float value) { return static_cast<double>(value); };
    for (std::size_t n = 0; n < batches.size(); ++n) {
        Lanes held = lanes(0);
        for (int i = 0; i < kLanes; ++i) {
            const Batch& batch = batches[n];
            if (!(batch.gap[i] < range) || features[batch.a[i]].on == 0 || features[batch.b[i]].on == 0) continue;
            held[i] = static_cast<float>(add_feature_wrenches(world_, feature_wrenches_, batch.a[i], batch.b[i],
                                                              {d(batch.nx[i]), d(batch.ny[i]), d(batch.nz[i])}, d(batch.gap[i])));
        }
        if (!contacts_.adhesion.empty()) contacts_.adhesion[contacts_.first_pair_batch(block) + n] = held;
    }
    shape_contacts_.let_go(block);
    thread_local std::vector<ShapeContacts::CompoundHold> of_compounds;
    of_compounds.clear();
    const std::span<const ShapeLane> lanes_of_shapes = std::as_const(shape_contacts_).lanes(block);
    for (std::size_t n = 0; n < lanes_of_shapes.size(); ++n) {
        if (lanes_of_shapes[n].obstacle != kNoSlot || !lanes_of_shapes[n].is_first()) continue;
        const ShapeBatch& batch = std::as_const(shape_contacts_).batches(block)[n / kLanes];
        const std::uint32_t a = batch.a[n % kLanes], b = batch.b[n % kLanes];
        if (a >= world_.bodies.count() || features[a].on == 0 || features[b].on == 0) continue;
        add_shape_feature_wrenches(world_, feature_wrenches_, a, b, [&](const HeldPlace& held) {
            if (lanes_of_shapes[n].of_compound)
                of_compounds.push_back({a, b, held});
            else
                shape_contacts_.hold(world_.bodies, block, n, held);
        });
    }
    shape_contacts_.hold_compounds(shape_setup(), block, of_compounds);
}

void ShapeContacts::need_holds() {
    if (held_.size() != batches_.size()) held_.assign(batches_.size(), HeldPoints{});
}

void ShapeContacts::let_go(std::uint32_t block) {
    if (held_.empty()) return;
    std::fill(held_.begin() + first_[block], held_.begin() + first_[block + 1], HeldPoints{});
}

void ShapeContacts::hold(const Bodies& bodies, std::uint32_t block, std::size_t lane, const HeldPlace& place) {
    MELD_EXPECT(held_.size() == batches_.size() && lane < lanes(block).size(), "lane {} of block {}", lane, block);
    const std::size_t batch = first_[block] + lane / kLanes;
    const int i = static_cast<int>(lane % kLanes);
    add_hold(bodies, batch, i, place);
    share_holds(bodies, batch, i, lanes(block)[lane].points);
}

void ShapeContacts::add_hold(const Bodies& bodies, std::size_t batch, int i, const HeldPlace& place) {
    const Vec3 moment = place.force_n * (place.at_m - centre_of(bodies.place[batches_[batch].a[i]]));
    HeldPoints& held = held_[batch];
    held.all[i] += static_cast<float>(place.force_n);
    held.x[i] += static_cast<float>(moment.x), held.y[i] += static_cast<float>(moment.y), held.z[i] += static_cast<float>(moment.z);
}

void ShapeContacts::share_holds(const Bodies& bodies, std::size_t batch, int i, std::size_t points) {
    HeldPoints& held = held_[batch];
    for (Lanes& force : held.force) force[i] = 0;
    if (!(held.all[i] > 0) || points == 0) return;
    const ShapeBatch& here = batches_[batch];
    const double radius = bodies.place[here.a[i]].radius;
    const Vec3 at = (1 / static_cast<double>(held.all[i])) * vector_of_lane(held.x, held.y, held.z, i);
    std::array<Vec3, kMaxManifoldPoints> arms;
    for (std::size_t p = 0; p < points; ++p)
        arms[p] = radius * vector_of_lane(here.points[p].ax, here.points[p].ay, here.points[p].az, i) - at;
    std::array<double, kMaxManifoldPoints> shares;
    shares_of(std::span(arms).first(points), std::span(shares).first(points));
    for (std::size_t p = 0; p < points; ++p) held.force[p][i] = held.all[i] * static_cast<float>(shares[p]);
}

void ShapeContacts::share_holds_anew(const Bodies& bodies, std::size_t batch, int i, std::size_t points) {
    std::array<HeldPoint, kMaxManifoldPoints> of;
    for (std::size_t p = 0; p < points; ++p) of[p] = {&batches_[batch], i, p, held_[batch].force[p][i], 0};
    share_holds(bodies, batch, i, points);
    for (std::size_t p = 0; p < points; ++p) of[p].now = held_[batch].force[p][i];
    move_pulls(std::span(of).first(points));
}

void ShapeContacts::move_pulls(std::span<const HeldPoint> points) {
    float gained = 0, pull = 0;
    for (const HeldPoint& point : points) gained += std::max(point.now - point.before, 0.0f);
    if (!(gained > 0)) return;
    for (const HeldPoint& point : points) {
        if (!(point.now < point.before)) continue;
        Lanes& impulses = point.batch->points[point.number].normal_impulse;
        const float moved = std::min(impulses[point.lane], 0.0f) * (1 - point.now / point.before);
        impulses[point.lane] -= moved, pull += moved;
    }
    for (const HeldPoint& point : points)
        if (point.now > point.before)
            point.batch->points[point.number].normal_impulse[point.lane] += pull * (point.now - point.before) / gained;
}

}  // namespace meld::physics
