// Syntax tree to checked program: declare, resolve and type rules, bind variables, find execution sites, stratify.
#pragma once

#include "compiler/check/program/program.h"
#include "compiler/diagnostics/diagnostics.h"
#include "compiler/syntax/tree.h"

namespace meld::check {

// Checks the tree (prelude first, then the program) after separate_modules(), and reports every mistake it finds; compiler/lint reports
// constructs that are correct but make no sense. The result is complete only if no error was reported; it is safe to print in any case.
// Names in the tree are replaced by their meaning. prelude_files: how many files of the set are ours.
Program check(const source::FileSet& files, syntax::Tree& tree, std::uint32_t prelude_files, diagnostics::Reporter& report,
              Worlds worlds = Worlds::Undecided, bool links_c = false);

// ---- the passes, one file each, in this order

// Modules: names of a module become `module-name`, imported names the names of what they import. Rules that use names which their module
// does not export are reported and left out.
void separate_modules(syntax::Tree& tree, std::uint32_t prelude_files, diagnostics::Reporter& report);
// Several programs in one tree: what more than one of them declares is kept once; declarations that differ are reported.
void merge_programs(syntax::Tree& tree, diagnostics::Reporter& report);
// Facts of threads become facts of nodes. Returns whether there are any.
bool apply_threads(syntax::Tree& tree, diagnostics::Reporter& report);
// `stable(p(A), 5)` in bodies: each becomes an atom of a predicate that holds when p has held for that long.
void expand_stable(syntax::Tree& tree, diagnostics::Reporter& report);
// Kinds of nodes: facts of the text for every node are those for every node of the kind that their predicates want. Returns whether there
// are kinds.
bool apply_node_kinds(syntax::Tree& tree, diagnostics::Reporter& report);
// Type names: each becomes the type it stands for, `list int` for `vector`, `node` for a kind of nodes.
void expand_type_names(syntax::Tree& tree, diagnostics::Reporter& report);
// Imports that repeat a declaration must agree with it.
void check_imports(const syntax::Tree& tree, diagnostics::Reporter& report);
// Predicates, constants and functions from declarations, the latter two by name and type. Sensed and action predicates must be
// known to the prelude.
void declare(const syntax::Tree& tree, std::uint32_t prelude_files, Program& program, diagnostics::Reporter& report);
// Aggregates of declared predicates, with the functions and links they name.
void declare_aggregates(const syntax::Tree& tree, Program& program, diagnostics::Reporter& report);
// Constants that give the number of values an aggregate keeps are ints. Assumes resolve_values().
void check_aggregate_parameters(const Program& program, diagnostics::Reporter& report);
// Constants and the bodies of functions: names to ids, types, values.
void resolve_values(const syntax::Tree& tree, Program& program, diagnostics::Reporter& report);
// Rules: names to ids, types of all terms, implicit conversions; heads of views are split into one rule each.
void resolve_rules(const source::FileSet& files, const syntax::Tree& tree, Program& program, diagnostics::Reporter& report);
// Bodies of views: an atom that stands there twice is dropped once.
void drop_repeated_atoms(Program& program);
// A predicate in the place of a sensed one that rules read and none derives.
void refuse_hidden_senses(Program& program, diagnostics::Reporter& report);
// Random functions may be used only in linear rules.
void refuse_random_views(Program& program, diagnostics::Reporter& report);
// Range restriction: every variable of a head, negation or test has a value.
void check_bindings(Program& program, diagnostics::Reporter& report);
// Execution sites: which catom a rule runs at, and whether links connect the others to it.
void find_sites(Program& program, diagnostics::Reporter& report);
// Several programs in one tree: each rule asks whether its catom runs the program that the rule is of. Assumes execution sites.
void guard_programs(const syntax::Tree& tree, Program& program, diagnostics::Reporter& report);
// Strata in order, recursion through negation and aggregates.
void stratify(Program& program, diagnostics::Reporter& report);
}  // namespace meld::check
