// Pass: join order. Turns every body into steps. What needs no new catom comes first, cheap and bound facts before
// unbound ones, a link only when nothing else is left; linear rules keep their textual order, which is their meaning.
// Assumes localized rules and a layout.
#include <algorithm>
#include <set>

#include "compiler/plan/order.h"

namespace meld::plan {

using namespace check;

namespace {

using Variables = std::set<VariableId>;

class Orderer {
  public:
    Orderer(const Plan& plan, const Rule& rule, bool ranked_component, const std::vector<PredicateId>& component)
        : plan_(plan), program_(plan.program), rule_(rule), ranked_(ranked_component), component_(component) {}

    struct State {
        Variables values;  // Known by value.
        Variables places;  // Known as the home or a direct neighbour.
    };

    State start() const {
        State s;
        if (rule_.home.valid()) s.places.insert(rule_.home);
        return s;
    }

    // Orders a body after what is already known; `later` are variables that clauses outside will bind or use.
    std::vector<Step> order(std::vector<Clause> body, State& state, bool textual, const Variables& outside) const {
        std::vector<Step> steps;
        while (!body.empty()) {
            if (take_ready(body, state, outside, steps)) continue;
            const std::size_t next = pick(body, state, textual);
            MELD_CHECK(next < body.size(), "rule {}: no atom can be read next", rule_.name);
            Clause clause = body[next];
            Choice why = choice(body, next, state, textual);
            const std::size_t before = steps.size();
            body.erase(body.begin() + static_cast<std::ptrdiff_t>(next));
            if (clause.kind == Clause::Kind::Element) {
                each(clause, state, steps);
                steps.back().choice = std::move(why);
                continue;
            }
            atom(clause.atom, state, steps);
            explain(steps, before, std::move(why), textual);
            if (clause.kind == Clause::Kind::Delta) delta(clause, steps);
        }
        return steps;
    }

    // One atom first, of which only changed rows are read; then what follows from it, and then the rest, but only where
    // something needed is still unknown.
    std::vector<Step> order_changed(std::vector<Clause> body, std::size_t first, const Variables& needed) const {
        State state = start();
        std::vector<Step> steps = start_changed(body, first, needed, state);
        if (std::all_of(needed.begin(), needed.end(), [&](VariableId v) { return known(v, state); })) return steps;
        for (Step& s : order(std::move(body), state, false, needed)) steps.push_back(std::move(s));
        return steps;
    }
    std::vector<Step> start_changed(std::vector<Clause>& body, std::size_t first, const Variables& needed, State& state) const {
        std::vector<Step> steps;
        const Atom changed = body[first].atom;
        body.erase(body.begin() + static_cast<std::ptrdiff_t>(first));
        atom(changed, state, steps);
        steps.back().changed = true;
        while (take_ready(body, state, needed, steps)) {
        }
        return steps;
    }

  private:
    bool known(VariableId v, const State& s) const { return s.values.contains(v) || s.places.contains(v); }
    bool known(const Term& t, const State& s) const {
        bool all = true;
        each_free_use(t, [&](const Term& use) { all = all && known(use.variable, s); });
        return all;
    }

    // A test or negation all of whose variables are known, or an equality that gives a new one its value.
    bool take_ready(std::vector<Clause>& body, State& state, const Variables& outside, std::vector<Step>& steps) const {
        for (std::size_t i = 0; i < body.size(); ++i) {
            const Clause& c = body[i];
            if (c.kind == Clause::Kind::Test) {
                if (known(c.test, state)) {
                    Step s{.kind = Step::Kind::Test};
                    s.term = c.test;
                    steps.push_back(std::move(s));
                } else if (!set(c.test, state, steps) && !take_apart(c.test, state, steps)) {
                    continue;
                }
            } else if (c.kind == Clause::Kind::Not || c.kind == Clause::Kind::Aggregate) {
                // A variable of another negation or aggregate alone is another one there.
                Variables others = outside;
                for (const Clause& other : body) {
                    if (other.kind == Clause::Kind::Aggregate)
                        others.insert(other.variable);
                    else if (other.kind != Clause::Kind::Not)
                        each_variable(other, [&](VariableId v) { others.insert(v); });
                }
                bool ready = true;
                const bool folds = c.kind == Clause::Kind::Aggregate;
                each_variable(
                    c, [&](VariableId v) { ready = ready && (known(v, state) || !others.contains(v) || (folds && v == c.variable)); });
                if (!ready) continue;
                Step s{.kind = folds ? Step::Kind::Fold : Step::Kind::Absent};
                State inner = state;
                s.inner = order(c.inner, inner, false, others);
                if (folds) {
                    s.variable = c.variable;
                    s.term = c.test;
                    s.aggregate = c.aggregate;
                    s.fold = c.fold;
                    s.initial = c.initial;
                    if (!known(c.variable, state)) state.values.insert(c.variable);
                }
                steps.push_back(std::move(s));
            } else {
                continue;
            }
            body.erase(body.begin() + static_cast<std::ptrdiff_t>(i));
            return true;
        }
        return false;
    }

