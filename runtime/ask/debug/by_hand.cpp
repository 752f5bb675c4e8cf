#include "runtime/ask/debug/by_hand.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <tuple>
#include <utility>

#include "runtime/ask/debug/facts.h"
#include "runtime/ask/query/query.h"
#include "runtime/ask/why/ground.h"
#include "runtime/base/bytes.h"
#include "runtime/base/files/output_file.h"
#include "runtime/comm/transport/collective_result.h"
#include "runtime/engine/tuple/facts.h"
#include "runtime/sim/core/setup/world_facts.h"
#include "runtime/world/file/event_section.h"
#include "runtime/world/shapes/expression.h"

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

// Those that are named, if all of them are there, or those for which the body holds.
Result<std::vector<std::uint64_t>> meant(sim::Subdomain& subdomain, const std::string& verb, const std::vector<std::uint64_t>& named,
                                         const std::string& body) {
    if (named.empty()) return catoms_of(subdomain, verb, body);
    for (const std::uint64_t id : named)
        if (auto is = exists(subdomain, id); !is) return tl::unexpected<Error>(is.error());
    return named;
}

// As it was typed; of many catoms only the first.
std::string in_words(const std::vector<std::uint64_t>& named, const std::string& body) {
    constexpr std::size_t kNamed = 4;
    std::string out = body;
    for (std::size_t i = 0; i < std::min(named.size(), kNamed); ++i) out += fmt::format("{}@{}", i == 0 ? "" : " ", named[i]);
    return named.size() > kNamed ? out + " ..." : out;
}

// A region of these catoms: runs of numbers, as neighbours have them.
std::string region_of(std::vector<std::uint64_t> ids) {
    std::ranges::sort(ids);
    std::string out;
    for (std::size_t i = 0; i < ids.size();) {
        std::size_t last = i;
        while (last + 1 < ids.size() && ids[last + 1] == ids[last] + 1) ++last;
        out += out.empty() ? "" : " || ";
        out += last == i ? fmt::format("id == {}", ids[i]) : fmt::format("id >= {} && id <= {}", ids[i], ids[last]);
        i = last + 1;
    }
    return out;
}

// Whether this process has the fact among those of a predicate, which may be the auxiliary for given ones.
bool has(sim::Subdomain& subdomain, const OneFact& fact, u32 predicate) {
    const ModuleInfo& module = subdomain.module;
    const std::optional<sim::Catom> catom = subdomain.ensemble.find(fact.catom);
    if (!catom || !subdomain.owned(*catom)) return false;
    PredicateInfo p = module.predicates[predicate];
    p.name = fact.given.predicate.c_str();
    bool found = false;
    tuple::each_fact(module, subdomain.columns, subdomain.geometry(), predicate, *catom,
                     [&](const Value* arguments) { found = found || tuple::print_fact(module, p, fact.catom, arguments) == fact.text; });
    return found;
}

tl::unexpected<Error> not_given(const std::string& fact) {
    return fail(fmt::format("{} is not given from outside: rules derive it, or the program's text says it", fact),
                fmt::format("why {} says what it rests on. Let the world give, in [facts], what is to be taken", fact));
}

// Facts that no world could give.
Result<void> may_be_given(sim::Subdomain& subdomain, const std::string& text) {
    const Result<inspect::Ground> ground = inspect::read_ground(subdomain, text);
    if (!ground) return tl::unexpected<Error>(ground.error());
    const ModuleInfo& module = subdomain.module;
    const std::optional<u32> predicate = tuple::find_predicate(module, ground->predicate, ground->arguments.size());
    const bool derived = predicate && module.predicates[*predicate].base == kNone16;
    return derived ? Result<void>(not_given(ground->text)) : Result<void>{};
}

Result<void> is_given(sim::Subdomain& subdomain, const OneFact& fact) {
    subdomain.refresh();
    const ModuleInfo& module = subdomain.module;
    const std::optional<u32> predicate = tuple::find_predicate(module, fact.given.predicate, fact.given.arguments.size());
    MELD_CHECK(predicate.has_value(), "{} was checked", fact.text);
    const u32 base = module.predicates[*predicate].base;
    const std::byte mine{static_cast<unsigned char>((has(subdomain, fact, base) ? 2 : 0) | (has(subdomain, fact, *predicate) ? 1 : 0))};
    std::byte all{0};
    for (const std::byte each : subdomain.comm.allgather({&mine, 1})) all |= each;
    if ((all & std::byte{2}) != std::byte{0}) return {};
    if (all == std::byte{0}) return fail(fmt::format("{} does not hold after tick {}", fact.text, subdomain.tick()), "why-not tells more");
    return not_given(fact.text);
}

}  // namespace

Result<OneFact> read_given_fact(sim::Subdomain& subdomain, std::string text, const char* verb) {
    if (text.ends_with('.')) text.pop_back();
    if (auto may = may_be_given(subdomain, text); !may) return tl::unexpected<Error>(may.error());
    Result<OneFact> fact = read_fact(subdomain, text, verb);
    if (!fact) return fact;
    if (auto is = is_given(subdomain, *fact); !is) return tl::unexpected<Error>(is.error());
    return fact;
}

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
    sim::Subdomain& subdomain = timeline.simulation().subdomain();
    const Result<OneFact> fact = asked.gives ? read_fact(subdomain, asked.fact, verb) : read_given_fact(subdomain, asked.fact, verb);
    if (!fact) return tl::unexpected<Error>(fact.error());
    const std::int64_t tick = timeline.tick() + 1;
    std::string values;
    for (const std::string& text : fact->given.arguments) values += (values.empty() ? "" : ", ") + toml_string(text);
    const std::string where = fmt::format("\"id == {}\"", fact->catom);
    const std::string what = values.empty() ? where : fmt::format("{{ where = {}, args = [{}] }}", where, values);
    Done done{.shown = {.tick = tick,
                        .verb = verb,
                        .fact = fact->text,
                        .predicate = fact->given.predicate,
                        .catom = fact->catom,
                        .arguments = fact->given.arguments},
              .event = {.tick = tick},
              .toml = fmt::format("{} = {{ {} = {} }}\n", verb, toml_string(fact->given.predicate), what)};
    (asked.gives ? done.event.give : done.event.take).push_back(fact->given);
    return add(timeline, std::move(done));
}

