// Pass: deltas. A predicate with many rows a catom is settled as a whole where a link or a flag has changed; where only
// single rows of its inputs have, it is enough to find the groups these rows can touch, and to derive these groups anew.
//     dist(B, S, D + 1) :- neighbor(A, B), dist(A, S, D).
// is touched, at each B, in the groups S of
//     for each neighbour A    changed dist(A, S, D)
// and derives a group S that is known by
//     for each neighbour A    dist(A, =S, D)                           a lookup in sorted rows
// Assumes ordered rules. What it leaves out is settled as before: single values, several predicates that recur together,
// negated and aggregated inputs, and rules that depend on when they are evaluated.
#include <algorithm>
#include <utility>

#include "compiler/check/library.h"
#include "compiler/plan/order.h"

namespace meld::plan {

using namespace check;

namespace {

bool plain(const Type& type) { return !type.compound(); }

bool all_plain(const Predicate& p) {
    return std::all_of(p.arguments.begin(), p.arguments.end(), [](const Argument& a) { return plain(a.type); });
}

// Sums of floats depend on the order of derivation; a function of the program is given its values in order.
bool any_order(const Predicate& p) {
    switch (p.aggregate) {
        case Aggregate::None:
        case Aggregate::Min:
        case Aggregate::Max:
        case Aggregate::Count:
        case Aggregate::First:
            return true;
        case Aggregate::Custom:
            return true;
        case Aggregate::Sum:
            return p.arguments[p.aggregate_at].type == Type::Int;
        default:
            return false;
    }
}

// Whether what terms mean depends on nothing but their variables: not on the tick, nor on what has been drawn before.
class Steady {
  public:
    explicit Steady(const Program& program) : program_(program), seen_(program.functions.count(), false) {}

