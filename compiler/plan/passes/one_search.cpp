// Pass: search. A linear rule that has fired starts over: the next match is the first one of all. But where a firing only takes facts away
// from what the rule reads, every match before the one that fired is still none, and the search goes on where it stands:
//     route(A, T, D), route(A, T, E), D <= E -o route(A, T, D).        keeps the first fact, takes the second one
//     seen(A, X), seen(A, X) -o seen(A, X).
//     best(A, T, D), offer(A, T, E), E < D -o best(A, T, E).           changes best in its place, and takes offer
// Rules fire in the same order either way. The conditions:
//   - What a head makes, no step of the rule reads, except that it may make a consumed fact again as it was. The first fact that the search
//     finds may also be made with other arguments: the search then goes on with that one.
//   - Between two firings nothing else happens: no view and no rule before it depends on what it makes or consumes.
//   - No step asks for the absence of what it consumes, or has another result when it is asked again.
// Runs when all rules have their steps.
#include <algorithm>

#include "compiler/plan/join/draws.h"
#include "compiler/plan/passes/in_between.h"
#include "compiler/plan/plan.h"

namespace meld::plan {

using namespace check;

namespace {

class SearchFinder {
  public:
    SearchFinder(const Plan& plan, std::size_t number)
        : plan_(plan), rule_(plan.linear_rules[number]), text_(plan.program.rules[rule_.rule]), number_(number) {}

    OneSearch find() {
        if (text_.select != Select::None || !find_consumed()) return {};
        found_.asked = true;
        for (const auto obstacle : {&SearchFinder::of_heads, &SearchFinder::of_steps, &SearchFinder::of_order, &SearchFinder::of_others})
            if (found_.obstacle = (this->*obstacle)(); !found_.obstacle.empty()) break;
        return found_;
    }

  private:
    const std::string& name(PredicateId p) const { return plan_.program.predicates[p].name; }
    std::uint64_t own_bit(PredicateId p) const { return plan_.column_of(p).own_dirty; }
    const Match& match(std::size_t step) const { return *as<Match>(rule_.steps[step]); }

    bool find_consumed() {
        for (std::size_t i = 0; i < rule_.steps.size(); ++i) {
            const Match* m = as<Match>(rule_.steps[i]);
            if (m != nullptr && m->at_site && !m->read_only && plan_.program.predicates[m->predicate].linear()) consumed_.push_back(i);
        }
        return !consumed_.empty();
    }

    // ---- what the heads make

