// Adding bodies to the arrays and bringing the arrays into another order.
#include "physics/bodies.h"

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

void Bodies::add(const Place& where, const Turn& turned, const Motion& moving, const Nature& what) {
    MELD_EXPECT(!has(what.id), "body {}", what.id);
    if (what.id >= slot_of_id_.size()) {
        if (what.id >= slot_of_id_.capacity()) slot_of_id_.reserve(std::max<std::size_t>(what.id + 1u, 2 * slot_of_id_.capacity()));
        slot_of_id_.resize(what.id + 1u, kNoSlot);
    }
    slot_of_id_[what.id] = static_cast<std::uint32_t>(count());
    place.resize(count()), motion.resize(count());
    place.push_back(where);
    turn.push_back(turned);
    motion.push_back(moving);
    nature.push_back(what);
    drift.push_back({0, 0, 0});
    if (!pushes.empty()) pushes.push_back({});
    if (!features.empty()) features.push_back({}), energy.push_back(0);
}

void Bodies::reserve(std::size_t bodies, std::size_t ids) {
    place.reserve(bodies), motion.reserve(bodies), turn.reserve(bodies), nature.reserve(bodies), drift.reserve(bodies);
    slot_of_id_.reserve(ids);
}

void Bodies::permute(std::span<const std::uint32_t> order, Workers& workers, std::size_t motionless) {
    const bool all_kept = order.size() == count();
    if (!all_kept) {
        std::vector<bool> kept(count());
        for (const std::uint32_t slot : order) kept[slot] = true;
        for (std::size_t slot = 0; slot < count(); ++slot)
            if (!kept[slot]) slot_of_id_[nature[slot].id] = kNoSlot;
    }
    permute_array(place, order, workers, motionless);
    permute_array(turn, order, workers);
    permute_array(motion, order, workers, motionless);
    permute_array(nature, order, workers);
    permute_array(drift, order, workers);
    if (!pushes.empty()) permute_array(pushes, order, workers);
    if (!features.empty()) permute_array(features, order, workers);
    if (!energy.empty()) permute_array(energy, order, workers);
    for (std::size_t slot = 0; slot < order.size(); ++slot) slot_of_id_[nature[slot].id] = static_cast<std::uint32_t>(slot);
}

void Bodies::restore_masses(std::uint32_t slot) {
    const Nature& what = nature[slot];
    const bool fixed = (what.flags & kFixed) != 0;
    motion[slot].inverse_mass = fixed ? 0.0f : 1.0f / what.mass;
    motion[slot].inverse_rim_mass = fixed ? 0.0f : 1.0f / (what.mass * what.inertia_factor);
}

std::size_t Bodies::bytes() const {
    return bytes_of(motion) + bytes_of(place) + bytes_of(turn) + bytes_of(nature) + bytes_of(drift) + bytes_of(pushes) +
           bytes_of(features) + bytes_of(energy) + bytes_of(slot_of_id_);
}

}  // namespace meld::physics
