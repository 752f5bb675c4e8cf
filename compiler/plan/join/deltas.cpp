// Pass: delta rules. A predicate with many rows per catom is evaluated as a whole if a link or a flag has changed. If only single rows of
// its inputs have changed, it is enough to find the groups that these rows can affect, and to derive those again. For
//     dist(B, S, D + 1) :- neighbor(A, B), dist(A, S, D).
// the affected groups S at each B are those of the delta rule
//     for each neighbour A    changed dist(A, S, D)
// and a group S that is known is derived by
//     for each neighbour A    dist(A, =S, D)                           a lookup in sorted rows
// Sets that recur at one catom get semi-naive rules instead, which derive from the rows of the last round. A failure in such a rule means
// that all groups are to be evaluated, to find the derivation without a value: so the rules must fail for the same facts in any order.
// Assumes ordered rules. The pass leaves out single values, several predicates that recur together, negated and aggregated inputs, and
// rules that depend on when they are evaluated; these are evaluated as a whole. So are long rules: one delta rule per atom would make a
// plan that grows with the square of the body.
#include <algorithm>
#include <utility>

#include "compiler/check/program/library.h"
#include "compiler/plan/join/may_fail.h"
#include "compiler/plan/join/order.h"

namespace meld::plan {

using namespace check;

namespace {

// The clauses of a body from which delta rules are made.
constexpr std::size_t kMaxClauses = 64;

bool plain(const Type& type) { return !type.compound(); }

bool all_plain(const Predicate& p) {
    return std::all_of(p.arguments.begin(), p.arguments.end(), [](const Argument& a) { return plain(a.type); });
}

// Sums of floats depend on the order of derivation; a function of the program gets its values in order.
bool any_order(const Predicate& p) {
    const AggregateInfo& about = info(p.aggregate);
    return about.has(AggregateInfo::kAnyOrder) ||
           (about.has(AggregateInfo::kIntsInAnyOrder) && p.arguments[p.aggregate_at].type == Type::Int);
}

// Whether the meaning of terms depends only on their variables: not on the tick, nor on earlier draws.
class Steady {
  public:
    explicit Steady(const Program& program) : program_(program), seen_(program.functions.count(), false) {}

    bool operator()(const Term& term) {
        bool steady = true;
        each_subterm(term, [&](const Term& t) {
            if (t.op == Op::Now || t.op == Op::Due || t.op == Op::Fresh || t.op == Op::NewNode) steady = false;
            if (t.op == Op::Library && library_function(t.text, t.operands.size())->random) steady = false;
            if (t.op == Op::Call) steady = steady && function(t.function);
        });
        return steady;
    }
    bool operator()(const std::vector<Clause>& body) {
        return std::all_of(body.begin(), body.end(), [&](const Clause& c) {
            return c.kind != Clause::Kind::Delta && (c.aggregate != Aggregate::Custom || function(c.fold)) && all(c.atom.arguments) &&
                   (*this)(c.parameter) && (*this)(c.test) && (*this)(c.inner);
        });
    }
    bool all(const std::vector<Term>& terms) {
        return std::all_of(terms.begin(), terms.end(), [&](const Term& t) { return (*this)(t); });
    }

    // A function that calls itself is as steady as the rest of it.
    bool function(FunctionId id) {
        if (seen_[id.index()]) return true;
        seen_[id.index()] = true;
        return (*this)(program_.functions[id].body);
    }

  private:
    const Program& program_;
    std::vector<bool> seen_;
};

// Finds the delta rules of one stratum.
class DeltaPlanner {
  public:
    DeltaPlanner(Plan& plan, StratumPlan& stratum)
        : plan_(plan), stratum_(stratum), head_(plan.program.predicates[stratum.predicates[0]]) {}

