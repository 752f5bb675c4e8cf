// Which facts of a recursion another one may rest on: those of lower rank. So an explanation is finite.
#pragma once

#include <functional>

#include "runtime/ask/why/explainer.h"
#include "runtime/ask/why/rounds.h"

namespace meld::inspect {

class LowerRanks {
  public:
    explicit LowerRanks(Explainer& explainer) : e_(explainer), rounds_(explainer) {}

    // Whether an atom of the body may be matched by a fact, if the body gives `head`; both outlive the answer. Empty: by any.
    using Allowed = std::function<bool(const check::Clause&, const Fact&)>;
    Allowed than(const PartialMatch& match, const Known& head);

  private:
    Explainer& e_;
    Rounds rounds_;
};

}  // namespace meld::inspect
