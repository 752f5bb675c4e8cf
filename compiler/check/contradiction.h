// Conditions of a body that cannot all be true.
#pragma once

#include <optional>

#include "compiler/check/program.h"

namespace meld::check {

struct Contradiction {
    const Term* test = nullptr;  // Never true ...
    const Term* with = nullptr;  // ... together with this; null where it is so alone.
};

// The first condition of the rule's body that cannot be true, by itself or with others: of what lies between literals, of
// two terms that are compared in two ways, of texts. Constants are no literals, for --set gives them other values.
std::optional<Contradiction> contradiction(const Program& program, const Rule& rule);

}  // namespace meld::check
