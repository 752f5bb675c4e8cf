// The passes of the check in order.
#include "compiler/check/check.h"

#include "compiler/check/program/well_formed.h"

namespace meld::check {

Program check(const source::FileSet& files, syntax::Tree& tree, std::uint32_t prelude_files, diagnostics::Reporter& report, Worlds worlds,
              bool links_c) {
    Program program;
    program.worlds = worlds;
    program.links_c = links_c;
    merge_programs(tree, report);
    const bool threads = apply_threads(tree, report);
    expand_stable(tree, report);
    program.kinds = apply_node_kinds(tree, report) || threads;
    expand_type_names(tree, report);
    check_imports(tree, report);
    declare(tree, prelude_files, program, report);
    declare_aggregates(tree, program, report);
    resolve_values(tree, program, report);
    check_aggregate_parameters(program, report);
    resolve_rules(files, tree, program, report);
    refuse_hidden_senses(program, report);
    drop_repeated_atoms(program);
    refuse_random_views(program, report);
    find_sites(program, report);
    guard_programs(tree, program, report);
    check_bindings(program, report);
    stratify(program, report);
    if (!report.has_errors()) expect_well_formed(program);
    return program;
}

}  // namespace meld::check
