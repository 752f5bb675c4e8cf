// What rests on what in a recursion at one catom, where nothing is stored for it: the rounds of a computation from nothing.
#pragma once

#include <map>
#include <string>
#include <tuple>

#include "runtime/ask/why/explainer.h"

namespace meld::inspect {

class Rounds {
  public:
    explicit Rounds(Explainer& explainer) : e_(explainer) {}

    // By the text of each fact of the recursion at the catom: the round in which it can first be derived from those of the rounds before.
    using ByFact = std::map<std::string, std::size_t>;
    const ByFact& of(const check::Stratum& recursion, u64 catom, std::size_t age);

  private:
    Explainer& e_;
    std::map<std::tuple<const check::Stratum*, u64, std::size_t>, ByFact> known_;
};

}  // namespace meld::inspect