    bool is_here(const MakeFact& fact) const {
        return fact.place == text_.site && plan_.program.predicates[fact.predicate].kind != PredicateKind::Action &&
               plan_.of(fact.predicate).column.valid();
    }
    // Whether a head makes the fact that a step has found, bit by bit: of two equal floats one may be -0.
    bool same_fact(const Match& m, const MakeFact& fact) const {
        for (std::size_t i = 0; i < m.arguments.size(); ++i) {
            const Term &found = m.arguments[i], &made = fact.arguments[i];
            const Type& type = plan_.program.predicates[m.predicate].arguments[i + 1].type;
            const bool exact = m.uses[i] == ArgumentUse::Bind || type == Type::Int || type == Type::Bool || type == Type::Node;
            if (m.uses[i] == ArgumentUse::Skip || !exact || !found.is_variable() || !made.is_variable() ||
                found.variable != made.variable || text_.variables[found.variable].type != type)
                return false;
        }
        return true;
    }
    std::string of_heads() {
        std::vector<std::size_t> others;  // Heads that make facts here, other than those that put one back.
        std::vector<std::size_t> left = consumed_;
        for (std::size_t i = 0; i < rule_.heads.size(); ++i) {
            const MakeFact* fact = as<MakeFact>(rule_.heads[i]);
            if (fact == nullptr || !is_here(*fact)) continue;
            const auto same = std::ranges::find_if(
                left, [&](std::size_t step) { return match(step).predicate == fact->predicate && same_fact(match(step), *fact); });
            if (same == left.end()) {
                others.push_back(i);
                continue;
            }
            found_.put_back.push_back({*same, i});
            left.erase(same);
        }
        if (left.empty()) return "it takes nothing away";
        for (const std::size_t i : others)
            if (std::string obstacle = of_made(i, left); !obstacle.empty()) return obstacle;
        for (const HeadPlan& h : rule_.heads)
            if (std::string obstacle = of_nested(h); !obstacle.empty()) return obstacle;
        return "";
    }
    // A head that makes a new fact: of what no step reads, or the first fact of the search with other arguments.
    std::string of_made(std::size_t head, std::vector<std::size_t>& left) {
        const MakeFact& fact = *as<MakeFact>(rule_.heads[head]);
        made_ |= own_bit(fact.predicate);
        if (times_read(fact.predicate) == 0) return "";
        const bool first = times_read(fact.predicate) == 1 && !left.empty() && left[0] == consumed_[0] &&
                           match(left[0]).predicate == fact.predicate && found_.changed.head == OneSearch::kNone && reads_first(left[0]);
        if (!first) return fmt::format("it reads {} and makes another one", name(fact.predicate));
        found_.changed = {left[0], head};
        return "";
    }
    // Whether nothing is read before this step.
    bool reads_first(std::size_t step) const {
        return std::all_of(rule_.steps.begin(), rule_.steps.begin() + static_cast<std::ptrdiff_t>(step),
                           [](const Step& s) { return as<Test>(s) != nullptr || as<Set>(s) != nullptr; });
    }
    int times_read(PredicateId p) const {
        int times = 0;
        const auto count = [&](const Step& s) {
            const Match* m = as<Match>(s);
            const ChangeSince* since = as<ChangeSince>(s);
            times += (m != nullptr && m->predicate == p) || (since != nullptr && since->predicate == p);
        };
        each_step(rule_.steps, count);
        each_head_plan(rule_.heads, [&](const HeadPlan& h) {
            if (const std::vector<Step>* steps = steps_of(h)) each_step(*steps, count);
        });
        return times;
    }
    // What is in a comprehension, or depends on a condition.
    std::string of_nested(const HeadPlan& head) {
        if (as<MakeFact>(head) != nullptr) return "";
        std::string obstacle;
        each_head_plan({head}, [&](const HeadPlan& h) {
            if (const MakeFact* fact = as<MakeFact>(h); fact != nullptr && is_here(*fact)) {
                made_ |= own_bit(fact->predicate);
                if (times_read(fact->predicate) > 0) obstacle = fmt::format("it reads {} and makes another one", name(fact->predicate));
            }
            if (const std::vector<Step>* steps = steps_of(h))
                each_step(*steps, [&](const Step& s) {
                    const Match* m = as<Match>(s);
                    if (m != nullptr && plan_.program.predicates[m->predicate].linear())
                        obstacle = fmt::format("a head reads {}", name(m->predicate));
                });
        });
        return obstacle;
    }

    // ---- what the steps ask

    std::string of_steps() {
        for (const std::size_t i : consumed_) {
            const PredicateId p = match(i).predicate;
            const auto times = std::ranges::count_if(consumed_, [&](std::size_t k) { return match(k).predicate == p; });
            if (times_read(p) != times) return fmt::format("it also reads {} without consuming it", name(p));
        }
        std::string obstacle;
        each_step(rule_.steps, [&](const Step& s) {
            each_part(
                s,
                [&](const Term& t) {
                    if (draws(plan_.program, t)) obstacle = "a condition depends on when it is asked";
                },
                [](VariableId) {});
            if (as<ChangeSince>(s) != nullptr) obstacle = "it compares with the previous tick";
        });
        return obstacle;
    }
    // A fact that changes in its place is found by its order alone.
    std::string of_order() {
        if (found_.changed.step == OneSearch::kNone) return "";
        const Match& m = match(found_.changed.step);
        return m.lookup.kind == Lookup::Kind::Index
                   ? fmt::format("{} is found by an index and made with other arguments", name(m.predicate))
                   : "";
    }
    std::string of_others() {
        std::uint64_t consumed = 0;
        for (const std::size_t i : consumed_) consumed |= own_bit(match(i).predicate);
        return in_between(plan_, number_, made_, consumed);
    }

    const Plan& plan_;
    const RulePlan& rule_;
    const Rule& text_;
    std::size_t number_;
    std::vector<std::size_t> consumed_;  // Numbers of steps.
    std::uint64_t made_ = 0;             // Dirty bits.
    OneSearch found_;
};

}  // namespace

void plan_searches(Plan& plan) {
    for (std::size_t i = 0; i < plan.linear_rules.size(); ++i) plan.linear_rules[i].search = SearchFinder(plan, i).find();
}

}  // namespace meld::plan
