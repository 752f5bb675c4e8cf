#include "runtime/sim/watchers/watcher.h"

#include <fmt/format.h>

#include <algorithm>
#include <iterator>
#include <string_view>

#include "runtime/base/bytes.h"
#include "runtime/base/did_you_mean.h"
#include "runtime/base/files/standard_streams.h"
#include "runtime/base/terminal/progress.h"
#include "runtime/comm/transport/collective_result.h"
#include "runtime/engine/tuple/facts.h"
#include "runtime/engine/tuple/values.h"
#include "runtime/module/abi/actions.h"
#include "runtime/sim/core/subdomain.h"

namespace meld::sim {

namespace {

bool stored(const PredicateInfo& p) { return !p.auxiliary && p.column != kNone16 && p.kind != PredicateKind::Action; }

}  // namespace

Result<void> Watcher::start(Subdomain& subdomain) {
    watch_ = subdomain.program_actions.predicate_of(ActionKind::Watch);
    watch_all_ = subdomain.program_actions.predicate_of(ActionKind::WatchAll);
    return {};
}

// The watches that catoms of all processes have requested since the last tick.
Result<void> Watcher::begin(Subdomain& subdomain) {
    const auto repeats = [&](const std::optional<u32>& action) { return action && subdomain.module.predicates[*action].repeats; };
    if (repeats(watch_)) named_.clear();
    if (repeats(watch_all_)) everything_.clear();
    if (subdomain.totals.actions > 0) {
        ByteWriter mine;
        for (const eval::Action& a : subdomain.actions()) {
            if (watch_ != a.predicate && watch_all_ != a.predicate) continue;
            mine.write(subdomain.ensemble.id(a.catom));
            mine.write(watch_all_ == a.predicate);
            mine.write_string(watch_all_ == a.predicate ? std::string_view{} : tuple::bytes_of(a.arguments[0].list));
        }
        for (const std::vector<std::byte>& bytes : subdomain.comm.allgather_any(mine.view())) {
            ByteReader in(bytes, "what catoms watch");
            while (!in.done()) {
                const u64 id = in.read<u64>();
                const bool all = in.read<bool>();
                const std::string name = in.read_string();
                if (all)
                    everything_.insert(id);
                else if (auto added = add(subdomain, id, name); !added)
                    return added;
            }
        }
    }
    watched_ = named_;
    for (const u64 id : everything_)
        for (u32 i = 0; i < subdomain.module.predicate_count; ++i)
            if (stored(subdomain.module.predicates[i])) watched_.emplace(id, i);
    return {};
}

Result<void> Watcher::add(Subdomain& subdomain, u64 id, const std::string& name) {
    std::vector<std::string_view> known;
    bool found = false;
    for (u32 i = 0; i < subdomain.module.predicate_count; ++i) {
        if (!stored(subdomain.module.predicates[i])) continue;
        known.emplace_back(subdomain.module.predicates[i].name);
        if (known.back() != name) continue;
        named_.emplace(id, i);
        found = true;
    }
    if (found) return {};
    return fail(fmt::format("catom @{} watches '{}', and the program stores no such predicate", id, name), did_you_mean(name, known),
                ExitCode::ProgramWrong);
}

// Sorted, with repetitions.
Watcher::Facts Watcher::facts_of(Subdomain& subdomain, const Watch& watch) const {
    Facts facts;
    const auto catom = subdomain.ensemble.find(watch.first);
    const PredicateInfo& p = subdomain.module.predicates[watch.second];
    tuple::each_fact(subdomain.module, subdomain.columns, subdomain.geometry(), watch.second, *catom,
                     [&](const Value* v) { facts.push_back(tuple::print_fact(subdomain.module, p, watch.first, v)); });
    std::sort(facts.begin(), facts.end());
    return facts;
}

void Watcher::write_facts(const Watch& watch, const Facts& facts, bool here, ByteWriter& out) {
    out.write(watch.first);
    out.write(watch.second);
    out.write(here);
    out.write_count(facts.size());
    for (const std::string& fact : facts) out.write_string(fact);
}

// The facts of this process's catoms that have not been sent to process 0. A catom that has migrated is skipped: its new process sends its
// facts, and if there is none it has been removed.
std::vector<std::byte> Watcher::changes(Subdomain& subdomain) {
    ByteWriter out;
    std::erase_if(reported_, [&](const auto& reported) {
        const auto catom = subdomain.ensemble.find(reported.first.first);
        const bool stays = watched_.contains(reported.first) && catom && subdomain.owned(*catom);
        if (!stays) write_facts(reported.first, {}, false, out);
        return !stays;
    });
    for (const Watch& watch : watched_) {
        const auto catom = subdomain.ensemble.find(watch.first);
        if (!catom || !subdomain.owned(*catom)) continue;
        Facts facts = facts_of(subdomain, watch);
        const auto reported = reported_.find(watch);
        if (reported != reported_.end() && reported->second == facts) continue;
        write_facts(watch, facts, true, out);
        reported_[watch] = std::move(facts);
    }
    return out.take();
}

void Watcher::receive(std::span<const std::byte> bytes, std::map<Watch, Facts>& now) const {
    ByteReader in(bytes, "facts that are watched");
    while (!in.done()) {
        Watch watch;
        watch.first = in.read<u64>();
        watch.second = in.read<u32>();
        const bool here = in.read<bool>();
        Facts facts;
        for (auto left = in.read_count(sizeof(u32)); left > 0; --left) facts.push_back(in.read_string());
        if (here)
            now[watch] = std::move(facts);
        else
            now.emplace(watch, Facts{});
    }
}

Result<void> Watcher::print(Subdomain& subdomain, const std::map<Watch, Facts>& now) {
    std::string text;
    for (const auto& [watch, facts] : now) {
        Facts& before = known_[watch];
        Facts gone, come;
        std::set_difference(before.begin(), before.end(), facts.begin(), facts.end(), std::back_inserter(gone));
        std::set_difference(facts.begin(), facts.end(), before.begin(), before.end(), std::back_inserter(come));
        // If a watch has ended, nothing has changed.
        if (watched_.contains(watch)) {
            for (const std::string& fact : gone) text += fmt::format("tick {}: - {}\n", subdomain.tick(), fact);
            for (const std::string& fact : come) text += fmt::format("tick {}: + {}\n", subdomain.tick(), fact);
        }
        before = facts;
    }
    if (text.empty() || to_ == nullptr) return {};
    clear_progress();
    return meld::print(to_, text);
}

// By name: a run that branches off may have a program that numbers its predicates otherwise.
void Watcher::save_watch(const Subdomain& subdomain, const Watch& watch, ByteWriter& out) {
    const PredicateInfo& p = subdomain.module.predicates[watch.second];
    out.write(watch.first);
    out.write_string(p.name);
    out.write(p.arity);
}

// None if the program has no such predicate.
std::optional<Watcher::Watch> Watcher::load_watch(const Subdomain& subdomain, ByteReader& in) {
    const u64 id = in.read<u64>();
    const std::string name = in.read_string();
    const std::optional<u32> found = tuple::find_predicate(subdomain.module, name, in.read<u16>());
    return found && stored(subdomain.module.predicates[*found]) ? std::optional(Watch{id, *found}) : std::nullopt;
}

void Watcher::save_rest(const Subdomain& subdomain, ByteWriter& out) const {
    if (subdomain.comm.process() != 0) return;
    out.write_count(named_.size());
    for (const Watch& watch : named_) save_watch(subdomain, watch, out);
    out.write_count(everything_.size());
    for (const u64 id : everything_) out.write(id);
    out.write(watching_);
    out.write_count(known_.size());
    for (const auto& [watch, facts] : known_) {
        save_watch(subdomain, watch, out);
        out.write_count(facts.size());
        for (const std::string& fact : facts) out.write_string(fact);
    }
}

Result<void> Watcher::load_rest(Subdomain& subdomain, ByteReader& in) {
    if (in.done()) return {};
    for (auto left = in.read_count(sizeof(u64) + sizeof(u32)); left > 0; --left)
        if (const std::optional<Watch> watch = load_watch(subdomain, in)) named_.insert(*watch);
    for (auto left = in.read_count(sizeof(u64)); left > 0; --left) everything_.insert(in.read<u64>());
    watching_ = in.read<bool>();
    std::map<Watch, Facts> known;
    for (auto left = in.read_count(sizeof(u64) + sizeof(u32)); left > 0; --left) {
        const std::optional<Watch> watch = load_watch(subdomain, in);
        Facts facts(in.read_count(sizeof(u32)));
        for (std::string& fact : facts) fact = in.read_string();
        if (watch) known[*watch] = std::move(facts);
    }
    for (const auto& [watch, facts] : known) {
        const auto catom = subdomain.ensemble.find(watch.first);
        if (catom && subdomain.owned(*catom)) reported_[watch] = facts;
    }
    if (subdomain.comm.process() == 0) known_ = std::move(known);
    return {};
}

Result<void> Watcher::after(Subdomain& subdomain) {
    if (!watch_ && !watch_all_) return {};
    if (auto done = begin(subdomain); !done) return done;
    // The same on all processes, so that all exchange or none does; once more after the last watch has ended.
    const bool ended = watched_.empty() && !watching_;
    watching_ = !watched_.empty();
    if (ended) return {};
    std::vector<std::byte> mine = changes(subdomain);
    std::vector<comm::Packet> packets;
    if (subdomain.comm.process() != 0 && !mine.empty()) packets.push_back({0, std::move(mine)});
    if (subdomain.comm.processes() > 1) packets = subdomain.comm.exchange(std::move(packets));
    if (subdomain.comm.process() != 0) return comm::outcome_of_first(subdomain.comm, {});
    std::map<Watch, Facts> now;
    receive(mine, now);
    for (const comm::Packet& packet : packets) receive(packet.bytes, now);
    return comm::outcome_of_first(subdomain.comm, print(subdomain, now));
}

}  // namespace meld::sim
