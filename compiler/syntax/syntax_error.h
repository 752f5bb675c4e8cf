// Explains in plain words why the grammar could not continue.
#pragma once

#include <vector>

#include "compiler/diagnostics/diagnostics.h"
#include "compiler/syntax/tokens.h"

namespace meld::syntax {

// The help for an unknown word after `@`.
inline constexpr const char* kBehindAt =
    "behind `@` stands the number of a catom, @7, a run argument, @arg1 to @arg9, or @world, the number of catoms";

// The place where the grammar stopped: the item starts at `begin`, the token at `at` fits nowhere, and one of `expected` would fit.
struct Stop {
    const std::vector<Token>& tokens;
    std::size_t begin;
    std::size_t at;
    const std::vector<TokenKind>& expected;
    bool next_starts_item;  // The token behind it looks like the start of another item, or there is none.
};

void report_syntax_error(const Stop& stop, diagnostics::Reporter& report);
// The item that starts at `begin` should have ended before the token at `at`.
void report_missing_period(const std::vector<Token>& tokens, std::size_t begin, std::size_t at, diagnostics::Reporter& report);

}  // namespace meld::syntax
