// The pieces of the printer that several of its files need.
#pragma once

#include <string>
#include <string_view>

#include "compiler/syntax/tree.h"

namespace meld::syntax {

std::string print_clause(const Clause& clause);
std::string print_head(const HeadItem& head);
// "+", "<>", "&&".
std::string_view spelling(BinaryOp op);
// A text in quotes with its escapes.
std::string quoted_text(std::string_view text);
// The shortest digits that read back as the same number, without an exponent: 0.25, 3.
std::string plain_decimal(double value);

}  // namespace meld::syntax
