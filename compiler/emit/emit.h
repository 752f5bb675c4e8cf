// Rule plans to readable C++ text: one function per rule, named after its head and line, with the rule as its comment, over plain arrays
// from the ABI header.
#pragma once

#include <cstdint>
#include <string>

#include "compiler/plan/plan.h"

namespace meld::emit {

// The text of the module. It includes "runtime/module/kernel/views.h", or "runtime/module/kernel/deltas.h" if it has delta rules.
std::string emit_module(const plan::Plan& plan);

// A hash of everything that the columns of a running ensemble depend on: predicates, fields, offsets. Two modules with the same hash can
// read each other's state.
std::uint64_t schema_hash(const plan::Plan& plan);

}  // namespace meld::emit