    bool set(const Term& test, State& state, std::vector<Step>& steps) const {
        if (test.op != Op::Equal) return false;
        for (std::size_t side = 0; side < 2; ++side) {
            const Term& target = test.operands[side];
            const Term& value = test.operands[1 - side];
            if (!target.is_variable() || known(target.variable, state) || !known(value, state)) continue;
            Step s{.kind = Step::Kind::Set};
            s.variable = target.variable;
            s.term = value;
            state.values.insert(target.variable);
            steps.push_back(std::move(s));
            return true;
        }
        return false;
    }

    static Step test(Term term) {
        Step s{.kind = Step::Kind::Test};
        s.term = std::move(term);
        return s;
    }
    static Term part_of(const Term& value, Op op, const Type& type, std::size_t number = 0) {
        return {.op = op, .type = type, .span = value.span, .integer = static_cast<std::int64_t>(number), .operands = {value}};
    }

    // L = [X | Rest] with L known: whether L is such a list, then X and Rest from it, or compared with it where known.
    bool take_apart(const Term& equality, State& state, std::vector<Step>& steps) const {
        const TakeApart found = taken_apart(equality);
        if (!found || !known(*found.value, state)) return false;
        const Term &value = *found.value, &made = *found.constructor;
        const Type element = value.type.parts.empty() ? Type::Float : value.type.parts[0];
        if (made.op == Op::Cons) {
            Term empty = part_of(value, Op::IsEmpty, Type::Bool);
            steps.push_back(test({.op = Op::Not, .type = Type::Bool, .span = value.span, .operands = {std::move(empty)}}));
        } else if (made.op == Op::List) {
            Term length{.op = Op::Library, .type = Type::Int, .span = value.span, .text = "llength", .operands = {value}};
            Term count{.op = Op::Int, .type = Type::Int, .span = value.span, .integer = static_cast<std::int64_t>(made.operands.size())};
            steps.push_back(
                test({.op = Op::Equal, .type = Type::Bool, .span = value.span, .operands = {std::move(length), std::move(count)}}));
        }
        for (std::size_t i = 0; i < made.operands.size(); ++i) {
            const Term& part = made.operands[i];
            Term is = made.op == Op::Cons ? part_of(value, i == 0 ? Op::ListHead : Op::ListTail, i == 0 ? element : value.type)
                      : made.op == Op::List || value.type == Type::Vec3 ? part_of(value, Op::Item, element, i)
                                                                        : part_of(value, Op::Item, value.type.parts[i], i);
            if (!part.is_variable() || known(part.variable, state)) {
                steps.push_back(test({.op = Op::Equal, .type = Type::Bool, .span = part.span, .operands = {std::move(is), part}}));
                continue;
            }
            Step s{.kind = Step::Kind::Set};
            s.variable = part.variable;
            s.term = std::move(is);
            state.values.insert(part.variable);
            steps.push_back(std::move(s));
        }
        return true;
    }

    bool is_neighbor(const Atom& a) const {
        const WorldSource w = program_.predicates[a.predicate].world;
        return w == WorldSource::Neighbor || w == WorldSource::NeighborPort;
    }

