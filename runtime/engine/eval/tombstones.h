// Tombstones of retraction: which groups have lost a value, and when, so that no fact of a higher rank takes its place too early.
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <vector>

#include "runtime/base/assert.h"
#include "runtime/module/abi/module_abi.h"

namespace meld::eval {

// The losses of groups (docs/design.md, "Ranks and quarantine"). Empty in a quiescent ensemble; in a wave of retraction most catoms have
// one, so they stand in one array in the order in which they came, found by a table of lines of catoms. Memory: 32 bytes a loss, and for
// each sixteen catoms one of which has lost something 64 and 16 to 32; twice as much while it grows.
class Tombstones {
  public:
    struct Entry {
        u16 predicate;
        u32 least_rank;
        u64 key;
        i64 time;
    };

    bool empty() const { return catoms_ == 0; }
    // Of catoms that have lost something.
    std::size_t count() const { return catoms_; }
    bool has(u32 catom) const { return first_of(catom) != kNone32; }

    const Entry* find(u32 catom, u16 predicate, u64 key) const {
        for (u32 at = first_of(catom); at != kNone32; at = losses_[at].next)
            if (losses_[at].entry.predicate == predicate && losses_[at].entry.key == key) return &losses_[at].entry;
        return nullptr;
    }
    // Those of a catom, in the order in which its groups lost something.
    std::vector<Entry> of(u32 catom) const {
        std::vector<Entry> found;
        for (u32 at = first_of(catom); at != kNone32; at = losses_[at].next) found.push_back(losses_[at].entry);
        return found;
    }
    // A group has now lost a fact of this rank. A tombstone that had expired is replaced, not extended.
    void lose(u32 catom, u16 predicate, u64 key, u32 rank, i64 now, u32 greatest_rank, u32 latency);
    // No existing rank is so great that this tombstone would still delay it.
    static bool expired(const Entry& e, i64 now, u32 greatest_rank, u32 latency) {
        return now > e.time + (i64{greatest_rank} - i64{e.least_rank} + 2) * latency;
    }
    // Removes what has expired. Cost: all tombstones.
    void sweep(i64 now, u32 greatest_rank, u32 latency);
    void forget(u32 catom);
    // Calls visit(catom, entries), in no order.
    template <class Visit>
    void each(const Visit& visit) const {
        for (const Line& line : lines_)
            for (const u32 first : line)
                if (first != kNone32) visit(losses_[first].catom, of(losses_[first].catom));
    }
    void restore(u32 catom, const std::vector<Entry>& entries);

  private:
    struct Loss {
        Entry entry;
        u32 catom;  // kNone32: it has been forgotten.
        u32 next;   // Of the same catom.
    };
    // The first loss of each of sixteen catoms in a row: what is lost in one tick is mostly near. One line of the cache.
    static constexpr u32 kLine = 16;
    using Line = std::array<u32, kLine>;
    struct Slot {
        u32 catoms = kNone32;  // The number of the line's first catom, divided by kLine.
        u32 line = 0;
    };
    // The slot of the catom's line, or the empty one in which it would be.
    std::size_t slot_of(u32 catoms) const {
        const std::size_t mask = table_.size() - 1;
        std::size_t slot = (u64{catoms} * 0x9E3779B97F4A7C15u >> 32) & mask;
        while (table_[slot].catoms != catoms && table_[slot].catoms != kNone32) slot = (slot + 1) & mask;
        return slot;
    }
    u32 first_of(u32 catom) const {
        if (catoms_ == 0) return kNone32;
        const Slot& slot = table_[slot_of(catom / kLine)];
        return slot.catoms == kNone32 ? kNone32 : lines_[slot.line][catom % kLine];
    }
    void add(u32 catom, const Entry& entry);
    Line& line_of(u32 catom);

    std::vector<Loss> losses_;
    std::vector<Line> lines_;
    std::vector<Slot> table_;  // Of lines_; open addressing, at most half full.
    std::size_t catoms_ = 0;
    bool forgotten_ = false;  // Some of losses_ have no catom.
};

}  // namespace meld::eval
