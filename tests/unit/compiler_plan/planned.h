// Programs as the planner leaves them.
#pragma once

#include <stdexcept>
#include <string>

#include "compiler/diagnostics/diagnostics.h"
#include "compiler/front/front_end.h"
#include "compiler/plan/plan.h"

namespace meld::plan {

inline Plan plan_of(const std::string& text) {
    source::FileSet files;
    diagnostics::Reporter report;
    const std::uint32_t prelude = front::add_prelude(files);
    const std::uint32_t file = files.add("planned.meld", text);
    front::ParsedProgram parsed = front::parse_program(files, file, prelude, report, {});
    check::Program checked = front::check_program(files, file, prelude, std::move(parsed), report);
    if (report.has_errors()) throw std::runtime_error("there are errors in\n" + text);
    return make_plan(std::move(checked));
}

}  // namespace meld::plan
