// What should hold when nothing changes any more: the rules applied to all facts at once, from nothing, stratum by
// stratum, until nothing is new.
#pragma once

#include <functional>

#include "tests/reference/evaluator/solver.h"

namespace meld::reference {

struct Model {
    Facts facts;
    bool failed = false;     // Some derivation has no value: it is left out.
    bool too_large = false;  // More than this slow evaluator can do: it gave up, and knows nothing.
    bool settled = true;     // False: the rounds did not end. The program has no model, or not by this way.
};

// given: facts from outside and those that linear rules have made. chosen: which of several possible facts the runtime has
// chosen where the language leaves it to history; taken if it is one of them, so that what follows from it is checked too.
// That is the value of `first`, and the payload of equal values of a recursive min or max, where the lowest rank
// wins. A choice that is not possible, or depends on itself, is not taken, and shows as a difference.
Model make_model(const Scene& scene, const Facts& given, const Facts& chosen);

// What was given or derived, and of which neighbours it is a contribution.
struct Derived {
    Row row;
    std::set<std::int64_t> from = {};
};
// The facts of one predicate, of all that was given or derived, with repeats. chosen: null where the language decides. facts: what
// it waits for is seen there. Returns false where a group is left out because its aggregate has no value.
bool reduce(const Scene& scene, const Facts& facts, const check::Predicate& p, const std::vector<Derived>& derived, const Rows* chosen,
            Rows& out);

// Whether one of several facts that a group may have is chosen by history.
bool left_to_history(const check::Predicate& p, const check::Stratum& stratum);

// Calls visit(made, variables) for everything the view rule makes at one catom, until it returns false. Returns whether all
// expressions met on the way had values; derivations with one that has none are left out.
bool derive(const check::Rule& rule, const Sight& sight, std::int64_t site, const std::function<bool(Derived, const Environment&)>& visit);

// The values of a head's arguments, or nothing where one has none.
std::optional<Row> head_row(const Scene& scene, const check::Atom& head, const Environment& env);

}  // namespace meld::reference
