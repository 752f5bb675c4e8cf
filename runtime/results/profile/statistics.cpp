#include "runtime/results/profile/statistics.h"

#include <algorithm>
#include <map>
#include <set>
#include <tuple>

#include "runtime/base/bytes.h"
#include "runtime/comm/transport/gather_to_root.h"
#include "runtime/engine/tuple/facts.h"

namespace meld::profile {

namespace {

constexpr std::size_t kBusiest = 10;
constexpr std::size_t kMostSettlings = 10'000;

// Adds one to the busiest so far, which are in order.
template <class Item, class Busier>
void keep_busiest(std::vector<Item>& all, const Item& one, const Busier& busier) {
    if (all.size() == kBusiest && !busier(one, all.back())) return;
    all.insert(std::upper_bound(all.begin(), all.end(), one, busier), one);
    if (all.size() > kBusiest) all.pop_back();
}

// A catom of this process, or one whose load is known already.
struct Candidate {
    u64 id;
    eval::CatomSums sums;
    std::size_t place;  // Its index here, or its number among those.
};
bool more_evaluations(const Candidate& a, const Candidate& b) {
    return std::tuple(b.sums.evaluations, a.id) < std::tuple(a.sums.evaluations, b.id);
}
bool more_messages(const Candidate& a, const Candidate& b) {
    return std::tuple(b.sums.messages.messages, a.id) < std::tuple(a.sums.messages.messages, b.id);
}
bool busier_link(const Candidate& a, const Candidate& b) {
    const LinkCounts &x = a.sums.greatest_link, &y = b.sums.greatest_link;
    return std::tuple(y.messages, y.bits, a.id) < std::tuple(x.messages, x.bits, b.id);
}

// Those that may be the busiest of all catoms.
struct Busiest {
    std::vector<Candidate> by_evaluations, by_messages, by_link;

