#include "tests/reference/answers/judge_way.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <utility>

#include "tests/reference/evaluator/model.h"

namespace meld::reference {

using check::Clause;
using check::Op;
using check::Predicate;
using Node = Answer::Node;
using Part = Answer::Part;
using Way = Answer::Way;

bool WayJudge::fails(std::string why) {
    why_ = std::move(why);
    return false;
}

std::optional<HeadOf> WayJudge::head_of(const Way& way, PredicateId p) {
    for (HeadOf& h : heads_of(program_, p, RuleKind::View))
        if (h.rule->name == way.rule && h.rule->text == way.text && h.rule->file == way.file && h.rule->line == way.line)
            return std::move(h);
    why_ = fmt::format("{}:{} is no rule that gives it: {}", way.file, way.line, way.text);
    return std::nullopt;
}

bool WayJudge::so(std::size_t i, const Way& w, const Pattern& fact) {
    ++judged_.ways;
    const std::optional<HeadOf> head = head_of(w, fact.predicate);
    if (!head) return false;
    const std::optional<Environment> with = bodies_.environment(*head, w.with);
    if (!with) return fails("the values of its variables are none");
    // In one state, or where the run has read it; what is wrong with the latter is said.
    std::string at_once;
    for (const bool spread : {false, true}) {
        const When when{answer_.nodes[i].tick, spread};
        if (body(i, w, *head, fact, *with, when)) return held_long_enough(*head, fact, when);
        if (!spread) at_once = why_;
    }
    return fails(at_once + "; and by what it has read: " + why_);
}

bool WayJudge::assign(std::size_t i, const Way& w, const HeadOf& head, const When& when, Assigned& out) {
    const auto ages = Bodies::ages(program_, *head.rule, head.clauses);
    const std::int64_t own = answer_.nodes[i].tick;
    const auto age = [&](const check::Atom& a) { return when.spread ? ages.at(&a) : 0; };
    std::vector<const Part*> rest;
    for (const Part& part : w.parts) {
        ++judged_.parts;
        if (part.is == "condition") out.conditions.push_back(part.text);
        if (part.is != "condition" || says(part.note, " match")) rest.push_back(&part);
    }
    std::ranges::reverse(rest);
    const auto next = [&](const char* is) -> const Part* {
        if (rest.empty() || rest.back()->is != is) return nullptr;
        const Part* part = rest.back();
        rest.pop_back();
        return part;
    };
    for (const Clause& c : head.clauses) {
        switch (c.kind) {
            case Clause::Kind::Atom: {
                const Part* part = next("fact");
                if (part == nullptr) return fails("a fact is missing for " + check::print(program_, *head.rule, c));
                if (!fact_part(i, *part, head, c.atom, own - age(c.atom), out.named[&c.atom])) return false;
                break;
            }
            case Clause::Kind::Not: {
                const Part* part = next("absent");
                if (part == nullptr) return fails("what is absent is missing for " + check::print(program_, *head.rule, c));
                std::int64_t oldest = 0;
                check::each_atom(c.inner, [&](const check::Atom& a, bool) { oldest = std::max(oldest, age(a)); });
                if (part->tick.value_or(own) != own - oldest) return fails("the tick of what is absent is another");
                out.absent[&c] = part;
                break;
            }
            case Clause::Kind::Aggregate: {
                const Part* part = next("condition");
                if (part == nullptr) return fails("an aggregate is missing");
                const auto atoms = static_cast<std::size_t>(std::ranges::count(c.inner, Clause::Kind::Atom, &Clause::kind));
                Assigned::Matches& matches = out.matches[&c];
                matches.count = static_cast<std::size_t>(number_after(part->note, "of ").value_or(0));
                for (std::size_t n = 0; n < atoms * (asked_.all ? matches.count : std::min(matches.count, kShown)); ++n) {
                    matches.facts.push_back(next("fact"));
                    if (matches.facts.back() == nullptr) return fails("a match of an aggregate is missing");
                }
                break;
            }
            default:
                break;
        }
    }
    return rest.empty() || fails("more parts than the rule has: " + rest.back()->text);
}

// What an answer names for an atom.
bool WayJudge::fact_part(std::size_t i, const Part& part, const HeadOf& head, const check::Atom& atom, std::int64_t tick, Rows& out) {
    if (!part.node || *part.node >= facts_.size()) return fails("a part says no fact: " + part.text);
    const Node& child = answer_.nodes[*part.node];
    const Pattern& fact = facts_[*part.node];
    if (child.fact != part.text) return fails(fmt::format("a part names {} for {}", part.text, child.fact));
    if (fact.predicate != atom.predicate) return fails(part.text + " is of another predicate");
    if (child.tick != tick) return fails(fmt::format("{} is of tick {} instead of {}", part.text, child.tick, tick));
    if (!lower(i, *part.node)) return false;
    const Moment& then = past_.at(tick);
    for (const Facts* facts : {&then.facts, &then.fronts})
        for (const Row& row : (*facts)[atom.predicate.index()])
            if (fact.fits(row)) out.insert(row);
    if (!out.empty()) return true;
    if (without_value(child, fact) && asks_only_existence(head, facts_[i], atom))
        if (const auto row = some_row(fact)) out.insert(*row);
    return !out.empty() || fails(part.text + " does not hold");
}

// Whether the value of the atom's group may be any: nothing reads it, except what the head makes of it where that stands with _ too.
bool WayJudge::asks_only_existence(const HeadOf& head, const Pattern& made, const check::Atom& atom) const {
    const Predicate &p = program_.predicates[atom.predicate], &of = program_.predicates[made.predicate];
    for (std::size_t a = p.aggregate_at; a < atom.arguments.size(); ++a) {
        const check::Term& term = atom.arguments[a];
        if (term.op == Op::Anonymous) continue;
        if (!term.is_variable()) return false;
        std::size_t uses = 0;
        const auto count = [&](check::VariableId v) { uses += v == term.variable ? 1 : 0; };
        for (const Clause& c : head.clauses) check::each_variable(c, count);
        for (std::size_t h = 0; h < head.head->atom.arguments.size(); ++h)
            if (made.whole() || h < of.aggregate_at) check::each_variable(head.head->atom.arguments[h], count);
        if (uses != 1) return false;
    }
    return true;
}

// A row of the group with a value that some fact of the predicate has had.
std::optional<Row> WayJudge::some_row(const Pattern& group) const {
    for (std::int64_t tick = past_.last(); tick >= 0; --tick)
        for (const Facts* facts : {&past_.at(tick).facts, &past_.at(tick).fronts})
            for (Row row : (*facts)[group.predicate.index()]) {
                for (std::size_t a = 0; a < row.size(); ++a)
                    if (group.arguments[a]) row[a] = *group.arguments[a];
                return row;
            }
    return std::nullopt;
}

// Within a recursion ranks fall. Whether a group has a value is a recursion of its own, and its facts stand with _.
bool WayJudge::lower(std::size_t head, std::size_t body) {
    const Node &above = answer_.nodes[head], &below = answer_.nodes[body];
    if (!above.rank || !below.rank || unranked(above)) return true;
    const PredicateId p = facts_[head].predicate, q = facts_[body].predicate;
    const bool alike = p == q && facts_[head].whole() == facts_[body].whole();
    return !alike || *below.rank < *above.rank || fails(fmt::format("{} has rank {}", below.fact, *below.rank));
}

bool WayJudge::body(std::size_t i, const Way& w, const HeadOf& head, const Pattern& fact, const Environment& with, const When& when) {
    Assigned parts;
    if (!assign(i, w, head, when, parts)) return false;
    why_ = "its rule does not give it from this";
    const auto ages = Bodies::ages(program_, *head.rule, head.clauses);
    return bodies_.solve({*head.rule, head.clauses, ages, when, with, parts.named}, [&](const Environment& env) {
        if (answer_.nodes[i].is == "combined" && w.note != "gives " + bodies_.print(*head.rule, env, head.head->atom))
            return fails("a way gives something other than it says: " + w.note);
        return gives(head, env, fact) && printed(head, env, parts) && matched(i, head, env, parts, when);
    });
}

// Whether the head is this fact. Of max(X, Y) either side is a value that the group has had.
bool WayJudge::gives(const HeadOf& head, const Environment& env, const Pattern& fact) {
    const Scene& scene = past_.at(answer_.tick).scene;
    const Predicate& p = program_.predicates[fact.predicate];
    const std::optional<Row> row = head_row(scene, head.head->atom, env);
    if (row && fact.fits(*row)) return true;
    const check::Term& made = head.head->atom.arguments[p.aggregate_at];
    if (p.aggregate != check::Aggregate::None && (made.op == Op::Max || made.op == Op::Min))
        for (const check::Term& side : made.operands) {
            check::Atom one = head.head->atom;
            one.arguments[p.aggregate_at] = side;
            const std::optional<Row> of_side = head_row(scene, one, env);
            if (of_side && fact.fits(*of_side)) return true;
        }
    return fails("its rule gives " + (row ? print(program_, fact.predicate, *row) : "nothing") + " from this");
}

// Whether conditions and absences are those of the rule.
bool WayJudge::printed(const HeadOf& head, const Environment& env, const Assigned& parts) {
    std::vector<std::string> conditions;
    for (const Clause& c : head.clauses) {
        if (c.kind == Clause::Kind::Test && bodies_.says_nothing(*head.rule, env, c.test)) continue;
        if (c.kind == Clause::Kind::Test || c.kind == Clause::Kind::Element || c.kind == Clause::Kind::Aggregate)
            conditions.push_back(bodies_.print(*head.rule, env, c));
        if (c.kind != Clause::Kind::Not) continue;
        const std::string text = bodies_.print(*head.rule, env, c.inner);
        if (parts.absent.at(&c)->text != text) return fails(fmt::format("absent is {} instead of {}", parts.absent.at(&c)->text, text));
    }
    if (conditions == parts.conditions) return true;
    return fails(fmt::format("the conditions are {} instead of {}", fmt::join(parts.conditions, "; "), fmt::join(conditions, "; ")));
}

// ---- aggregates over matches

// Whether all matches are counted, and those that are shown are some.
bool WayJudge::matched(std::size_t i, const HeadOf& head, const Environment& env, const Assigned& parts, const When& when) {
    const auto ages = Bodies::ages(program_, *head.rule, head.clauses);
    for (const auto& [clause, matches] : parts.matches) {
        std::size_t count = 0;
        bodies_.solve({*head.rule, clause->inner, ages, when, env}, [&](const Environment&) {
            ++count;
            return false;
        });
        if (count != matches.count) return fails(fmt::format("{} matches are said to be {}", count, matches.count));
        std::vector<const check::Atom*> atoms;
        for (const Clause& c : clause->inner)
            if (c.kind == Clause::Kind::Atom) atoms.push_back(&c.atom);
        for (std::size_t first = 0; first < matches.facts.size(); first += atoms.size()) {
            std::map<const check::Atom*, Rows> named;
            for (std::size_t n = 0; n < atoms.size(); ++n) {
                const std::int64_t tick = when.tick - (when.spread ? ages.at(atoms[n]) : 0);
                if (!fact_part(i, *matches.facts[first + n], head, *atoms[n], tick, named[atoms[n]])) return false;
            }
            if (!bodies_.solve({*head.rule, clause->inner, ages, when, env, named}, [](const Environment&) { return true; }))
                return fails(matches.facts[first]->text + " begins what is no match");
        }
    }
    return true;
}

// ---- facts that wait

// A head with a delay holds if its body has for so long.
bool WayJudge::held_long_enough(const HeadOf& head, const Pattern& fact, const When& when) {
    if (head.head->delay.op == Op::Anonymous) return true;
    const std::int64_t delay = evaluate(past_.at(when.tick).scene, head.head->delay, {})->integer();
    for (std::int64_t tick = when.tick - delay; tick < when.tick; ++tick)
        if (!past_.has(tick) || !given_by(head, fact, {tick, true}))
            return fails(fmt::format("it waits {} ticks, and its body was not met in tick {}", delay, tick));
    return true;
}

bool WayJudge::given_by(const HeadOf& head, const Pattern& fact, const When& when) const {
    bool any = false;
    each_derivation(head, fact.arguments[0]->integer(), when, [&](const Row& row, const Environment&) { any = any || fact.fits(row); });
    return any;
}

// Every way in which a rule derives something at a catom.
void WayJudge::each_derivation(const HeadOf& head, std::int64_t catom, const When& when,
                               const std::function<void(const Row&, const Environment&)>& visit) const {
    Environment env(head.rule->variables.count());
    env[head.head->atom.arguments[0].variable.index()] = value_of(catom);
    const auto ages = Bodies::ages(program_, *head.rule, head.clauses);
    bodies_.solve({*head.rule, head.clauses, ages, when, env}, [&](const Environment& found) {
        if (const std::optional<Row> row = head_row(past_.at(when.tick).scene, head.head->atom, found)) visit(*row, found);
        return false;
    });
}

void WayJudge::each_counted(const HeadOf& head, std::int64_t catom, const When& when,
                            const std::function<void(const Row&, const Environment&)>& visit) const {
    if (head.head->delay.op == Op::Anonymous) return each_derivation(head, catom, when, visit);
    const Apart apart(program_, head);
    each_derivation(apart.head(), catom, when, [&](const Row& row, const Environment& env) {
        if (waited(apart, env, when.tick)) visit(row, env);
    });
}

// Whether this derivation has held for long enough.
bool WayJudge::waited(const Apart& apart, const Environment& env, std::int64_t now) const {
    const HeadOf& h = apart.head();
    const std::int64_t delay = evaluate(past_.at(now).scene, h.head->delay, {})->integer();
    const auto ages = Bodies::ages(program_, *h.rule, h.clauses);
    const Environment known = apart.known(env);
    for (std::int64_t tick = now - delay; tick < now; ++tick)
        if (tick < 1 || !past_.has(tick) ||
            !bodies_.solve({*h.rule, h.clauses, ages, {tick, true}, known}, [](const Environment&) { return true; }))
            return false;
    return true;
}

}  // namespace meld::reference
