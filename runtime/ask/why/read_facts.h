// The facts that a solution of a body has read, and those of them that an explanation shows.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "runtime/ask/why/explainer.h"

namespace meld::inspect {

// What is bound and has been looked at: not what stands behind a group of which it is asked only whether it has a value.
Bound looked_at(const Explainer& explainer, const PartialMatch& match, Bound bound, const Explainer::Search& search);
// The fact that an atom has read; of what it asks only whether there is one, the value stays open.
Known read_by(Explainer& explainer, const PartialMatch& match, const check::Clause& atom, const Fact& fact, std::size_t age,
              const Explainer::Search& search);
// The oldest tick that a part of a body is read in, if it is not that of the answer.
std::optional<std::int64_t> oldest_tick(const Explainer& explainer, const PartialMatch& match, const check::Clause& part,
                                        const Explainer::Search& search);
// Whether a test says of a value only what it is.
bool says_nothing(const Explainer& explainer, const check::Rule& named, const check::Clause& test);

// The facts of a group that are given from outside or made by linear rules, as text; of the group the arguments before the value are known.
std::vector<std::string> given_to(Explainer& explainer, const Known& group);
// A question as the body of a rule, with this catom as that of its first fact; its last parts only say which way it is.
PartialMatch at_catom(const check::Rule& question, u64 catom, std::size_t last_parts);

}  // namespace meld::inspect
