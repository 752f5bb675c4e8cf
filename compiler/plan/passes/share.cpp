// Pass: common prefixes of bodies. Rules that derive the same predicate and begin with the same steps, up to the names of variables,
// execute these steps together and separate where they differ:
//     near(A, K) :- neighbor(A, B), item(B, K), warm(A).         for each neighbour B: item(B, K):  if warm(A) -> near(A, K)
//     near(A, L) :- neighbor(A, C), item(C, L), L > 9.                                              if K > 9 -> near(A, K)
// Sums are left alone: floats would be added in another order. Runs last, when each rule has its order of reading.
#include <algorithm>
#include <map>

#include "compiler/plan/plan.h"

namespace meld::plan {

using namespace check;

namespace {

// The variables of one rule in terms of those of another.
using Names = std::map<VariableId, VariableId>;

bool same(const Term& a, const Term& b, const Names& names) {
    if (a.op != b.op || a.type != b.type || a.integer != b.integer || a.text != b.text || a.constant != b.constant ||
        a.function != b.function)
        return false;
    if (a.real != b.real || a.operands.size() != b.operands.size()) return false;
    if (a.op == Op::Let) return false;
    if (a.is_variable()) {
        const auto found = names.find(b.variable);
        if (found == names.end() || found->second != a.variable) return false;
    }
    for (std::size_t i = 0; i < a.operands.size(); ++i)
        if (!same(a.operands[i], b.operands[i], names)) return false;
    return true;
}

// A place where a step may give a variable its value: it takes the other's name if it is new in both.
bool bind(VariableId a, VariableId b, Names& names) {
    if (a.valid() != b.valid()) return false;
    if (!a.valid()) return true;
    const auto [at, is_new] = names.emplace(b, a);
    if (!is_new) return at->second == a;
    return std::count_if(names.begin(), names.end(), [&](const auto& n) { return n.second == a; }) == 1;
}

bool same(const PortUse& a, const PortUse& b, Names& names) {
    return a.from_other_side == b.from_other_side && same(a.equals, b.equals, names) && bind(a.bind, b.bind, names);
}

bool same_arguments(const Match& a, const Match& b, Names& names) {
    if (a.uses != b.uses || a.arguments.size() != b.arguments.size()) return false;
    for (std::size_t i = 0; i < a.arguments.size(); ++i) {
        if (a.uses[i] == ArgumentUse::Bind ? !bind(a.arguments[i].variable, b.arguments[i].variable, names)
                                           : !same(a.arguments[i], b.arguments[i], names))
            return false;
    }
    return true;
}

bool same(const EachNeighbour& a, const EachNeighbour& b, Names& names) {
    return same(a.only, b.only, names) && bind(a.place, b.place, names) && same(a.port, b.port, names);
}
bool same(const FindNeighbour& a, const FindNeighbour& b, Names& names) {
    return bind(a.place, b.place, names) && same(a.port, b.port, names);
}
bool same(const Match& a, const Match& b, Names& names) {
    return a.predicate == b.predicate && a.at_site == b.at_site && a.read_only == b.read_only && a.ranks == b.ranks &&
           a.changed == b.changed && bind(a.place, b.place, names) && same_arguments(a, b, names);
}
bool same(const Test& a, const Test& b, Names& names) { return same(a.condition, b.condition, names); }
bool same(const Set& a, const Set& b, Names& names) { return same(a.value, b.value, names) && bind(a.variable, b.variable, names); }
// These are never shared: their inner steps are not compared.
bool same(const Unless&, const Unless&, Names&) { return false; }
bool same(const EachElement&, const EachElement&, Names&) { return false; }
bool same(const AggregateOver&, const AggregateOver&, Names&) { return false; }
bool same(const ChangeSince&, const ChangeSince&, Names&) { return false; }

// Whether the steps do the same; `names` then knows what b's step binds.
bool same(const Step& a, const Step& b, Names& names) {
    return std::visit(
        [&](const auto& step) {
            const auto* other = as<std::decay_t<decltype(step)>>(b);
            return other != nullptr && same(step, *other, names);
        },
        a.what);
}

// Rules that share their first steps: all of them are one C++ function, and Clang takes more than proportionally longer for long functions.
constexpr std::size_t kMaxBranches = 16;

class Sharer {
  public:
    Sharer(const Plan& plan, StratumPlan& stratum) : program_(plan.program), rules_(stratum.rules) {}

