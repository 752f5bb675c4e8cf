#include "runtime/ask/facts/holders.h"

#include <algorithm>
#include <bit>

#include "runtime/engine/tuple/facts.h"

namespace meld::inspect {

namespace {

constexpr std::size_t kBits = 64;
// If one catom of so many holds facts of a predicate, most words have a bit, and all catoms are looked at in the order of memory.
constexpr std::size_t kCommon = 16;

}  // namespace

Holders::Holders(sim::Subdomain& subdomain, std::vector<u32> predicates) : subdomain_(subdomain), touched_(subdomain.follow()) {
    for (const u32 predicate : predicates) all_.push_back({.predicate = predicate});
}

void Holders::update() {
    subdomain_.refresh();
    changed_.clear();
    touched_.take([&](sim::Catom catom) { changed_.push_back(catom); });
    if (changed_.empty()) return;
    for (Of& one : all_) note(one, changed_);
}

void Holders::note(Of& one, std::span<const sim::Catom> catoms) const {
    one.words.resize(std::max(one.words.size(), catoms.back() / kBits + 1), 0);
    for (const sim::Catom catom : catoms) {
        const bool holds = catom < subdomain_.ensemble.index_count() && subdomain_.owned(catom) &&
                           tuple::count_facts(subdomain_.module, subdomain_.columns, subdomain_.geometry(), one.predicate, catom) > 0;
        u64& word = one.words[catom / kBits];
        const u64 bit = u64{1} << (catom % kBits);
        if (((word & bit) != 0) == holds) continue;
        word ^= bit;
        one.count = holds ? one.count + 1 : one.count - 1;
    }
    one.listed = false;
}

void Holders::list(Of& one) const {
    one.by_id.clear();
    for (std::size_t at = 0; at < one.words.size(); ++at)
        for (u64 left = one.words[at]; left != 0; left &= left - 1) {
            const auto catom = static_cast<sim::Catom>(at * kBits + static_cast<std::size_t>(std::countr_zero(left)));
            one.by_id.emplace_back(subdomain_.ensemble.id(catom), catom);
        }
    if (!std::ranges::is_sorted(one.by_id)) std::ranges::sort(one.by_id);
    one.listed = true;
}

const std::vector<std::pair<u64, sim::Catom>>* Holders::few(u32 predicate) {
    const auto found = std::ranges::find(all_, predicate, &Of::predicate);
    if (found == all_.end() || found->count > subdomain_.ensemble.owned_count() / kCommon) return nullptr;
    if (!found->listed) list(*found);
    return &found->by_id;
}

}  // namespace meld::inspect
