// Pass: indexes. A match that knows some arguments of its facts need not look at all rows of the catom:
//     route(A, =T, D)        rows are sorted by their arguments, so those of T follow each other: found by halving
//     link(A, S, =T)         the rows of each T are in a hash table, which the module makes when it has looked through all rows a few times
// Both find the same rows in the same order as looking at each, and both are left alone while a catom holds few rows. An argument helps if
// its value is known before any row is read, for certain: a computation that may fail is done for each row, as it is without an index.
// A whole group is looked up in any case (emit/lookups.cpp).
//     changed field(A, O, F, P)  those alike once
//       load(A, V, W, =F)  index
//         points(A, =W, =O)
//           -> points(A, V, P)
// A semi-naive rule that joins changed rows with several other facts does so once for all rows that differ only in what the head reads:
// here in P. Runs when all rules have their steps.
#include <algorithm>

#include "compiler/plan/join/draws.h"
#include "compiler/plan/join/may_fail.h"
#include "compiler/plan/plan.h"

namespace meld::plan {

using namespace check;

namespace {

class IndexChooser {
  public:
    explicit IndexChooser(Plan& plan) : plan_(plan) {}

    void choose() {
        for (StratumPlan& s : plan_.strata) {
            stratum_ = &s;
            for (auto* rules : {&s.rules, &s.semi_naive, &s.deltas.affected, &s.deltas.regroup})
                for (RulePlan& r : *rules) rule(r);
            for (RulePlan& r : s.semi_naive) join_alike(r);
        }
        stratum_ = nullptr;
        for (RulePlan& r : plan_.linear_rules) rule(r);
        for (RulePlan& r : plan_.initial_facts) rule(r);
    }

  private:
    void rule(RulePlan& r) {
        steps(r.steps);
        heads(r.heads);
        for (RulePlan& b : r.branches) rule(b);
    }
    void steps(std::vector<Step>& all) {
        for (Step& s : all) {
            if (auto* inner = inner_steps(s)) steps(*inner);
            if (Match* m = as<Match>(s)) m->lookup = lookup(*m);
        }
    }
    // A comprehension takes facts away while it looks for more: it looks at all.
    void heads(std::vector<HeadPlan>& all) {
        for (HeadPlan& h : all)
            visit_head(
                h, [](MakeFact&) {}, [&](ForAll& each) { comprehension(each); },
                [&](AggregateAll& each) {
                    comprehension(each.each);
                    heads(each.results);
                },
                [&](Choose& choice) {
                    heads(choice.heads);
                    heads(choice.others);
                },
                [&](With& with) { heads(with.heads); });
    }
    void comprehension(ForAll& all) {
        in_comprehension_ = true;
        steps(all.steps);
        in_comprehension_ = false;
        heads(all.heads);
    }

    Lookup lookup(const Match& m) const {
        const Predicate& p = plan_.program.predicates[m.predicate];
        if (p.world != WorldSource::None || m.changed || plan_.of(m.predicate).storage != Storage::Rows) return {};
        std::vector<std::size_t> known;
        std::string obstacle;
        for (std::size_t i = 1; i <= m.arguments.size(); ++i) {
            if (m.uses[i - 1] != ArgumentUse::Compare) continue;
            if (std::string why = of_argument(m, i); why.empty())
                known.push_back(i);
            else
                obstacle = std::move(why);
        }
        if (in_comprehension_ && p.linear() && !m.read_only) return {.obstacle = known.empty() ? "" : "the comprehension consumes it"};
        if (known.empty()) return {.obstacle = obstacle};
        // A whole row is in the table that drops those that are there already.
        if (stratum_ != nullptr && stratum_->grows(m.predicate) && m.at_site)
            return known.size() == m.arguments.size() ? Lookup{} : Lookup{.kind = Lookup::Kind::Rounds, .by = known};
        // What lies behind the group does not order the rows. A group that is known as a whole has one row at most.
        const std::size_t sorted = p.linear() ? p.arguments.size() - 1 : group_arguments(p);
        std::size_t first = 0;
        while (first < known.size() && known[first] == first + 1 && first < sorted) ++first;
        if (!p.linear() && first == sorted) return {};
        if (first == known.size()) return {.kind = Lookup::Kind::Prefix, .by = known};
        if (in_comprehension_ && p.linear()) return {.obstacle = "a comprehension makes no index of linear facts"};
        return {.kind = Lookup::Kind::Index, .by = known};
    }
    std::string of_argument(const Match& m, std::size_t i) const {
        const Term& t = m.arguments[i - 1];
        bool here = false;
        for (std::size_t k = 0; k < m.arguments.size(); ++k)
            if (m.uses[k] == ArgumentUse::Bind) each_variable(t, [&](VariableId v) { here = here || v == m.arguments[k].variable; });
        if (here) return "it is compared with an argument of the same fact";
        if (!(t.type == plan_.program.predicates[m.predicate].arguments[i].type)) return "an int is compared with a float";
        if (may_fail(plan_.program, t)) return "what it is compared with may fail";
        return draws(plan_.program, t) ? "what it is compared with is drawn" : "";
    }

    // With one other fact, finding rows that are alike takes as long as looking for it.
    static constexpr std::ptrdiff_t kLeastJoins = 2;

    void join_alike(RulePlan& r) const {
        Match* const changed = r.steps.empty() ? nullptr : as<Match>(r.steps[0]);
        if (changed == nullptr || !changed->changed) return;
        const auto joins = std::count_if(r.steps.begin() + 1, r.steps.end(), [](const Step& s) { return as<Match>(s) != nullptr; });
        if (joins < kLeastJoins) return;
        std::vector<std::size_t> by;
        std::size_t late = 0;
        for (std::size_t i = 1; i <= changed->arguments.size(); ++i) {
            if (changed->uses[i - 1] == ArgumentUse::Skip) continue;
            if (changed->uses[i - 1] == ArgumentUse::Bind && mentions(r.steps, changed->arguments[i - 1].variable) == 1)
                ++late;
            else
                by.push_back(i);
        }
        if (late > 0 && !by.empty()) changed->lookup = {.kind = Lookup::Kind::Alike, .by = by};
    }
    static std::size_t mentions(const std::vector<Step>& steps, VariableId v) {
        std::size_t count = 0;
        const auto note = [&](VariableId other) { count += other == v ? 1 : 0; };
        each_step(steps, [&](const Step& s) { each_part(s, [&](const Term& t) { each_variable(t, note); }, note); });
        return count;
    }

    Plan& plan_;
    const StratumPlan* stratum_ = nullptr;  // Of the rule.
    bool in_comprehension_ = false;
};

}  // namespace

void choose_indexes(Plan& plan) { IndexChooser(plan).choose(); }

}  // namespace meld::plan
