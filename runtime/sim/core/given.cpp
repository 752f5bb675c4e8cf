// PartState: the facts that the world gives to its catoms, at the start and while they run.
#include <algorithm>
#include <cstring>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "runtime/base/assert.h"
#include "runtime/base/log.h"
#include "runtime/base/nearest.h"
#include "runtime/sim/core/part_state.h"
#include "runtime/tuple/facts.h"
#include "runtime/tuple/value_text.h"

namespace meld::sim {

namespace {

// A value as an example, as TOML has it.
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

// How the predicate would be written in a world: temp = { where = "all", args = [0.5] }.
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
                                      : "Rules derive it or the world senses it: give facts to a predicate of its own");
    }
    return fail(fact.place + ": the program has no predicate " + fact.predicate + " with " + std::to_string(fact.arguments.size()) +
                    " arguments after the catom",
                known.empty() ? "Declare it in the program" : "Predicates: " + did_you_mean(fact.predicate, known));
}

}  // namespace

Cell PartState::cell_in_regions(Catom catom) const {
    if (!ensemble.is_free()) return ensemble.cell(catom);
    return catom < start_cells.size() ? start_cells[catom] : nearest_cell(ensemble.position(catom));
}

Result<void> PartState::change_given(const world::GivenFact& fact, Given how, u64* matched) {
    const std::optional<u32> predicate = tuple::find_predicate(module, fact.predicate, fact.arguments.size());
    if (!predicate) return no_predicate(module, fact);
    const PredicateInfo& p = module.predicates[*predicate];
    if (p.base == kNone16 || p.column == kNone16)
        return fail(fact.place + ": facts of " + fact.predicate + " are derived by rules or sensed, so the world cannot give them",
                    "Give facts to a predicate of its own and derive " + fact.predicate + " from it");
    tuple::Arena lists;
    std::vector<Value> values;
    for (u32 i = 0; i < p.arity; ++i) {
        const Result<Value> value = tuple::parse_value(tuple::type_of(module, p.fields[i]), fact.arguments[i], lists);
        if (!value) return fail(fact.place + ": " + value.error().problem, value.error().suggestion);
        values.push_back(*value);
    }
    // Kept once, so that the catoms share them.
    for (u32 i = 0; i < p.arity; ++i) values[i] = columns.lists().keep(tuple::type_of(module, p.fields[i]), values[i], 0);
    const Result<void> fits = check_length(fact.place + ": an argument of " + fact.predicate);
    for (Catom c = 0; c < ensemble.index_count() && (how != Given::Check || (matched != nullptr && *matched == 0)); ++c) {
        if (!fits || !owned(c) || !fact.where.contains(ensemble.id(c), cell_in_regions(c), ensemble.position(c))) continue;
        if (matched != nullptr) ++*matched;
        if (how == Given::Check) continue;
        if (how == Given::Give)
            give(p.base, c, values.data());
        else
            take(p.base, c, values.data());
    }
    for (u32 i = 0; i < p.arity; ++i) columns.lists().release(tuple::type_of(module, p.fields[i]), values[i], 0);
    return fits;
}

Result<void> PartState::given_facts() {
    // Who is where and who is there stays as it is.
    const bool still = world.motion.kind == "none" && world.components.empty();
    std::vector<const world::GivenFact*> facts;
    std::vector<u64> matched;
    for (const world::GivenFact& fact : world.facts) {
        facts.push_back(&fact);
        if (auto done = change_given(fact, Given::Give, &matched.emplace_back(0)); !done) return done;
    }
    // A mistake in what happens late is told now.
    for (const world::Event& event : world.events)
        for (const auto* changes : {&event.take, &event.give})
            for (const world::GivenFact& fact : *changes) {
                u64 some = 0;
                if (auto done = change_given(fact, Given::Check, still ? &some : nullptr); !done) return done;
                if (!still) continue;
                facts.push_back(&fact);
                matched.push_back(some);
            }
    warn_of_nobody(facts, matched);
    if (still || !tuple::find_action(module, "create", 1)) warn_of_missing_catoms();
    return {};
}

// A region that matches no catom on any part is hardly meant.
void PartState::warn_of_nobody(const std::vector<const world::GivenFact*>& facts, std::vector<u64> matched) {
    if (!alone()) {
        const std::vector<std::byte> all = comm.allgather(std::as_bytes(std::span(matched)));
        for (std::size_t at = 0; at < all.size(); at += sizeof(u64)) {
            u64 some = 0;
            std::memcpy(&some, all.data() + at, sizeof some);
            matched[at / sizeof some % matched.size()] += some;
        }
    }
    if (comm.part() != 0) return;
    for (std::size_t i = 0; i < facts.size(); ++i)
        if (matched[i] == 0)
            log::warning("{}: `{}` matches no catom, so it changes no facts of {}", facts[i]->place, facts[i]->where.text(),
                         facts[i]->predicate);
}

// Nor is a rule at a catom that is not there and never will be.
void PartState::warn_of_missing_catoms() {
    if (comm.part() != 0) return;
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

// What the world does in this tick.
void PartState::happen() {
    for (const world::Event& event : world.events) {
        if (!event.happens_in(abi.now)) continue;
        for (const world::GivenFact& fact : event.take)
            MELD_CHECK(change_given(fact, Given::Take).has_value(), "an event at {} that was checked", fact.place);
        for (const world::GivenFact& fact : event.give)
            MELD_CHECK(change_given(fact, Given::Give).has_value(), "an event at {} that was checked", fact.place);
    }
}

}  // namespace meld::sim
