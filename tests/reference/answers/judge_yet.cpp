#include "tests/reference/answers/judge_yet.h"

#include <fmt/format.h>

#include <algorithm>
#include <set>
#include <string_view>
#include <utility>

#include "tests/reference/evaluator/model.h"

namespace meld::reference {

using check::Clause;
using check::Op;
using check::Predicate;
using check::Term;
using Way = Answer::Way;

namespace {

constexpr std::string_view kWaits = "its body is met, and it waits for what comes from ";

}  // namespace

bool YetJudge::fails(std::string why) {
    why_ = std::move(why);
    return false;
}

// Whether some way to satisfy the body gives the fact.
bool YetJudge::met(const HeadOf& h, const Pattern& fact, const When& when) const {
    if (h.of_results) return false;
    Environment env(h.rule->variables.count());
    const std::vector<Term>& arguments = h.head->atom.arguments;
    for (std::size_t a = 0; a < arguments.size(); ++a) {
        if (!arguments[a].is_variable() || !fact.arguments[a]) continue;
        if (h.rule->variables[arguments[a].variable].type == program_.predicates[fact.predicate].arguments[a].type)
            env[arguments[a].variable.index()] = fact.arguments[a];
    }
    const auto ages = Bodies::ages(program_, *h.rule, h.clauses);
    return bodies_.solve({*h.rule, h.clauses, ages, when, env}, [&](const Environment& found) {
        for (std::size_t a = 0; a < arguments.size(); ++a) {
            if (!fact.arguments[a] || arguments[a].op == Op::Anonymous || !all_bound(arguments[a], found) || beyond_states(arguments[a]))
                continue;
            const std::optional<Value> is = evaluate(past_.at(when.tick).scene, arguments[a], found);
            if (!is || *is != *fact.arguments[a]) return false;
        }
        return true;
    });
}

bool YetJudge::so(const Way& w, const HeadOf& h, const Pattern& fact) {
    if (h.of_results) return w.note == "its body is met; results of aggregates in its head were not checked" || fails("it says: " + w.note);
    if (!met(h, fact, {tick_, false})) return fails("its body is not met");
    if (w.note == "it is given once, in the first tick") return h.rule->initial_fact || fails("it is no fact of the text");
    if (says(w.note, "it fires in the next tick")) return (h.rule->linear && !h.rule->initial_fact) || fails("it does not fire");
    if (w.note == "its body is met by one fact twice, and what a rule consumes, no other part of its body matches")
        return consumes_of_several(h) || fails("it reads no linear predicate twice");
    if (h.rule->linear) return fails("it says: " + w.note);
    if (w.note.starts_with(kWaits)) return waits(w, h, fact);
    if (w.note == "its body is met, but not for long enough yet") return too_short(h, fact);
    if (h.head->delay.op != Op::Anonymous) return fails("it says: " + w.note);
    if (says(w.note, " holds")) return others_hold(w, h, fact);
    if (const auto lost = number_after(w.note, "its body is met, and still in quarantine after a loss of rank "))
        return loses(fact, number_after(w.note, fmt::format("of rank {} in tick ", *lost)).value_or(0));
    if (const auto until = number_after(w.note, "in quarantine until tick ")) return quarantine(w, fact, *until);
    if (w.note.ends_with(" is still in quarantine, whatever its value")) return keeps_apart(w, h, fact);
    if (w.note != "its body is met now, and was not when the catom read it; it is read again in the next tick")
        return fails("it says: " + w.note);
    return !met(h, fact, {tick_, true}) || fails("its body was met when the catom read it");
}

// Whether the body, or that of a head, matches several facts of a linear predicate and consumes one of them.
bool YetJudge::consumes_of_several(const HeadOf& h) const {
    const auto is_atom = [](const Clause& c) { return c.kind == Clause::Kind::Atom; };
    return h.rule->linear && std::ranges::any_of(h.clauses, [&](const Clause& c) {
               return is_atom(c) && !c.atom.read_only && program_.predicates[c.atom.predicate].linear() &&
                      std::ranges::count_if(
                          h.clauses, [&](const Clause& other) { return is_atom(other) && other.atom.predicate == c.atom.predicate; }) > 1;
           });
}

bool YetJudge::too_short(const HeadOf& h, const Pattern& fact) {
    if (h.head->delay.op == Op::Anonymous) return fails("it does not wait");
    const std::int64_t delay = evaluate(now().scene, h.head->delay, {})->integer();
    for (std::int64_t tick = tick_ - delay; tick <= tick_; ++tick)
        if (!past_.has(tick) || !met(h, fact, {tick, true})) return true;
    return fails("it has waited for long enough");
}

// Of an open group: in each that the body gives, there is a value that this one could not replace.
bool YetJudge::others_hold(const Way& w, const HeadOf& h, const Pattern& fact) {
    const Predicate& p = program_.predicates[fact.predicate];
    std::string_view said = w.note;
    if (p.aggregate == check::Aggregate::None || !said.starts_with("its body is met, and ")) return fails("it says: " + w.note);
    said.remove_prefix(21);
    const std::optional<Pattern> named = take_fact(program_, said);
    if (!named || !named->whole() || !Past::any(now().facts, *named)) return fails("it does not hold: " + w.note);
    Environment env(h.rule->variables.count());
    env[h.head->atom.arguments[0].variable.index()] = fact.arguments[0];
    bool all = true, some = false;
    bodies_.solve({*h.rule, h.clauses, {}, {tick_, false}, env}, [&](const Environment& found) {
        const std::optional<Row> row = head_row(now().scene, h.head->atom, found);
        if (!row || !(combines(p.aggregate) || fact.fits(*row))) return false;
        Pattern group{.predicate = fact.predicate, .arguments = {}};
        for (std::size_t a = 0; a < row->size(); ++a) {
            group.arguments.emplace_back();
            if (a < p.aggregate_at) group.arguments.back() = (*row)[a];
            if (a < p.aggregate_at && fact.arguments[a] && *fact.arguments[a] != (*row)[a]) return false;
        }
        all = all && Past::any(now().facts, group);
        some = some || group.fits(named->row());
        return false;
    });
    return (all && some) || fails("there is a group without a value, or this one is not of it: " + w.note);
}

// Each of these neighbours must contribute to a group that the body gives, and has not.
bool YetJudge::waits(const Way& w, const HeadOf& h, const Pattern& fact) {
    const Predicate& p = program_.predicates[fact.predicate];
    if (!p.complete_link.valid()) return fails("it waits for nobody");
    std::set<std::int64_t> named;
    for (std::string_view rest = std::string_view(w.note).substr(kWaits.size()); !rest.empty();) {
        const std::size_t end = std::min(rest.find(','), rest.size());
        const std::optional<Value> catom = parse_value(check::Type::Node, rest.substr(0, end));
        if (!catom) return fails("it says: " + w.note);
        named.insert(catom->integer());
        rest.remove_prefix(std::min(end + 2, rest.size()));
    }
    const auto group_of = [&](const Row& row) { return Row(row.begin(), row.begin() + static_cast<std::ptrdiff_t>(p.aggregate_at)); };
    std::map<Row, std::set<std::int64_t>> heard;
    std::set<Row> given;
    for (const HeadOf& other : heads_of(program_, fact.predicate, RuleKind::View))
        for (const bool spread : {false, true}) {
            Environment env(other.rule->variables.count());
            env[other.rule->site.index()] = fact.arguments[0];
            const auto ages = Bodies::ages(program_, *other.rule, other.clauses);
            bodies_.solve({*other.rule, other.clauses, ages, {tick_, spread}, env}, [&](const Environment& found) {
                const std::optional<Row> row = head_row(now().scene, other.head->atom, found);
                if (!row) return false;
                if (other.head == h.head) given.insert(group_of(*row));
                for (const check::VariableId v : other.rule->contributors)
                    if (spread) heard[group_of(*row)].insert(found[v.index()]->integer());
                return false;
            });
        }
    return std::ranges::any_of(given,
                               [&](const Row& group) {
                                   for (std::size_t a = 0; a < group.size(); ++a)
                                       if (fact.arguments[a] && *fact.arguments[a] != group[a]) return false;
                                   return silent(fact, heard[group]) == named;
                               }) ||
           fails("it waits for others than it says: " + w.note);
}

std::set<std::int64_t> YetJudge::silent(const Pattern& fact, const std::set<std::int64_t>& heard) const {
    const Predicate& p = program_.predicates[fact.predicate];
    std::set<std::int64_t> out;
    for (const Link& link : now().scene.links.at(fact.arguments[0]->integer())) {
        const Value here = *fact.arguments[0], there = value_of(link.other);
        Pattern route{.predicate = p.complete_link, .arguments = {p.complete_outgoing ? here : there, p.complete_outgoing ? there : here}};
        route.arguments.resize(program_.predicates[p.complete_link].arguments.size());
        if (Past::any(now().facts, route) && !heard.contains(link.other)) out.insert(link.other);
    }
    return out;
}

// The body was met when it was read, and what it names is of a min or max of the same recursion.
bool YetJudge::keeps_apart(const Way& w, const HeadOf& h, const Pattern& fact) {
    constexpr std::string_view kBegins = "its body is met, and that there is ";
    std::string_view said = w.note;
    if (!said.starts_with(kBegins)) return fails("it says: " + w.note);
    said.remove_prefix(kBegins.size());
    const std::optional<Pattern> named = take_fact(program_, said);
    if (!named || !Past::any(now().facts, *named)) return fails("it does not hold: " + w.note);
    const check::Aggregate aggregate = program_.predicates[named->predicate].aggregate;
    if (aggregate != check::Aggregate::Min && aggregate != check::Aggregate::Max) return fails("it is no min or max: " + w.note);
    const bool together = std::ranges::any_of(program_.strata, [&](const check::Stratum& s) {
        return s.recursive && s.contains(fact.predicate) && s.contains(named->predicate);
    });
    if (!together) return fails("it is of another recursion: " + w.note);
    const bool reads = std::ranges::any_of(
        h.clauses, [&](const check::Clause& c) { return c.kind == check::Clause::Kind::Atom && c.atom.predicate == named->predicate; });
    if (!reads) return fails("the rule does not read it: " + w.note);
    return met(h, fact, {tick_, true}) || fails("its body was not met when the catom read it");
}

// It ends, and there is what it waits for: the group has lost a value in that tick.
bool YetJudge::quarantine(const Way& w, const Pattern& fact, std::int64_t until) {
    ++judged_.quarantines;
    const auto rank = number_after(w.note, ": rank "), lost = number_after(w.note, "against a loss of rank "),
               when = number_after(w.note, fmt::format("of rank {} in tick ", lost.value_or(0)));
    if (!rank || !lost || !when) return fails("it says: " + w.note);
    if (until <= tick_ || *when > tick_ || *when < 1) return fails("this quarantine is over");
    // Of links that take one tick.
    if (until != *when + *rank - *lost + 2) return fails("the quarantine ends in another tick");
    return loses(fact, *when);
}

// Whether the group has lost a value in this tick.
bool YetJudge::loses(const Pattern& fact, std::int64_t when) {
    if (when < 1 || when > tick_) return fails(fmt::format("it can have lost nothing in tick {}", when));
    const Predicate& p = program_.predicates[fact.predicate];
    Pattern group = fact;
    if (p.aggregate != check::Aggregate::None)
        for (std::size_t a = p.aggregate_at; a < group.arguments.size(); ++a) group.arguments[a].reset();
    const auto all_at = [&](std::int64_t tick) {
        Rows out;
        for (const Facts* facts : {&past_.at(tick).facts, &past_.at(tick).fronts})
            for (const Row& row : (*facts)[fact.predicate.index()])
                if (group.fits(row)) out.insert(row);
        return out;
    };
    const Rows before = all_at(when - 1), then = all_at(when);
    return !std::ranges::includes(then, before) || fails(fmt::format("nothing was lost in tick {}", when));
}

}  // namespace meld::reference
