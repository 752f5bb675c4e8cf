// Rule plans to C++ text that is meant to be read: a function a rule, named after its head and line, with the rule as
// its comment, over plain arrays from the ABI header.
#pragma once

#include <cstdint>
#include <string>

#include "compiler/plan/plan.h"

namespace meld::emit {

// The text of the module. It includes "runtime/kernel/views.h", or "runtime/kernel/deltas.h" where it follows single rows.
std::string emit_module(const plan::Plan& plan);

// A hash of everything a running ensemble's columns depend on: predicates, fields, offsets. Two modules with the same
// one can read each other's state.
std::uint64_t schema_hash(const plan::Plan& plan);

}  // namespace meld::emit
