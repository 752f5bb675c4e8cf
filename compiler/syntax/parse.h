// Text to syntax tree: tokens, grammar, includes.
#pragma once

#include <string>

#include "compiler/diagnostics/diagnostics.h"
#include "compiler/source/source.h"
#include "compiler/syntax/tree.h"

namespace meld::syntax {

// Parses the file and what it includes (each file once). Reports every mistake and goes on after the next full stop, so
// the tree holds all items that could be read. Cost: linear in the text.
Tree parse(source::FileSet& files, std::uint32_t file, diagnostics::Reporter& report);

// One line per token: place, kind, text. For `meldc --emit=tokens`.
std::string print_tokens(const source::FileSet& files, std::uint32_t file, diagnostics::Reporter& report);

// The tree as Meld text, one item a line; parsing the output gives the same tree. For `meldc --emit=ast`.
std::string print(const Tree& tree);
std::string print(const Expr& expr);
std::string print(const Rule& rule);
std::string print(const Declaration& declaration);

}  // namespace meld::syntax
