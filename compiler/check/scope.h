// The variables of one rule, function or constant, and the typing of its expressions. Used by the passes that resolve them.
#pragma once

#include <map>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "compiler/check/library.h"
#include "compiler/check/program.h"
#include "compiler/check/types.h"
#include "compiler/diagnostics/diagnostics.h"
#include "compiler/syntax/tree.h"

namespace meld::check {

// Names of the whole program, made once.
struct Names {
    std::map<std::pair<std::string, std::size_t>, PredicateId> predicates;
    std::map<std::string, ConstantId> constants;
    std::map<std::string, FunctionId> functions;
    // What the tree lost to syntax errors: not known, and not to be missed.
    const syntax::Tree& tree;
    Names(const Program& program, const syntax::Tree& tree);
};

class Scope {
  public:
    // `rule` holds the variables; of a function or a constant it is a makeshift.
    Scope(Program& program, const Names& names, Rule& rule, diagnostics::Reporter& report, bool lower_case_variables)
        : program_(program), names_(names), rule_(rule), report_(report), lower_case_variables_(lower_case_variables) {}

    // The variable of this name, made on first use.
    VariableId variable(const std::string& name, Span span);
    VariableId fresh(const std::string& name, const Type& type, Span span);
    // In a part of the rule, known by its address, these names are other variables than outside: the same ones each time
    // the part is entered. leave() ends the part entered last.
    void enter(const void* part, const std::set<std::string>& names);
    void leave();
    bool inside_part() const { return !entered_.empty(); }
    // The name, if the expression is nothing but a variable; a lower-case name that is no constant counts in original Meld.
    const std::string* variable_name(const syntax::Expr& e) const;
    // The type of an expression as far as it is known by now, silently.
    Type infer(const syntax::Expr& e) const;
    // The typed term; `wanted` is what the place needs (Type::Error: anything). Reports what does not fit, with the place
    // that says what is wanted, if there is one.
    Term resolve(const syntax::Expr& e, const Type& wanted, const std::string& where, bool anonymous_fits = false, Span declared = {});
    // Converts int to float where that is wanted; reports other differences.
    Term convert(Term term, const Type& wanted, const std::string& where, Span declared = {});

    // A call of a function that gives a bool, where a fact could stand.
    bool is_function(const std::string& name) const;
    Term condition(const syntax::Atom& atom);

    // ---- patterns (patterns.cpp)

    // Whether it is a list, struct or tuple with variables in it: it can be taken apart as well as made.
    bool is_pattern(const syntax::Expr& e) const;
    // Gives the variables of an expression the types that follow from its own. Returns whether anything became known.
    bool spread_type(const syntax::Expr& e, const Type& type);
    // A pattern as one constructor of variables and known values; what else stands in it becomes a variable and a test.
    Term pattern(const syntax::Expr& e, const Type& wanted, std::vector<Clause>& tests);
    // A fresh variable that equals the pattern, for the place of an argument.
    Term pattern_variable(const syntax::Expr& e, const Type& wanted, std::vector<Clause>& tests);

  private:
    Type infer_call(const syntax::Call& call) const;
    Type infer_list(const syntax::ListValue& list) const;
    Type infer_let(const syntax::Let& let) const;
    Type infer_binary(const syntax::Binary& b) const;

    // Each gives the term of one kind of expression; `wanted` guides empty lists and the like.
    Term untyped(const syntax::Expr& e, const Type& wanted);
    Term constant_name(const syntax::Call& call, Span span);
    using Arguments = std::vector<syntax::ExprPtr>;
    Term call(const std::string& name, const Arguments& arguments, Span span, const Type& wanted);
    Term call_function(FunctionId id, const Arguments& arguments, Span span);
    Term call_library(const LibraryFunction& f, const Arguments& arguments, Span span, const Type& wanted);
    std::optional<Term> scheduling(const std::string& name, const Arguments& arguments, Span span);
    Term unknown_function(const std::string& name, const Arguments& arguments, Span span);
    enum class Named { No, Yes };
    std::string parameters(const Arguments& arguments, Named named);
    void wrong_count(const std::string& name, std::size_t needs, std::size_t given, Span span, Span declared);
    Term unary(const syntax::Unary& u, Span span);
    Term binary(const syntax::Binary& b, Span span);
    Term vector_product(const syntax::Binary& b, Span span, const Type& left, const Type& right);
    Term conditional(const syntax::Conditional& c, Span span, const Type& wanted);
    Term list(const syntax::ListValue& l, Span span, const Type& wanted);
    Term fields(const std::vector<syntax::ExprPtr>& values, Type::Kind kind, Span span, const Type& wanted);
    Term let(const syntax::Let& l, Span span, const Type& wanted);
    Term run_argument(int number, Span span, const Type& wanted);
    Term in_pattern(const syntax::Expr& e, const Type& wanted, std::vector<Clause>& tests);
    bool mentions_variable(const syntax::Expr& e) const;

    Program& program_;
    const Names& names_;
    Rule& rule_;
    diagnostics::Reporter& report_;
    bool lower_case_variables_;
    int depth_ = 0;  // Of the expression that is being resolved.
    std::map<std::string, VariableId> variables_;
    // The types of let variables that infer() is inside of, innermost last.
    mutable std::vector<std::pair<std::string, Type>> lets_;
    struct Entered {
        const void* part;
        std::map<std::string, VariableId> hidden;
        std::set<std::string> names;
    };
    std::vector<Entered> entered_;
    std::map<const void*, std::map<std::string, VariableId>> parts_;
};

// The test that two terms are equal.
Clause equality(Term left, Term right, Span span);

}  // namespace meld::check
