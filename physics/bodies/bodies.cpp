// Adding bodies to the arrays and reordering the arrays.
#include "physics/bodies/bodies.h"

#include <algorithm>

#include "runtime/base/assert.h"

namespace meld::physics {

namespace {

constexpr std::size_t kSlotsPerJob = 16384;

template <class Array>
void permute_array(Array& array, std::span<const std::uint32_t> order, Workers& workers, std::size_t room = 0) {
    Array sorted;
    sorted.reserve(order.size() + room);
    sorted.resize(order.size());
    const std::size_t jobs = (order.size() + kSlotsPerJob - 1) / kSlotsPerJob;
    workers.run(jobs, [&](int, std::size_t job) {
        const std::size_t end = std::min(order.size(), (job + 1) * kSlotsPerJob);
        for (std::size_t i = job * kSlotsPerJob; i < end; ++i) sorted[i] = array[order[i]];
    });
    array.swap(sorted);
}

template <class Array>
std::size_t bytes_of(const Array& array) {
    return array.capacity() * sizeof(array[0]);
}

}  // namespace

void Bodies::add(const Place& where, const Orientation& turned, const BodyVelocity& moving, const BodyProperties& what) {
    MELD_EXPECT(!has(what.id), "body {}", what.id);
    if (what.id >= slot_of_id_.size()) {
        if (what.id >= slot_of_id_.capacity()) slot_of_id_.reserve(std::max<std::size_t>(what.id + 1u, 2 * slot_of_id_.capacity()));
        slot_of_id_.resize(what.id + 1u, kNoSlot);
    }
    MELD_EXPECT(where.radius > 0 && what.mass > 0, "body {}: radius {}, mass {}", what.id, where.radius, what.mass);
    slot_of_id_[what.id] = static_cast<std::uint32_t>(count());
    place.resize(count()), velocity.resize(count());
    place.push_back(where);
    orientation.push_back(turned);
    velocity.push_back(moving);
    properties.push_back(what);
    drift.push_back({0, 0, 0});
    if (!wrenches.empty()) wrenches.push_back({});
    if (!features.empty()) features.push_back({}), energy.push_back(0);
}

void Bodies::reserve(std::size_t bodies, std::size_t ids) {
    place.reserve(bodies), velocity.reserve(bodies), orientation.reserve(bodies), properties.reserve(bodies), drift.reserve(bodies);
    slot_of_id_.reserve(ids);
}

void Bodies::permute(std::span<const std::uint32_t> order, Workers& workers, std::size_t motionless) {
    MELD_EXPECT(order.size() <= count(), "{} of {} bodies", order.size(), count());
    MELD_EXPECT(place.size() >= count() && velocity.size() >= count() && orientation.size() == count() && drift.size() == count());
    const bool all_kept = order.size() == count();
    if (!all_kept) {
        std::vector<bool> kept(count());
        for (const std::uint32_t slot : order) kept[slot] = true;
        for (std::size_t slot = 0; slot < count(); ++slot)
            if (!kept[slot]) slot_of_id_[properties[slot].id] = kNoSlot;
    }
    permute_array(place, order, workers, motionless);
    permute_array(orientation, order, workers);
    permute_array(velocity, order, workers, motionless);
    permute_array(properties, order, workers);
    permute_array(drift, order, workers);
    if (!wrenches.empty()) permute_array(wrenches, order, workers);
    if (!features.empty()) permute_array(features, order, workers);
    if (!energy.empty()) permute_array(energy, order, workers);
    for (std::size_t slot = 0; slot < order.size(); ++slot) slot_of_id_[properties[slot].id] = static_cast<std::uint32_t>(slot);
    MELD_ENSURE(count() == order.size() && (wrenches.empty() || wrenches.size() == count()) &&
                (features.empty() || (features.size() == count() && energy.size() == count())));
}

void Bodies::restore_masses(std::uint32_t slot) {
    MELD_EXPECT(slot < count(), "slot {} of {}", slot, count());
    const BodyProperties& what = properties[slot];
    const bool fixed = (what.flags & (kFixed | kMember)) != 0;
    velocity[slot].inverse_mass = fixed ? 0.0f : 1.0f / what.mass;
    const bool turns_by_number = !fixed && (what.flags & kShaped) == 0;
    velocity[slot].inverse_surface_mass = turns_by_number ? 1.0f / (what.mass * what.inertia_factor) : 0.0f;
}

std::size_t Bodies::bytes() const {
    return bytes_of(velocity) + bytes_of(place) + bytes_of(orientation) + bytes_of(properties) + bytes_of(drift) + bytes_of(wrenches) +
           bytes_of(features) + bytes_of(energy) + bytes_of(slot_of_id_);
}

}  // namespace meld::physics
