#include "runtime/debug/session.h"

#include <fmt/format.h>

#include <limits>
#include <utility>

#include "runtime/base/bytes.h"
#include "runtime/debug/facts.h"

namespace meld::debug {

namespace {

constexpr std::int64_t kForever = std::numeric_limits<std::int64_t>::max();

template <class... Calls>
struct Overloaded : Calls... {
    using Calls::operator()...;
};

}  // namespace

Result<Answer> Session::execute(const Command& command) {
    const std::int64_t now = timeline_.tick();
    return std::visit(
        Overloaded{[&](const Step& step) { return go(step.ticks > kForever - now ? kForever : now + step.ticks); },
                   [&](const Back& past) { return back(past.ticks); }, [&](const To& to) { return go(to.tick); },
                   [&](const Run&) { return go(kForever); },
                   [&](const Facts& facts) -> Result<Answer> {
                       return find_facts(timeline_.simulation().subdomain(), {facts.catom, facts.name, most_lines_});
                   },
                   [&](const Where&) { return stand(); }, [&](const Diff& diff) { return compare(diff.since.value_or(came_from_)); },
                   [&](const Help& help) -> Result<Answer> { return Explained{help.text}; },
                   [&](const Quit&) -> Result<Answer> { return Explained{}; }},
        command);
}

Result<Answer> Session::go(std::int64_t tick) {
    const std::int64_t from = timeline_.tick(), first = timeline_.first_tick();
    if (tick < first)
        return fail(fmt::format("to {}: the first tick here is {}", tick, first),
                    fmt::format("This is a checkpoint of tick {}, and what came before is not in it", first));
    if (auto done = timeline_.to(tick); !done) return tl::unexpected<Error>(done.error());
    came_from_ = from;
    return Moved{.from = from, .tick = timeline_.tick(), .ended = timeline_.ended()};
}

Result<Answer> Session::back(std::int64_t ticks) {
    const std::int64_t now = timeline_.tick(), first = timeline_.first_tick();
    if (ticks > now - first)
        return fail(fmt::format("back {}: this is tick {}, and the first is {}", ticks, now, first),
                    fmt::format("`to {}` goes there", first));
    return go(now - ticks);
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
