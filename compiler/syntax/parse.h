// Text to syntax tree: tokens, grammar, includes.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "compiler/diagnostics/diagnostics.h"
#include "compiler/source/source.h"
#include "compiler/syntax/include_path.h"
#include "compiler/syntax/tree.h"

namespace meld::syntax {

struct ParseOptions {
    // Folders searched for an include after the folder of the including file, and for `use` before all others.
    std::vector<std::string> library_paths = {};
    // The libraries that are part of the compiler.
    std::vector<Library> libraries = {};
    // If false, the tree holds only the items of the file, and the files that an include or import names need not exist.
    bool follow_includes = true;
    // Which file of the set each include and import means, in the order of reading; none: a library of the compiler. Then nothing is
    // searched for or read from disk.
    std::optional<std::vector<std::optional<std::uint32_t>>> meant = {};
    // Files of the set with other programs of the same ensemble. Their names are those of the program.
    std::vector<std::uint32_t> programs = {};
    // C files are linked, which have the functions that `extern` declares. The parser does not care.
    bool links_c = false;
};

// One for each bit of Tree::programs_of.
constexpr std::size_t kMaxPrograms = 64;

// Brackets and operators nested deeper than this are refused, so that all code can walk a tree by recursion.
constexpr int kMaxNesting = 1000;

// Parses the file and everything it includes and uses: each module once, another file once in each of those that include it. Reports every
// mistake and continues after the next full stop, so the tree holds all items that could be read. An included file is taken from the
// FileSet if its path is there, otherwise read from disk. Other programs follow; what several of them include or use is read once.
// Cost: linear in the text.
Tree parse(source::FileSet& files, std::uint32_t file, diagnostics::Reporter& report, const ParseOptions& options = {});

// One line per token: place, kind, text. For `meldc --emit=tokens`.
std::string print_tokens(const source::FileSet& files, std::uint32_t file, diagnostics::Reporter& report);

// The tree as Meld text, one item per line; parsing the output gives the same tree. For `meldc --emit=ast`.
std::string print(const Tree& tree);
std::string print(const Expr& expr);
std::string print(const Rule& rule);
std::string print(const Declaration& declaration);
std::string print(const Type& type);

}  // namespace meld::syntax
