// Magnets, plates and latches along the candidate pairs. Forces are added to per-body sums in colour order, so no two threads add to one
// body and the order of additions depends only on the world; latches act through the contact rows.
#include <algorithm>
#include <utility>

#include "physics/bodies/actuation.h"
#include "physics/solver/block_engine.h"
#include "physics/solver/feature_wrenches.h"

namespace meld::physics {

void BlockEngine::begin_actuation(double dt_s, Workers& workers) {
    const bool latches = std::any_of(world_.tables.begin(), world_.tables.end(), [](const auto& table) {
        return std::any_of(table.begin(), table.end(), [](const Feature& feature) { return feature.kind == FeatureKind::Latch; });
    });
    if (latches) contacts_.need_adhesion();
    begin_feature_wrenches(world_, feature_wrenches_, dt_s, workers);
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
    const std::span<const ShapeLane> lanes_of_shapes = std::as_const(shape_contacts_).lanes(block);
    for (std::size_t n = 0; n < lanes_of_shapes.size(); ++n) {
        if (lanes_of_shapes[n].obstacle != kNoSlot || !lanes_of_shapes[n].is_first()) continue;
        const ShapeBatch& batch = std::as_const(shape_contacts_).batches(block)[n / kLanes];
        const std::uint32_t a = batch.a[n % kLanes], b = batch.b[n % kLanes];
        if (a >= world_.bodies.count() || features[a].on == 0 || features[b].on == 0) continue;
        add_shape_feature_wrenches(world_, feature_wrenches_, a, b);
    }
}

}  // namespace meld::physics
