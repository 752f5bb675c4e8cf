// The derivations of views that have no value at present: something in them divides by zero, overflows, or asks for an element that a list
// does not have. They count as absent (docs/design.md, "Undefined derivations"). Empty in most runs, and otherwise for most catoms.
#pragma once

#include <algorithm>
#include <tuple>
#include <unordered_map>
#include <vector>

#include "runtime/base/assert.h"
#include "runtime/engine/eval/failure.h"

namespace meld::eval {

class Undefined {
  public:
    // The first undefined derivation of a rule, in the order in which the catom's facts are read.
    struct Entry {
        u32 stratum;
        Failure failure;  // With the tick since which it has been undefined.
    };
    // For one catom, by rule, one each.
    using Entries = std::vector<Entry>;

    bool empty() const { return by_catom_.empty(); }
    const Entries* of(u32 catom) const {
        const auto found = by_catom_.find(catom);
        return found == by_catom_.end() ? nullptr : &found->second;
    }
    // The result of an evaluation of the catom. An undefined derivation that was there before keeps its tick.
    void replace(u32 catom, Entries entries) {
        MELD_EXPECT(std::is_sorted(entries.begin(), entries.end(), by_rule), "catom {}", catom);
        if (entries.empty()) {
            by_catom_.erase(catom);
            return;
        }
        Entries& held = by_catom_[catom];
        for (Entry& e : entries)
            for (const Entry& before : held)
                if (same_mistake(before.failure, e.failure)) e.failure.tick = before.failure.tick;
        held = std::move(entries);
    }
    void forget(u32 catom) { by_catom_.erase(catom); }
    // Calls visit(catom, entries), in no order.
    template <class Visit>
    void each(const Visit& visit) const {
        for (const auto& [catom, entries] : by_catom_) visit(catom, entries);
    }
    void restore(u32 catom, Entries entries) {
        MELD_EXPECT(!by_catom_.contains(catom), "catom {} has undefined derivations already", catom);
        if (!entries.empty()) by_catom_[catom] = std::move(entries);
    }
    // The first of all, which is reported, whichever process has it; trap None: there is none. Cost: all of them.
    Failure first() const {
        Failure first;
        for (const auto& [catom, entries] : by_catom_)
            for (const Entry& e : entries)
                if (first.trap == Trap::None || earlier(e.failure, first)) first = e.failure;
        return first;
    }
    // By tick, then catom, then rule.
    static bool earlier(const Failure& a, const Failure& b) {
        return std::tie(a.tick, a.catom, a.rule) < std::tie(b.tick, b.catom, b.rule);
    }
    static bool by_rule(const Entry& a, const Entry& b) { return a.failure.rule < b.failure.rule; }

  private:
    static bool same_mistake(const Failure& a, const Failure& b) {
        return a.rule == b.rule && a.trap == b.trap && a.left.integer == b.left.integer && a.right.integer == b.right.integer &&
               std::equal(std::begin(a.text), std::end(a.text), std::begin(b.text));
    }

    std::unordered_map<u32, Entries> by_catom_;
};

}  // namespace meld::eval
