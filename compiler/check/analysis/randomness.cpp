// Pass: random functions. A view holds while its body does, so its values must not be drawn again at each evaluation: random functions are
// for linear rules and for initial facts. Assumes resolved rules.
#include <algorithm>

#include "compiler/check/check.h"
#include "compiler/check/program/library.h"

namespace meld::check {

using diagnostics::Kind;

namespace {

enum class In { View, Question };

std::string reason(In in) { return in == In::View ? "a view would never become quiescent" : "a question is about what is there"; }

class Randomness {
  public:
    Randomness(Program& program, diagnostics::Reporter& report) : program_(program), report_(report) {}

    void run() {
        for (const Constant& c : program_.constants)
            if (c.computed.valid())
                refuse(program_.functions[c.computed].body, In::View,
                       fmt::format("the constant `{}` would never become quiescent", c.name));
        for (const Predicate& p : program_.predicates)
            if (p.fold.valid()) refuse_fold(p.fold, p.span);
        for (Rule& rule : program_.rules) {
            if (rule.linear) continue;
            const std::size_t errors = report_.error_count();
            check_body(rule.body, In::View);
            each_head(rule.heads, [&](const Head& h) {
                for (const Term& t : h.atom.arguments) refuse(t, In::View);
                refuse(h.term, In::View);
                check_body(h.body, In::View);
                for (const HeadAggregate& f : h.aggregates) {
                    refuse(f.parameter, In::View);
                    if (f.aggregate == Aggregate::Custom) refuse_fold(f.function, h.span);
                }
            });
            rule.refused = rule.refused || report_.error_count() > errors;
        }
        for (const Rule& question : program_.questions) check_body(question.body, In::Question);
    }

  private:
    void check_body(const std::vector<Clause>& body, In in) {
        for (const Clause& c : body) {
            if (c.aggregate == Aggregate::Custom) refuse_fold(c.fold, c.span);
            for (const Term& t : c.atom.arguments) refuse(t, in);
            refuse(c.test, in);
            check_body(c.inner, in);
        }
    }
    void refuse_fold(FunctionId fold, Span span) { refuse(Term{.op = Op::Call, .span = span, .function = fold}, In::View); }
    void refuse(const Term& term, In in) { refuse(term, in, reason(in)); }
    void refuse(const Term& term, In in, const std::string& why) {
        each_subterm(term, [&](const Term& t) {
            if ((t.op != Op::Library && t.op != Op::Call) || !is_random(program_, t)) return;
            const std::string& name = t.op == Op::Call ? program_.functions[t.function].name : t.text;
            const bool inside =
                std::any_of(t.operands.begin(), t.operands.end(), [&](const Term& operand) { return is_random(program_, operand); });
            if (!inside)
                report_.add(Kind::RandomInView, t.span, fmt::format("`{}` returns a different value each time, and {}", name, why)).help =
                    in == In::Question ? "leave it out" : "draw in a rule that consumes a linear fact, and keep the value in a fact";
        });
    }

    Program& program_;
    diagnostics::Reporter& report_;
};

}  // namespace

void refuse_random_views(Program& program, diagnostics::Reporter& report) { Randomness(program, report).run(); }

}  // namespace meld::check
