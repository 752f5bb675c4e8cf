// Tombstones of retraction: which groups have lost a value, and when, so that no fact of a higher rank takes its place too early.
#pragma once

#include <algorithm>
#include <cstddef>
#include <unordered_map>
#include <vector>

#include "runtime/base/assert.h"
#include "runtime/module/abi/module_abi.h"

namespace meld::eval {

// The losses of groups (docs/design.md, "Ranks and quarantine"). Empty in a quiescent ensemble.
class Tombstones {
  public:
    struct Entry {
        u16 predicate;
        u32 least_rank;
        u64 key;
        i64 time;
    };

    bool empty() const { return by_catom_.empty(); }
    std::size_t count() const { return by_catom_.size(); }

    const Entry* find(u32 catom, u16 predicate, u64 key) const {
        const auto found = by_catom_.find(catom);
        if (found == by_catom_.end()) return nullptr;
        for (const Entry& e : found->second)
            if (e.predicate == predicate && e.key == key) return &e;
        return nullptr;
    }
    // A group has now lost a fact of this rank. A tombstone that had expired is replaced, not extended.
    void lose(u32 catom, u16 predicate, u64 key, u32 rank, i64 now, u32 greatest_rank, u32 latency) {
        MELD_EXPECT(predicate != kNone16 && now > 0, "predicate {} in tick {}", predicate, now);
        std::vector<Entry>& list = by_catom_[catom];
        for (Entry& e : list)
            if (e.predicate == predicate && e.key == key) {
                e.least_rank = expired(e, now, greatest_rank, latency) ? rank : std::min(e.least_rank, rank);
                e.time = now;
                return;
            }
        list.push_back({predicate, rank, key, now});
    }
    // No existing rank is so great that this tombstone would still delay it.
    static bool expired(const Entry& e, i64 now, u32 greatest_rank, u32 latency) {
        return now > e.time + (i64{greatest_rank} - i64{e.least_rank} + 2) * latency;
    }
    // Removes what has expired. Cost: all tombstones.
    void sweep(i64 now, u32 greatest_rank, u32 latency) {
        for (auto it = by_catom_.begin(); it != by_catom_.end();) {
            std::erase_if(it->second, [&](const Entry& e) { return expired(e, now, greatest_rank, latency); });
            it = it->second.empty() ? by_catom_.erase(it) : std::next(it);
        }
    }
    void forget(u32 catom) { by_catom_.erase(catom); }
    // Calls visit(catom, entries), in no order.
    template <class Visit>
    void each(const Visit& visit) const {
        for (const auto& [catom, entries] : by_catom_) visit(catom, entries);
    }
    const std::vector<Entry>* of(u32 catom) const {
        const auto found = by_catom_.find(catom);
        return found == by_catom_.end() ? nullptr : &found->second;
    }
    void restore(u32 catom, std::vector<Entry> entries) {
        MELD_EXPECT(!by_catom_.contains(catom), "catom {} remembers losses already", catom);
        if (!entries.empty()) by_catom_[catom] = std::move(entries);
    }

  private:
    std::unordered_map<u32, std::vector<Entry>> by_catom_;
};

}  // namespace meld::eval
