#include "runtime/sim/core/setup/world_facts.h"

#include <fmt/format.h>

#include <algorithm>
#include <atomic>
#include <functional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "runtime/base/assert.h"
#include "runtime/base/bytes.h"
#include "runtime/base/did_you_mean.h"
#include "runtime/base/terminal/log.h"
#include "runtime/engine/tuple/facts.h"
#include "runtime/engine/tuple/value_text.h"
#include "runtime/sim/core/failures/catom_failures.h"
#include "runtime/sim/core/setup/graph_facts.h"
#include "runtime/sim/core/setup/robot_facts.h"
#include "runtime/sim/core/setup/setup.h"
#include "runtime/sim/core/setup/unmatched.h"
#include "runtime/sim/core/setup/unmatched_links.h"
#include "runtime/world/shapes/region_id.h"

namespace meld::sim {

namespace {

// An example value, in TOML.
std::string some_value(tuple::Type type) {
    switch (type.kind()) {
        case ValueType::Int:
            return "1";
        case ValueType::Float:
            return "0.5";
        case ValueType::Bool:
            return "true";
        case ValueType::Node:
            return "\"@0\"";
        case ValueType::String:
            return "\"text\"";
        case ValueType::List:
            return "[" + some_value(type.item(0)) + "]";
        default:
            return tuple::type_name(type);
    }
}

// How a world would give the predicate: temp = { where = "all", args = [0.5] }.
std::string as_given(const ModuleInfo& module, const PredicateInfo& p) {
    if (p.arity == 0) return fmt::format("{} = \"all\"", p.name);
    std::string values;
    for (u32 i = 0; i < p.arity; ++i) values += fmt::format("{}{}", i == 0 ? "" : ", ", some_value(tuple::type_of(module, p.fields[i])));
    return fmt::format("{} = {{ where = \"all\", args = [{}] }}", p.name, values);
}

tl::unexpected<Error> no_predicate(const ModuleInfo& module, const world::GivenFact& fact) {
    std::vector<std::string_view> known;
    for (u32 i = 0; i < module.predicate_count; ++i) {
        const PredicateInfo& p = module.predicates[i];
        if (p.auxiliary) continue;
        if (p.base != kNone16) known.emplace_back(p.name);
        if (p.name != fact.predicate) continue;
        const auto arguments = [](std::size_t n) { return fmt::format("{} argument{}", n, n == 1 ? "" : "s"); };
        return fail(fmt::format("{}: {} has {} after the catom, and is given {}", fact.place, p.name, arguments(p.arity),
                                arguments(fact.arguments.size())),
                    p.base != kNone16 ? "Write " + as_given(module, p)
                                      : "Rules derive it or the world senses it: give facts to a separate predicate");
    }
    return fail(fact.place + ": the program has no predicate " + fact.predicate + " with " + std::to_string(fact.arguments.size()) +
                    " arguments after the catom",
                known.empty() ? "Declare it in the program" : did_you_mean(fact.predicate, known));
}

}  // namespace

std::vector<std::string> never_given(const ModuleInfo& module, const world::World& world) {
    std::vector<bool> made(module.predicate_count);
    for (u32 r = 0; r < module.rule_count; ++r)
        for (u32 i = 0; i < module.rules[r].head_count; ++i) made[module.rules[r].heads[i]] = true;
    const auto give = [&](const std::vector<world::GivenFact>& facts) {
        for (const world::GivenFact& fact : facts)
            if (const auto predicate = tuple::find_predicate(module, fact.predicate, fact.arguments.size())) made[*predicate] = true;
    };
    give(world.facts);
    for (const world::Event& event : world.events) give(event.give);
    std::vector<std::string> names;
    const std::span<const PredicateInfo> all(module.predicates, module.predicate_count);
    for (u32 i = 0; i < module.predicate_count; ++i) {
        const PredicateInfo& p = module.predicates[i];
        const bool may_be_given = !p.auxiliary && p.base != kNone16 && p.column != kNone16;
        // Motion makes three linear facts, of amoebots a fourth, and a component in C++ may send any.
        const std::string_view name = p.name;
        const bool may_be_sent = p.kind == PredicateKind::Linear && (!world.components.empty() || name == "failed" || name == "created" ||
                                                                     name == "broke" || (name == "activated" && world.has_amoebots()));
        if (made[i] || graph_gives(world, name) || robots_give(module, world, i) || !may_be_given || !p.read ||
            p.kind == PredicateKind::Sensed || may_be_sent)
            continue;
        const auto namesakes = std::ranges::count_if(all, [&](const PredicateInfo& q) { return !q.auxiliary && q.name == name; });
        names.push_back(namesakes == 1 ? std::string(name) : fmt::format("{}/{}", name, p.arity + 1));
    }
    return names;
}

Result<void> GivenFacts::change_one(const world::GivenFact& fact, Change how, Reached* reached, const std::vector<Catom>* only) {
    const std::optional<u32> predicate = tuple::find_predicate(subdomain_.module, fact.predicate, fact.arguments.size());
    if (!predicate) return no_predicate(subdomain_.module, fact);
    const PredicateInfo& p = subdomain_.module.predicates[*predicate];
    if (p.base == kNone16 || p.column == kNone16)
        return fail(
            fact.place + ": facts of " + fact.predicate + " are derived by rules or sensed, so the world can neither give nor take them",
            "Give facts to a separate predicate and derive " + fact.predicate + " from it");
    tuple::ListStore& lists_of_facts = subdomain_.facts_.columns.lists();
    tuple::Arena lists;
    std::vector<Value> values;
    for (u32 i = 0; i < p.arity; ++i) {
        const Result<Value> value = tuple::parse_value(tuple::type_of(subdomain_.module, p.fields[i]), fact.arguments[i], lists);
        if (!value) return fail(fact.place + ": " + value.error().problem, value.error().suggestion);
        values.push_back(*value);
    }
    // Stored once, so that the catoms share them.
    for (u32 i = 0; i < p.arity; ++i) values[i] = lists_of_facts.keep(tuple::type_of(subdomain_.module, p.fields[i]), values[i], 0);
    const Result<void> fits = check_length(lists_of_facts, subdomain_.abi_, fact.place + ": an argument of " + fact.predicate);
    const std::optional<std::size_t> route = as_route(fact, p, how);
    std::vector<Catom> one;
    if (const std::optional<std::uint64_t> id = only == nullptr ? world::named_id(fact.where) : std::nullopt) {
        if (const std::optional<Catom> catom = subdomain_.ensemble.find(*id)) one.push_back(*catom);
        only = &one;
    }
    const bool at_once = only == nullptr && (how == Change::Give || how == Change::Take) && !route && fits;
    if (at_once) {
        const Reached here = change_all(fact, p.base, how, values.data());
        if (reached != nullptr) reached->matched += here.matched, reached->changed += here.changed;
    }
    const std::size_t count = at_once ? 0 : only != nullptr ? only->size() : subdomain_.ensemble.index_count();
    for (std::size_t i = 0; i < count && (how != Change::Check || (reached != nullptr && reached->matched == 0)); ++i) {
        const Catom c = only != nullptr ? (*only)[i] : static_cast<Catom>(i);
        if (!fits || !subdomain_.owned(c) || !subdomain_.members_.in_region(fact.where, c)) continue;
        if (reached != nullptr) ++reached->matched;
        if (how == Change::Check) continue;
        if (how == Change::Look) {
            if (holds(*predicate, c, values.data())) ++reached->changed;
            continue;
        }
        if (route) dead_links_.look_at_given(*route, c, *predicate, values[0].catom);
        const bool changed = how == Change::Give ? subdomain_.give(p.base, c, values.data()) : subdomain_.take(p.base, c, values.data());
        if (reached != nullptr && changed) ++reached->changed;
    }
    for (u32 i = 0; i < p.arity; ++i) lists_of_facts.release(tuple::type_of(subdomain_.module, p.fields[i]), values[i], 0);
    return fits;
}

GivenFacts::Reached GivenFacts::change_all(const world::GivenFact& fact, u32 predicate, Change how, const Value* arguments) {
    FactStore& facts = subdomain_.facts_;
    const std::size_t count = subdomain_.ensemble.index_count();
    std::atomic<u64> matched = 0, changed = 0;
    subdomain_.workers.run((count + eval::Agenda::kBlock - 1) / eval::Agenda::kBlock, [&](int worker, std::size_t block) {
        u64 here = 0, other = 0;
        for (std::size_t i = block * eval::Agenda::kBlock; i < std::min(count, (block + 1) * eval::Agenda::kBlock); ++i) {
            const Catom c = static_cast<Catom>(i);
            if (!subdomain_.owned(c) || !subdomain_.members_.in_region(fact.where, c)) continue;
            ++here;
            other += how == Change::Give ? facts.give(predicate, c, arguments, worker) : facts.take(predicate, c, arguments, worker);
        }
        matched.fetch_add(here, std::memory_order_relaxed);
        changed.fetch_add(other, std::memory_order_relaxed);
    });
    return {matched, changed};
}

Result<void> GivenFacts::start() {
    Matched all;
    for (const world::GivenFact& fact : subdomain_.world.facts) {
        all.facts.push_back(&fact);
        Reached reached;
        if (auto done = change_one(fact, Change::Give, &reached); !done) return done;
        all.catoms.push_back(reached.matched);
    }
    if (auto done = give_graph_facts(subdomain_); !done) return done;
    give_robot_facts(subdomain_);
    if (auto done = look_at_events(all); !done) return done;
    warn_of_unmatched(all);
    CatomFailures(subdomain_).look_at_events();
    UnmatchedLinks(subdomain_).look_at_events();
    CatomFailures(subdomain_).look_at_faults();
    UnmatchedLinks(subdomain_).look_at_start();
    if (still() || !subdomain_.program_actions.uses(ActionKind::Create)) warn_of_missing_catoms();
    // Catoms that move may come to touch.
    if (subdomain_.world.motion.kind != "none") return {};
    dead_links_.look_at_text();
    return dead_links_.verdict();
}

void GivenFacts::give_again(const std::vector<Catom>& catoms) {
    for (const world::GivenFact& fact : subdomain_.world.facts)
        MELD_CHECK(change_one(fact, Change::Give, nullptr, &catoms).has_value(), "a fact at {} that was given before", fact.place);
    MELD_CHECK(give_graph_facts(subdomain_, &catoms).has_value(), "facts of the graph that were given before");
    give_robot_facts(subdomain_, &catoms);
}

// A mistake in an event is reported now, however late the event is.
Result<void> GivenFacts::look_at_events(Matched& all) {
    for (const world::Event& event : subdomain_.world.events)
        for (const auto* changes : {&event.take, &event.give})
            for (const world::GivenFact& fact : *changes) {
                Reached some;
                if (auto done = change_one(fact, Change::Check, still() ? &some : nullptr); !done) return done;
                if (!still()) continue;
                all.facts.push_back(&fact);
                all.catoms.push_back(some.matched);
            }
    return {};
}

Result<void> GivenFacts::check_events() {
    Matched all;
    if (auto done = look_at_events(all); !done) return done;
    warn_of_unmatched(all);
    CatomFailures(subdomain_).look_at_events();
    UnmatchedLinks(subdomain_).look_at_events();
    if (still()) warn_of_missing_catoms();
    return {};
}

std::optional<std::size_t> GivenFacts::as_route(const world::GivenFact& fact, const PredicateInfo& p, Change how) const {
    const std::vector<world::GivenFact>& all = subdomain_.world.facts;
    if (how != Change::Give || !p.route || subdomain_.world.motion.kind != "none") return std::nullopt;
    // The facts of events are stored elsewhere.
    const bool at_start = std::greater_equal<>{}(&fact, all.data()) && std::less<>{}(&fact, all.data() + all.size());
    return at_start ? std::optional(static_cast<std::size_t>(&fact - all.data())) : std::nullopt;
}

void GivenFacts::warn_of_unmatched(const Matched& all) {
    Unmatched unmatched(subdomain_.comm);
    for (std::size_t i = 0; i < all.facts.size(); ++i)
        unmatched.add(all.catoms[i] > 0, [fact = all.facts[i]] {
            return fmt::format("{}: `{}` matches no catom, so it changes no facts of {}", fact->place, fact->where.text(), fact->predicate);
        });
    unmatched.warn();
}

// A rule at a catom that does not exist and never will is probably a mistake.
void GivenFacts::warn_of_missing_catoms() {
    if (subdomain_.comm.process() != 0) return;
    const ModuleInfo& module = subdomain_.module;
    const std::uint64_t next_id = subdomain_.next_id();
    const RuleInfo* first = nullptr;
    u32 count = 0;
    for (u32 r = 0; r < module.rule_count; ++r) {
        const RuleInfo& rule = module.rules[r];
        if (rule.at == kEverywhere || rule.at < next_id) continue;
        if (first == nullptr) first = &rule;
        ++count;
    }
    if (first == nullptr || next_id == 0) return;
    log::warning("rule {} names catom @{}, and the world has only @0 to @{}: {}{}", first->name, first->at, next_id - 1, first->text,
                 count > 1 ? " (and " + std::to_string(count - 1) + " more such rules)" : "");
}

GivenFacts::Reached GivenFacts::sum_of_all(Reached mine) {
    if (subdomain_.alone()) return mine;
    Reached sum;
    const std::vector<std::byte> all = subdomain_.comm.allgather(std::as_bytes(std::span(&mine, 1)));
    for (ByteReader in(all, "catoms that an event reaches"); !in.done();) {
        const auto theirs = in.read<Reached>();
        sum.matched += theirs.matched, sum.changed += theirs.changed;
    }
    return sum;
}

bool GivenFacts::holds(u32 predicate, Catom catom, const Value* arguments) const {
    bool found = false;
    const PredicateInfo& p = subdomain_.module.predicates[predicate];
    tuple::each_fact(subdomain_.module, subdomain_.columns, subdomain_.geometry(), predicate, catom,
                     [&](const Value* held) { found = found || tuple::compare_arguments(subdomain_.module, p, held, arguments) == 0; });
    return found;
}

// An event that happens again and again may find nothing in between, so it warns only the first time.
void GivenFacts::take(const world::Event& event, const world::GivenFact& fact) {
    Reached reached;
    MELD_CHECK(change_one(fact, Change::Take, &reached).has_value(), "an event at {} that was checked", fact.place);
    reached = sum_of_all(reached);
    if (reached.changed > 0 || subdomain_.tick() != event.tick) return;
    // Of a region that never matches, the start has warned.
    if (reached.matched == 0 && still()) return;
    subdomain_.refresh();
    Reached held;
    MELD_CHECK(change_one(fact, Change::Look, &held).has_value(), "an event at {} that was checked", fact.place);
    held = sum_of_all(held);
    if (subdomain_.comm.process() != 0) return;
    std::string text = fact.predicate;
    for (const std::string& argument : fact.arguments) text += (text.size() == fact.predicate.size() ? "(_, " : ", ") + argument;
    if (!fact.arguments.empty()) text += ")";
    if (held.changed > 0)
        log::warning(
            "{}: {} is taken in tick {}, but is not given from outside, or no longer: what rules derive or the program's text says stays. "
            "Let "
            "the world give, in [facts], what is to be taken",
            fact.place, text, subdomain_.tick());
    else
        log::warning("{}: {} is taken in tick {}, but `{}` matches no catom that has it then, so nothing is taken", fact.place, text,
                     subdomain_.tick(), fact.where.text());
}

// The world's changes in this tick.
void GivenFacts::change() {
    for (const world::Event& event : subdomain_.world.events) {
        if (!event.happens_in(subdomain_.tick())) continue;
        for (const world::GivenFact& fact : event.take) take(event, fact);
        for (const world::GivenFact& fact : event.give)
            MELD_CHECK(change_one(fact, Change::Give).has_value(), "an event at {} that was checked", fact.place);
    }
}

}  // namespace meld::sim