    // Lower is sooner; a large number: cannot be read yet.
    static constexpr int kNotYet = 1000;
    int cost(const Atom& a, const State& s) const {
        const VariableId at = a.arguments[0].variable;
        const bool home = at == rule_.home;
        int unknown = 0, unknown_group = 0;
        for (std::size_t i = 1; i < a.arguments.size(); ++i) {
            if (a.arguments[i].is_variable())
                unknown += known(a.arguments[i].variable, s) ? 0 : 1;
            else if (a.arguments[i].op != Op::Anonymous && !known(a.arguments[i], s))
                return kNotYet;
            const bool open = a.arguments[i].op == Op::Anonymous || (a.arguments[i].is_variable() && !known(a.arguments[i].variable, s));
            unknown_group += open && i <= group_arguments(program_.predicates[a.predicate]) ? 1 : 0;
        }
        if (is_neighbor(a)) {
            const VariableId other = home ? a.arguments[1].is_variable() ? a.arguments[1].variable : VariableId() : at;
            if (other.valid() && s.places.contains(other)) return 5;
            if (other.valid() && s.values.contains(other)) return 30;
            return 60;
        }
        const Storage storage = plan_.of(a.predicate).storage;
        const bool one = storage == Storage::Flag || storage == Storage::Single || (storage == Storage::World);
        // A group that is known has one row at most, and it is looked up.
        const bool key = unknown == 0 || unknown_group == 0;
        if (home) return one ? 10 + unknown : (key ? 20 : 40 + unknown);
        if (s.places.contains(at)) return one ? 15 + unknown : (key ? 25 : 50 + unknown);
        if (s.values.contains(at)) return 35 + unknown;
        // Nothing is known of this catom: it must be a neighbour that points here; all neighbours are asked.
        const bool points_home = program_.predicates[a.predicate].route && a.arguments.size() > 1 && a.arguments[1].is_variable() &&
                                 a.arguments[1].variable == rule_.home;
        return points_home ? 70 : kNotYet;
    }

    int cost(const Clause& c, const State& s) const {
        if (!reads(c) || (c.kind != Clause::Kind::Atom && !known(c.test, s))) return kNotYet;
        return c.kind == Clause::Kind::Element ? 42 : cost(c.atom, s);
    }
    static bool reads(const Clause& c) {
        return c.kind != Clause::Kind::Test && c.kind != Clause::Kind::Not && c.kind != Clause::Kind::Aggregate;
    }

    std::size_t pick(const std::vector<Clause>& body, const State& s, bool textual) const {
        std::size_t best = body.size();
        int least = kNotYet;
        for (std::size_t i = 0; i < body.size(); ++i) {
            const int c = cost(body[i], s);
            if (c >= kNotYet) continue;
            if (textual) return i;
            if (c < least) {
                least = c;
                best = i;
            }
        }
        return best;
    }

    // Why the clause `next` is read now, in words of what was known before it.
    Choice choice(const std::vector<Clause>& body, std::size_t next, const State& s, bool textual) const {
        Choice out;
        if (body[next].kind == Clause::Kind::Element)
            out.reason = Reason::Elements;
        else
            explain(body[next].atom, s, out);
        if (textual) out.reason = Reason::Written;
        for (std::size_t i = 0; i < next; ++i) {
            if (!reads(body[i])) continue;
            (cost(body[i], s) < kNotYet ? out.dearer : out.waiting)
                .push_back(body[i].kind == Clause::Kind::Element ? PredicateId() : body[i].atom.predicate);
        }
        return out;
    }
    void explain(const Atom& a, const State& s, Choice& out) const {
        std::size_t open = 0, new_values = 0, open_group = 0;
        for (std::size_t i = 1; i < a.arguments.size(); ++i) {
            const bool unknown = a.arguments[i].is_variable() && !known(a.arguments[i].variable, s);
            new_values += unknown ? 1 : 0;
            open += unknown || a.arguments[i].op == Op::Anonymous ? 1 : 0;
            if (i <= group_arguments(program_.predicates[a.predicate])) open_group = open;
        }
        out.known = a.arguments.size() - 1 - open;
        const Storage storage = plan_.of(a.predicate).storage;
        const WorldSource world = program_.predicates[a.predicate].world;
        const bool several = world == WorldSource::Vacant || world == WorldSource::TargetPort || world == WorldSource::Facts;
        const bool one = storage == Storage::Flag || storage == Storage::Single || (storage == Storage::World && !several);
        out.reason = open == 0 ? Reason::Test : new_values == 0 ? Reason::Exists : one || open_group == 0 ? Reason::One : Reason::Rows;
    }
    // The steps of one atom: the link that leads to its catom, if that is new, and the fact there.
    static void explain(std::vector<Step>& steps, std::size_t before, Choice why, bool textual) {
        for (std::size_t i = before; i < steps.size(); ++i) {
            Step& s = steps[i];
            if (s.kind != Step::Kind::Match && s.kind != Step::Kind::Neighbours && s.kind != Step::Kind::Locate) continue;
            s.choice = why;
            if (s.kind != Step::Kind::Match && !textual) s.choice.reason = s.kind == Step::Kind::Locate ? Reason::Named : Reason::Links;
            why.dearer.clear();
            why.waiting.clear();
        }
    }

