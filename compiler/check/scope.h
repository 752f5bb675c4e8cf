// The variables of one rule and the typing of its expressions. Used by pass 2 only.
#pragma once

#include <map>
#include <string>

#include "compiler/check/program.h"
#include "compiler/diagnostics/diagnostics.h"
#include "compiler/syntax/tree.h"

namespace meld::check {

// Names of the whole program, made once.
struct Names {
    std::map<std::pair<std::string, std::size_t>, PredicateId> predicates;
    std::map<std::string, ConstantId> constants;
    // What the tree lost to syntax errors: not known, and not to be missed.
    const syntax::Tree& tree;
    Names(const Program& program, const syntax::Tree& tree);
};

class Scope {
  public:
    Scope(const Program& program, const Names& names, Rule& rule, diagnostics::Reporter& report, bool lower_case_variables)
        : program_(program), names_(names), rule_(rule), report_(report), lower_case_variables_(lower_case_variables) {}

    // The variable of this name, made on first use.
    VariableId variable(const std::string& name, Span span);
    VariableId fresh(const std::string& name, const Type& type, Span span);
    // The name, if the expression is nothing but a variable; a lower-case name that is no constant counts in original Meld.
    const std::string* variable_name(const syntax::Expr& e) const;
    // The type of an expression as far as it is known by now, silently.
    Type infer(const syntax::Expr& e) const;
    // The typed term; `wanted` is what the place needs (Type::Error: anything). Reports what does not fit.
    Term resolve(const syntax::Expr& e, const Type& wanted, const std::string& where, bool anonymous_fits = false);
    // Converts int to float where that is wanted; reports other differences.
    Term convert(Term term, const Type& wanted, const std::string& where);

  private:
    Term untyped(const syntax::Expr& e);
    Term name_or_call(const syntax::Call& call, Span span);
    Term unary(const syntax::Unary& u, Span span);
    Term binary(const syntax::Binary& b, Span span);
    Term conditional(const syntax::Conditional& c, Span span);
    Term unsupported(Span span, const std::string& what);
    static bool compatible(const Type& a, const Type& b);

    const Program& program_;
    const Names& names_;
    Rule& rule_;
    diagnostics::Reporter& report_;
    bool lower_case_variables_;
    std::map<std::string, VariableId> variables_;
};

}  // namespace meld::check
