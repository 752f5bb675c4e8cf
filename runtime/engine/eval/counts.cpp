#include "runtime/engine/eval/counts.h"

#include <algorithm>

namespace meld::eval {

void add(RuleCounts& sum, const RuleCounts& more) {
    sum.evaluations += more.evaluations;
    sum.firings += more.firings;
    sum.derivations += more.derivations;
    sum.messages += more.messages;
    sum.bits += more.bits;
}

void add(PredicateCounts& sum, const PredicateCounts& more) {
    sum.gained += more.gained;
    sum.lost += more.lost;
    sum.retracted += more.retracted;
    sum.waiting += more.waiting;
    sum.messages += more.messages;
    sum.bits += more.bits;
    sum.last_tick = std::max(sum.last_tick, more.last_tick);
}

void raise(LinkCounts& greatest, const LinkCounts& other) {
    greatest.messages = std::max(greatest.messages, other.messages);
    greatest.bits = std::max(greatest.bits, other.bits);
}

namespace {

void add(LinkCounts& sum, const LinkCounts& more) {
    sum.messages += more.messages;
    sum.bits += more.bits;
}

}  // namespace

void add(CatomLoad& sum, const CatomLoad& more) {
    sum.evaluations += more.evaluations;
    sum.told.each += more.told.each;
    sum.told.messages += more.told.messages;
    sum.told.each_bits += more.told.each_bits;
    sum.told.bits += more.told.bits;
    for (std::size_t port = 0; port < sum.sent.size(); ++port) add(sum.sent[port], more.sent[port]);
}

LinkCounts CatomLoad::messages() const {
    LinkCounts sum{told.messages, told.bits};
    for (const LinkCounts& port : sent) add(sum, port);
    return sum;
}

LinkCounts CatomLoad::greatest_link() const {
    LinkCounts greatest;
    for (const LinkCounts& port : sent) raise(greatest, port);
    return {greatest.messages + told.each, greatest.bits + told.each_bits};
}

Counts::Counts(const ModuleInfo& module, std::size_t threads) : module_(module), threads_(threads) {
    for (Thread& t : threads_) {
        t.rules.resize(module.rule_count);
        t.predicates.resize(module.predicate_count);
        t.counters.rules = t.rules.data();
        t.counters.predicates = t.predicates.data();
    }
}

void Counts::resize(std::size_t catoms) {
    evaluations_.resize(catoms);
    if (!module_.counts) return;
    told_.resize(catoms);
    if (module_.sends) links_.resize(catoms * kMaxPorts);
    for (Thread& t : threads_) t.counters.links = links_.data();
}

void Counts::room_for_ports(std::size_t ports) {
    if (links_.empty()) return;
    for (Thread& t : threads_) {
        if (t.sent.size() < ports) t.sent.resize(ports);
        t.counters.sent = t.sent.data();
    }
}

void Counts::begin_block(std::size_t i, std::size_t catoms) {
    Thread& t = threads_[i];
    if (t.told.size() < catoms) t.told.resize(catoms);
    t.counters.told = t.told.data();
    t.counters.told_count = 0;
}

void Counts::end_block(std::size_t i, std::span<const u32> catoms) {
    for (const u32 catom : catoms) ++evaluations_[catom];
    Thread& t = threads_[i];
    LinkCounts greatest = t.counters.greatest;
    for (const Told& one : std::span(t.told).first(t.counters.told_count)) {
        ToldSoFar& sum = told_[one.catom];
        const u64 each_bits = sum.each_bits + one.each.bits, bits = sum.bits + one.each.bits * one.links;
        sum.each += static_cast<u32>(one.each.messages);
        sum.messages += static_cast<u32>(one.each.messages * one.links);
        sum.each_bits = static_cast<u32>(each_bits);
        sum.bits = static_cast<u32>(bits);
        if ((each_bits | bits) >> 32 != 0) [[unlikely]] {
            CatomTold& large = t.large[one.catom];
            large.each_bits += each_bits - sum.each_bits;
            large.bits += bits - sum.bits;
        }
        raise(greatest, one.each);
    }
    t.counters.greatest = greatest;
    t.counters.told_count = 0;
}

void Counts::forget(u32 catom, u64 id) {
    MELD_EXPECT(catom < evaluations_.size(), "catom {} of {}", catom, evaluations_.size());
    // Ghosts are never evaluated.
    if (evaluations_[catom] == 0) return;
    add(left_[id], this->catom(catom));
    evaluations_[catom] = 0;
    if (!told_.empty()) told_[catom] = {};
    for (Thread& t : threads_) t.large.erase(catom);
    if (!links_.empty()) std::fill_n(links_.begin() + std::ptrdiff_t{catom} * kMaxPorts, kMaxPorts, LinkCounts{});
}

RuleCounts Counts::rule(u32 rule) const {
    RuleCounts sum;
    for (const Thread& t : threads_) add(sum, t.rules[rule]);
    if (!module_.rules[rule].linear) sum.firings = sum.derivations;
    return sum;
}

PredicateCounts Counts::predicate(u32 predicate) const {
    PredicateCounts sum;
    for (const Thread& t : threads_) add(sum, t.predicates[predicate]);
    return sum;
}

LinkCounts Counts::greatest() const {
    LinkCounts greatest;
    for (const Thread& t : threads_) raise(greatest, t.counters.greatest);
    return greatest;
}

CatomTold Counts::told(u32 catom) const {
    if (told_.empty()) return {};
    const ToldSoFar& small = told_[catom];
    CatomTold told{small.each, small.messages, small.each_bits, small.bits};
    for (const Thread& t : threads_) {
        if (t.large.empty()) continue;
        const auto large = t.large.find(catom);
        if (large == t.large.end()) continue;
        told.each_bits += large->second.each_bits;
        told.bits += large->second.bits;
    }
    return told;
}

CatomLoad Counts::catom(u32 catom) const {
    CatomLoad load{evaluations_[catom], told(catom), {}};
    if (!links_.empty()) std::copy_n(links_.begin() + std::ptrdiff_t{catom} * kMaxPorts, kMaxPorts, load.sent.begin());
    return load;
}

CatomSums Counts::sums(u32 catom) const {
    if (links_.empty()) {
        const CatomTold all = told(catom);
        return {evaluations_[catom], {all.messages, all.bits}, {all.each, all.each_bits}};
    }
    const CatomLoad load = this->catom(catom);
    return {load.evaluations, load.messages(), load.greatest_link()};
}

}  // namespace meld::eval
