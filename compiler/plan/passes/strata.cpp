// Pass: strata. Finds the strongly connected components of the predicates again, including those that earlier passes have made, and splits
// those that recur along a tree (trees.cpp). The strata are evaluated in order.
#include "compiler/check/check.h"
#include "compiler/plan/plan.h"

namespace meld::plan {

void find_strongly_connected(check::Program& program) {
    program.strata.clear();
    diagnostics::Reporter report;
    check::stratify(program, report);
    // An error would be new: a pass has made a program that cannot be stratified from one that could.
    for (const diagnostics::Diagnostic& d : report.sorted())
        MELD_CHECK(false, "{} at {}: {}", diagnostics::info(d.kind).name, d.span.begin, d.message);
}

void find_strata(check::Program& program) {
    find_strongly_connected(program);
    split_trees(program);
}

}  // namespace meld::plan
