// Pass: singles. Often a catom holds at most one fact of each linear predicate, its state, besides messages that a rule takes in one pass
// (sweep.cpp):
//     temperature(A, R, T), neighborCount(A, N) -o { B | neighbor(A, B) | told(B, R, T) }, listening(A, R, T, N, 0.0).
// It needs no lists of facts while it is evaluated: the module has the rules a second time, with each fact in a variable. Before a rule
// would make a second fact of a predicate, the lists take over. Rules are read and fire in the same order either way.
//
// For programs without views and functions. Their rules read linear facts and the world, always make the same predicates at the catom, and
// may be tried twice. Runs when all rules have their steps, after the sweeps.
#include <algorithm>

#include "compiler/plan/join/draws.h"
#include "compiler/plan/plan.h"

namespace meld::plan {

using namespace check;

namespace {

// More would mean a long module, and few catoms that take the way through all of them.
constexpr std::size_t kMostRules = 8;
constexpr const char* kDraws = "what a rule draws depends on how often it is tried";

bool contains(const std::vector<PredicateId>& all, PredicateId p) { return std::ranges::find(all, p) != all.end(); }

class SinglesFinder {
  public:
    explicit SinglesFinder(const Plan& plan) : plan_(plan) {}

    Singles find() {
        if (plan_.linear_rules.empty()) return {};
        found_.obstacle = of_program();
        for (const RulePlan& r : plan_.linear_rules)
            if (found_.obstacle.empty()) found_.obstacle = of_rule(r);
        if (!found_.obstacle.empty()) return {.facts = {}, .messages = {}, .obstacle = found_.obstacle};
        std::erase_if(found_.messages, [&](PredicateId p) { return contains(found_.facts, p); });
        return found_;
    }

  private:
    const std::string& name(PredicateId p) const { return plan_.program.predicates[p].name; }

    std::string of_program() const {
        if (plan_.counts) return "what its rules do is counted";
        if (!plan_.strata.empty()) return "the program has views";
        if (!plan_.program.functions.empty()) return "the program has functions";
        return plan_.linear_rules.size() > kMostRules ? fmt::format("there are more than {} linear rules", kMostRules) : "";
    }

    std::string of_rule(const RulePlan& r) {
        const Rule& rule = plan_.program.rules[r.rule];
        if (rule.select != Select::None) return fmt::format("{} chooses among facts", rule.name);
        const bool sweeps = r.sweep.applies() && only_state(r);
        if (sweeps) add(found_.messages, r.sweep.messages);
        made_.clear();
        const std::string obstacle = of_steps(r.steps, sweeps ? r.sweep.messages : PredicateId());
        return obstacle.empty() ? of_heads(r.heads, rule, false) : obstacle;
    }
    // Whether all that a sweep makes is its state, so that what it has done can be forgotten.
    bool only_state(const RulePlan& r) const {
        return std::ranges::all_of(r.heads, [&](const HeadPlan& h) {
            const MakeFact* fact = as<MakeFact>(h);
            return fact != nullptr && fact->predicate == r.sweep.state && fact->place == plan_.program.rules[r.rule].site;
        });
    }

    std::string of_steps(const std::vector<Step>& steps, PredicateId messages) {
        std::vector<PredicateId> read;
        for (const Step& step : steps) {
            if (draws(step)) return kDraws;
            if (as<AggregateOver>(step) != nullptr || as<ChangeSince>(step) != nullptr) return "a rule aggregates facts";
            if (const Unless* unless = as<Unless>(step))
                if (std::string inner = of_steps(unless->steps, {}); !inner.empty()) return inner;
            const Match* m = as<Match>(step);
            if (m == nullptr || plan_.program.predicates[m->predicate].world != WorldSource::None) continue;
            if (!m->at_site || !plan_.program.predicates[m->predicate].linear()) return fmt::format("{} is not linear", name(m->predicate));
            if (contains(read, m->predicate)) return fmt::format("a rule reads two {}", name(m->predicate));
            read.push_back(m->predicate);
            if (m->predicate != messages) add(found_.facts, m->predicate);
        }
        return "";
    }

    // `inside`: another head decides whether, or how often.
    std::string of_heads(const std::vector<HeadPlan>& heads, const Rule& rule, bool inside) {
        std::string obstacle;
        for (const HeadPlan& h : heads)
            if (obstacle.empty())
                visit_head(
                    h, [&](const MakeFact& fact) { obstacle = of_fact(fact, rule, inside); },
                    [&](const ForAll& all) {
                        obstacle = of_comprehension(all.steps);
                        if (obstacle.empty()) obstacle = of_heads(all.heads, rule, true);
                    },
                    [&](const AggregateAll&) { obstacle = fmt::format("a head of {} aggregates", rule.name); },
                    [&](const Choose& choose) {
                        obstacle = draws(choose.condition) ? kDraws : of_heads(choose.heads, rule, true);
                        if (obstacle.empty()) obstacle = of_heads(choose.others, rule, true);
                    },
                    [&](const With& with) { obstacle = draws(with.value) ? kDraws : of_heads(with.heads, rule, true); });
        return obstacle;
    }
    std::string of_comprehension(const std::vector<Step>& steps) const {
        for (const Step& step : steps) {
            const Match* m = as<Match>(step);
            if (m != nullptr && plan_.program.predicates[m->predicate].world == WorldSource::None)
                return fmt::format("a comprehension reads {}", name(m->predicate));
            if (draws(step)) return kDraws;
            if (inner_steps(step) != nullptr) return "a comprehension asks what is absent, or aggregates";
        }
        return "";
    }
    std::string of_fact(const MakeFact& fact, const Rule& rule, bool inside) {
        const Predicate& p = plan_.program.predicates[fact.predicate];
        if (std::ranges::any_of(fact.arguments, [&](const Term& t) { return draws(t); })) return kDraws;
        if (p.begins || p.finds_its_way) return fmt::format("{} goes to nodes without a link", p.name);
        if (fact.place != rule.site || p.kind == PredicateKind::Action) return "";
        if (!p.linear()) return fmt::format("{} is not linear", p.name);
        if (inside) return fmt::format("{} does not always make one {}", rule.name, p.name);
        if (contains(made_, fact.predicate)) return fmt::format("{} makes several {}", rule.name, p.name);
        made_.push_back(fact.predicate);
        add(found_.facts, fact.predicate);
        return "";
    }
    bool draws(const Term& term) const { return plan::draws(plan_.program, term); }
    bool draws(const Step& step) const {
        bool found = false;
        each_part(step, [&](const Term& t) { found = found || draws(t); }, [](VariableId) {});
        return found;
    }
    static void add(std::vector<PredicateId>& to, PredicateId p) {
        if (!contains(to, p)) to.push_back(p);
    }

    const Plan& plan_;
    Singles found_;
    std::vector<PredicateId> made_;  // By the rule that is looked at, at its catom.
};

}  // namespace

void find_singles(Plan& plan) { plan.singles = SinglesFinder(plan).find(); }

}  // namespace meld::plan
