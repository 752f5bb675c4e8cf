#include "runtime/ask/why/heads.h"

#include <utility>

namespace meld::inspect {

using check::Clause;
using check::Head;
using check::Op;
using check::Term;
using check::Type;

namespace {

Clause test_of(Op op, std::vector<Term> operands, source::Span span) {
    Clause out{.kind = Clause::Kind::Test, .span = span};
    out.test = {.op = op, .type = Type::Bool, .span = span};
    out.test.operands = std::move(operands);
    return out;
}

void each_of(const check::Rule& rule, const std::vector<Head>& heads, const std::vector<Clause>& around, bool of_results,
             const std::function<void(const HeadWithin&)>& visit) {
    for (const Head& h : heads) {
        std::vector<Clause> more = around, otherwise = around;
        more.insert(more.end(), h.body.begin(), h.body.end());
        visit({h, more, of_results});
        if (h.kind == Head::Kind::If) {
            more.push_back({.kind = Clause::Kind::Test, .test = h.term, .span = h.span});
            otherwise.push_back(test_of(Op::Not, {h.term}, h.span));
        }
        if (h.kind == Head::Kind::Set && h.term.op != Op::Fresh) {
            Term variable{.op = Op::Variable, .type = rule.variables[h.variable].type, .span = h.span};
            variable.variable = h.variable;
            more.push_back(test_of(Op::Equal, {std::move(variable), h.term}, h.span));
        }
        each_of(rule, h.heads, more, of_results, visit);
        each_of(rule, h.others, otherwise, of_results || h.kind == Head::Kind::Aggregate, visit);
    }
}

}  // namespace

void each_head_within(const check::Rule& rule, const std::function<void(const HeadWithin&)>& visit) {
    each_of(rule, rule.heads, {}, false, visit);
}

}  // namespace meld::inspect
