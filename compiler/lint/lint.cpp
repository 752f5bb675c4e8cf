// The passes of the lint in order.
#include "compiler/lint/lint.h"

namespace meld::lint {

void lint(const check::Program& program, std::uint32_t program_file, const std::vector<diagnostics::Diagnostic>& unused_names,
          const Place& place, diagnostics::Reporter& report) {
    const bool errors = report.has_errors();
    warn_of_single_use(program, report);
    warn_of_recursion(program, report, place.graph);
    if (errors) return;
    warn_of_ports(program, place, report);
    warn_of_arrival_order(program, report);
    warn_of_useless(program, program_file, report);
    for (const diagnostics::Diagnostic& d : unused_names) report.add(d);
}

}  // namespace meld::lint
