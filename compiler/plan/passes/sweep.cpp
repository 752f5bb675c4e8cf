// Pass: sweeps. A linear rule that updates one fact, the state, by each fact of another predicate, the messages,
//     listening(A, R, T, M, S), told(A, R, U) -o listening(A, R, T, M - 1, S + U - T).
// takes all messages of a catom in one pass over them, in their order, if that is what its firings would do one by one:
//   - Between two firings nothing else happens: no view and no rule before it depends on what it makes or consumes.
//   - A message that did not fit the state does not fit the next one either: no condition on a message depends on an argument of the state
//     that the rule changes. Conditions on the state alone, or on a message alone, may be any.
// It is decided for a state that is one fact; where a catom holds several, rules fire one by one. Runs when all rules have their steps.
#include <algorithm>
#include <map>

#include "compiler/plan/join/draws.h"
#include "compiler/plan/passes/in_between.h"
#include "compiler/plan/plan.h"

namespace meld::plan {

using namespace check;

namespace {

class SweepFinder {
  public:
    SweepFinder(const Plan& plan, std::size_t number) : plan_(plan), rule_(plan.linear_rules[number]), number_(number) {}

    Sweep find() {
        if (plan_.program.rules[rule_.rule].select != Select::None || !find_facts()) return {};
        for (const auto obstacle :
             {&SweepFinder::other_steps, &SweepFinder::other_heads, &SweepFinder::in_between, &SweepFinder::conditions})
            if (sweep_.obstacle = (this->*obstacle)(); !sweep_.obstacle.empty()) break;
        return sweep_;
    }

  private:
    const std::string& name(PredicateId p) const { return plan_.program.predicates[p].name; }
    std::uint64_t own_bit(PredicateId p) const { return plan_.column_of(p).own_dirty; }

    // Two consumed facts, one of which the rule makes again.
    bool find_facts() {
        std::vector<const Match*> consumed;
        each_step(rule_.steps, [&](const Step& step) {
            const Match* m = as<Match>(step);
            if (m != nullptr && m->at_site && !m->read_only && plan_.program.predicates[m->predicate].linear()) consumed.push_back(m);
        });
        if (consumed.size() != 2 || consumed[0]->predicate == consumed[1]->predicate) return false;
        for (const std::size_t i : {0u, 1u}) {
            const MakeFact* made = made_here(consumed[i]->predicate);
            if (made == nullptr || made_here(consumed[1 - i]->predicate) != nullptr) continue;
            state_ = consumed[i];
            message_ = consumed[1 - i];
            next_ = made;
            sweep_ = {.state = state_->predicate, .messages = message_->predicate};
            return true;
        }
        return false;
    }
    const MakeFact* made_here(PredicateId p) const {
        for (const HeadPlan& h : rule_.heads)
            if (const MakeFact* fact = as<MakeFact>(h); fact != nullptr && fact->predicate == p && fact->place == site()) return fact;
        return nullptr;
    }
    VariableId site() const { return plan_.program.rules[rule_.rule].site; }

    std::string other_steps() {
        for (const Step& step : rule_.steps) {
            const Match* m = as<Match>(step);
            if (m != nullptr && m != state_ && m != message_) {
                // A second state or message is another fact than the one that changes, or is taken.
                if (m->predicate != sweep_.state && m->predicate != sweep_.messages)
                    return fmt::format("it reads {} too", name(m->predicate));
                return fmt::format("it also reads {} without consuming it", name(m->predicate));
            }
            if (m == nullptr && as<Test>(step) == nullptr && as<Set>(step) == nullptr) return "it asks for more than two facts";
            bool drawn = false;
            each_part(step, [&](const Term& t) { drawn = drawn || draws(plan_.program, t); }, [](VariableId) {});
            if (drawn) return "a condition depends on when it is asked";
        }
        return "";
    }
    std::string other_heads() {
        std::size_t states = 0;
        for (const HeadPlan& h : rule_.heads) {
            const MakeFact* fact = as<MakeFact>(h);
            if (fact == nullptr) return "not all of its heads are single facts";
            states += fact->predicate == sweep_.state && fact->place == site();
        }
        return states > 1 ? fmt::format("it makes several {}", name(sweep_.state)) : "";
    }

    std::string in_between() {
        std::uint64_t made = 0;
        const std::uint64_t consumed = own_bit(sweep_.state) | own_bit(sweep_.messages);
        for (const HeadPlan& h : rule_.heads)
            if (const MakeFact& fact = *as<MakeFact>(h); fact.place == site() && plan_.of(fact.predicate).column.valid())
                made |= own_bit(fact.predicate);
        return meld::plan::in_between(plan_, number_, made, consumed);
    }

    // ---- what a value depends on

    static constexpr unsigned kChanging = 1, kMessage = 2;
    // Whether the rule puts the argument back as it is.
    bool carried(std::size_t i) const {
        const Term &before = state_->arguments[i], &after = next_->arguments[i];
        return state_->uses[i] != ArgumentUse::Skip && before.is_variable() && after.is_variable() && before.variable == after.variable;
    }
    unsigned on(const Term& term) const {
        unsigned mask = 0;
        check::each_variable(term, [&](VariableId v) {
            if (const auto found = depends_.find(v); found != depends_.end()) mask |= found->second;
        });
        return mask;
    }
    unsigned of_field(const Match& m, std::size_t i) const { return &m == message_ ? kMessage : carried(i) ? 0 : kChanging; }

    std::string conditions() {
        const auto both = [](unsigned mask) { return mask == (kChanging | kMessage); };
        const std::string obstacle =
            fmt::format("which {} fit depends on a value of {} that it changes", name(sweep_.messages), name(sweep_.state));
        for (const Step& step : rule_.steps) {
            if (const Test* test = as<Test>(step); test != nullptr && both(on(test->condition))) return obstacle;
            if (const Set* set = as<Set>(step)) depends_[set->variable] |= on(set->value);
            const Match* m = as<Match>(step);
            if (m == nullptr) continue;
            for (std::size_t i = 0; i < m->arguments.size(); ++i) {
                if (m->uses[i] == ArgumentUse::Bind) depends_[m->arguments[i].variable] |= of_field(*m, i);
                if (m->uses[i] == ArgumentUse::Compare && both(of_field(*m, i) | on(m->arguments[i]))) return obstacle;
            }
        }
        return "";
    }

    const Plan& plan_;
    const RulePlan& rule_;
    std::size_t number_;
    Sweep sweep_;
    const Match* state_ = nullptr;
    const Match* message_ = nullptr;
    const MakeFact* next_ = nullptr;
    std::map<VariableId, unsigned> depends_;
};

}  // namespace

void plan_sweeps(Plan& plan) {
    for (std::size_t i = 0; i < plan.linear_rules.size(); ++i) plan.linear_rules[i].sweep = SweepFinder(plan, i).find();
}

}  // namespace meld::plan
