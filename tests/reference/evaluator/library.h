// The library's functions on numbers, lists, sets, arrays and strings, as their descriptions say. Not those that give
// floats whose last digits are a matter of the mathematics library, nor chance.
#pragma once

#include <optional>

#include "tests/reference/evaluator/value.h"

namespace meld::reference {

// Nothing: the function has no value for these arguments, or is not one of those above.
std::optional<Value> call_library(const std::string& name, const Values& arguments);

}  // namespace meld::reference
