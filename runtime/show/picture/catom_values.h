// What a body says of catoms: it is about the first of its variables that is a catom, and the value of a catom is that of the last other
// one, of several ways in the first.
#pragma once

#include <cstddef>
#include <optional>
#include <span>

#include "runtime/ask/query/table.h"

namespace meld::picture {

// Columns of its table.
struct CatomValues {
    // Holds: there is no value.
    enum class Kind { Holds, Whole, Real, Text };
    std::size_t catom = 0;
    std::optional<std::size_t> value = {};
    Kind kind = Kind::Holds;
};

// Nothing: no variable is a catom.
std::optional<CatomValues> catom_values(std::span<const inspect::Table::Column> columns);

}  // namespace meld::picture
