// Warnings that need reasoning and change nothing: parts of a program that can never matter, or may never end.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "compiler/check/program/program.h"
#include "compiler/diagnostics/diagnostics.h"
#include "compiler/syntax/tree.h"

namespace meld::lint {

// Acyclic: the facts of `link`, as the graph of a world gives them, lead in no circle.
enum class Graph { Any, Acyclic };

// The constants, functions and type names that the program declares and nothing uses, with the warnings for them. Reads the tree between
// check::separate_modules() and check::check(), which replaces names by their meaning. program_file: the file of the set that is the
// program; only its names are reported as unused.
std::vector<diagnostics::Diagnostic> find_unused_names(const source::FileSet& files, syntax::Tree& tree, std::uint32_t program_file);

// What is known of the world that a program is for.
struct Place {
    std::string lattice = {};  // "cubic"; empty: unknown.
    std::string ports = {};    // Whose numbers ports have; empty: nobody has said.
    Graph graph = Graph::Any;
};

// Warns about a program that check::check() has returned. If it reported errors, only about mistakes that do not follow from them.
void lint(const check::Program& program, std::uint32_t program_file, const std::vector<diagnostics::Diagnostic>& unused_names,
          const Place& place, diagnostics::Reporter& report);

// ---- the passes, one file each, in this order

// Variables used only once in a rule.
void warn_of_single_use(const check::Program& program, diagnostics::Reporter& report);
// Recursion that may not end: values that grow or improve through themselves, sums that feed themselves over links.
void warn_of_recursion(const check::Program& program, diagnostics::Reporter& report, Graph graph);
// Ports whose numbers and names are those of another robot's sides. Assumes that no error was reported.
void warn_of_ports(const check::Program& program, const Place& place, diagnostics::Reporter& report);
// Messages of one link whose order decides what happens, though they may arrive in one tick. Assumes that no error was reported.
void warn_of_arrival_order(const check::Program& program, diagnostics::Reporter& report);
// Rules that never fire, predicates that never hold or are never used, unused parameters. Assumes that no error was reported.
void warn_of_useless(const check::Program& program, std::uint32_t program_file, diagnostics::Reporter& report);

}  // namespace meld::lint
