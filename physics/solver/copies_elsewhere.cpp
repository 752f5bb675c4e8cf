// Copies of composites in blocks of other subdomains of a divided world.
#include <algorithm>
#include <utility>

#include "physics/solver/composite_rows.h"
#include "runtime/base/assert.h"

namespace meld::physics {

std::vector<PlaceOfCopy> CompositeRows::copies_here() const {
    std::vector<PlaceOfCopy> here;
    if (empty()) return here;
    for (std::uint32_t c = 0; c + 1 < first_copy_.size(); ++c) {
        for (std::uint32_t n = first_copy_[c]; n < first_copy_[c + 1]; ++n)
            if (copy_of_[n] < block_of_copy_.size()) here.push_back({c, 0, copy_of_[n]});
        for (const Entry& entry : entries_of(c)) here.push_back({c, 1, entry.at});
    }
    return here;
}

CopyName CompositeRows::name_of(const PlaceOfCopy& copy, std::span<const Block> blocks, const Composites& composites) const {
    const BodyId lowest = composites.members(composites.all()[copy.composite]).front().id;
    if (copy.is_entry == 0) return {lowest, 0, blocks[block_of_copy_[copy.at]].key};
    const auto entries = entries_of(copy.composite);
    const auto entry = std::ranges::find(entries, copy.at, &Entry::at);
    MELD_CHECK(entry != entries.end(), "no entry {}", copy.at);
    return {lowest, 1, blocks[entry->block].key};
}

std::vector<PlaceOfCopy> CompositeRows::add_copies(std::span<const CopyName> elsewhere, ShapeContacts& shapes, Bodies& bodies,
                                                   const Composites& composites, std::span<const Block> blocks) {
    std::vector<PlaceOfCopy> places;
    if (elsewhere.empty()) return places;
    fresh_ = in_copies_ = false;
    // The copies of each composite with the keys of their blocks, and with the place of each.
    using Keyed = std::pair<std::uint64_t, std::uint32_t>;
    std::vector<std::vector<Keyed>> copies(composites.all().size());
    for (std::uint32_t copy = 0; copy < composite_of_.size(); ++copy)
        if (composite_of_[copy] != kNoComposite) copies[composite_of_[copy]].emplace_back(blocks[block_of_copy_[copy]].key, copy);
    for (Entry& entry : entries_) entry.block = blocks[entry.block].key;
    for (const CopyName& name : elsewhere) {
        const std::uint32_t composite = composites.composite_of(name.lowest);
        MELD_CHECK(composite != kNoComposite, "another part has a copy of a composite with body {}", name.lowest);
        if (name.is_entry != 0) {
            entries_.push_back({composite, add_entry(composite, shapes, bodies, composites), name.block});
            places.push_back({composite, 1, entries_.back().at});
            continue;
        }
        const auto copy = static_cast<std::uint32_t>(composite_of_.size());
        composite_of_.push_back(composite);
        copies[composite].emplace_back(name.block, copy);
        places.push_back({composite, 0, copy});
    }
    copies_.resize(composite_of_.size()), centres_.resize(composite_of_.size());
    for (const PlaceOfCopy& place : places)
        if (place.is_entry == 0) copies_[place.at] = {}, centres_[place.at] = {};
    first_copy_.assign(1, 0);
    copy_of_.clear();
    for (auto& of_one : copies) {
        std::ranges::sort(of_one);
        for (const auto& [key, copy] : of_one) copy_of_.push_back(copy);
        first_copy_.push_back(static_cast<std::uint32_t>(copy_of_.size()));
    }
    std::ranges::sort(entries_, {}, &Entry::block);
    sort_entries(composites);
    return places;
}

CopyVelocity CompositeRows::velocity_of(const PlaceOfCopy& copy, const Bodies& bodies) const {
    const float* linear = copy.is_entry != 0 ? bodies.velocity[copy.at].linear : copies_[copy.at].linear;
    const float* spin = copy.is_entry != 0 ? bodies.velocity[copy.at].surface : copies_[copy.at].spin;
    return {linear[0], linear[1], linear[2], spin[0], spin[1], spin[2]};
}

void CompositeRows::set_velocity(const PlaceOfCopy& copy, const CopyVelocity& velocity, Bodies& bodies) {
    float* linear = copy.is_entry != 0 ? bodies.velocity[copy.at].linear : copies_[copy.at].linear;
    float* spin = copy.is_entry != 0 ? bodies.velocity[copy.at].surface : copies_[copy.at].spin;
    std::copy_n(velocity.begin(), 3, linear);
    std::copy_n(velocity.begin() + 3, 3, spin);
}

}  // namespace meld::physics
