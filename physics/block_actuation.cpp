// Magnets, plates and latches along the candidate pairs. Forces go to per-body sums in colour order, so no two threads add to
// one body and the order of additions is the world's; latches go into the contact rows.
#include <algorithm>
#include <cmath>

#include "physics/actuation.h"
#include "physics/block_engine.h"

namespace meld::physics {

namespace {

constexpr std::size_t kSlotsPerJob = 4096;

Vec3 position(const Place& place) { return {place.x, place.y, place.z}; }
Quat orientation(const Turn& turn) {
    return {static_cast<double>(turn.w), static_cast<double>(turn.x), static_cast<double>(turn.y), static_cast<double>(turn.z)};
}

// The features of one body that are on and so near the other body that they can matter.
struct Near {
    std::uint8_t count = 0;
    std::uint8_t index[kMostFeatures];
};

// `towards` leads to the other body, a unit vector in the world; a feature at angle t from it has its surface point as far
// from the other's centre as the law of cosines says.
Near near_features(const std::vector<Feature>& table, std::uint32_t on, Quat turned, Vec3 towards, double radius, double other_radius,
                   double distance, double range) {
    const Vec3 local = rotate(conjugate(turned), towards);
    const double farthest = other_radius + range;
    const double least_cosine = (radius * radius + distance * distance - farthest * farthest) / (2 * radius * distance);
    Near near;
    for (std::size_t i = 0; i < table.size(); ++i)
        if ((on >> i & 1) != 0 && dot(table[i].direction, local) >= least_cosine) near.index[near.count++] = static_cast<std::uint8_t>(i);
    return near;
}

void add_push(Push& push, Vec3 force, Vec3 torque) {
    push.force[0] += static_cast<float>(force.x), push.force[1] += static_cast<float>(force.y),
        push.force[2] += static_cast<float>(force.z);
    push.torque[0] += static_cast<float>(torque.x), push.torque[1] += static_cast<float>(torque.y),
        push.torque[2] += static_cast<float>(torque.z);
}

}  // namespace

void BlockEngine::begin_actuation(double dt_s, Workers& workers) {
    Bodies& bodies = world_.bodies;
    pulls_.resize(bodies.count());
    const bool latches = std::any_of(world_.tables.begin(), world_.tables.end(), [](const auto& table) {
        return std::any_of(table.begin(), table.end(), [](const Feature& feature) { return feature.kind == FeatureKind::Latch; });
    });
    if (latches) contacts_.need_adhesion();
    workers.run((bodies.count() + kSlotsPerJob - 1) / kSlotsPerJob, [&](int, std::size_t job) {
        for (std::size_t slot = job * kSlotsPerJob; slot < std::min(bodies.count(), (job + 1) * kSlotsPerJob); ++slot) {
            pulls_[slot] = {};
            Bodies::FeatureState& state = bodies.features[slot];
            state.charge_before_j = std::exchange(state.charge_j, 0.0f);
            const std::vector<Feature>& table = world_.tables[state.table];
            for (std::size_t i = 0; i < table.size(); ++i)
                if (state.on >> i & 1) bodies.energy[slot] += table[i].power_w * dt_s;
        }
    });
}

// Charging a plate takes C V^2 from its supply, shared by both bodies; discharging gives nothing back. Bodies that sleep keep their charge.
void BlockEngine::settle_charges(Workers& workers) {
    Bodies& bodies = world_.bodies;
    workers.run((bodies.count() + kSlotsPerJob - 1) / kSlotsPerJob, [&](int, std::size_t job) {
        for (std::size_t slot = job * kSlotsPerJob; slot < std::min(bodies.count(), (job + 1) * kSlotsPerJob); ++slot) {
            Bodies::FeatureState& state = bodies.features[slot];
            if (bodies.motion[slot].inverse_mass == 0 && (bodies.nature[slot].flags & kFixed) == 0)
                state.charge_j = state.charge_before_j;
            else
                bodies.energy[slot] += std::max(0.0, static_cast<double>(state.charge_j) - static_cast<double>(state.charge_before_j));
        }
    });
}

void BlockEngine::actuate_block(std::uint32_t block) {
    const std::span<Batch> batches = contacts_.pairs(block);
    const auto range = static_cast<float>(world_.feature_range_m());
    const auto& features = world_.bodies.features;
    for (std::size_t n = 0; n < batches.size(); ++n) {
        Lanes held = lanes(0);
        for (int i = 0; i < kLanes; ++i) {
            const Batch& batch = batches[n];
            if (!(batch.gap[i] < range) || features[batch.a[i]].on == 0 || features[batch.b[i]].on == 0) continue;
            held[i] = static_cast<float>(actuate_pair(batch, i));
        }
        if (!contacts_.adhesion.empty()) contacts_.adhesion[contacts_.first_pair_batch(block) + n] = held;
    }
}

double BlockEngine::actuate_pair(const Batch& batch, int lane) {
    Bodies& bodies = world_.bodies;
    const std::uint32_t a = batch.a[lane], b = batch.b[lane];
    Bodies::FeatureState &a_state = bodies.features[a], &b_state = bodies.features[b];
    const std::vector<Feature>&a_table = world_.tables[a_state.table], &b_table = world_.tables[b_state.table];
    const Place &a_place = bodies.place[a], &b_place = bodies.place[b];
    const Quat a_turn = orientation(bodies.turn[a]), b_turn = orientation(bodies.turn[b]);
    const Vec3 normal{static_cast<double>(batch.nx[lane]), static_cast<double>(batch.ny[lane]), static_cast<double>(batch.nz[lane])};
    const double distance = static_cast<double>(batch.gap[lane]) + a_place.radius + b_place.radius, range = world_.feature_range_m();

    const Near a_near = near_features(a_table, a_state.on, a_turn, normal, a_place.radius, b_place.radius, distance, range);
    if (a_near.count == 0) return 0;
    const Near b_near = near_features(b_table, b_state.on, b_turn, -normal, b_place.radius, a_place.radius, distance, range);
    const auto pose = [](const Place& place, Quat turned, const Feature& feature, std::uint32_t reversed, std::uint8_t index) {
        const Vec3 direction = rotate(turned, feature.direction);
        return FeaturePose{position(place) + place.radius * direction, direction, (reversed >> index & 1) != 0 ? -1.0 : 1.0};
    };
    double held = 0;
    for (std::uint8_t i = 0; i < a_near.count; ++i)
        for (std::uint8_t j = 0; j < b_near.count; ++j) {
            const Feature &first = a_table[a_near.index[i]], &second = b_table[b_near.index[j]];
            if (first.kind != second.kind) continue;
            const FeaturePose first_pose = pose(a_place, a_turn, first, a_state.reversed, a_near.index[i]);
            const FeaturePose second_pose = pose(b_place, b_turn, second, b_state.reversed, b_near.index[j]);
            if (first.kind == FeatureKind::Latch) {
                if (length(second_pose.surface - first_pose.surface) < std::min(first.range_m, second.range_m))
                    held += std::min(first.strength, second.strength);
                continue;
            }
            double charge = 0;
            const Interaction done = interact(first, first_pose, second, second_pose, charge);
            const Vec3 a_lever = a_place.radius * first_pose.direction, b_lever = b_place.radius * second_pose.direction;
            add_push(pulls_[a], -done.force_n, done.first_torque_nm - cross(a_lever, done.force_n));
            add_push(pulls_[b], done.force_n, done.second_torque_nm + cross(b_lever, done.force_n));
            a_state.charge_j += static_cast<float>(charge / 2);
            b_state.charge_j += static_cast<float>(charge / 2);
        }
    return held;
}

}  // namespace meld::physics
