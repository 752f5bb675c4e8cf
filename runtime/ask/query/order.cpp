#include "runtime/ask/query/order.h"

#include <algorithm>
#include <utility>

#include "runtime/base/assert.h"

namespace meld::inspect {

namespace {

using check::Clause;
using check::Op;
using check::Term;
using check::VariableId;

enum class Whole { No, Yes };
// Of what comes in a part of a body when there are no more facts to look at.
constexpr int kLater = 100;

class Orderer {
  public:
    Orderer(const Program& program, const check::Rule& rule, const std::vector<Clause>& body, Bound& bound, Whole whole, bool once)
        : program_(program), rule_(rule), body_(body), bound_(bound), in_the_end_(bound), part_(whole == Whole::No), once_(once) {
        find_what_is_bound();
    }

    std::vector<Step> run() {
        std::vector<bool> done(body_.size(), false);
        std::vector<Step> steps;
        for (std::size_t left = body_.size(); left > 0; --left) {
            std::optional<std::size_t> best;
            int least = 0;
            for (std::size_t i = 0; i < body_.size(); ++i) {
                if (done[i]) continue;
                const std::optional<int> cost = cost_of(body_[i], false);
                if (cost && (!best || *cost < least)) {
                    best = i;
                    least = *cost;
                }
            }
            // In p(A, X, Y + 1), q(A, Y, X + 1) each waits for the other: one of them goes first, and is compared later.
            for (std::size_t i = 0; i < body_.size() && !best; ++i)
                if (!done[i] && cost_of(body_[i], true)) best = i;
            // The check has found a value for every variable.
            MELD_CHECK(best, "the body of {} cannot be put in order", rule_.name);
            done[*best] = true;
            steps.push_back(step_of(body_[*best], *best));
            compare_late(steps);
        }
        MELD_ENSURE(late_.empty(), "{} arguments of {} are never known", late_.size(), rule_.name);
        return steps;
    }

  private:
    bool is_bound(VariableId v) const { return bound_[v.index()]; }
    bool all_bound(const Term& term) const {
        return check::all_free(term, [&](VariableId v) { return is_bound(v); });
    }

    // What the clauses bind in the end, in whichever order.
    void find_what_is_bound() {
        for (const Clause& c : body_)
            if (c.kind == Clause::Kind::Atom)
                for (const Term& a : c.atom.arguments)
                    if (a.is_variable()) in_the_end_[a.variable.index()] = true;
        const auto has = [&](const Term& term) {
            return check::all_free(term, [&](VariableId v) { return bool{in_the_end_[v.index()]}; });
        };
        for (bool changed = true; changed;) {
            changed = false;
            const auto bind = [&](const Term& t) {
                if (t.is_variable() && !in_the_end_[t.variable.index()]) changed = in_the_end_[t.variable.index()] = true;
            };
            for (const Clause& c : body_) {
                if (c.kind == Clause::Kind::Aggregate || c.kind == Clause::Kind::Element) {
                    if (!in_the_end_[c.variable.index()]) changed = in_the_end_[c.variable.index()] = true;
                }
                if (c.kind != Clause::Kind::Test || c.test.op != Op::Equal) continue;
                for (const std::size_t side : {0u, 1u})
                    if (has(c.test.operands[1 - side])) bind(c.test.operands[side]);
                if (const check::TakeApart parts = check::taken_apart(c.test); parts && has(*parts.value))
                    for (const Term& part : parts.constructor->operands) bind(part);
            }
        }
    }

    // A part of the body can be looked at once all that it shares with the rest has its value.
    bool shared_is_bound(const Clause& part) const {
        bool all = true;
        const auto look = [&](VariableId v) { all = all && (is_bound(v) || !in_the_end_[v.index()]); };
        for (const Clause& c : part.inner) check::each_variable(c, look);
        check::each_variable(part.test, look);
        return all && all_bound(part.parameter);
    }

    std::optional<std::size_t> side_to_bind(const Term& test) const {
        if (test.op != Op::Equal) return std::nullopt;
        for (const std::size_t side : {0u, 1u})
            if (test.operands[side].is_variable() && !is_bound(test.operands[side].variable) && all_bound(test.operands[1 - side]))
                return side;
        return std::nullopt;
    }
    bool can_take_apart(const Term& test) const {
        const check::TakeApart parts = check::taken_apart(test);
        return parts && all_bound(*parts.value) &&
               std::ranges::all_of(parts.constructor->operands, [&](const Term& part) { return part.is_variable() || all_bound(part); });
    }

