// Pass `delay`. A fact that a linear rule makes for later waits as a linear fact of its own, at the catom where it will be:
//     a(A, X) -o p(A, X)@+3.
// becomes
//     a(A, X) -o p@later(A, X, now + 3).      p@later(A, X, T), due(T) -o p(A, X).
// A view for later holds when its body has held so long without a break; p@since keeps the tick since which it has:
//     p@12.since(A, X, now) :- body.          p(A, X) :- p@12.since(A, X, T), due(T + 3).
// All that waits is stored in columns, so it moves with its catom.
#include <map>

#include "compiler/desugar/desugar.h"
#include "compiler/desugar/made.h"

namespace meld::desugar {

using namespace check;

namespace {

class Delays {
  public:
    explicit Delays(Program& program) : program_(program) {}

    void run() {
        for (std::size_t i = 0, end = program_.rules.count(); i < end; ++i) {
            const RuleId id(i);
            if (program_.rules[id].linear) {
                Rule rule = program_.rules[id];
                later(rule.heads);
                program_.rules[id] = std::move(rule);
            } else if (program_.rules[id].heads[0].delay.op != Op::Anonymous) {
                since(id);
            }
        }
    }

  private:
    static Predicate auxiliary(const Predicate& p, std::string name) {
        Predicate out;
        out.name = std::move(name);
        out.span = p.span;
        out.arguments = p.arguments;
        out.auxiliary = true;
        return out;
    }

    void later(std::vector<Head>& heads) {
        for (Head& h : heads) {
            later(h.heads);
            later(h.others);
            if (h.delay.op == Op::Anonymous) continue;
            h.atom.predicate = waiting(h.atom.predicate);
            h.atom.arguments.push_back(made_term(Op::Add, Type::Int, {made_term(Op::Now, Type::Int), std::move(h.delay)}));
            h.delay = {};
        }
    }

    // The linear auxiliary in which facts of p wait, made with its rule on first use.
    PredicateId waiting(PredicateId p) {
        const auto found = waiting_.find(p);
        if (found != waiting_.end()) return found->second;
        MELD_EXPECT(program_.predicates[p].kind != PredicateKind::Sensed, "nothing makes {}", program_.predicates[p].name);
        Predicate made = auxiliary(program_.predicates[p], program_.predicates[p].name + "@later");
        made.kind = PredicateKind::Linear;
        made.arguments.push_back({Type::Int, "Due"});
        made.carries = p;
        made.behind = 1;
        const PredicateId id = program_.predicates.add(made);
        MadeRule arrival(program_, id, made.name);
        arrival.rule.linear = arrival.rule.arrives = true;
        arrival.rule.body.push_back(due(arrival.body.atom.arguments.back()));
        arrival.head(program_, p, 0);
        arrival.add_to(program_);
        return waiting_[p] = id;
    }

    static Clause due(Term tick) {
        Clause c{.kind = Clause::Kind::Test};
        c.test = made_term(Op::Due, Type::Bool, {std::move(tick)});
        return c;
    }

    void since(RuleId id) {
        Rule rule = program_.rules[id];
        MELD_EXPECT(!rule.linear && rule.heads.size() == 1, "rule {}", rule.name);
        Head& head = rule.heads[0];
        const PredicateId p = head.atom.predicate;
        if (program_.predicates[p].aggregate == Aggregate::Count) {
            // What is counted is not computed, and changes nothing.
            Term& counted = head.atom.arguments[program_.predicates[p].aggregate_at];
            counted = {.op = Op::Int, .type = Type::Int, .span = counted.span, .integer = 1};
        }
        Predicate made = auxiliary(program_.predicates[p], rule.name + ".since");
        for (std::size_t i = 0; i < made.arguments.size(); ++i) made.arguments[i].type = head.atom.arguments[i].type;
        if (program_.predicates[p].needs_all()) tell_apart(rule, made);
        made.aggregate = Aggregate::Since;
        made.aggregate_at = made.arguments.size();
        made.arguments.push_back({Type::Int, "Since"});
        head.atom.arguments.push_back(made_term(Op::Now, Type::Int));
        head.atom.predicate = program_.predicates.add(made);
        Term delay = std::move(head.delay);
        head.delay = {};

        MadeRule holds(program_, head.atom.predicate, rule.name + ".due");
        holds.rule.line = rule.line;
        holds.rule.body.push_back(due(made_term(Op::Add, Type::Int, {holds.body.atom.arguments.back(), std::move(delay)})));
        holds.head(program_, p, 0);
        for (const VariableId v : rule.contributors) keep_contributor(rule, v, holds);
        rule.contributors.clear();
        rule.text += "  // since when";
        program_.rules[id] = std::move(rule);
        holds.add_to(program_);
    }

    static void keep_contributor(const Rule& rule, VariableId v, MadeRule& holds) {
        const std::vector<Term>& made = rule.heads[0].atom.arguments;
        for (std::size_t i = 0; i < made.size(); ++i)
            if (made[i].is_variable() && made[i].variable == v) holds.rule.contributors.push_back(holds.body.atom.arguments[i].variable);
    }

    // A sum and a count know every derivation, so each waits as a fact of its own: by the facts that the body has found, and the
    // places of the elements of lists. What is computed of them is no part of it.
    static void tell_apart(Rule& rule, Predicate& made) {
        Variables given;
        for (const Term& t : rule.heads[0].atom.arguments)
            if (t.is_variable()) given.insert(t.variable);
        const auto keep = [&](Term t) {
            if (t.is_variable() && !given.insert(t.variable)) return;
            made.arguments.push_back({t.type, ""});
            rule.heads[0].atom.arguments.push_back(std::move(t));
        };
        for (Clause& c : rule.body) {
            if (c.kind == Clause::Kind::Element) {
                // Equal elements of a list are derivations of their own.
                c.position = rule.variables.add({"_", c.span, Type::Int});
                keep({.op = Op::Variable, .type = Type::Int, .span = c.span, .variable = c.position});
            }
            if (c.kind != Clause::Kind::Atom && c.kind != Clause::Kind::Delta) continue;
            for (Term& t : c.atom.arguments) {
                if (t.op == Op::Anonymous) {
                    t.op = Op::Variable;
                    t.variable = rule.variables.add({"_", t.span, t.type});
                }
                if (t.is_variable()) keep(t);
            }
        }
        for (const Clause& c : rule.body) {
            if (c.kind != Clause::Kind::Atom && c.kind != Clause::Kind::Delta) continue;
            for (const Term& t : c.atom.arguments) {
                bool known = true;
                each_variable(t, [&](VariableId v) { known = known && given.contains(v); });
                if (!known) keep(t);
            }
        }
    }

    Program& program_;
    std::map<PredicateId, PredicateId> waiting_;
};

}  // namespace

void delay_heads(Program& program) { Delays(program).run(); }

}  // namespace meld::desugar
