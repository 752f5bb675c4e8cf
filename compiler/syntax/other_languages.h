// What people write who know another language: what it is called here.
#pragma once

#include <string>

#include "compiler/syntax/syntax_error.h"

namespace meld::syntax {

// The help for a place where the grammar stopped; empty where the text is of no other language.
std::string cure_of_other_language(const Stop& stop);

}  // namespace meld::syntax
