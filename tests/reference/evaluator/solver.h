// Finds the ways to satisfy a body, one clause after the other: what has become known is tested at once, and facts are
// tried by nested loops; aggregates and negations come when nothing else is left.
#pragma once

#include <functional>

#include "tests/reference/evaluator/expressions.h"
#include "tests/reference/trials/scene.h"

namespace meld::reference {

// Whether its facts are the neighbours of a catom.
inline bool is_neighbor(const check::Predicate& p) {
    return p.world == check::WorldSource::Neighbor || p.world == check::WorldSource::NeighborPort;
}

// A linear fact that an atom of a body has matched.
struct Taken {
    PredicateId predicate;
    Row row;
    std::size_t at = 0;     // Its place among those of the predicate at the catom: there may be equal ones.
    bool consumed = false;  // Otherwise it is only read.
};

// What can be seen.
struct Sight {
    const Scene& scene;
    const Facts& facts;                        // Persistent ones.
    const std::vector<Bag>* linear = nullptr;  // Of one catom, by predicate.
    const Facts* before = nullptr;             // Persistent ones as they were before this tick; null: as they are.
    const Links* links_before = nullptr;       // What neighbours tell of their links, which is as late as all they tell;
    check::VariableId site = {};               // links that do not begin or end here.
    // Instead of all this: what an atom of the body may match, at a catom or, if none is known, anywhere.
    std::function<std::vector<Row>(const check::Atom& atom, const std::optional<Value>& place)> rows = {};
};

class Solver {
  public:
    explicit Solver(const Sight& sight)
        : program_(*sight.scene.program), sight_(sight), scene_(sight.scene), facts_(sight.facts), linear_(sight.linear) {}

    // Calls found() for each way to satisfy the body after what env binds, until it returns true; returns whether it did.
    // Facts are tried in the order of the text, as soon as their catom is known, lowest fact first, neighbours by port.
    bool solve(const std::vector<check::Clause>& body, Environment& env, const std::function<bool()>& found);

    // In found(): the linear facts that this way consumes.
    std::vector<Taken> taken() const;
    // Some expression had no value. The ways that need it are none.
    bool failed() const { return failed_; }

  private:
    using Clauses = std::vector<const check::Clause*>;
    using Found = std::function<bool()>;
    using Next = Clauses::const_iterator;
    struct Deferred {
        const check::Term* term;
        Value value;
    };
    // What is bound on the way is forgotten on the way back.
    class Mark;

    bool step(Clauses open, Environment& env, const Found& found);
    bool try_test(const check::Clause& clause, Clauses rest, Environment& env, const Found& found);
    bool try_atom(const check::Atom& atom, Clauses rest, Environment& env, const Found& found);
    bool try_change(const check::Clause& clause, Clauses rest, Environment& env, const Found& found);
    bool try_elements(const check::Clause& clause, Clauses rest, Environment& env, const Found& found);
    bool try_aggregate(const check::Clause& clause, Clauses rest, Environment& env, const Found& found);
    bool finish(const Clauses& negations, Environment& env, const Found& found);

    Next next_test(const Clauses& open, const Environment& env) const;
    Next next_choice(const Clauses& open, const Environment& env) const;
    bool readable(const check::Atom& atom, const Environment& env) const;
    bool nothing_satisfies(const std::vector<check::Clause>& inner, Environment& env);
    std::vector<Row> candidates(const check::Atom& atom, const Environment& env) const;
    std::vector<Row> linked(const check::Atom& atom, const std::optional<Value>& place, const Environment& env) const;
    double change_of(const check::Clause& clause, const Row& row) const;
    bool is_free(const check::Atom& atom, std::size_t at) const;
    bool match(const check::Atom& atom, const Row& row, Environment& env);
    bool unify(const check::Term& term, const Value& value, Environment& env);
    void bind(std::size_t variable, const Value& value, Environment& env);
    std::optional<Value> value(const check::Term& term, const Environment& env);

    const Program& program_;
    const Sight sight_;
    const Scene& scene_;
    const Facts& facts_;
    const std::vector<Bag>* linear_;
    std::vector<std::size_t> bound_;  // The variables bound so far, in this order.
    std::vector<Taken> matched_;
    std::vector<Deferred> deferred_;  // Arguments that were expressions over variables not yet known.
    bool inside_ = false;             // A negation or an aggregate: what is matched there is not consumed.
    bool failed_ = false;
};

}  // namespace meld::reference