    void reach(VariableId at, State& s, std::vector<Step>& steps) const {
        if (s.places.contains(at)) return;
        Step step{.kind = s.values.contains(at) ? Step::Kind::Locate : Step::Kind::Neighbours};
        step.place = at;
        s.places.insert(at);
        steps.push_back(std::move(step));
    }

    void atom(const Atom& a, State& s, std::vector<Step>& steps) const {
        if (is_neighbor(a)) return neighbor(a, s, steps);
        const VariableId at = a.arguments[0].variable;
        reach(at, s, steps);
        Step step{.kind = Step::Kind::Match};
        step.place = at;
        step.at_home = at == rule_.home;
        step.predicate = a.predicate;
        step.read_only = a.read_only;
        step.ranks = ranked_ && std::find(component_.begin(), component_.end(), a.predicate) != component_.end();
        for (std::size_t i = 1; i < a.arguments.size(); ++i) {
            const Term& t = a.arguments[i];
            step.arguments.push_back(t);
            if (t.op == Op::Anonymous) {
                step.uses.push_back(ArgumentUse::Skip);
            } else if (t.is_variable() && !known(t.variable, s)) {
                step.uses.push_back(ArgumentUse::Bind);
                s.values.insert(t.variable);
                if (i == 1 && plan_.of(a.predicate).storage == Storage::PerLink) s.places.insert(t.variable);
            } else {
                step.uses.push_back(ArgumentUse::Compare);
            }
        }
        steps.push_back(std::move(step));
    }

    void each(const Clause& c, State& s, std::vector<Step>& steps) const {
        Step step{.kind = Step::Kind::Each};
        step.variable = c.variable;
        step.term = c.test;
        if (!known(c.variable, s)) s.values.insert(c.variable);
        step.position = c.position;
        if (c.position.valid()) s.values.insert(c.position);
        steps.push_back(std::move(step));
    }

    // The fact that has just been matched is compared with what held before the tick.
    void delta(const Clause& c, std::vector<Step>& steps) const {
        Step step{.kind = Step::Kind::Delta};
        step.predicate = c.atom.predicate;
        step.variable = c.variable;
        step.compare = c.compare;
        step.term = c.test;
        for (std::size_t i = 1; i < c.atom.arguments.size(); ++i) step.arguments.push_back(c.atom.arguments[i]);
        steps.push_back(std::move(step));
    }

    // neighbor(A, B, P) seen from the home, whichever of the two it is.
    void neighbor(const Atom& a, State& s, std::vector<Step>& steps) const {
        const bool forward = a.arguments[0].variable == rule_.home;
        const Term& other = forward ? a.arguments[1] : a.arguments[0];
        if (other.is_variable() && other.variable == rule_.home) {
            // No catom is its own neighbour.
            Step never{.kind = Step::Kind::Test};
            never.term.op = Op::Bool;
            never.term.type = Type::Bool;
            steps.push_back(std::move(never));
            return;
        }
        Step step{.kind = Step::Kind::Neighbours};
        step.port_from_other_side = !forward;
        if (other.is_variable() && s.places.contains(other.variable) && other.variable != rule_.home) {
            if (a.arguments.size() < 3 || a.arguments[2].op == Op::Anonymous) return;  // It is one: nothing to check.
            step.place = other.variable;
            step.kind = Step::Kind::Locate;
        } else if (other.is_variable()) {
            step.place = other.variable;
            step.kind = s.values.contains(other.variable) ? Step::Kind::Locate : Step::Kind::Neighbours;
            s.places.insert(other.variable);
        } else {
            step.term = other;  // A fixed catom or `_`.
        }
        if (a.arguments.size() > 2) {
            const Term& port = a.arguments[2];
            if (port.is_variable() && !known(port.variable, s)) {
                step.port = port.variable;
                s.values.insert(port.variable);
            } else {
                step.port_compare = port;
            }
        }
        steps.push_back(std::move(step));
    }

    const Plan& plan_;
    const Program& program_;
    const Rule& rule_;
    bool ranked_;
    const std::vector<PredicateId>& component_;
};

class Inputs {
  public:
    explicit Inputs(const Plan& plan) : plan_(plan) {}

