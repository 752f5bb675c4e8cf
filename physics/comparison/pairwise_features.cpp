// Features pair by pair, from a separate search for pairs.
#include "physics/comparison/pairwise_features.h"

#include <algorithm>

#include "physics/solver/feature_wrenches.h"

namespace meld::physics {

namespace {

Vec3 position(const Place& place) { return {place.x, place.y, place.z}; }

}  // namespace

Result<void> PairwiseFeatures::find(World& world, double dt_s, Workers& workers) {
    wrenches_.clear(), held_.clear();
    if (!world.has_features()) return {};
    Bodies& bodies = world.bodies;
    bodies.need_features();
    begin_feature_wrenches(world, wrenches_, dt_s, workers);
    const double range = world.feature_range_m();
    if (auto found = broadphase_->find(bodies, range, workers); !found) return found;
    for (const auto& list : broadphase_->pairs)
        for (const BodyPair pair : list) {
            if (bodies.features[pair.first].on == 0 || bodies.features[pair.second].on == 0) continue;
            const Place &a = bodies.place[pair.first], &b = bodies.place[pair.second];
            const Vec3 apart = position(b) - position(a);
            const double distance = length(apart), gap = distance - a.radius - b.radius;
            if (!(distance > 0 && gap < range)) continue;
            const Touch touch = touch_of(bodies.properties[pair.first].id, bodies.properties[pair.second].id);
            if (((bodies.properties[pair.first].flags | bodies.properties[pair.second].flags) & kShaped) != 0) {
                double all = 0;
                add_shape_feature_wrenches(world, wrenches_, pair.first, pair.second, [&](const HeldPlace& held) {
                    const Vec3 force = held.force_n * held.axis;
                    add_wrench(wrenches_[pair.first], force, cross(held.at_m - position(a), force));
                    add_wrench(wrenches_[pair.second], -force, cross(held.at_m - position(b), -force));
                    all += held.force_n;
                });
                if (all > 0) held_.push_back({touch, all});
                continue;
            }
            const Vec3 normal = (1 / distance) * apart;
            const double held = add_feature_wrenches(world, wrenches_, pair.first, pair.second, normal, gap);
            if (held == 0) continue;
            add_wrench(wrenches_[pair.first], held * normal, {});
            add_wrench(wrenches_[pair.second], -held * normal, {});
            held_.push_back({touch, held});
        }
    std::sort(held_.begin(), held_.end(), [](const Held& one, const Held& other) { return one.touch < other.touch; });
    return {};
}

void PairwiseFeatures::discount(std::vector<ContactReport>& reports) const {
    std::vector<bool> done(held_.size());
    for (ContactReport& report : reports) {
        const auto found = std::lower_bound(held_.begin(), held_.end(), report.touch,
                                            [](const Held& held, const Touch& touch) { return held.touch < touch; });
        if (found == held_.end() || found->touch != report.touch) continue;
        if (auto once = done[static_cast<std::size_t>(found - held_.begin())]; !once) report.normal_force_n -= found->force_n, once = true;
    }
}

}  // namespace meld::physics
