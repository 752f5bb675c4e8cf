// Data that exists only temporarily: tombstones of groups that lost their value, and catoms to be woken later.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <iterator>
#include <limits>
#include <map>
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

// Catoms to mark at a later tick, and groups of theirs to look at then.
class Timers {
  public:
    void add(i64 now, i64 tick, u32 catom, u64 bits) {
        MELD_EXPECT(tick > now, "catom {} is to be woken in tick {}, which is past in {}", catom, tick, now);
        at_[tick].catoms.push_back({{catom, forgettings_}, static_cast<u32>(bits)});
    }
    // `row` is one of the group, with this many bytes.
    void add_group(i64 now, i64 tick, u32 catom, u16 column, const u8* row, std::size_t bytes) {
        MELD_EXPECT(tick > now && bytes > 0, "a group of catom {} is to be woken in tick {}, which is past in {}", catom, tick, now);
        Due& due = at_[tick];
        due.groups.push_back({{catom, forgettings_}, column, due.rows.size()});
        due.rows.insert(due.rows.end(), row, row + bytes);
    }
    bool empty() const { return at_.empty(); }
    i64 next() const {
        MELD_EXPECT(!empty());
        return at_.begin()->first;
    }
    // Timers added so far for a catom that is removed or has migrated are not for the next user of its index.
    void forget(u32 catom) {
        if (!at_.empty()) forgotten_[catom] = ++forgettings_;
    }

    // What still waits, in the order in which it will be marked: mark(tick, catom, bits) and wake_group(tick, catom, column, row); and
    // idle(tick) for a tick whose timers have all been forgotten. A run waits for that tick nevertheless: whether a catom has left this
    // process or has forgotten must make no difference to its end.
    template <class Mark, class WakeGroup, class Idle>
    void each(const Mark& mark, const WakeGroup& wake_group, const Idle& idle) const {
        for (const auto& [tick, due] : at_) {
            bool held = false;
            for (const Catom& c : due.catoms) {
                if (!holds(c.who)) continue;
                held = true;
                mark(tick, c.who.catom, c.bits);
            }
            for (const Group& g : due.groups) {
                if (!holds(g.who)) continue;
                held = true;
                wake_group(tick, g.who.catom, g.column, due.rows.data() + g.offset);
            }
            if (!held) idle(tick);
        }
    }
    void add_idle(i64 tick) { at_.try_emplace(tick); }

    // mark(catom, bits) and wake_group(catom, column, row).
    template <class Mark, class WakeGroup>
    void fire(i64 now, const Mark& mark, const WakeGroup& wake_group) {
        while (!at_.empty() && at_.begin()->first <= now) {
            const Due& due = at_.begin()->second;
            for (const Catom& c : due.catoms)
                if (holds(c.who)) mark(c.who.catom, c.bits);
            for (const Group& g : due.groups)
                if (holds(g.who)) wake_group(g.who.catom, g.column, due.rows.data() + g.offset);
            at_.erase(at_.begin());
        }
        if (at_.empty()) forgotten_.clear();
    }
    // Those that are due in this tick or later are so now.
    template <class Mark, class WakeGroup>
    void fire_late(i64 from, const Mark& mark, const WakeGroup& wake_group) {
        Timers late;
        late.forgettings_ = forgettings_;
        late.forgotten_ = forgotten_;
        const auto first = at_.lower_bound(from);
        late.at_.insert(std::make_move_iterator(first), std::make_move_iterator(at_.end()));
        at_.erase(first, at_.end());
        late.fire(std::numeric_limits<i64>::max(), mark, wake_group);
    }
    // Whether some are.
    bool waits_late(i64 from) const { return !at_.empty() && at_.rbegin()->first >= from; }

  private:
    struct Who {
        u32 catom;
        u64 after;  // How many times something had been forgotten when it was added. In one tick a catom may come and go, and another come.
    };
    struct Catom {
        Who who;
        u32 bits;
    };
    struct Group {
        Who who;
        u16 column;
        std::size_t offset;  // Into rows.
    };
    struct Due {
        std::vector<Catom> catoms;
        std::vector<Group> groups;
        std::vector<u8> rows;
    };
    bool holds(const Who& who) const {
        const auto found = forgotten_.find(who.catom);
        return found == forgotten_.end() || who.after >= found->second;
    }

    std::map<i64, Due> at_;
    u64 forgettings_ = 0;
    std::unordered_map<u32, u64> forgotten_;  // While a timer waits: which catoms' timers from before a forgetting are invalid.
};

}  // namespace meld::eval
