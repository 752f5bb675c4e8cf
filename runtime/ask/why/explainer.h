// What `why` and `why-not` share: rules whose heads fit a fact, in which states their bodies are looked up, and all of it as text.
#pragma once

#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "runtime/ask/facts/facts.h"
#include "runtime/ask/query/solver.h"
#include "runtime/ask/query/terms.h"
#include "runtime/ask/why/existence.h"
#include "runtime/ask/why/explanation.h"
#include "runtime/ask/why/partial_match.h"

namespace meld::inspect {

// States of one run, as a question has them: this tick, the one before, and so on.
struct States {
    std::span<Facts* const> facts;
    std::int64_t tick = 0;        // Of the first.
    std::int64_t first_tick = 0;  // There is nothing before it.
    bool settled = false;         // The run is quiet: the tick before was like this one.
    u32 latency = 1;              // Of links, at most, in ticks.
    bool apart = false;           // What a catom reads of its neighbours is what has come over their links.
};

class Explainer {
  public:
    Explainer(const Program& program, const States& states, Terms& terms);

    const check::Program& checked() const { return program_.checked(); }
    const check::Predicate& predicate(check::PredicateId id) const { return checked().predicates[id]; }
    const States& states() const { return states_; }
    Facts& facts(std::size_t age) { return *states_.facts[age]; }

    // dist(@42, 7), with _ for what is open.
    std::string text(const Known& fact);
    std::string value_text(const check::Type& type, Value v);
    // Copies what lives only as long as a search.
    Known keep(check::PredicateId predicate, const Fact& fact, std::size_t age);
    Value keep(const check::Type& type, Value v);

    // The fact that the question's body asks for: an atom, and what its arguments are. Errors: it asks for something else.
    Result<Known> asked();
    // Whether the question says more of that fact than values of its arguments: a test, or that two of them are equal.
    bool asks_more();
    // All facts that match it, until `visit` says false.
    Result<void> each_match(const std::function<bool(const Known&)>& visit);
    // Whether a fact holds in the state of its age; its rank then.
    std::optional<u32> holds(const Known& fact);
    // The same among the facts of another source.
    std::optional<u32> holds_in(const Source& source, const Known& fact);

    // The rules that derive facts of a predicate: its views as the program states them, its views as the run evaluates them, and the linear
    // rules with such a head.
    std::vector<const check::Rule*> views(check::PredicateId id) const;
    const std::vector<const check::Rule*>& derivations(check::PredicateId id) const { return existence_.views(id); }
    std::vector<const check::Rule*> linear_rules(check::PredicateId id) const;
    std::optional<PartialMatch> match_head(const check::Rule& rule, const check::Atom& head, const Known& fact, bool solve,
                                           const std::vector<check::Clause>& more = {}) {
        return inspect::match_head(program_, terms_, rule, head, fact, solve, more);
    }
    std::string cannot(const std::vector<check::Clause>& body) const { return inspect::cannot(program_, body); }

    // How many ticks before its head's evaluation each atom of a body is read: one for each link in between. `spread`: where facts were
    // read; otherwise all in one state.
    std::size_t age_of(const PartialMatch& match, const check::Clause& clause, bool spread) const;
    std::size_t linear_age(const check::Clause& clause) const { return predicate(clause.atom.predicate).linear() ? 1 : 0; }
    // Searches the body in states of this age and before. False: it needs states that there are not, which `wanted` then counts.
    struct Search {
        std::size_t age = 0;
        bool spread = false;
        // Instead: of the neighbours of the catom where the rule runs, what had come to it when it was evaluated for the state of this age.
        bool as_heard = false;
        bool linear_before = false;  // Linear facts are those of the tick before, which linear rules have taken since.
        std::function<bool(const check::Clause&, const Fact&)> allowed = {};
        // Of the head, if it is in one: there the facts of fronts are read.
        const check::Stratum* recursion = nullptr;
        Attempt* best = nullptr;
        std::function<void(const Attempt&)> further = {};
    };
    Result<bool> search(const PartialMatch& match, const Search& how, const Solver::Found& found);
    // A part of a body alone, with what is bound.
    Result<void> search_part(const PartialMatch& match, const std::vector<check::Clause>& part, Values values, Bound bound,
                             const Search& how, const Solver::Found& found);
    // How many states before the first were asked for and are not there.
    std::size_t wanted() const { return wanted_; }
    // Whether something would have to be looked up before the first tick.
    bool before_the_first() const { return before_the_first_; }

    // Whether an atom asks only whether a group of an aggregate has a value, where the run keeps that apart.
    bool asks_existence(const PartialMatch& match, const check::Clause& clause, const check::Stratum* recursion) const {
        return recursion != nullptr && existence_.asks(*match.of, match.body, match.bound, match.open, clause);
    }
    const Existence& existence() const { return existence_; }
    // A copy of the rule whose variables are named by their values.
    check::Rule named(const PartialMatch& match, const Values& values, const Bound& bound);
    std::string print(const check::Rule& named, const std::vector<check::Clause>& clauses) const;
    std::string print(const check::Rule& named, const check::Clause& clause) const { return check::print(checked(), named, clause); }
    Explanation::Way way_of(const check::Rule& rule) const;
    // The rule's variables that have a value, and it.
    std::vector<std::pair<std::string, std::string>> with(const PartialMatch& match, const Values& values, const Bound& bound);

    // Where facts of a predicate that are given are; nothing: rules derive all of them.
    std::optional<Source> base_of(check::PredicateId id) const;
    // Whether a fact is given from outside, or made by a linear rule.
    bool is_base(const Known& fact);
    // Where its facts have ranks: its front, if it keeps one.
    Source ranked_source(check::PredicateId id) const;
    // The stratum of recursion; nothing: it is in none.
    const check::Stratum* recursion_of(check::PredicateId id) const;

    const Program& program() const { return program_; }
    Terms& terms() { return terms_; }

  private:
    void find_fronts();
    // The source of `neighbor`.
    Source links() const;
    // The facts of a state as the catom where a rule runs has heard those of its neighbours.
    Facts& as_heard(Facts& facts, u64 by);
    // Whether it is before the first tick, so that no catom has told others anything.
    bool told_nothing(std::size_t age) const;
    // Of facts that point from catom to catom: whether a link was between these two when the nearer one read what the other had told.
    // Nothing: the body has none.
    std::function<bool(const check::Clause&, const Fact&)> readable(const PartialMatch& match, const Search& how);
    // Whether there are as many facts as a linear rule must match: what it consumes, no other atom of its body does.
    bool are_different(const PartialMatch& match, const Solution& solution, const std::function<Facts&(const check::Clause&)>& from);
    std::map<check::VariableId, std::size_t> distances(const PartialMatch& match) const;

    const Program& program_;
    States states_;
    Terms& terms_;
    Solver solver_;
    tuple::Arena lists_;
    std::map<u32, u32> fronts_;                        // Of the module's predicates.
    std::vector<std::unique_ptr<Facts>> with_fronts_;  // Of each state, if there are fronts.
    Existence existence_;
    std::vector<std::unique_ptr<Facts>> groups_;  // Of each state, if existence is kept apart.
    std::map<std::pair<Facts*, u64>, std::unique_ptr<Facts>> heard_;
    std::size_t wanted_ = 0;
    bool before_the_first_ = false;
};

}  // namespace meld::inspect
