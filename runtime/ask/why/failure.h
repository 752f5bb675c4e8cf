// Why a part of a body, within `not` or `forall`, is not as it should be.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "runtime/ask/why/explainer.h"

namespace meld::inspect {

bool all_bound(const check::Term& term, const Bound& bound);

// The fact that an atom asks for, as far as it is known. Nothing: it is there in another way, or its catom is not known.
std::optional<Known> missing_fact(Explainer& explainer, const check::Atom& atom, const Bound& bound, Values& values);

struct Failure {
    std::string note = {};
    std::optional<Known> missing = {};  // What comes after the note: a fact that is not there.
};
// What holds that must not; and if something must not hold beside it, as q(A) must in not (p(A), not q(A)), what of that fails. `forall
// p(A) [q(A)]` says the same.
Failure failure_of_absence(Explainer& explainer, const PartialMatch& match, const std::vector<check::Clause>& inner, const Values& values,
                           const Bound& bound);

}  // namespace meld::inspect