    bool operator()(const Term& term) {
        bool steady = true;
        each_subterm(term, [&](const Term& t) {
            if (t.op == Op::Now || t.op == Op::Due || t.op == Op::Fresh) steady = false;
            if (t.op == Op::Library && library_function(t.text, t.operands.size())->random) steady = false;
            if (t.op == Op::Call) steady = steady && function(t.function);
        });
        return steady;
    }
    bool operator()(const std::vector<Clause>& body) {
        return std::all_of(body.begin(), body.end(), [&](const Clause& c) {
            return c.kind != Clause::Kind::Delta && (c.aggregate != Aggregate::Custom || function(c.fold)) && all(c.atom.arguments) &&
                   (*this)(c.initial) && (*this)(c.test) && (*this)(c.inner);
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

// As in runtime/abi/module_abi.h.
constexpr std::uint64_t kWake = 8, kGroups = 32;

class Component {
  public:
    Component(Plan& plan, ComponentPlan& component)
        : plan_(plan), component_(component), head_(plan.program.predicates[component.predicates[0]]) {}

    void run() {
        if (component_.recursion == Recursion::LocalSets) return rounds();
        if (!fits()) return;
        whole_ = waiting_inputs(plan_, component_.predicates[0]);
        for (const RulePlan& r : component_.rules) study(r);
        for (bool again = true; again;) again = drop_joined();
        if (touches_.empty()) return;
        Deltas& deltas = component_.deltas;
        deltas.inputs = followed();
        for (const RulePlan& r : component_.rules) deltas.groups.push_back(group(r));
        const auto is_head = [&](const Touch& t) { return !t.at_home && t.predicate == component_.predicates[0]; };
        if (component_.inputs & kWake && std::any_of(touches_.begin(), touches_.end(), is_head)) deltas.inputs |= kGroups;
        for (Touch& t : touches_) {
            t.plan.unchanged &= deltas.inputs;
            if (!t.at_home || is_given(t.predicate)) plan_.columns[plan_.of(t.predicate).column].follows_rows = true;
            deltas.touches.push_back(std::move(t.plan));
        }
    }

  private:
    struct Touch {
        RulePlan plan;
        std::uint64_t input = 0;
        PredicateId predicate;
        bool at_home = false;
    };

    bool is_given(PredicateId p) const { return plan_.of(p).base == p; }

    bool fits() const {
        if (component_.predicates.size() != 1 || plan_.of(component_.predicates[0]).storage != Storage::Rows ||
            head_.kind != PredicateKind::Persistent)
            return false;
        if (component_.recursion == Recursion::LocalSets || component_.recursion == Recursion::Mutual) return false;
        if (group_arguments(head_) == 0 || !all_plain(head_) || !any_order(head_)) return false;
        if (head_.fold.valid() && !Steady(plan_.program).function(head_.fold)) return false;
        return std::all_of(component_.rules.begin(), component_.rules.end(), [&](const RulePlan& r) {
            const Rule& rule = plan_.program.rules[r.rule];
            Steady steady(plan_.program);
            return rule.heads[0].delay.op == Op::Anonymous && steady(rule.body) && steady.all(rule.heads[0].atom.arguments);
        });
    }

    // Sets that recur at one catom are made in rounds; each but the first starts from the rows that the last one made. What
    // neighbours have of them does not change meanwhile.
    void rounds() {
        const auto in_component = [&](PredicateId p) {
            return std::find(component_.predicates.begin(), component_.predicates.end(), p) != component_.predicates.end();
        };
        for (const PredicateId p : component_.predicates)
            if (plan_.of(p).storage != Storage::Rows) return;
        for (const RulePlan& r : component_.rules) {
            Steady steady(plan_.program);
            const Rule& rule = plan_.program.rules[r.rule];
            if (rule.heads[0].delay.op != Op::Anonymous || !steady(rule.body) || !steady.all(rule.heads[0].atom.arguments)) return;
        }
        for (const RulePlan& r : component_.rules) {
            const Rule& rule = plan_.program.rules[r.rule];
            for (std::size_t i = 0; i < rule.body.size(); ++i)
                if (rule.body[i].kind == Clause::Kind::Atom && rule.body[i].atom.arguments[0].variable == rule.home &&
                    in_component(rule.body[i].atom.predicate))
                    component_.deltas.touches.push_back(order_fresh(plan_, r.rule, compared_later(r.rule, i), i));
        }
    }

    // The rule's body where arguments of an atom that are computed are compared after it has been read: when its changed rows
    // come first, nothing is known yet of what they are computed of.
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
    std::uint64_t bit(PredicateId p, bool at_home) const {
        const Column& c = plan_.columns[plan_.of(p).column];
        return at_home ? c.own_dirty : c.reader_dirty;
    }

    // Every way for a changed row of the rule's body to touch a group of the head; what cannot be followed is noted.
    void study(const RulePlan& r) {
        const Rule& rule = plan_.program.rules[r.rule];
        for (const Step& s : r.steps) {
            const std::uint64_t inputs = inputs_of(plan_, {s});
            const bool rows = s.kind == Step::Kind::Match && has_rows(s.predicate);
            whole_ |= rows ? inputs & ~bit(s.predicate, s.at_home) : inputs;
        }
        std::vector<VariableId> needed;
        for (std::size_t i = 1; i <= group_arguments(head_); ++i)
            each_variable(rule.heads[0].atom.arguments[i], [&](VariableId v) { needed.push_back(v); });
        for (std::size_t i = 0; i < rule.body.size(); ++i) {
            const Atom& a = rule.body[i].atom;
            if (rule.body[i].kind != Clause::Kind::Atom || !has_rows(a.predicate)) continue;
            Touch t;
            t.plan.rule = r.rule;
            t.predicate = a.predicate;
            t.at_home = a.arguments[0].variable == rule.home;
            t.input = bit(a.predicate, t.at_home);
            t.plan.inputs = t.input;
            t.plan.heads = r.heads;
            t.plan.steps = order_changed(plan_, rule, compared_later(r.rule, i), i, needed);
            for (const Step& s : t.plan.steps)
                if (!s.changed) t.plan.unchanged |= inputs_of(plan_, {s});
            touches_.push_back(std::move(t));
        }
    }

    std::uint64_t followed() const {
        std::uint64_t bits = 0;
        for (const Touch& t : touches_) bits |= t.input;
        return bits & ~whole_;
    }

    // A row that is joined with rows that change at the same moment would have to meet them as they were, too.
    bool drop_joined() {
        const std::uint64_t before = whole_;
        for (const Touch& t : touches_)
            if (t.plan.unchanged & t.input) whole_ |= t.input;
        std::erase_if(touches_, [&](const Touch& t) { return (t.input & whole_) != 0; });
        return whole_ != before;
    }

    // The rule for one group: every argument of the group equals a variable that is known.
    RulePlan group(const RulePlan& r) {
        Rule& rule = plan_.program.rules[r.rule];
        std::vector<Clause> body = rule.body;
        std::vector<VariableId> given;
        for (std::size_t i = 1; i <= group_arguments(head_); ++i) {
            const Type& type = head_.arguments[i].type;
            given.push_back(rule.variables.add({fmt::format("Group{}", i), rule.span, type}));
            body.push_back(equality(rule.heads[0].atom.arguments[i], {.op = Op::Variable, .type = type, .variable = given.back()}));
        }
        return order_group(plan_, r.rule, component_, body, given);
    }

    Plan& plan_;
    ComponentPlan& component_;
    const Predicate& head_;
    std::vector<Touch> touches_;
    std::uint64_t whole_ = 0;  // Inputs whose change means that all is settled.
};

}  // namespace

void plan_deltas(Plan& plan) {
    for (ComponentPlan& c : plan.components) Component(plan, c).run();
    // Groups that wait in quarantine are woken one by one, where there is a place to say which: in the rows that readers follow,
    // whoever these are. Where the predicate itself does not follow them, all of it is settled then.
    for (ComponentPlan& c : plan.components)
        for (const PredicateId p : c.predicates)
            if (c.inputs & kWake && plan.of(p).column.valid() && plan.columns[plan.of(p).column].follows_rows) c.inputs |= kGroups;
}

}  // namespace meld::plan
