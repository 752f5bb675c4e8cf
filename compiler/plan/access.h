// How an atom or the elements of a list would be read at one point of a body, and at what cost: the one decision that the join order
// follows and --explain-rules prints.
#pragma once

#include <optional>
#include <utility>
#include <vector>

#include "compiler/plan/plan.h"

namespace meld::plan {

// What is known at a point of a body.
struct Known {
    Variables values;  // By value.
    Variables places;  // As the execution site or a direct neighbour.

    bool has(VariableId v) const { return values.contains(v) || places.contains(v); }
    // Whether all variables of the term are known.
    bool has(const Term& term) const;
};

// How a clause can be read.
struct Access {
    Reason reason = Reason::Rows;
    // Why the previous step goes to the neighbour where the atom is read; only if that neighbour is new.
    Reason link = Reason::Links;
    std::size_t known = 0;  // Of the arguments after the catom.
    int cost = 0;           // Lower is sooner; comparable only with the costs of other clauses.
};

class AccessPlanner {
  public:
    // `growing`: the predicates that get rows while the rule is evaluated, round by round, if any do.
    AccessPlanner(const Plan& plan, const check::Rule& rule, std::vector<PredicateId> growing = {})
        : plan_(plan), rule_(rule), growing_(std::move(growing)) {}

    // How the clause is read when `known` is known; nothing: it cannot be read yet, or it does not read.
    std::optional<Access> access(const check::Clause& clause, const Known& known) const;
    // Whether the clause iterates over facts or elements: all but tests, negations and aggregates.
    static bool reads(const check::Clause& clause);
    // Whether the atom is of neighbor/2 or neighbor/3.
    bool is_link(const check::Atom& atom) const;

  private:
    std::optional<Access> of_atom(const check::Atom& atom, const Known& known) const;
    std::optional<Access> of_link(const check::Atom& atom, const Known& known) const;

    const Plan& plan_;
    const check::Rule& rule_;
    std::vector<PredicateId> growing_;
};

}  // namespace meld::plan
