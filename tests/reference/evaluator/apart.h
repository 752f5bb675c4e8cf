// What tells derivations by one rule apart where each of them counts.
#pragma once

#include <vector>

#include "tests/reference/evaluator/bodies.h"

namespace meld::reference {

// The rule with variables for facts that differ only in what it does not look at, and for the places of elements in lists.
check::Rule told_apart(const check::Rule& rule);

// A head that waits. One of its derivations is known again by the facts of the body, the places of elements, and what the head is; what is
// computed beside these may change meanwhile.
class Apart {
  public:
    Apart(const check::Program& program, const HeadOf& head);
    Apart(const Apart&) = delete;
    Apart& operator=(const Apart&) = delete;

    // The head, with a variable for each of these.
    const HeadOf& head() const { return head_; }
    // Their values.
    Environment known(const Environment& env) const;

  private:
    check::Rule rule_;
    HeadOf head_;
    std::vector<check::VariableId> known_by_;
};

}  // namespace meld::reference
