// Pass: letters. A linear fact that a comprehension sends to many catoms is written once, with a list of its receivers,
//     { B | neighbor(A, B) | told(B, R, T) }
// if its arguments are the same for all: they depend on nothing that the comprehension finds. Facts with lists are copied by the runtime
// one by one. Runs when all rules have their steps.
#include <algorithm>

#include "compiler/plan/join/invariant.h"
#include "compiler/plan/plan.h"

namespace meld::plan {

using namespace check;

namespace {

class LetterFinder {
  public:
    LetterFinder(const Program& program, const Rule& rule) : program_(program), rule_(rule) {}

    void outside(std::vector<HeadPlan>& heads) const {
        for (HeadPlan& h : heads)
            visit_head(
                h, [](MakeFact&) {}, [&](ForAll& all) { inside(all.heads, found_by(all.steps)); },
                [&](AggregateAll& all) {
                    inside(all.each.heads, found_by(all.each.steps));
                    outside(all.results);
                },
                [&](Choose& choose) {
                    outside(choose.heads);
                    outside(choose.others);
                },
                [&](With& with) { outside(with.heads); });
    }

  private:
    // `found`: by the comprehension that the heads are in.
    void inside(std::vector<HeadPlan>& heads, const Variables& found) const {
        for (HeadPlan& h : heads)
            visit_head(
                h, [&](MakeFact& fact) { decide(fact, found); }, [&](ForAll& all) { inside(all.heads, found_by(all.steps)); },
                [&](AggregateAll& all) {
                    inside(all.each.heads, found_by(all.each.steps));
                    Variables more = found;
                    for (const HeadAggregate& a : all.aggregates) more.insert(a.result);
                    inside(all.results, more);
                },
                [&](Choose& choose) {
                    inside(choose.heads, found);
                    inside(choose.others, found);
                },
                [&](With& with) {
                    Variables more = found;
                    more.insert(with.variable);
                    inside(with.heads, more);
                });
    }

    static Variables found_by(const std::vector<Step>& steps) {
        Variables found;
        for (const Step& s : steps) {
            each_part(s, [](const Term&) {}, [&](VariableId v) { found.insert(v); });
            if (const Match* m = as<Match>(s))
                for (std::size_t i = 0; i < m->arguments.size(); ++i)
                    if (m->uses[i] == ArgumentUse::Bind) found.insert(m->arguments[i].variable);
        }
        return found;
    }

    void decide(MakeFact& fact, const Variables& found) const {
        const Predicate& p = program_.predicates[fact.predicate];
        if (!p.linear() || p.kind == PredicateKind::Action || p.finds_its_way || p.begins || fact.place == rule_.site) return;
        fact.difference = difference(fact, found);
        fact.alike = fact.difference.empty();
    }

    std::string difference(const MakeFact& fact, const Variables& found) const {
        const Predicate& p = program_.predicates[fact.predicate];
        if (std::ranges::any_of(p.arguments, [](const Argument& a) { return a.type.compound(); })) return "lists are copied";
        for (const Term& t : fact.arguments) {
            if (is_invariant(program_, t, [&](VariableId v) { return !found.contains(v); })) continue;
            std::string variable;
            each_subterm(t, [&](const Term& part) {
                if (part.is_variable() && found.contains(part.variable)) variable = rule_.variables[part.variable].name;
            });
            return variable.empty() ? "a value may differ from call to call" : variable + " differs";
        }
        return "";
    }

    const Program& program_;
    const Rule& rule_;
};

}  // namespace

void find_letters(Plan& plan) {
    for (RulePlan& r : plan.linear_rules) LetterFinder(plan.program, plan.program.rules[r.rule]).outside(r.heads);
}

}  // namespace meld::plan
