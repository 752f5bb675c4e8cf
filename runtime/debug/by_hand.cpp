#include "runtime/debug/by_hand.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <tuple>
#include <utility>

#include "runtime/base/bytes.h"
#include "runtime/base/output_file.h"
#include "runtime/comm/outcome.h"
#include "runtime/debug/facts.h"
#include "runtime/inspect/ground.h"
#include "runtime/inspect/query.h"
#include "runtime/sim/core/given.h"
#include "runtime/world/expression.h"

namespace meld::debug {

namespace {

// In TOML, a value of the language is a string with its text.
std::string toml_string(const std::string& text) {
    std::string out = "\"";
    for (const char c : text) {
        if (c == '"' || c == '\\') out += '\\';
        out += c;
    }
    return out + '"';
}

Result<void> exists(sim::Subdomain& subdomain, std::uint64_t id) {
    if (catom_exists(subdomain, id)) return {};
    return fail(fmt::format("there is no catom @{} in tick {}", id, subdomain.tick()));
}

// The catoms for which a body holds: those that its first variable that is a catom can be. The same on every process.
Result<std::vector<std::uint64_t>> catoms_of(sim::Subdomain& subdomain, const std::string& verb, const std::string& body) {
    const Result<inspect::Table> table = inspect::query(subdomain, body);
    if (!table) {
        Error error = table.error();
        // Regions are for worlds.
        if (body.find('(') == std::string::npos)
            error.suggestion = fmt::format("Write a catom, as in {0} @5, or a body, as in {0} cell(A, X, Y, Z), X = 0", verb);
        return tl::unexpected<Error>(error);
    }
    std::vector<std::uint64_t> ids;
    Result<void> fits;
    ByteWriter mine;
    if (subdomain.comm.process() == 0) {
        const auto& columns = table->columns();
        const auto catom = std::ranges::find(columns, check::Type::Kind::Node, [](const auto& column) { return column.type.kind; });
        if (catom == columns.end())
            fits = fail(fmt::format("{}: no variable is a catom in `{}`", verb, body),
                        fmt::format("Write it as in {} dist(A, D), D > 9", verb));
        else if (table->rows() == 0)
            fits = fail(fmt::format("{}: `{}` holds for no catom in tick {}", verb, body, subdomain.tick()));
        for (std::size_t row = 0; fits && row < table->rows(); ++row)
            mine.write(table->cell(row, static_cast<std::size_t>(catom - columns.begin())).catom);
    }
    if (auto all = comm::outcome_of_first(subdomain.comm, fits); !all) return tl::unexpected<Error>(all.error());
    for (const auto& theirs : subdomain.comm.allgather_any(mine.view()))
        for (ByteReader in(theirs, "catoms that fail"); !in.done();) ids.push_back(in.read<std::uint64_t>());
    std::ranges::sort(ids);
    const auto twice = std::ranges::unique(ids);
    ids.erase(twice.begin(), twice.end());
    return ids;
}

// Programs that find neighbours by geometry find those, whatever fails.
Result<void> knows_links(const sim::Subdomain& subdomain, const std::string& verb) {
    const world::Ensemble& ensemble = subdomain.ensemble;
    if (ensemble.is_free() && !ensemble.is_graph()) return fail(fmt::format("{} is not for bodies", verb), "Use kill");
    if (ensemble.keeps_links()) return {};
    return fail(fmt::format("{}: this run finds neighbours by geometry, and needs a table of links", verb), "Begin it with --by-links");
}

}  // namespace

Result<OneFact> read_fact(sim::Subdomain& subdomain, std::string fact, const char* verb) {
    if (fact.ends_with('.')) fact.pop_back();
    Result<inspect::Ground> ground = inspect::read_ground(subdomain, fact);
    if (!ground) return tl::unexpected<Error>(ground.error());
    const auto where = world::parse_region_text(fmt::format("id == {}", ground->catom));
    MELD_CHECK(where.has_value(), "a region of one catom, {}", ground->catom);
    const world::GivenFact given{
        .predicate = ground->predicate, .arguments = ground->arguments, .where = *where, .place = fmt::format("{} {}", verb, ground->text)};
    if (auto can = sim::GivenFacts(subdomain).check(given); !can) return tl::unexpected<Error>(can.error());
    if (auto is = exists(subdomain, ground->catom); !is) return tl::unexpected<Error>(is.error());
    return OneFact{.text = ground->text, .catom = ground->catom, .given = given};
}

Result<Answer> ByHand::change(timeline::Timeline& timeline, const Change& asked) {
    const char* const verb = asked.gives ? "give" : "take";
    const Result<OneFact> fact = read_fact(timeline.simulation().subdomain(), asked.fact, verb);
    if (!fact) return tl::unexpected<Error>(fact.error());
    const std::int64_t tick = timeline.tick() + 1;
    Done done{.shown = {.tick = tick,
                        .verb = verb,
                        .fact = fact->text,
                        .predicate = fact->given.predicate,
                        .catom = fact->catom,
                        .arguments = fact->given.arguments},
              .event = {.tick = tick}};
    (asked.gives ? done.event.give : done.event.take).push_back(fact->given);
    return add(timeline, std::move(done));
}

Result<Answer> ByHand::kill(timeline::Timeline& timeline, const Kill& asked) {
    sim::Subdomain& subdomain = timeline.simulation().subdomain();
    std::vector<std::uint64_t> killed;
    if (asked.verb != "kill")
        if (auto known = knows_links(subdomain, asked.verb); !known) return tl::unexpected<Error>(known.error());
    if (asked.catom) {
        if (auto is = exists(subdomain, *asked.catom); !is) return tl::unexpected<Error>(is.error());
        killed = {*asked.catom};
    } else {
        auto found = catoms_of(subdomain, asked.verb, asked.body);
        if (!found) return tl::unexpected<Error>(found.error());
        killed = std::move(*found);
    }
    const std::int64_t tick = timeline.tick() + 1;
    const std::string text = asked.catom ? fmt::format("@{}", *asked.catom) : asked.body;
    Done done{.shown = {.tick = tick, .verb = asked.verb, .fact = text, .killed = killed}, .event = {.tick = tick}};
    auto& list = asked.verb == "kill" ? done.event.kill : asked.verb == "hang" ? done.event.hang : done.event.restart;
    for (const std::uint64_t id : killed) list.push_back({.id = id, .place = asked.verb + " " + text});
    return add(timeline, std::move(done));
}

Result<Answer> ByHand::cut_or_heal(timeline::Timeline& timeline, const CutOrHeal& asked) {
    sim::Subdomain& subdomain = timeline.simulation().subdomain();
    const std::string verb = asked.cuts ? "cut" : "heal";
    if (auto known = knows_links(subdomain, verb); !known) return tl::unexpected<Error>(known.error());
    std::vector<std::uint64_t> ends = {asked.catom};
    std::string text = fmt::format("@{}", asked.catom);
    if (asked.other) {
        ends.push_back(*asked.other);
        text += fmt::format(" @{}", *asked.other);
    }
    for (const std::uint64_t id : ends)
        if (auto is = exists(subdomain, id); !is) return tl::unexpected<Error>(is.error());
    const std::int64_t tick = timeline.tick() + 1;
    Done done{.shown = {.tick = tick, .verb = verb, .fact = text, .killed = ends}, .event = {.tick = tick}};
    world::LinkChoice choice{.place = verb + " " + text};
    if (asked.other)
        choice.pair = {asked.catom, *asked.other};
    else
        choice.where = *world::parse_region_text(fmt::format("id == {}", asked.catom));
    (asked.cuts ? done.event.cut : done.event.heal).push_back(std::move(choice));
    return add(timeline, std::move(done));
}

Result<Answer> ByHand::add(timeline::Timeline& timeline, Done done) {
    const std::int64_t now = timeline.tick();
    const auto stays = std::ranges::find_if(state_.done, [&](const Done& one) { return one.shown.tick > now + 1; });
    EventsFound answer{.tick = now, .dropped = static_cast<std::uint64_t>(state_.done.end() - stays)};
    state_.done.erase(stays, state_.done.end());
    state_.done.push_back(std::move(done));
    give_to_world();
    timeline.changes_from_here();
    answer.events.push_back(state_.done.back().shown);
    return answer;
}

void ByHand::give_to_world() {
    world_.events.resize(own_events_);
    for (std::size_t i = state_.first; i < state_.done.size(); ++i) world_.events.push_back(state_.done[i].event);
}

std::size_t ByHand::happens_after(std::int64_t tick) {
    const auto first = std::ranges::find_if(state_.done, [&](const Done& one) { return one.shown.tick > tick; });
    const std::size_t before = state_.first;
    happens_from(static_cast<std::size_t>(first - state_.done.begin()));
    return before;
}

void ByHand::happens_from(std::size_t first) {
    state_.first = first;
    give_to_world();
}

std::optional<std::int64_t> ByHand::parts_from(const State& other) const {
    const auto& mine = state_.done;
    std::size_t i = 0;
    const auto same = [](const Done& a, const Done& b) {
        return std::tie(a.shown.tick, a.shown.verb, a.shown.fact, a.shown.killed) ==
               std::tie(b.shown.tick, b.shown.verb, b.shown.fact, b.shown.killed);
    };
    while (i < mine.size() && i < other.done.size() && same(mine[i], other.done[i])) ++i;
    std::optional<std::int64_t> tick;
    for (const auto* all : {&mine, &other.done})
        if (i < all->size()) tick = std::min(tick.value_or((*all)[i].shown.tick), (*all)[i].shown.tick);
    return tick;
}

void ByHand::restore(State state) {
    state_ = std::move(state);
    give_to_world();
}

EventsFound ByHand::all(std::int64_t tick) const {
    EventsFound found{.tick = tick};
    for (const Done& one : state_.done) found.events.push_back(one.shown);
    return found;
}

std::string ByHand::to_come(std::int64_t tick) const {
    const bool any = !state_.done.empty() && state_.done.back().shown.tick > tick;
    return any ? as_toml(tick) : "";
}

std::string ByHand::as_toml(std::int64_t after) const {
    std::string out = "# What was done by hand. A world ends with it to make the same run.\n";
    for (const auto& [one, event] : state_.done) {
        if (one.tick <= after) continue;
        if (!one.killed.empty()) {
            const bool links = one.verb == "cut" || one.verb == "heal";
            const std::string what = !links                   ? fmt::format("[{}]", fmt::join(one.killed, ", "))
                                     : one.killed.size() == 1 ? fmt::format("\"id == {}\"", one.killed[0])
                                                              : fmt::format("[[{}]]", fmt::join(one.killed, ", "));
            out += fmt::format("\n[[event]]\ntick = {}\n{} = {}\n", one.tick, one.verb, what);
            continue;
        }
        std::string values;
        for (const std::string& text : one.arguments) values += (values.empty() ? "" : ", ") + toml_string(text);
        const std::string what = values.empty() ? fmt::format("\"id == {}\"", one.catom)
                                                : fmt::format("{{ where = \"id == {}\", args = [{}] }}", one.catom, values);
        out += fmt::format("\n[[event]]\ntick = {}\n{} = {{ {} = {} }}\n", one.tick, one.verb, toml_string(one.predicate), what);
    }
    return out;
}

Result<Answer> ByHand::write(const std::string& path, comm::Communicator& comm) const {
    const Result<void> mine = comm.process() == 0 ? write_file(path, as_toml(0)) : Result<void>{};
    if (auto all = comm::outcome_of_first(comm, mine); !all) return tl::unexpected<Error>(all.error());
    return Written{.path = path, .what = "event", .count = state_.done.size()};
}

}  // namespace meld::debug
