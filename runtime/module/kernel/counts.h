// Included by modules with counters: counts what rules do, and what becomes of it at the end of a catom's evaluation.
#pragma once

#include "runtime/module/kernel/relation.h"

namespace meld {

// While the body of a rule is evaluated, or its own part of one that it shares with rules that begin alike.
class CountedRule {
  public:
    CountedRule(Eval& e, u32 rule) : e_(e), counts_(e.counters->rules[rule]), before_(e.derivations) {}
    CountedRule(const CountedRule&) = delete;
    CountedRule& operator=(const CountedRule&) = delete;
    ~CountedRule() { counts_.derivations += e_.derivations - before_; }

  private:
    Eval& e_;
    RuleCounts& counts_;
    u64 before_;
};

// The bits of a value that consists of several words, as it would be sent: a list, set, array or string begins with its length.
[[gnu::noinline]] inline u64 value_bits(const TypeInfo* types, u16 type, u64 word) {
    constexpr u64 kLength_bits = 32;
    const TypeInfo& t = types[type];
    switch (t.kind) {
        case ValueType::Bool:
            return 1;
        case ValueType::Int:
        case ValueType::Float:
        case ValueType::Node:
            return 64;
        case ValueType::Vec3:
            return 3 * 64;
        default:
            break;
    }
    const List* list = reinterpret_cast<const List*>(word);
    const u32 count = list == nullptr ? 0 : list->count;
    if (t.kind == ValueType::String) return kLength_bits + u64{8} * count;
    const bool parts = t.kind == ValueType::Struct || t.kind == ValueType::Tuple;
    u64 bits = parts ? 0 : kLength_bits;
    for (u32 i = 0; i < count; ++i) bits += value_bits(types, t.parts[parts ? i : 0], list->items[i]);
    return bits;
}

// What an evaluation has changed in a predicate.
struct Changes {
    u64 gained = 0, lost = 0, retracted = 0;
    LinkCounts told = {};  // Over each link.
};

// Where the group of a row begins, or would begin, among those that hold now: they are in the order of their groups.
template <class T>
u32 first_of_group(const Relation<T>& r, const typename T::Row& row) {
    u32 begin = 0, end = r.count;
    while (begin < end) {
        const u32 middle = begin + (end - begin) / 2;
        if (T::group(r.rows[middle], row) < 0)
            begin = middle + 1;
        else
            end = middle;
    }
    return begin;
}

// Compares what held before with what holds now. bits(row): of a message.
template <class T, class Bits>
[[gnu::noinline]] Changes compare_rows(const Relation<T>& r, const Bits& bits) {
    using Row = typename T::Row;
    Changes out;
    const auto tell = [&](const Row& row) {
        ++out.told.messages;
        out.told.bits += bits(row);
    };
    // Of values of one group, if there may be several (fronts.h).
    const auto superseded = [&]([[maybe_unused]] const Row& row) {
        if constexpr (requires { T::group(row, row); })
            for (u32 i = first_of_group<T>(r, row); i < r.count && T::group(r.rows[i], row) == 0; ++i)
                if (!T::better(row, r.rows[i])) return true;
        return false;
    };
    u32 a = 0, b = 0;
    while (a < r.origin_count || b < r.count) {
        const int side = a == r.origin_count ? 1 : b == r.count ? -1 : T::key(r.origin[a], r.rows[b]);
        if (side < 0) {
            ++out.lost;
            out.retracted += !superseded(r.origin[a]);
            tell(r.origin[a]);
        } else if (side > 0) {
            ++out.gained;
            tell(r.rows[b]);
        } else if (!T::same(r.origin[a], r.rows[b])) {
            ++out.lost;
            ++out.gained;
            out.retracted += !T::better(r.rows[b], r.origin[a]);
            tell(r.rows[b]);
        } else if constexpr (T::kRanked) {
            // The same fact, which neighbours now trust otherwise.
            if (r.origin[a].rank != r.rows[b].rank) tell(r.rows[b]);
        }
        a += side <= 0;
        b += side >= 0;
    }
    return out;
}

// links: over how many links neighbours read the predicate, 0 if none does.
template <class T, class Bits>
void count_changes(Eval& e, const Relation<T>& r, u32 predicate, u32 links, const Bits& bits) {
    // Most often, a fact has come where there was none.
    const Changes made = r.origin_count == 0 && r.count == 1 ? Changes{1, 0, 0, {1, bits(r.rows[0])}} : compare_rows(r, bits);
    PredicateCounts& counts = e.counters->predicates[predicate];
    counts.gained += made.gained;
    counts.lost += made.lost;
    counts.retracted += made.retracted;
    if (made.gained + made.lost != 0) counts.last_tick = e.subdomain->now;
    if (links == 0) return;
    counts.messages += made.told.messages * links;
    counts.bits += made.told.bits * links;
    e.counters->now_links = links;
    e.counters->now.messages += made.told.messages;
    e.counters->now.bits += made.told.bits;
}

// Linear facts made at their catom, or consumed there; actions asked for.
inline void count_gained(Eval& e, u32 predicate) {
    ++e.counters->predicates[predicate].gained;
    e.counters->predicates[predicate].last_tick = e.subdomain->now;
}
inline void count_consumed(Eval& e, u32 predicate, u32 n) {
    e.counters->predicates[predicate].lost += n;
    e.counters->predicates[predicate].last_tick = e.subdomain->now;
}

// A linear fact is sent over the link at a port; port -1: to a catom that no link leads to.
inline void count_sent(Eval& e, u32 rule, u32 predicate, i32 port, u64 bits) {
    Counters& all = *e.counters;
    ++all.rules[rule].messages;
    all.rules[rule].bits += bits;
    ++all.predicates[predicate].messages;
    all.predicates[predicate].bits += bits;
    all.predicates[predicate].last_tick = e.subdomain->now;
    if (port < 0) return;
    ++all.sent[port].messages;
    all.sent[port].bits += bits;
    all.any_sent = true;
}

// The ports over which linear facts were sent.
[[gnu::noinline]] inline void count_ports(Eval& e) {
    Counters& all = *e.counters;
    const i32 ports = ports_of(e.subdomain->geometry, e.catom);
    for (i32 port = 0; port < ports; ++port) {
        LinkCounts& sent = all.sent[port];
        if (sent.messages == 0) continue;
        LinkCounts& link = all.links[u64{e.catom} * kMaxPorts + static_cast<u32>(port < kMaxPorts ? port : kMaxPorts - 1)];
        link.messages += sent.messages;
        link.bits += sent.bits;
        const LinkCounts now{all.now.messages + sent.messages, all.now.bits + sent.bits};
        if (now.messages > all.greatest.messages) all.greatest.messages = now.messages;
        if (now.bits > all.greatest.bits) all.greatest.bits = now.bits;
        sent = {};
    }
    all.any_sent = false;
}

// At the end of a catom's evaluation: what its links have carried in this tick.
inline void end_counts(Eval& e) {
    Counters& all = *e.counters;
    if (all.any_sent) count_ports(e);
    if (all.now.messages == 0) return;
    all.told[all.told_count++] = {e.catom, all.now_links, all.now};
    all.now = {};
}

}  // namespace meld