    void run() {
        for (std::size_t i = 0; i < rules_.size(); ++i) {
            if (!may_share(rules_[i])) continue;
            std::size_t length = 0;
            std::vector<std::size_t> others;
            for (std::size_t k = i + 1; k < rules_.size(); ++k) {
                if (rules_[k].derived().predicate != rules_[i].derived().predicate) continue;
                const std::size_t common = common_steps(rules_[i], rules_[k]);
                if (common == 0 || (length > 0 && common < length)) continue;
                if (length == 0) length = common;
                others.push_back(k);
                if (others.size() + 1 == kMaxBranches) break;
            }
            if (others.empty()) continue;
            rules_[i] = join(i, others, length);
            for (auto k = others.rbegin(); k != others.rend(); ++k) rules_.erase(rules_.begin() + static_cast<std::ptrdiff_t>(*k));
        }
    }

  private:
    bool may_share(const RulePlan& r) const {
        const Aggregate a = program_.predicates[r.derived().predicate].aggregate;
        const bool loops = std::any_of(r.steps.begin(), r.steps.end(), goes_through_facts);
        return loops && (a == Aggregate::None || keeps_best(a));
    }
    static bool goes_through_facts(const Step& s) { return as<Match>(s) != nullptr || as<EachNeighbour>(s) != nullptr; }

    // How many steps both begin with; none where no step among them goes through facts.
    std::size_t common_steps(const RulePlan& a, const RulePlan& b) const {
        Names names = start(a, b);
        std::size_t n = 0;
        bool loops = false;
        for (; n < a.steps.size() && n < b.steps.size(); ++n) {
            Names next = names;
            if (!same(a.steps[n], b.steps[n], next)) break;
            names = std::move(next);
            loops = loops || goes_through_facts(a.steps[n]);
        }
        return loops ? n : 0;
    }

    Names start(const RulePlan& a, const RulePlan& b) const { return {{program_.rules[b.rule].site, program_.rules[a.rule].site}}; }

    RulePlan join(std::size_t first, const std::vector<std::size_t>& others, std::size_t length) {
        const RulePlan& a = rules_[first];
        MELD_EXPECT(length > 0 && length <= a.steps.size() && !others.empty(), "{} steps of {} are shared", length, a.steps.size());
        const auto rest = [&](const RulePlan& r) {
            RulePlan branch;
            branch.rule = r.rule;
            branch.steps.assign(r.steps.begin() + static_cast<std::ptrdiff_t>(length), r.steps.end());
            branch.heads = r.heads;
            return branch;
        };
        RulePlan out;
        out.rule = a.rule;
        out.inputs = a.inputs;
        out.steps.assign(a.steps.begin(), a.steps.begin() + static_cast<std::ptrdiff_t>(length));
        out.branches.push_back(rest(a));
        for (const std::size_t k : others) {
            const RulePlan& b = rules_[k];
            Names names = start(a, b);
            for (std::size_t i = 0; i < length; ++i) same(a.steps[i], b.steps[i], names);
            RulePlan branch = rest(b);
            const auto rename = [&](VariableId& v) {
                if (!v.valid()) return;
                const auto [at, is_new] = names.emplace(v, VariableId(program_.rules[a.rule].variables.count() + out.more.size()));
                if (is_new) out.more.push_back(program_.rules[b.rule].variables[v]);
                v = at->second;
            };
            for (Step& s : branch.steps) rewrite_variables(s, rename);
            MakeFact& fact = *as<MakeFact>(branch.heads[0]);
            rename(fact.place);
            for (Term& t : fact.arguments) rewrite_variables(t, rename);
            for (VariableId& v : fact.contributors) rename(v);
            out.inputs |= b.inputs;
            out.branches.push_back(std::move(branch));
        }
        MELD_ENSURE(out.branches.size() == others.size() + 1 && out.heads.empty());
        return out;
    }

    const Program& program_;
    std::vector<RulePlan>& rules_;
};

}  // namespace

void share_prefixes(Plan& plan) {
    for (StratumPlan& s : plan.strata) Sharer(plan, s).run();
}

check::Rule rule_of(const Plan& plan, const RulePlan& r) {
    check::Rule rule = plan.program.rules[r.rule];
    for (const check::Variable& v : r.more) rule.variables.add(v);
    return rule;
}

}  // namespace meld::plan