    // How many ways to go on it may have, roughly; nothing: not yet.
    std::optional<int> cost_of(const Clause& c, bool late) const {
        switch (c.kind) {
            case Clause::Kind::Test:
                return all_bound(c.test) || side_to_bind(c.test) || can_take_apart(c.test) ? std::optional(0) : std::nullopt;
            case Clause::Kind::Not:
                return shared_is_bound(c) ? std::optional(part_ ? kLater + 1 : 3) : std::nullopt;
            case Clause::Kind::Aggregate:
                return shared_is_bound(c) ? std::optional(part_ ? kLater : 4) : std::nullopt;
            case Clause::Kind::Element:
                return all_bound(c.test) ? std::optional(part_ ? 1 : 6) : std::nullopt;
            case Clause::Kind::Atom:
                return cost_of(c.atom, late);
            case Clause::Kind::Delta:
                break;
        }
        MELD_CHECK(false, "a question with a delta");
    }
    std::optional<int> cost_of(const check::Atom& atom, bool late) const {
        int known = 0, all = 0;
        for (std::size_t i = 1; i < atom.arguments.size(); ++i) {
            const Term& t = atom.arguments[i];
            if (t.op == Op::Anonymous) continue;
            ++all;
            if (all_bound(t))
                ++known;
            else if (!t.is_variable() && !late)
                return std::nullopt;
        }
        const Source& source = program_.source(atom.predicate);
        if (part_ && (place_known(atom) || leads_here(atom))) return 1;
        if (place_known(atom)) return known == all ? 2 : 5;
        if (can_go_back(atom)) return 7;
        if (known > 0) return 8 + (all - known);
        // Nearly all catoms have neighbours and a place.
        return source.kind == Source::Kind::World ? 40 : 30;
    }
    bool place_known(const check::Atom& atom) const { return atom.arguments[0].is_variable() && is_bound(atom.arguments[0].variable); }
    bool leads_here(const check::Atom& atom) const {
        return program_.checked().predicates[atom.predicate].route && atom.arguments[1].is_variable() &&
               is_bound(atom.arguments[1].variable);
    }
    bool can_go_back(const check::Atom& atom) const {
        const Source& source = program_.source(atom.predicate);
        return source.kind == Source::Kind::World && is_link(source.world) && atom.arguments[1].op != Op::Anonymous &&
               all_bound(atom.arguments[1]);
    }

    void bind(VariableId v) { bound_[v.index()] = true; }

    // Uses terms as the arguments of a fact or the parts of a value, from the first to the last.
    Argument use(const Term& t, const check::Type& type) {
        Argument out{.use = Argument::Use::Skip, .term = &t, .type = type};
        if (t.op == Op::Anonymous) return out;
        if (!t.is_variable() && !all_bound(t)) return use_late(t, type);
        const bool binds = t.is_variable() && !is_bound(t.variable);
        out.use = binds ? Argument::Use::Bind : Argument::Use::Compare;
        if (binds) bind(t.variable);
        return out;
    }

    // Keeps the value of an argument until the term that it must be equal to is known.
    Argument use_late(const Term& t, const check::Type& type) {
        Term kept{.op = Op::Variable, .type = type, .span = t.span};
        kept.variable = VariableId(bound_.size());
        bound_.push_back(true);
        in_the_end_.push_back(true);
        Term test{.op = Op::Equal, .type = check::Type::Bool, .span = t.span};
        test.operands = {kept, t};
        late_.push_back(std::make_shared<const Term>(std::move(test)));
        made_.push_back(late_.back());
        return {.use = Argument::Use::Bind, .term = &late_.back()->operands[0], .type = type};
    }
    void compare_late(std::vector<Step>& steps) {
        steps.back().keep = std::exchange(made_, {});
        std::erase_if(late_, [&](const std::shared_ptr<const Term>& test) {
            if (!all_bound(*test)) return false;
            Step step{.kind = Step::Kind::Test, .clause = steps.back().clause, .number = steps.back().number};
            step.term = test.get();
            step.keep = {test};
            steps.push_back(std::move(step));
            return true;
        });
    }