Result<Answer> ByHand::kill(timeline::Timeline& timeline, const Kill& asked) {
    sim::Subdomain& subdomain = timeline.simulation().subdomain();
    if (asked.verb != "kill")
        if (auto known = knows_links(subdomain, asked.verb); !known) return tl::unexpected<Error>(known.error());
    const auto struck = meant(subdomain, asked.verb, asked.catoms, asked.body);
    if (!struck) return tl::unexpected<Error>(struck.error());
    const std::int64_t tick = timeline.tick() + 1;
    const std::string text = in_words(asked.catoms, asked.body);
    Done done{.shown = {.tick = tick, .verb = asked.verb, .fact = text, .struck = *struck},
              .event = {.tick = tick},
              .toml = fmt::format("{} = [{}]\n", asked.verb, fmt::join(*struck, ", "))};
    auto& list = asked.verb == "kill" ? done.event.kill : asked.verb == "hang" ? done.event.hang : done.event.restart;
    for (const std::uint64_t id : *struck) list.push_back({.id = id, .place = asked.verb + " " + text});
    return add(timeline, std::move(done));
}

Result<Answer> ByHand::strike_links(timeline::Timeline& timeline, const StrikeLinks& asked) {
    sim::Subdomain& subdomain = timeline.simulation().subdomain();
    if (auto known = knows_links(subdomain, asked.verb); !known) return tl::unexpected<Error>(known.error());
    const auto struck = meant(subdomain, asked.verb, asked.catoms, asked.body);
    if (!struck) return tl::unexpected<Error>(struck.error());
    const bool jams = asked.verb == "jam";
    const std::int64_t tick = timeline.tick() + 1;
    const std::string text =
        (jams ? fmt::format("{} ", asked.ticks) : "") + (asked.around ? "around " : "") + in_words(asked.catoms, asked.body);
    Done done{.shown = {.tick = tick, .verb = asked.verb, .fact = text, .struck = *struck, .links = true}, .event = {.tick = tick}};
    world::LinkChoice choice{.place = asked.verb + " " + text};
    const std::string these = region_of(*struck), others = fmt::format("!({})", these);
    std::string links = toml_string(these);
    if (asked.around) {
        choice.where = *world::parse_region_text(these);
        choice.other = *world::parse_region_text(others);
        links = fmt::format("{{ between = [{}, {}] }}", toml_string(these), toml_string(others));
    } else if (struck->size() == 2) {
        choice.pair = {(*struck)[0], (*struck)[1]};
        links = fmt::format("[[{}]]", fmt::join(*struck, ", "));
    } else {
        choice.where = *world::parse_region_text(these);
    }
    if (!jams) {
        done.toml = fmt::format("{} = {}\n", asked.verb, links);
        (asked.verb == "cut" ? done.event.cut : done.event.heal).push_back(std::move(choice));
        return add(timeline, std::move(done));
    }
    done.shown.ticks = asked.ticks;
    // Of two catoms, the link is named by its ends.
    const std::string key = asked.around ? links.substr(2, links.size() - 4) : fmt::format("where = {}", links);
    done.toml = fmt::format("jam = {{ {}, ticks = {} }}\n", key, asked.ticks);
    done.event.jam.push_back({.links = std::move(choice), .ticks = asked.ticks});
    if (auto fits = may_jam(done.event); !fits) return tl::unexpected<Error>(fits.error());
    return add(timeline, std::move(done));
}

// Jams make messages late, by no more than the run was prepared for: quarantines last as long.
Result<void> ByHand::may_jam(const world::Event& event) const {
    std::vector<world::Event> all(world_.events.begin(), world_.events.begin() + static_cast<std::ptrdiff_t>(own_events_));
    for (std::size_t i = state_.first; i < state_.done.size(); ++i)
        if (state_.done[i].event.tick <= event.tick) all.push_back(state_.done[i].event);
    all.push_back(event);
    const std::optional<std::int64_t> longest = world::longest_jam(all, world_.clock);
    if (longest && *longest <= world_.longest_jam) return {};
    if (world_.longest_jam == 0)
        return fail("jam: the world of this run does not say how long links may be jammed",
                    "Begin it with a world that has [network] longest_jam = 50, for jams of 50 ticks in all");
    return fail(
        fmt::format("jam: messages would be late by more than {} ticks, the most that the world of this run foresees", world_.longest_jam),
        "Make it shorter, or begin with a world that has a greater [network] longest_jam");
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
        return std::tie(a.shown.tick, a.shown.fact, a.toml) == std::tie(b.shown.tick, b.shown.fact, b.toml);
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
    for (const auto& [one, event, toml] : state_.done) {
        if (one.tick <= after) continue;
        out += fmt::format("\n[[event]]\ntick = {}\n{}", one.tick, toml);
    }
    return out;
}

Result<Answer> ByHand::write(const std::string& path, comm::Communicator& comm) const {
    const Result<void> mine = comm.process() == 0 ? write_file(path, as_toml(0)) : Result<void>{};
    if (auto all = comm::outcome_of_first(comm, mine); !all) return tl::unexpected<Error>(all.error());
    return Written{.path = path, .what = "event", .count = state_.done.size()};
}

}  // namespace meld::debug