    std::uint64_t of(const std::vector<Step>& steps) const {
        // The bits of runtime/abi/module_abi.h.
        constexpr std::uint64_t born = 1, links = 2, place = 4, wake = 8, tick = 16;
        std::uint64_t bits = born;
        for (const Step& s : steps) {
            bits |= of(s.inner);
            // A change is true in one tick alone; what is due is so when the time has come.
            if (s.kind == Step::Kind::Delta) bits |= wake;
            each_subterm(s.term, [&](const Term& t) { bits |= t.op == Op::Due ? wake : 0; });
            if (s.kind == Step::Kind::Neighbours || s.kind == Step::Kind::Locate) bits |= links;
            if (s.kind != Step::Kind::Match) continue;
            const Stored& stored = plan_.of(s.predicate);
            switch (plan_.program.predicates[s.predicate].world) {
                case WorldSource::None:
                    bits |= s.at_home ? plan_.columns[stored.column].own_dirty : plan_.columns[stored.column].reader_dirty | links;
                    if (stored.storage == Storage::PerLink) bits |= links;
                    break;
                case WorldSource::Neighbor:
                case WorldSource::NeighborPort:
                case WorldSource::NeighborCount:
                case WorldSource::Vacant:
                    bits |= links;
                    break;
                case WorldSource::Cell:
                case WorldSource::Position:
                case WorldSource::PositionVector:
                case WorldSource::Target:
                case WorldSource::TargetPort:
                    bits |= place;
                    break;
                case WorldSource::Tick:
                    bits |= tick;
                    break;
                case WorldSource::Id:
                case WorldSource::Facts:
                    break;
            }
        }
        return bits;
    }
    std::uint64_t of(const std::vector<HeadPlan>& heads) const {
        std::uint64_t bits = 0;
        for (const HeadPlan& h : heads) bits |= of(h.steps) | of(h.heads) | of(h.others);
        return bits;
    }
    // Linear facts of which fewer may let the steps succeed. Consuming any other leaves a rule that could not fire as it was.
    std::uint64_t absent(const std::vector<Step>& steps) const {
        std::uint64_t bits = 0;
        for (const Step& s : steps) bits |= of_linear(s.inner);
        return bits;
    }

  private:
    std::uint64_t of_linear(const std::vector<Step>& steps) const {
        std::uint64_t bits = 0;
        for (const Step& s : steps) {
            bits |= of_linear(s.inner);
            if (s.kind == Step::Kind::Match && plan_.program.predicates[s.predicate].linear())
                bits |= plan_.columns[plan_.of(s.predicate).column].own_dirty;
        }
        return bits;
    }

