// The effects of two bodies' features on each other, body by body and pair by pair.
#include "physics/solver/feature_wrenches.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <span>

#include "physics/bodies/actuation.h"
#include "runtime/base/assert.h"

namespace meld::physics {

namespace {

constexpr std::size_t kWrenchesPerJob = 4096;

Vec3 position(const Place& place) { return {place.x, place.y, place.z}; }
Quat orientation(const Orientation& turn) {
    return {static_cast<double>(turn.w), static_cast<double>(turn.x), static_cast<double>(turn.y), static_cast<double>(turn.z)};
}

// The features of one body that are on and near enough to the other body to matter.
struct Near {
    std::uint8_t count = 0;
    std::uint8_t index[kMaxFeatures];
};

// `towards` leads to the other body, a unit vector in the world. The distance of a feature at angle t from the other's centre, at its
// depth, follows from the law of cosines; the deepest feature stands for all.
Near near_features(const std::vector<Feature>& table, std::uint32_t on, Quat turned, Vec3 towards, double radius, double other_radius,
                   double distance, double range, double depth) {
    const Vec3 local = rotate(conjugate(turned), towards);
    const double inner = radius - depth, farthest = other_radius + range + depth;
    const double least_cosine = inner > 0 ? (inner * inner + distance * distance - farthest * farthest) / (2 * inner * distance)
                                          : -std::numeric_limits<double>::infinity();
    Near near;
    for (std::size_t i = 0; i < table.size(); ++i)
        if ((on >> i & 1) != 0 && dot(table[i].direction, local) >= least_cosine) near.index[near.count++] = static_cast<std::uint8_t>(i);
    return near;
}

// The features of a body that are on and may reach another one.
struct Reaching {
    struct One {
        const Feature* feature;
        FeaturePose pose;
        Vec3 lever;
    };
    std::size_t count = 0;
    std::array<One, kMaxFeatures> of;
};

void find_reaching(const World& world, std::uint32_t slot, std::uint32_t other, Reaching& found) {
    const Bodies& bodies = world.bodies;
    const Bodies::FeatureState& state = bodies.features[slot];
    const std::vector<Feature>& table = world.tables[state.table];
    const BodyShapes::Index shape = world.shapes.of(bodies.properties[slot].id);
    const Place &place = bodies.place[slot], &other_place = bodies.place[other];
    const Quat turned = orientation(bodies.orientation[slot]);
    const Vec3 apart = position(other_place) - position(place);
    // Depths lead inwards, here and there, and so away from the other body.
    const double farthest = other_place.radius + world.feature_range_m() + 4 * world.feature_depth_m();
    found.count = 0;
    for (std::size_t i = 0; i < table.size(); ++i) {
        if ((state.on >> i & 1) == 0) continue;
        const double way = shape == 0 ? place.radius : world.shapes.kind(shape).shape.way_out_m(table[i].direction);
        const Vec3 direction = rotate(turned, table[i].direction), lever = way * direction, to_other = apart - lever;
        if (dot(to_other, to_other) > farthest * farthest) continue;
        const double sign = ((state.reversed >> i & 1) != 0 ? -1.0 : 1.0) * world.coils.share(bodies.properties[slot].id, i);
        found.of[found.count++] = {&table[i], {position(place) + lever, direction, sign}, lever};
    }
}

// Where two features hold each other that have met, if they do; `force_n` is above 0.
HeldPlace held_by(const Reaching::One& first, const Reaching::One& second, double force_n) {
    const Vec3 facing = first.pose.direction - second.pose.direction;
    const double faces = length(facing);
    const Vec3 axis = faces > 0 ? (1 / faces) * facing : first.pose.direction;
    return {0.5 * (first.pose.surface + second.pose.surface), axis, force_n, std::min(first.feature->range_m, second.feature->range_m)};
}

}  // namespace

void add_wrench(Wrench& wrench, Vec3 force, Vec3 torque) {
    wrench.force[0] += static_cast<float>(force.x), wrench.force[1] += static_cast<float>(force.y),
        wrench.force[2] += static_cast<float>(force.z);
    wrench.torque[0] += static_cast<float>(torque.x), wrench.torque[1] += static_cast<float>(torque.y),
        wrench.torque[2] += static_cast<float>(torque.z);
}

std::vector<std::uint32_t> begin_feature_wrenches(World& world, std::vector<Wrench>& wrenches, double dt_s, Workers& workers) {
    Bodies& bodies = world.bodies;
    MELD_EXPECT(bodies.features.size() == bodies.count() && bodies.energy.size() == bodies.count(), "{} bodies", bodies.count());
    std::vector<std::uint32_t> changed = world.coils.step(world.tables, bodies, dt_s, workers);
    wrenches.resize(bodies.count());
    workers.run((bodies.count() + kWrenchesPerJob - 1) / kWrenchesPerJob, [&](int, std::size_t job) {
        for (std::size_t slot = job * kWrenchesPerJob; slot < std::min(bodies.count(), (job + 1) * kWrenchesPerJob); ++slot) {
            wrenches[slot] = {};
            Bodies::FeatureState& state = bodies.features[slot];
            state.charge_before_j = std::exchange(state.charge_j, 0.0f);
            const std::vector<Feature>& table = world.tables[state.table];
            for (std::size_t i = 0; i < table.size(); ++i)
                if (state.on >> i & 1) bodies.energy[slot] += table[i].power_w * dt_s;
        }
    });
    return changed;
}

// Charging a plate takes C V^2 from its supply, shared by both bodies; discharging returns nothing. Bodies that sleep keep their charge.
void account_charges(World& world, Workers& workers) {
    Bodies& bodies = world.bodies;
    workers.run((bodies.count() + kWrenchesPerJob - 1) / kWrenchesPerJob, [&](int, std::size_t job) {
        for (std::size_t slot = job * kWrenchesPerJob; slot < std::min(bodies.count(), (job + 1) * kWrenchesPerJob); ++slot) {
            Bodies::FeatureState& state = bodies.features[slot];
            if (bodies.velocity[slot].inverse_mass == 0 && (bodies.properties[slot].flags & kFixed) == 0)
                state.charge_j = state.charge_before_j;
            else
                bodies.energy[slot] += std::max(0.0, static_cast<double>(state.charge_j) - static_cast<double>(state.charge_before_j));
        }
    });
}

double add_feature_wrenches(World& world, std::vector<Wrench>& wrenches, std::uint32_t a, std::uint32_t b, Vec3 normal, double gap_m) {
    MELD_EXPECT(a != b && a < wrenches.size() && b < wrenches.size(), "slots {} and {} of {}", a, b, wrenches.size());
    Bodies& bodies = world.bodies;
    Bodies::FeatureState &a_state = bodies.features[a], &b_state = bodies.features[b];
    const std::vector<Feature>&a_table = world.tables[a_state.table], &b_table = world.tables[b_state.table];
    const Place &a_place = bodies.place[a], &b_place = bodies.place[b];
    const Quat a_turn = orientation(bodies.orientation[a]), b_turn = orientation(bodies.orientation[b]);
    const double distance = gap_m + a_place.radius + b_place.radius, range = world.feature_range_m(), depth = world.feature_depth_m();

    const Near a_near = near_features(a_table, a_state.on, a_turn, normal, a_place.radius, b_place.radius, distance, range, depth);
    if (a_near.count == 0) return 0;
    const Near b_near = near_features(b_table, b_state.on, b_turn, -normal, b_place.radius, a_place.radius, distance, range, depth);
    const auto pose = [&](std::uint32_t slot, const Place& place, Quat turned, const Feature& feature, std::uint8_t index) {
        const Vec3 direction = rotate(turned, feature.direction);
        const double sign = (bodies.features[slot].reversed >> index & 1) != 0 ? -1.0 : 1.0;
        return FeaturePose{position(place) + place.radius * direction, direction,
                           sign * world.coils.share(bodies.properties[slot].id, index)};
    };
    double held = 0;
    for (std::uint8_t i = 0; i < a_near.count; ++i)
        for (std::uint8_t j = 0; j < b_near.count; ++j) {
            const Feature &first = a_table[a_near.index[i]], &second = b_table[b_near.index[j]];
            if (first.kind != second.kind) continue;
            const FeaturePose first_pose = pose(a, a_place, a_turn, first, a_near.index[i]);
            const FeaturePose second_pose = pose(b, b_place, b_turn, second, b_near.index[j]);
            double charge = 0;
            if (holds(first.kind)) {
                held += holding_force_n(first, first_pose, second, second_pose, charge);
            } else {
                const Interaction done = interact(first, first_pose, second, second_pose, charge);
                const Vec3 a_lever = a_place.radius * first_pose.direction, b_lever = b_place.radius * second_pose.direction;
                add_wrench(wrenches[a], -done.force_n, done.first_torque_nm - cross(a_lever, done.force_n));
                add_wrench(wrenches[b], done.force_n, done.second_torque_nm + cross(b_lever, done.force_n));
            }
            a_state.charge_j += static_cast<float>(charge / 2);
            b_state.charge_j += static_cast<float>(charge / 2);
        }
    return held;
}

void add_shape_feature_wrenches(World& world, std::vector<Wrench>& wrenches, std::uint32_t a, std::uint32_t b,
                                const std::function<void(const HeldPlace&)>& hold) {
    MELD_EXPECT(a != b && a < wrenches.size() && b < wrenches.size(), "slots {} and {} of {}", a, b, wrenches.size());
    Reaching of_a, of_b;
    find_reaching(world, a, b, of_a);
    if (of_a.count == 0) return;
    find_reaching(world, b, a, of_b);
    Bodies& bodies = world.bodies;
    for (const Reaching::One& first : std::span(of_a.of).first(of_a.count))
        for (const Reaching::One& second : std::span(of_b.of).first(of_b.count)) {
            if (first.feature->kind != second.feature->kind) continue;
            double charge = 0;
            if (holds(first.feature->kind)) {
                const double force = holding_force_n(*first.feature, first.pose, *second.feature, second.pose, charge);
                if (force > 0) hold(held_by(first, second, force));
            } else {
                const Interaction done = interact(*first.feature, first.pose, *second.feature, second.pose, charge);
                add_wrench(wrenches[a], -done.force_n, done.first_torque_nm - cross(first.lever, done.force_n));
                add_wrench(wrenches[b], done.force_n, done.second_torque_nm + cross(second.lever, done.force_n));
            }
            bodies.features[a].charge_j += static_cast<float>(charge / 2);
            bodies.features[b].charge_j += static_cast<float>(charge / 2);
        }
}

}  // namespace meld::physics
