#include "runtime/ask/debug/session.h"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <limits>
#include <utility>

#include "runtime/ask/debug/depends.h"
#include "runtime/ask/debug/facts.h"
#include "runtime/ask/messages/messages.h"
#include "runtime/ask/query/query.h"
#include "runtime/ask/why/why.h"
#include "runtime/base/bytes.h"
#include "runtime/comm/transport/collective_result.h"

namespace meld::debug {

namespace {

constexpr std::int64_t kForever = std::numeric_limits<std::int64_t>::max();

template <class Listed>
Result<Answer> listed(Result<Listed> found) {
    if (!found) return tl::unexpected<Error>(found.error());
    return std::move(*found);
}

template <class... Calls>
struct Overloaded : Calls... {
    using Calls::operator()...;
};

}  // namespace

Result<Answer> Session::execute(const Command& command) {
    const std::int64_t now = timeline_.tick();
    return std::visit(
        Overloaded{[&](const Step& step) { return go(step.ticks > kForever - now ? kForever : now + step.ticks); },
                   [&](const Back& past) { return back(past.ticks); },
                   [&](const To& to) { return go(to.tick); },
                   [&](const Run&) { return go(kForever); },
                   [&](const Reverse&) { return reverse(); },
                   [&](const Until& asked) { return until(asked.body); },
                   [&](const Break& asked) { return breaks_.add(module(), asked); },
                   [&](const Watch& asked) { return breaks_.add(module(), asked); },
                   [&](const Breaks&) -> Result<Answer> { return breaks_.all(); },
                   [&](const Delete& asked) { return breaks_.remove(asked.number); },
                   [&](const Change& asked) { return change(asked); },
                   [&](const Kill& asked) { return kill(asked); },
                   [&](const StrikeLinks& asked) { return strike_links(asked); },
                   [&](const Events&) -> Result<Answer> { return by_hand_.all(now); },
                   [&](const SaveEvents& asked) { return save_events(path_of(asked.path)); },
                   [&](const Fork& asked) { return fork(asked.name); },
                   [&](const BranchList&) -> Result<Answer> { return branches_.all(timeline_, by_hand_); },
                   [&](const Switch& asked) { return go_to(asked.name); },
                   [&](const Reload&) { return reload(); },
                   [&](const Save& asked) { return save(asked); },
                   [&](const Facts& facts) -> Result<Answer> {
                       return find_facts(timeline_.simulation().subdomain(), {facts.catom, facts.name, options_.most_lines});
                   },
                   [&](const Query& asked) { return query(asked.body); },
                   [&](const Why& asked) { return why(asked); },
                   [&](const History& asked) -> Result<Answer> {
                       auto found = inspect::history(timeline_, asked.fact);
                       if (!found) return tl::unexpected<Error>(found.error());
                       return std::move(*found);
                   },
                   [&](const Messages& asked) { return messages(asked); },
                   [&](const Depends& asked) { return without(asked); },
                   [&](const Rules& asked) { return listed(list_rules(timeline_.simulation().subdomain().module, asked.predicate)); },
                   [&](const Predicates&) { return listed(list_predicates(timeline_.simulation().subdomain().module)); },
                   [&](const Where&) { return stand(); },
                   [&](const Diff& diff) { return compare(diff.since.value_or(came_from_)); },
                   [&](const Help& help) -> Result<Answer> { return Explained{help.text}; },
                   [&](const Quit&) -> Result<Answer> { return Explained{}; }},
        command);
}

Result<Answer> Session::go(std::int64_t tick) {
    const std::int64_t from = timeline_.tick(), first = timeline_.first_tick();
    if (tick < first)
        return fail(fmt::format("to {}: the first tick here is {}", tick, first),
                    reloaded_ ? "The program was read again there, and the run before that was another one"
                              : fmt::format("This is a checkpoint of tick {}, and what came before is not in it", first));
    if (tick > from && !breaks_.empty()) return forward(tick, nullptr, "");
    const Result<void> done = timeline_.to(tick);
    breaks_.forget();
    if (!done) return tl::unexpected<Error>(done.error());
    came_from_ = from;
    return Moved{.from = from, .tick = timeline_.tick(), .ended = timeline_.ended()};
}

Result<Answer> Session::until(const std::string& body) {
    // The first way is enough, and one from before counts as well.
    Result<std::unique_ptr<inspect::Watches>> watches =
        inspect::Watches::make(module(), {rule_of(body, front::WatchRule::Verb::Never)}, nullptr);
    if (!watches) return tl::unexpected<Error>(watches.error());
    return forward(kForever, watches->get(), body);
}

// Tick by tick, with a look at what is watched after each.
Result<Answer> Session::forward(std::int64_t tick, inspect::Watches* until, const std::string& body) {
    const std::int64_t from = timeline_.tick();
    if (auto ready = breaks_.begin(timeline_.simulation().subdomain()); !ready) return tl::unexpected<Error>(ready.error());
    std::vector<Stop> stops;
    const Result<void> done = timeline_.forward_until(tick, [&](sim::Simulation& simulation) -> Result<bool> {
        Result<std::vector<Stop>> here = breaks_.after(simulation.subdomain());
        if (!here) return tl::unexpected<Error>(here.error());
        stops = std::move(*here);
        if (until != nullptr) {
            Result<inspect::Watches::Looked> looked = until->look(simulation.subdomain());
            if (!looked) return tl::unexpected<Error>(looked.error());
            for (auto& news : looked->news) stops.push_back({.what = body, .ways = std::move(news.lines)});
        }
        return comm::value_of_first(simulation.subdomain().comm, !stops.empty());
    });
    if (!done) {
        breaks_.forget();
        return tl::unexpected<Error>(done.error());
    }
    came_from_ = from;
    return Moved{.from = from, .tick = timeline_.tick(), .ended = timeline_.ended(), .stops = std::move(stops)};
}

Result<Answer> Session::back(std::int64_t ticks) {
    const std::int64_t now = timeline_.tick(), first = timeline_.first_tick();
    if (ticks > now - first)
        return fail(fmt::format("back {}: this is tick {}, and the first is {}", ticks, now, first),
                    fmt::format("`to {}` goes there", first));
    return go(now - ticks);
}

// Part by part, each longer than the one after it, so that a break that is near is found without the whole run.
Result<Answer> Session::reverse() {
    const std::int64_t now = timeline_.tick(), first = timeline_.first_tick();
    std::int64_t found = first;
    std::vector<Stop> stops;
    std::int64_t before = now, part = 64;
    while (!breaks_.empty() && found == first && before > first + 1) {
        const std::int64_t from = std::max(first, before - 1 - part);
        breaks_.forget();
        const Result<void> walked = timeline_.walk(from, before - 1, [&](sim::Simulation& simulation) -> Result<bool> {
            sim::Subdomain& there = simulation.subdomain();
            if (there.tick() == from) return breaks_.begin(there).map([] { return true; });
            Result<std::vector<Stop>> here = breaks_.after(there);
            if (!here) return tl::unexpected<Error>(here.error());
            if (!comm::value_of_first(there.comm, !here->empty())) return true;
            found = there.tick();
            stops = std::move(*here);
            return true;
        });
        breaks_.forget();
        if (!walked && walked.error().code == ExitCode::Interrupted)
            return Moved{.from = now, .tick = now, .ended = sim::Ending::Interrupted};
        if (!walked) return tl::unexpected<Error>(walked.error());
        before = from + 1;
        part *= 2;
    }
    Result<Answer> there = go(found);
    if (there) std::get<Moved>(*there).stops = std::move(stops);
    return there;
}

Result<void> Session::changeable() const {
    if (options_.recorded)
        return fail("a recording says itself what happens in its run, so nothing can be done by hand",
                    "Debug the program of the run, or a checkpoint of it");
    if (const auto ended = timeline_.ended(); ended && *ended != sim::Ending::Quiet && *ended != sim::Ending::Interrupted)
        return fail(fmt::format("the run ends with tick {}, so nothing comes after it", timeline_.tick()),
                    *ended == sim::Ending::Ticks ? "Begin with a larger --ticks, or go back, and then do it" : "Go back, and then do it");
    return {};
}

Result<Answer> Session::change(const Change& asked) {
    if (auto can = changeable(); !can) return tl::unexpected<Error>(can.error());
    return by_hand_.change(timeline_, asked);
}

Result<Answer> Session::kill(const Kill& asked) {
    if (auto can = changeable(); !can) return tl::unexpected<Error>(can.error());
    return by_hand_.kill(timeline_, asked);
}

Result<Answer> Session::strike_links(const StrikeLinks& asked) {
    if (auto can = changeable(); !can) return tl::unexpected<Error>(can.error());
    return by_hand_.strike_links(timeline_, asked);
}

Result<Answer> Session::fork(const std::string& name) {
    if (options_.recorded)
        return fail("a recording says itself what happens in its run, so it has no branches",
                    "Debug the program of the run, or a checkpoint of it");
    return branches_.fork(timeline_, by_hand_, name);
}

Result<Answer> Session::go_to(const std::string& branch) {
    const std::int64_t from = timeline_.tick();
    Result<Answer> there = branches_.go_to(timeline_, by_hand_, branch);
    breaks_.forget();
    if (there) came_from_ = from;
    return there;
}

Result<Answer> Session::save_events(const std::string& path) {
    comm::Communicator& comm = timeline_.simulation().subdomain().comm;
    std::vector<NamedPath> paths = options_.inputs;
    paths.push_back({"save-events", path, NamedPath::Written});
    const Result<void> mine = comm.process() == 0 ? check_distinct(paths) : Result<void>{};
    if (auto all = comm::outcome_of_first(comm, mine); !all) return tl::unexpected<Error>(all.error());
    return by_hand_.write(path, comm);
}

Result<Answer> Session::reload() {
    if (options_.recorded)
        return fail("a recording carries its program, which does not change", "Debug the program of the run, or a checkpoint of it");
    const std::int64_t now = timeline_.tick();
    // What was done by hand before this tick has happened, and the new program may not know it.
    const std::size_t before = by_hand_.happens_after(now);
    Result<Reloaded> done = options_.host.reload();
    if (!done || !done->changed) by_hand_.happens_from(before);
    if (!done) return tl::unexpected<Error>(done.error());
    if (!done->changed) return *done;
    came_from_ = now;
    reloaded_ = true;
    done->lost = breaks_.reread(module());
    done->branches = branches_.keep_the_present();
    return *done;
}

Result<Answer> Session::save(const Save& asked) {
    if (options_.recorded)
        return fail("the run of a recording cannot be saved: its program and world are in the recording", "Debug the program of the run");
    Result<Saved> saved = options_.host.save(path_of(asked.folder), by_hand_.to_come(timeline_.tick()));
    if (!saved) return tl::unexpected<Error>(saved.error());
    return *saved;
}

std::string Session::path_of(const std::string& path) const {
    return (std::filesystem::path(options_.folder) / path).lexically_normal().string();
}

Result<Answer> Session::query(const std::string& body) {
    Result<inspect::Table> table = inspect::query(timeline_.simulation().subdomain(), body, looked_);
    if (!table) return tl::unexpected<Error>(table.error());
    return RowsFound{.tick = timeline_.tick(), .body = body, .table = std::move(*table), .most_rows = options_.most_lines};
}

Result<Answer> Session::why(const Why& asked) {
    const inspect::WhyOptions options{
        .depth = asked.depth.value_or(asked.holds ? inspect::kWhyDepth : inspect::kWhyNotDepth), .all = asked.all, .origins = asked.replay};
    auto found = asked.holds ? inspect::why(timeline_, asked.fact, options) : inspect::why_not(timeline_, asked.fact, options);
    if (!found) return tl::unexpected<Error>(found.error());
    return WhyFound{.holds = asked.holds, .explanation = std::move(*found)};
}

Result<Answer> Session::messages(const Messages& asked) {
    auto found = inspect::messages(timeline_, {.catom = asked.catom, .most = options_.most_lines});
    if (!found) return tl::unexpected<Error>(found.error());
    return std::move(*found);
}

Result<Answer> Session::without(const Depends& asked) {
    if (options_.recorded)
        return fail("a recording says itself what happens in its run, so it cannot be run without a fact",
                    "Ask the program of the run, or a checkpoint of it");
    if (timeline_.ended() == sim::Ending::Finished)
        return fail(fmt::format("the run ends with tick {}, so nothing comes after it", timeline_.tick()), "Ask about an earlier tick");
    return depends(timeline_, world_,
                   {.fact = asked.fact, .ticks = asked.ticks.value_or(kDependsTicks), .most_lines = options_.most_lines});
}

Result<Answer> Session::stand() const {
    const sim::Subdomain& subdomain = timeline_.simulation().subdomain();
    const timeline::History& history = timeline_.history();
    Standing at{.tick = timeline_.tick(), .first_tick = timeline_.first_tick(), .ended = timeline_.ended()};
    if (const auto digest = timeline_.digest(at.tick)) at.digest = digest->to_string();
    ByteWriter mine;
    std::uint64_t owned = 0;
    for (sim::Catom c = 0; c < subdomain.ensemble.index_count(); ++c) owned += subdomain.owned(c) ? 1 : 0;
    mine.write(owned);
    mine.write(static_cast<std::uint64_t>(history.bytes()));
    const std::vector<std::byte> all = subdomain.comm.allgather(mine.view());
    for (ByteReader in(all, "where processes are"); !in.done();) {
        at.catoms += in.read<std::uint64_t>();
        at.history_bytes += in.read<std::uint64_t>();
    }
    const std::vector<std::int64_t> kept = history.ticks();
    at.snapshots = kept.size();
    if (!kept.empty()) at.oldest_snapshot = kept.front();
    return at;
}

Result<Answer> Session::compare(std::int64_t since) {
    Changes changes{.since = since, .tick = timeline_.tick()};
    if (since == changes.tick) return changes;
    const auto before = timeline_.beside(since);
    if (!before) return tl::unexpected<Error>(before.error());
    if ((*before)->subdomain().totals.stop) return fail("diff: interrupted", "", ExitCode::Interrupted);
    if (const std::int64_t reached = (*before)->subdomain().tick(); reached != since)
        return fail(fmt::format("diff: the run ends before tick {}, with tick {}", since, reached));
    changes.predicates = find_changes((*before)->subdomain(), timeline_.simulation().subdomain());
    return changes;
}

}  // namespace meld::debug