    void add(const Candidate& catom) {
        keep_busiest(by_evaluations, catom, more_evaluations);
        keep_busiest(by_messages, catom, more_messages);
        keep_busiest(by_link, catom, busier_link);
    }
};

// The catoms that have been on several processes, of all processes.
std::set<u64> wanderers(const sim::Subdomain& subdomain) {
    ByteWriter mine;
    if (subdomain.counts() != nullptr)
        for (const auto& [id, load] : subdomain.counts()->left()) mine.write(id);
    std::set<u64> all;
    for (const auto& bytes : subdomain.comm.allgather_any(mine.view()))
        for (ByteReader in(bytes, "catoms that have left a process"); !in.done();) all.insert(in.read<u64>());
    return all;
}

// How many bytes of a record a predicate takes, without its share of a byte of presence bits.
std::uint64_t record_bytes(const PredicateInfo& p) {
    std::uint64_t bytes = p.rank_offset != kNone32 ? kRankBytes : 0;
    for (u32 i = 0; i < p.arity; ++i)
        bytes += p.storage != Storage::PerLink ? p.fields[i].bytes : i == 0 ? 0 : std::uint64_t{p.fields[i].bytes} * kMaxPorts;
    return bytes;
}

std::vector<PredicateLoad> predicates_here(const sim::Subdomain& subdomain) {
    const ModuleInfo& module = subdomain.module;
    std::vector<PredicateLoad> all(module.predicate_count);
    for (u32 i = 0; i < module.predicate_count; ++i) {
        const PredicateInfo& p = module.predicates[i];
        if (subdomain.counts() != nullptr) all[i].counts = subdomain.counts()->predicate(i);
        if (p.column == kNone16) continue;
        for (u32 catom = 0; catom < subdomain.ensemble.index_count(); ++catom) {
            if (!subdomain.owned(catom)) continue;
            all[i].facts += tuple::count_facts(module, subdomain.columns, subdomain.geometry(), i, catom);
            all[i].bytes += p.storage == Storage::Rows ? kRowsHeadBytes + std::uint64_t{subdomain.columns.rows(p.column, catom).capacity} *
                                                                              module.columns[p.column].row_bytes
                                                       : record_bytes(p);
        }
    }
    return all;
}

}  // namespace

Result<void> RunStatistics::start(sim::Subdomain& subdomain) {
    if (catoms_ == Catoms::Counted) subdomain.count_evaluations();
    first_tick_ = subdomain.tick() + 1;
    return {};
}

Result<void> RunStatistics::resume(sim::Subdomain& subdomain) {
    begins_ = Settling::Cause::Resumed;
    return start(subdomain);
}

void RunStatistics::note_settling(const sim::Subdomain& subdomain) {
    const std::int64_t now = subdomain.tick();
    const auto& events = subdomain.world.events;
    const bool event = std::any_of(events.begin(), events.end(), [&](const world::Event& e) { return e.happens_in(now); });
    if (settlings_.empty()) settlings_.push_back({begins_, now, std::nullopt});
    if (event && settlings_.back().tick != now) {
        if (settlings_.size() < kMostSettlings)
            settlings_.push_back({Settling::Cause::Event, now, std::nullopt});
        else
            ++settlings_left_out_;
    }
    // What comes to rest after an event that is left out is not the last of these.
    Settling& last = settlings_.back();
    if (settlings_left_out_ == 0 && !last.rounds && subdomain.totals.quiescent()) last.rounds = now - last.tick + 1;
}

Result<void> RunStatistics::after(sim::Subdomain& subdomain) {
    // A run that goes on from a snapshot knows its tick only now.
    if (settlings_.empty()) first_tick_ = subdomain.tick();
    note_settling(subdomain);
    const eval::Statistics& all = subdomain.totals.tick;
    const eval::Statistics& own = subdomain.own_statistics();
    own_.evaluations += own.awake;
    own_.derivations += own.derivations;
    own_.changes += own.changes;
    own_.messages += own.messages;
    const TickLoad load{subdomain.tick(), all.awake, all.derivations, all.changes, all.messages};
    const auto busier = [](const TickLoad& a, const TickLoad& b) {
        return std::tuple(b.evaluations, b.derivations, a.tick) < std::tuple(a.evaluations, a.derivations, b.tick);
    };
    keep_busiest(ticks_, load, busier);
    return {};
}

Gathered RunStatistics::gather(const sim::Subdomain& subdomain) const {
    const ModuleInfo& module = subdomain.module;
    const eval::Counts nothing(module, 0);
    const eval::Counts& counts = subdomain.counts() != nullptr ? *subdomain.counts() : nothing;
    const std::set<u64> several = wanderers(subdomain);
    std::vector<NamedCatom> parts;
    Busiest busiest;
    for (const auto& [id, load] : counts.left()) parts.push_back({id, load});
    for (u32 catom = 0; catom < subdomain.ensemble.index_count(); ++catom) {
        if (!subdomain.owned(catom) || subdomain.counts() == nullptr) continue;
        const u64 id = subdomain.ensemble.id(catom);
        if (!several.empty() && several.contains(id))
            parts.push_back({id, counts.catom(catom)});
        else
            busiest.add({id, counts.sums(catom), catom});
    }

    ProcessLoad own = own_;
    own.catoms = subdomain.ensemble.owned_count();
    own.bytes = subdomain.bytes() + counts.bytes();
    ByteWriter mine;
    for (u32 r = 0; r < module.rule_count; ++r) mine.write(counts.rule(r));
    for (const PredicateLoad& p : predicates_here(subdomain)) mine.write(p);
    mine.write(counts.greatest());
    mine.write(own);
    mine.write_count(parts.size());
    for (const NamedCatom& part : parts) mine.write(part);
    for (const auto* list : {&busiest.by_evaluations, &busiest.by_messages, &busiest.by_link}) {
        mine.write_count(list->size());
        for (const Candidate& one : *list) mine.write(NamedCatom{one.id, counts.catom(static_cast<u32>(one.place))});
    }

    Gathered all;
    all.rules_counted = module.counts;
    all.first_tick = settlings_.empty() ? subdomain.tick() + 1 : first_tick_;
    all.last_tick = subdomain.tick();
    all.rules.resize(module.rule_count);
    all.predicates.resize(module.predicate_count);
    std::map<u64, eval::CatomLoad> whole;
    std::vector<NamedCatom> known;
    Busiest of_all;
    const auto candidate = [&](const NamedCatom& catom) {
        known.push_back(catom);
        const eval::CatomLoad& load = catom.load;
        return Candidate{catom.id, {load.evaluations, load.messages(), load.greatest_link()}, known.size() - 1};
    };
    for (const auto& bytes : comm::gather_to_root(subdomain.comm, mine.take())) {
        ByteReader in(bytes, "what a process has counted");
        for (RuleCounts& rule : all.rules) eval::add(rule, in.read<RuleCounts>());
        for (PredicateLoad& sum : all.predicates) {
            const auto more = in.read<PredicateLoad>();
            eval::add(sum.counts, more.counts);
            sum.facts += more.facts;
            sum.bytes += more.bytes;
        }
        eval::raise(all.in_one_tick, in.read<LinkCounts>());
        all.processes.push_back(in.read<ProcessLoad>());
        const auto each = [&](const auto& visit) {
            for (std::size_t left = in.read_count(sizeof(NamedCatom)); left > 0; --left) visit(in.read<NamedCatom>());
        };
        each([&](const NamedCatom& part) { eval::add(whole[part.id], part.load); });
        // Whoever is in several of these lists is counted in each once.
        each([&](const NamedCatom& catom) { keep_busiest(of_all.by_evaluations, candidate(catom), more_evaluations); });
        each([&](const NamedCatom& catom) { keep_busiest(of_all.by_messages, candidate(catom), more_messages); });
        each([&](const NamedCatom& catom) { keep_busiest(of_all.by_link, candidate(catom), busier_link); });
    }
    for (const auto& [id, load] : whole) of_all.add(candidate({id, load}));
    const auto loads = [&](const std::vector<Candidate>& list) {
        std::vector<NamedCatom> out;
        for (const Candidate& one : list) out.push_back(known[one.place]);
        return out;
    };
    all.busiest = loads(of_all.by_evaluations);
    all.most_messages = loads(of_all.by_messages);
    if (!of_all.by_link.empty()) all.busiest_link = known[of_all.by_link.front().place];
    all.settlings = settlings_;
    all.settlings_left_out = settlings_left_out_;
    all.ticks = ticks_;
    return all;
}

}  // namespace meld::profile
