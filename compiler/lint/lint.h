// Warnings that need reasoning and change nothing: what a program says that can never matter, or may never end.
#pragma once

#include <cstdint>
#include <vector>

#include "compiler/check/program.h"
#include "compiler/diagnostics/diagnostics.h"
#include "compiler/syntax/tree.h"

namespace meld::lint {

// Constants, functions and type names that the program declares and nothing uses: what to say of them. Reads the tree between
// check::separate_modules() and check::check(), which puts what names stand for in their place. program_file: the file of the set that
// is the program, of which alone it is said that something in it has no use.
std::vector<diagnostics::Diagnostic> find_unused_names(const source::FileSet& files, syntax::Tree& tree, std::uint32_t program_file);

// Warns of a program that check::check() has returned. Where it reported errors, only of what does not follow from them.
void lint(const check::Program& program, std::uint32_t program_file, const std::vector<diagnostics::Diagnostic>& unused_names,
          diagnostics::Reporter& report);

// ---- the passes, one file each, in this order

// Variables used once in a rule.
void warn_of_single_use(const check::Program& program, diagnostics::Reporter& report);
// Recursion that may not end: values that grow or improve through themselves, sums that feed themselves over links.
void warn_of_recursion(const check::Program& program, diagnostics::Reporter& report);
// Rules that never fire, predicates that never hold or are never used, parameters without a use. Assumes that no error was reported.
void warn_of_useless(const check::Program& program, std::uint32_t program_file, diagnostics::Reporter& report);

}  // namespace meld::lint