    Step step_of(const Clause& c, std::size_t number) {
        Step step{.clause = &c, .number = number};
        switch (c.kind) {
            case Clause::Kind::Atom:
                match(c.atom, step);
                break;
            case Clause::Kind::Test:
                test(c.test, step);
                break;
            case Clause::Kind::Element:
                step.kind = Step::Kind::Element;
                once_ = false;
                step.known = is_bound(c.variable);
                bind(c.variable);
                if (c.position.valid()) bind(c.position);
                break;
            case Clause::Kind::Not:
            case Clause::Kind::Aggregate: {
                step.kind = c.kind == Clause::Kind::Not ? Step::Kind::Not : Step::Kind::Aggregate;
                Bound inside = bound_;
                step.inner = Orderer(program_, rule_, c.inner, inside, Whole::No, once_).run();
                // What it needs for itself has its place behind all variables, where the next part may have its own.
                if (inside.size() > bound_.size()) grow(inside.size());
                if (c.kind == Clause::Kind::Not) break;
                step.known = is_bound(c.variable);
                bind(c.variable);
                break;
            }
            case Clause::Kind::Delta:
                break;
        }
        return step;
    }
    void grow(std::size_t variables) {
        bound_.resize(variables, true);
        in_the_end_.resize(variables, true);
    }
    void match(const check::Atom& atom, Step& step) {
        step.source = program_.source(atom.predicate);
        const bool here = place_known(atom), back = !here && can_go_back(atom);
        for (std::size_t i = 1; i < atom.arguments.size(); ++i)
            if (atom.arguments[i].op != Op::Anonymous && all_bound(atom.arguments[i])) step.key.push_back(i);
        step.kind = here ? Step::Kind::Here : back ? Step::Kind::Back : step.key.empty() || once_ ? Step::Kind::Each : Step::Kind::Indexed;
        once_ = false;
        const std::vector<check::Argument>& declared = program_.checked().predicates[atom.predicate].arguments;
        for (std::size_t i = 0; i < atom.arguments.size(); ++i) step.arguments.push_back(use(atom.arguments[i], declared[i].type));
    }
    void test(const Term& test, Step& step) {
        if (all_bound(test)) {
            step.kind = Step::Kind::Test;
            step.term = &test;
        } else if (const std::optional<std::size_t> side = side_to_bind(test)) {
            step.kind = Step::Kind::Bind;
            step.variable = test.operands[*side].variable;
            step.term = &test.operands[1 - *side];
            bind(step.variable);
        } else {
            const check::TakeApart parts = check::taken_apart(test);
            step.kind = Step::Kind::TakeApart;
            step.variable = parts.value->variable;
            step.term = parts.constructor;
            const check::Type& type = parts.constructor->type;
            for (std::size_t i = 0; i < parts.constructor->operands.size(); ++i) {
                const bool rest = parts.constructor->op == Op::Cons && i == 1;
                const check::Type& part =
                    type == check::Type::Vec3 ? check::Type::Float
                    : rest                    ? type
                           : type.parts[type.kind == check::Type::Kind::Struct || type.kind == check::Type::Kind::Tuple ? i : 0];
                step.arguments.push_back(use(parts.constructor->operands[i], part));
            }
        }
    }

    const Program& program_;
    const check::Rule& rule_;
    const std::vector<Clause>& body_;
    Bound& bound_;
    Bound in_the_end_;
    bool part_;                                      // Of a body, which has an order of its own.
    bool once_;                                      // The steps so far are taken once, so that an index would not pay.
    std::vector<std::shared_ptr<const Term>> late_;  // Comparisons that wait.
    std::vector<std::shared_ptr<const Term>> made_;  // By the present step.
};

}  // namespace

std::vector<Step> order(const Program& program, const check::Rule& rule, const std::vector<Clause>& body, Bound& bound, bool once) {
    MELD_EXPECT(bound.size() >= rule.variables.count(), "{} of {} variables", bound.size(), rule.variables.count());
    return Orderer(program, rule, body, bound, Whole::Yes, once).run();
}

}  // namespace meld::inspect
