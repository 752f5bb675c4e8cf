// Help for constructs of other languages: the equivalent in Meld.
#pragma once

#include <string>

#include "compiler/syntax/syntax_error.h"

namespace meld::syntax {

// The help for a place where the grammar stopped; empty if the text is not of another language.
std::string cure_of_other_language(const Stop& stop);

}  // namespace meld::syntax
