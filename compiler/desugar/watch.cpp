// Pass `watch`. delta(X; p(A, X)) compares what a rule derives with what it derived in the tick before. What is given or
// read from the world is there in place of what was, so it is looked at through a view of its own:
//     q(A) :- delta(X; p(A, X)) > 1.    becomes    q(A) :- delta(X; p@now(A, X)) > 1.    p@now(A, X) :- p(A, X).
#include <map>

#include "compiler/desugar/desugar.h"
#include "compiler/desugar/made.h"

namespace meld::desugar {

using namespace check;

namespace {

class Changes {
  public:
    explicit Changes(Program& program) : program_(program), derived_(program.predicates.count(), false) {}

    void run() {
        for (const Rule& rule : program_.rules)
            if (!rule.linear) derived_[rule.heads[0].atom.predicate.index()] = true;
        for (std::size_t i = 0, end = program_.rules.count(); i < end; ++i) {
            Rule rule = program_.rules[RuleId(i)];
            body(rule.body);
            heads(rule.heads);
            program_.rules[RuleId(i)] = std::move(rule);
        }
    }

  private:
    void body(std::vector<Clause>& clauses) {
        for (Clause& c : clauses) {
            body(c.inner);
            if (c.kind == Clause::Kind::Delta && !compares(c.atom.predicate)) c.atom.predicate = view_of(c.atom.predicate);
        }
    }
    void heads(std::vector<Head>& all) {
        for (Head& h : all) {
            body(h.body);
            heads(h.heads);
            heads(h.others);
        }
    }
    // Whether rows of the predicate can be compared with those before: derived ones that do not name a neighbour by its port.
    bool compares(PredicateId id) const {
        const Predicate& p = program_.predicates[id];
        const bool maybe_by_port = p.aggregate != Aggregate::None && p.aggregate_at == 2 && p.arguments[1].type == Type::Node;
        return derived_[id.index()] && !maybe_by_port;
    }
    PredicateId view_of(PredicateId of) {
        const auto found = views_.find(of);
        if (found != views_.end()) return found->second;
        Predicate made;
        made.name = program_.predicates[of].name + "@now";
        made.span = program_.predicates[of].span;
        made.arguments = program_.predicates[of].arguments;
        made.auxiliary = true;
        const PredicateId id = program_.predicates.add(made);
        MadeRule copy(program_, of, made.name);
        copy.head(program_, id, 0);
        copy.add_to(program_);
        return views_[of] = id;
    }

    Program& program_;
    std::vector<bool> derived_;
    std::map<PredicateId, PredicateId> views_;
};

}  // namespace

void watch_changes(Program& program) { Changes(program).run(); }

}  // namespace meld::desugar
