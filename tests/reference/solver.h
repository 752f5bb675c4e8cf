// Finds the ways to satisfy a body, by nested loops: facts first, then tests, then negations.
#pragma once

#include <functional>

#include "expressions.h"
#include "scene.h"

namespace meld::reference {

struct Taken {
    PredicateId predicate;
    Row row;
};

class Solver {
  public:
    // facts: what can be seen of persistent facts. linear: the bags of linear facts of one catom, by predicate, or null.
    Solver(const Program& program, const Scene& scene, const Facts& facts, const std::vector<Bag>* linear = nullptr)
        : program_(program), scene_(scene), facts_(facts), linear_(linear) {}

    // Calls found() for each way to satisfy the body after what env binds, until it returns true; returns whether it did.
    // Facts are tried in the order of the text, as soon as their catom is known, lowest fact first, neighbours by port.
    bool solve(const std::vector<check::Clause>& body, Environment& env, const std::function<bool()>& found);

    // In found(): the linear facts that this way consumes.
    const std::vector<Taken>& taken() const { return taken_; }
    // Some expression had no value. What the solver found meanwhile means little.
    bool failed() const { return failed_; }

  private:
    using Clauses = std::vector<const check::Clause*>;
    struct Deferred {
        const check::Term* term;
        Value value;
    };

    bool atoms(Clauses open, Environment& env, const std::function<bool()>& found);
    bool tests(Clauses open, Environment& env, const std::function<bool()>& found);
    bool run_tests(Clauses& open, Environment& env, std::vector<std::size_t>& bound);
    bool nothing_satisfies(const std::vector<check::Clause>& inner, Environment& env);
    Clauses::const_iterator next_atom(const Clauses& open, const Environment& env) const;
    bool readable(const check::Atom& atom, const Environment& env) const;
    std::vector<Row> candidates(const check::Atom& atom, const Environment& env) const;
    std::vector<Row> linked(const check::Atom& atom, const std::optional<Value>& place, const Environment& env) const;
    bool match(const check::Atom& atom, const Row& row, Environment& env, std::vector<std::size_t>& bound);
    bool holds(const check::Term& test, const Environment& env);

    const Program& program_;
    const Scene& scene_;
    const Facts& facts_;
    const std::vector<Bag>* linear_;
    std::vector<Taken> taken_;
    std::vector<Deferred> deferred_;  // Arguments that were expressions over variables not yet known.
    int negations_ = 0;               // Around the present body: what is matched there is not consumed.
    bool failed_ = false;
};

}  // namespace meld::reference
