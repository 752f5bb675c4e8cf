// Magnets, plates and latches along the candidate pairs. Forces are added to per-body sums in colour order, so no two threads add to one
// body and the order of additions depends only on the world; latches act through the contacts, between bodies with
// shapes through points that share their force.
#include <algorithm>
#include <array>
#include <span>
#include <utility>

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
    const std::span<const ShapeLane> lanes_of_shapes = std::as_const(shape_contacts_).lanes(block);
    for (std::size_t n = 0; n < lanes_of_shapes.size(); ++n) {
        if (lanes_of_shapes[n].obstacle != kNoSlot || !lanes_of_shapes[n].is_first()) continue;
        const ShapeBatch& batch = std::as_const(shape_contacts_).batches(block)[n / kLanes];
        const std::uint32_t a = batch.a[n % kLanes], b = batch.b[n % kLanes];
        if (a >= world_.bodies.count() || features[a].on == 0 || features[b].on == 0) continue;
        add_shape_feature_wrenches(world_, feature_wrenches_, a, b,
                                   [&](const HeldPlace& held) { shape_contacts_.hold(world_.bodies, block, n, held.at_m, held.force_n); });
    }
}

void ShapeContacts::need_holds() {
    if (held_.size() != batches_.size()) held_.assign(batches_.size(), HeldPoints{});
}

void ShapeContacts::let_go(std::uint32_t block) {
    if (held_.empty()) return;
    std::fill(held_.begin() + first_[block], held_.begin() + first_[block + 1], HeldPoints{});
}

void ShapeContacts::hold(const Bodies& bodies, std::uint32_t block, std::size_t lane, Vec3 at_m, double force_n) {
    MELD_EXPECT(held_.size() == batches_.size() && lane < lanes(block).size(), "lane {} of block {}", lane, block);
    const std::size_t batch = first_[block] + lane / kLanes;
    const int i = static_cast<int>(lane % kLanes);
    const Vec3 moment = force_n * (at_m - centre_of(bodies.place[batches_[batch].a[i]]));
    HeldPoints& held = held_[batch];
    held.all[i] += static_cast<float>(force_n);
    held.x[i] += static_cast<float>(moment.x), held.y[i] += static_cast<float>(moment.y), held.z[i] += static_cast<float>(moment.z);
    share_holds(bodies, batch, i, lanes(block)[lane].points);
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
    const PointShares shares = shares_of(std::span(arms).first(points));
    for (std::size_t p = 0; p < points; ++p) held.force[p][i] = held.all[i] * static_cast<float>(shares[p]);
}

}  // namespace meld::physics
