// Text to syntax tree: tokens, grammar, includes.
#pragma once

#include <string>
#include <vector>

#include "compiler/diagnostics/diagnostics.h"
#include "compiler/source/source.h"
#include "compiler/syntax/include_path.h"
#include "compiler/syntax/tree.h"

namespace meld::syntax {

struct ParseOptions {
    // Folders where an include is looked for after the folder of the file that names it, and `use` before all others.
    std::vector<std::string> library_paths = {};
    // The libraries that are part of the compiler.
    std::vector<Library> libraries = {};
    // Without, the tree holds the items of the file alone, and what an include or import names need not exist.
    bool follow_includes = true;
};

// Brackets and operators nested deeper than this are refused, so that a tree can be walked by recursion everywhere.
constexpr int kMaxNesting = 1000;

// Parses the file and what it includes and uses: each module once, another file once in each of those that include it. Reports
// every mistake and goes on after the next full stop, so the tree holds all items that could be read. An included file is taken
// from the FileSet if its path is there, else read from disk. Cost: linear in the text.
Tree parse(source::FileSet& files, std::uint32_t file, diagnostics::Reporter& report, const ParseOptions& options = {});

// One line per token: place, kind, text. For `meldc --emit=tokens`.
std::string print_tokens(const source::FileSet& files, std::uint32_t file, diagnostics::Reporter& report);

// The tree as Meld text, one item a line; parsing the output gives the same tree. For `meldc --emit=ast`.
std::string print(const Tree& tree);
std::string print(const Expr& expr);
std::string print(const Rule& rule);
std::string print(const Declaration& declaration);
std::string print(const Type& type);

}  // namespace meld::syntax
