// Variables that a rule uses once, as counted by the check: often a slip of the pen.
#include <set>
#include <utility>

#include "compiler/lint/lint.h"

namespace meld::lint {

using namespace check;
using diagnostics::Kind;

void warn_of_single_use(const Program& program, diagnostics::Reporter& report) {
    // The heads of a view are rules of their own: what is wrong with one says why the other has no use for a variable.
    using Place = std::pair<std::uint32_t, std::uint32_t>;
    std::set<Place> refused, errors;
    for (const Rule& rule : program.rules)
        if (rule.refused) refused.emplace(rule.span.file, rule.span.begin);
    // What is wrong in the text of a rule may have been the other use.
    if (report.has_errors())
        for (const diagnostics::Diagnostic& d : report.sorted())
            if (info(d.kind).severity == diagnostics::Severity::Error) errors.emplace(d.span.file, d.span.begin);
    const auto wrong = [&](const Rule& rule) {
        const auto first = errors.lower_bound({rule.span.file, rule.span.begin});
        return refused.contains({rule.span.file, rule.span.begin}) ||
               (first != errors.end() && *first < Place{rule.span.file, rule.span.end});
    };
    for (const Rule& rule : program.rules) {
        // A variable that stands once in a rule is often a slip of the pen; `_` or `_Name` says it is meant.
        if (rule.used_once.empty() || wrong(rule)) continue;
        for (const VariableId v : rule.used_once)
            report.add(Kind::SingleUse, rule.variables[v].span, fmt::format("`{}` is used once in this rule", rule.variables[v].name))
                .help = "write `_` if any value will do";
    }
}

}  // namespace meld::lint