    void run() {
        if (stratum_.recursion == Recursion::LocalSets) return plan_semi_naive();
        if (!fits()) return;
        whole_ = waiting_inputs(plan_, stratum_.predicates[0]);
        for (const RulePlan& r : stratum_.rules) study(r);
        for (bool again = true; again;) again = drop_joined();
        if (candidates_.empty()) return;
        DeltaRules& deltas = stratum_.deltas;
        deltas.inputs = followed();
        for (const RulePlan& r : stratum_.rules) deltas.regroup.push_back(group(r));
        const auto is_head = [&](const Candidate& c) { return !c.at_site && c.predicate == stratum_.predicates[0]; };
        if (stratum_.inputs & kDirtyWake && std::any_of(candidates_.begin(), candidates_.end(), is_head)) deltas.inputs |= kDirtyGroups;
        for (Candidate& c : candidates_) {
            c.plan.unchanged &= deltas.inputs;
            if (!c.at_site || is_given(c.predicate)) plan_.columns[plan_.of(c.predicate).column].follows_rows = true;
            deltas.whole.push_back(*std::ranges::find(stratum_.rules, c.plan.rule, &RulePlan::rule));
            deltas.affected.push_back(std::move(c.plan));
        }
        MELD_ENSURE(deltas.regroup.size() == stratum_.rules.size() && (deltas.inputs & kDirtyLinks) == 0);
    }

  private:
    // A delta rule, until it is known whether the changes of all its inputs are recorded by row.
    struct Candidate {
        RulePlan plan;
        std::uint64_t input = 0;
        PredicateId predicate;
        bool at_site = false;
    };

    bool is_given(PredicateId p) const { return plan_.of(p).base == p; }

    bool fits() const {
        if (stratum_.predicates.size() != 1 || plan_.of(stratum_.predicates[0]).storage != Storage::Rows ||
            head_.kind != PredicateKind::Persistent)
            return false;
        if (stratum_.recursion != Recursion::None && stratum_.recursion != Recursion::Ranked && stratum_.recursion != Recursion::Tree)
            return false;
        if (group_arguments(head_) == 0 || !all_plain(head_) || !any_order(head_)) return false;
        if (head_.fold.valid() && !Steady(plan_.program).function(head_.fold)) return false;
        return std::all_of(stratum_.rules.begin(), stratum_.rules.end(), [&](const RulePlan& r) {
            const Rule& rule = plan_.program.rules[r.rule];
            Steady steady(plan_.program);
            return rule.body.size() <= kMaxClauses && rule.heads[0].delay.op == Op::Anonymous && fails_in_any_order(plan_.program, r) &&
                   steady(rule.body) && steady.all(rule.heads[0].atom.arguments);
        });
    }

    // Sets that recur at one catom are derived in semi-naive rounds: each but the first starts from the rows that the last one derived. The
    // neighbours' rows do not change in the meantime.
    void plan_semi_naive() {
        const auto in_stratum = [&](PredicateId p) {
            return std::find(stratum_.predicates.begin(), stratum_.predicates.end(), p) != stratum_.predicates.end();
        };
        for (const PredicateId p : stratum_.predicates)
            if (plan_.of(p).storage != Storage::Rows) return;
        for (const RulePlan& r : stratum_.rules) {
            Steady steady(plan_.program);
            const Rule& rule = plan_.program.rules[r.rule];
            if (rule.body.size() > kMaxClauses || rule.heads[0].delay.op != Op::Anonymous || !steady(rule.body) ||
                !steady.all(rule.heads[0].atom.arguments))
                return;
        }
        for (const RulePlan& r : stratum_.rules) {
            const Rule& rule = plan_.program.rules[r.rule];
            for (std::size_t i = 0; i < rule.body.size(); ++i)
                if (rule.body[i].kind == Clause::Kind::Atom && rule.body[i].atom.arguments[0].variable == rule.site &&
                    in_stratum(rule.body[i].atom.predicate))
                    stratum_.semi_naive.push_back(order_semi_naive(plan_, r.rule, compared_later(r.rule, i), i, stratum_.predicates));
        }
    }

    // The rule's body, rewritten so that computed arguments of an atom are compared after it has been read: when its changed rows come
    // first, the variables they are computed from are not known yet.
    std::vector<Clause> compared_later(RuleId id, std::size_t first) {
        Rule& rule = plan_.program.rules[id];
        std::vector<Clause> body = rule.body;
        const Predicate& p = plan_.program.predicates[body[first].atom.predicate];
        for (std::size_t i = 1; i < p.arguments.size(); ++i) {
            Term& argument = body[first].atom.arguments[i];
            bool computed = false;
            if (!argument.is_variable()) each_free_use(argument, [&](const Term&) { computed = true; });
            if (!computed) continue;
            const Type& type = p.arguments[i].type;
            const Term read{.op = Op::Variable, .type = type, .variable = rule.variables.add({fmt::format("Read{}", i), rule.span, type})};
            body.push_back(equality(std::exchange(argument, read), read));
        }
        return body;
    }

