// Rule plans to readable C++ text: one function per rule, named after its head and line, with the rule as its comment, over plain arrays
// from the ABI header.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "compiler/plan/plan.h"

namespace meld::emit {

// The text of the module. It includes "runtime/module/kernel/views.h", or "runtime/module/kernel/deltas.h" if it has delta rules.
std::string emit_module(const plan::Plan& plan);

// A module that is compiled in pieces: declarations that all parts see, and parts, each of which holds what is likely to change with one
// rule, and stays the same when rules of other heads come and go.
struct ModulePart {
    std::string name;
    std::string text;
    // Rules of the program, functions of the kernel for its row types, or data, which change with every line.
    enum class Kind { Rules, Kernel, Tables } kind = Kind::Rules;
};
struct ModuleParts {
    std::string shared;
    std::vector<ModulePart> parts;
};
// How many functions a plan has of its rules: by it, a module counts as very long.
std::size_t functions_of_rules(const plan::Plan& plan);
// Gives the rules names that let the module be emitted for compilation in pieces.
void name_for_pieces(plan::Plan& plan);
ModuleParts emit_parts(const plan::Plan& plan);

// A hash of everything that the columns of a running ensemble depend on: predicates, fields, offsets. Two modules with the same hash can
// read each other's state.
std::uint64_t schema_hash(const plan::Plan& plan);

}  // namespace meld::emit
