// Help for constructs of other languages: the equivalent in Meld.
#pragma once

#include <optional>
#include <string>

#include "compiler/syntax/syntax_error.h"

namespace meld::syntax {

// How to write an aggregate that is called like a function.
inline constexpr const char* kAggregateClause = "an aggregate is a clause of its own: `N = count : { p(A, _) }`, `S = sum X : { p(A, X) }`";

struct Cure {
    std::string help = {};
    std::optional<diagnostics::Fix> fix = {};
};

// The cure for a place where the grammar stopped; without help if the text is not of another language.
Cure cure_of_other_language(const Stop& stop);

}  // namespace meld::syntax
