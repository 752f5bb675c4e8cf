// Variables that a rule uses once, as the check has counted them: often a slip of the pen.
#include <set>
#include <utility>

#include "compiler/lint/lint.h"

namespace meld::lint {

using namespace check;
using diagnostics::Kind;

void warn_of_single_use(const Program& program, diagnostics::Reporter& report) {
    // The heads of a view are rules of their own: what is wrong with one says why the other has no use for a variable.
    std::set<std::pair<std::uint32_t, std::uint32_t>> refused;
    for (const Rule& rule : program.rules)
        if (rule.refused) refused.emplace(rule.span.file, rule.span.begin);
    for (const Rule& rule : program.rules) {
        // A variable that stands once in a rule is often a slip of the pen; `_` or `_Name` says it is meant.
        for (const VariableId v : rule.used_once)
            if (!refused.contains({rule.span.file, rule.span.begin}))
                report.add(Kind::SingleUse, rule.variables[v].span, fmt::format("`{}` is used once in this rule", rule.variables[v].name))
                    .help = "write `_` if any value will do";
    }
}

}  // namespace meld::lint
