// The heads of a rule, one by one, with what must hold around each beside the rule's body.
#pragma once

#include <functional>
#include <vector>

#include "compiler/check/program/program.h"

namespace meld::inspect {

struct HeadWithin {
    const check::Head& head;
    // The bodies of comprehensions, its own among them, the conditions and the values that are given names.
    const std::vector<check::Clause>& around;
    // It stands behind an aggregate of heads, and may depend on a result of it, which no clause says.
    bool of_results = false;
};
void each_head_within(const check::Rule& rule, const std::function<void(const HeadWithin&)>& visit);

}  // namespace meld::inspect