    // Of a value, which may be an int where a float is meant, and a variable.
    static Clause equality(Term value, Term variable) {
        if (!(value.type == variable.type)) value = Term{.op = Op::ToFloat, .type = variable.type, .operands = {std::move(value)}};
        Clause equal{.kind = Clause::Kind::Test};
        equal.test = Term{.op = Op::Equal, .type = Type::Bool, .operands = {std::move(value), std::move(variable)}};
        return equal;
    }

    bool has_rows(PredicateId p) const {
        return plan_.of(p).storage == Storage::Rows && !plan_.program.predicates[p].linear() && all_plain(plan_.program.predicates[p]);
    }
    std::uint64_t bit(PredicateId p, bool at_site) const {
        const Column& c = plan_.column_of(p);
        return at_site ? c.own_dirty : c.reader_dirty;
    }

    // Every way in which a changed row of the rule's body can affect a group of the head; notes the inputs that cannot be followed.
    void study(const RulePlan& r) {
        const Rule& rule = plan_.program.rules[r.rule];
        for (const Step& s : r.steps) {
            const std::uint64_t inputs = inputs_of(plan_, {s});
            const Match* m = as<Match>(s);
            const bool rows = m != nullptr && has_rows(m->predicate);
            whole_ |= rows ? inputs & ~bit(m->predicate, m->at_site) : inputs;
        }
        std::vector<VariableId> needed;
        for (std::size_t i = 1; i <= group_arguments(head_); ++i)
            each_variable(rule.heads[0].atom.arguments[i], [&](VariableId v) { needed.push_back(v); });
        for (std::size_t i = 0; i < rule.body.size(); ++i) {
            const Atom& a = rule.body[i].atom;
            if (rule.body[i].kind != Clause::Kind::Atom || !has_rows(a.predicate)) continue;
            Candidate c;
            c.plan.rule = r.rule;
            c.predicate = a.predicate;
            c.at_site = a.arguments[0].variable == rule.site;
            c.input = bit(a.predicate, c.at_site);
            c.plan.inputs = c.input;
            c.plan.heads = r.heads;
            c.plan.steps = order_changed(plan_, rule, compared_later(r.rule, i), i, needed);
            for (const Step& s : c.plan.steps)
                if (const Match* m = as<Match>(s); m == nullptr || !m->changed) c.plan.unchanged |= inputs_of(plan_, {s});
            candidates_.push_back(std::move(c));
        }
    }

    std::uint64_t followed() const {
        std::uint64_t bits = 0;
        for (const Candidate& c : candidates_) bits |= c.input;
        return bits & ~whole_;
    }

    // A row that is joined with rows that change at the same time would have to meet their old versions, too.
    bool drop_joined() {
        const std::uint64_t before = whole_;
        for (const Candidate& c : candidates_)
            if (c.plan.unchanged & c.input) whole_ |= c.input;
        std::erase_if(candidates_, [&](const Candidate& c) { return (c.input & whole_) != 0; });
        return whole_ != before;
    }

    // The rule for one group: every argument of the group equals a known variable.
    RulePlan group(const RulePlan& r) {
        Rule& rule = plan_.program.rules[r.rule];
        std::vector<Clause> body = rule.body;
        std::vector<VariableId> given;
        for (std::size_t i = 1; i <= group_arguments(head_); ++i) {
            const Type& type = head_.arguments[i].type;
            given.push_back(rule.variables.add({fmt::format("Group{}", i), rule.span, type}));
            body.push_back(equality(rule.heads[0].atom.arguments[i], {.op = Op::Variable, .type = type, .variable = given.back()}));
        }
        return order_group(plan_, r.rule, stratum_, body, given);
    }

    Plan& plan_;
    StratumPlan& stratum_;
    const Predicate& head_;
    std::vector<Candidate> candidates_;
    std::uint64_t whole_ = 0;  // Inputs after whose change all groups are evaluated.
};

}  // namespace

void plan_deltas(Plan& plan) {
    for (StratumPlan& s : plan.strata) DeltaPlanner(plan, s).run();
    // Groups that wait in quarantine are woken one by one, if the column records its changes by row, which then name the group. If it does
    // not, the whole predicate is evaluated.
    for (StratumPlan& s : plan.strata)
        for (const PredicateId p : s.predicates)
            if (s.inputs & kDirtyWake && plan.of(p).column.valid() && plan.column_of(p).follows_rows) s.inputs |= kDirtyGroups;
}

}  // namespace meld::plan
