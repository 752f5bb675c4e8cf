// The passes of the check in order.
#include "compiler/check/check.h"

namespace meld::check {

Program check(const source::FileSet& files, syntax::Tree& tree, std::uint32_t prelude_files, std::uint32_t program_file,
              diagnostics::Reporter& report) {
    Program program;
    separate_modules(tree, prelude_files, report);
    const std::vector<diagnostics::Diagnostic> unused_names = find_unused_names(files, tree, program_file);
    expand_stable(tree, report);
    expand_type_names(tree, report);
    check_imports(tree, report);
    declare(tree, prelude_files, program, report);
    declare_aggregates(tree, program, report);
    resolve_values(tree, program, report);
    check_aggregate_parameters(program, report);
    resolve_rules(files, tree, program, report);
    refuse_random_views(program, report);
    find_homes(program, report);
    check_bindings(program, report);
    stratify(program, report);
    if (report.has_errors()) return program;
    warn_of_useless(program, program_file, report);
    for (const diagnostics::Diagnostic& d : unused_names) report.add(d);
    return program;
}

}  // namespace meld::check