    const Plan& plan_;
};

Variables head_variables(const std::vector<Head>& heads) {
    Variables out;
    for (const Head& h : heads) each_variable(h, [&](VariableId v) { out.insert(v); });
    return out;
}

std::vector<HeadPlan> plan_heads(const Orderer& orderer, const std::vector<Head>& heads, const Orderer::State& state) {
    std::vector<HeadPlan> out;
    for (const Head& h : heads) {
        HeadPlan plan;
        plan.kind = h.kind;
        plan.folds = h.folds;
        plan.term = h.term;
        plan.variable = h.variable;
        if (h.kind == Head::Kind::Fact) {
            plan.predicate = h.atom.predicate;
            plan.place = h.atom.arguments[0].variable;
            plan.arguments.assign(h.atom.arguments.begin() + 1, h.atom.arguments.end());
        }
        Orderer::State inner = state;
        Variables used = head_variables(h.heads);
        for (const Fold& f : h.folds)
            if (f.each.valid()) used.insert(f.each);
        plan.steps = orderer.order(h.body, inner, true, used);
        if (h.kind == Head::Kind::Set) inner.values.insert(h.variable);
        plan.heads = plan_heads(orderer, h.heads, inner);
        Orderer::State last = state;
        for (const Fold& f : h.folds) last.values.insert(f.result);
        plan.others = plan_heads(orderer, h.others, last);
        out.push_back(std::move(plan));
    }
    return out;
}

RulePlan plan_rule(const Plan& plan, RuleId id, bool ranked, const std::vector<PredicateId>& component) {
    const Rule& rule = plan.program.rules[id];
    const Orderer orderer(plan, rule, ranked, component);
    Orderer::State state = orderer.start();
    RulePlan out;
    out.rule = id;
    Variables used = head_variables(rule.heads);
    if (rule.selected.valid()) used.insert(rule.selected);
    out.steps = orderer.order(rule.body, state, rule.linear, used);
    out.heads = plan_heads(orderer, rule.heads, state);
    for (HeadPlan& h : out.heads) h.contributors = rule.contributors;
    const Inputs inputs(plan);
    out.inputs = inputs.of(out.steps) | inputs.of(out.heads);
    if (rule.linear) out.absent = inputs.absent(out.steps);
    return out;
}

}  // namespace

std::vector<Step> order_changed(const Plan& plan, const Rule& rule, const std::vector<Clause>& body, std::size_t first,
                                const std::vector<VariableId>& needed) {
    const std::vector<PredicateId> no_ranks;
    return Orderer(plan, rule, false, no_ranks).order_changed(body, first, {needed.begin(), needed.end()});
}

RulePlan order_fresh(const Plan& plan, RuleId id, std::vector<Clause> body, std::size_t first) {
    const Rule& rule = plan.program.rules[id];
    const std::vector<PredicateId> no_ranks;
    const Orderer orderer(plan, rule, false, no_ranks);
    Orderer::State state = orderer.start();
    const Variables used = head_variables(rule.heads);
    RulePlan out;
    out.rule = id;
    out.steps = orderer.start_changed(body, first, used, state);
    for (Step& s : orderer.order(std::move(body), state, false, used)) out.steps.push_back(std::move(s));
    out.heads = plan_heads(orderer, rule.heads, state);
    for (HeadPlan& h : out.heads) h.contributors = rule.contributors;
    return out;
}

RulePlan order_group(const Plan& plan, RuleId id, const ComponentPlan& component, const std::vector<Clause>& body,
                     const std::vector<VariableId>& given) {
    const Rule& rule = plan.program.rules[id];
    const Orderer orderer(plan, rule, plan.of(component.predicates[0]).ranked, component.predicates);
    Orderer::State state = orderer.start();
    state.values.insert(given.begin(), given.end());
    const Variables used = head_variables(rule.heads);
    RulePlan out;
    out.rule = id;
    out.steps = orderer.order(body, state, false, used);
    out.heads = plan_heads(orderer, rule.heads, state);
    for (HeadPlan& h : out.heads) h.contributors = rule.contributors;
    out.given = given;
    return out;
}

std::uint64_t inputs_of(const Plan& plan, const std::vector<Step>& steps) { return Inputs(plan).of(steps); }

std::uint64_t waiting_inputs(const Plan& plan, PredicateId predicate) {
    constexpr std::uint64_t links = 2;
    const PredicateId link = plan.program.predicates[predicate].complete_link;
    if (!link.valid()) return 0;
    return plan.program.predicates[link].world != WorldSource::None ? links : links | plan.columns[plan.of(link).column].own_dirty;
}

namespace {

bool is_ranked(const Plan& plan, const Component& c) { return plan.of(c.predicates[0]).ranked; }

}  // namespace

void order_rules(Plan& plan) {
    for (const Component& c : plan.program.components) {
        if (c.rules.empty()) continue;
        ComponentPlan out;
        out.predicates = c.predicates;
        out.links = c.links;
        const bool ranked = is_ranked(plan, c);
        out.recursion = !c.recursive                         ? Recursion::None
                        : c.tree && !c.local                 ? Recursion::Tree
                        : !ranked                            ? Recursion::LocalSets
                        : c.local || c.predicates.size() > 1 ? Recursion::Mutual
                                                             : Recursion::Ranked;
        for (const RuleId id : c.rules) {
            out.rules.push_back(plan_rule(plan, id, ranked, c.predicates));
            out.inputs |= out.rules.back().inputs;
        }
        for (const PredicateId p : c.predicates) out.inputs |= waiting_inputs(plan, p);
        constexpr std::uint64_t wake = 8;
        if (ranked && c.links) out.inputs |= wake;
        for (const PredicateId p : c.predicates) out.outputs |= plan.columns[plan.of(p).column].own_dirty;
        plan.components.push_back(std::move(out));
    }
    // What arrives is there before the program's own rules look.
    for (const bool arrivals : {true, false})
        for (const RuleId id : plan.program.rules.ids()) {
            const Rule& rule = plan.program.rules[id];
            if (rule.linear && rule.arrives == arrivals)
                (rule.birth ? plan.births : plan.linear_rules).push_back(plan_rule(plan, id, false, {}));
        }
    const std::uint64_t tick = 16;
    for (const ComponentPlan& c : plan.components) plan.reads_tick = plan.reads_tick || (c.inputs & tick);
    for (const RulePlan& r : plan.linear_rules) plan.reads_tick = plan.reads_tick || (r.inputs & tick);
}

}  // namespace meld::plan
