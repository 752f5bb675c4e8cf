// Expressions of a checked rule under given values of its variables.
#pragma once

#include <optional>

#include "scene.h"

namespace meld::reference {

// By VariableId: what is bound.
using Environment = std::vector<std::optional<Value>>;

bool all_bound(const check::Term& term, const Environment& env);

// The value of a term whose variables are all bound. Nothing: an arithmetic error, which stops a run: overflow, division by
// zero, a conversion that has no result.
std::optional<Value> evaluate(const Scene& scene, const check::Term& term, const Environment& env);

}  // namespace meld::reference
