// Variables that a rule uses once, as counted by the check: often a slip of the pen.
#include <algorithm>
#include <set>
#include <utility>

#include "compiler/lint/lint.h"

namespace meld::lint {

using namespace check;
using diagnostics::Kind;

namespace {

// Whether it stands as an argument of a fact, where `_` can stand. Elsewhere, as in X = 1, it needs a name.
bool is_argument(const std::vector<Clause>& body, VariableId v) {
    return std::any_of(body.begin(), body.end(), [&](const Clause& c) {
        return is_argument(c.inner, v) || std::any_of(c.atom.arguments.begin(), c.atom.arguments.end(),
                                                      [&](const Term& t) { return t.is_variable() && t.variable == v; });
    });
}

// Whether its name says what a rule aggregate works on: it stands in more places than it is used in.
bool is_aggregated(const std::vector<Head>& heads, VariableId v) {
    return std::any_of(heads.begin(), heads.end(), [&](const Head& h) {
        return is_aggregated(h.heads, v) || is_aggregated(h.others, v) ||
               std::any_of(h.aggregates.begin(), h.aggregates.end(),
                           [&](const HeadAggregate& one) { return one.each == v || one.result == v; });
    });
}

}  // namespace

void warn_of_single_use(const Program& program, diagnostics::Reporter& report) {
    // The heads of a view are rules of their own: what is wrong with one says why the other has no use for a variable.
    using Where = std::pair<std::uint32_t, std::uint32_t>;
    std::set<Where> refused, errors;
    for (const Rule& rule : program.rules)
        if (rule.refused) refused.emplace(rule.span.file, rule.span.begin);
    // What is wrong in the text of a rule may have been the other use.
    if (report.has_errors())
        for (const diagnostics::Diagnostic& d : report.sorted())
            if (info(d.kind).severity == diagnostics::Severity::Error) errors.emplace(d.span.file, d.span.begin);
    const auto wrong = [&](const Rule& rule) {
        const auto first = errors.lower_bound({rule.span.file, rule.span.begin});
        return refused.contains({rule.span.file, rule.span.begin}) ||
               (first != errors.end() && *first < Where{rule.span.file, rule.span.end});
    };
    for (const Rule& rule : program.rules) {
        // A variable that stands once in a rule is often a slip of the pen; `_` or `_Name` says it is meant.
        if (rule.used_once.empty() || wrong(rule)) continue;
        for (const VariableId v : rule.used_once) {
            const Variable& once = rule.variables[v];
            auto& d = report.add(Kind::SingleUse, once.span, fmt::format("`{}` is used once in this rule", once.name));
            d.help = "write `_` if any value will do";
            if (!is_aggregated(rule.heads, v)) d.fixes = {diagnostics::write(once.span, is_argument(rule.body, v) ? "_" : "_" + once.name)};
        }
    }
}

}  // namespace meld::lint
