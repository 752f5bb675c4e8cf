// The variables of one rule, function or constant, and the typing of its expressions. Used by the passes that resolve them.
#pragma once

#include <map>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "compiler/check/program/library.h"
#include "compiler/check/program/program.h"
#include "compiler/check/program/types.h"
#include "compiler/diagnostics/diagnostics.h"
#include "compiler/syntax/tree.h"

namespace meld::check {

// Names of the whole program, made once.
struct Names {
    std::map<std::pair<std::string, std::size_t>, PredicateId> predicates;
    std::map<std::string, ConstantId> constants;
    std::map<std::string, FunctionId> functions;
    // Names that the tree lost to syntax errors: unknown, but not to be reported as missing.
    const syntax::Tree& tree;
    Names(const Program& program, const syntax::Tree& tree);
};

class Scope {
  public:
    // `rule` holds the variables; for a function or a constant it is a temporary rule.
    Scope(Program& program, const Names& names, Rule& rule, diagnostics::Reporter& report, bool lower_case_variables)
        : program_(program), names_(names), rule_(rule), report_(report), lower_case_variables_(lower_case_variables) {}

    // The variable of this name, made on first use.
    VariableId variable(const std::string& name, Span span);
    VariableId fresh(const std::string& name, const Type& type, Span span);
    // In a part of the rule, identified by its address, these names are different variables than outside: the same ones each time the part
    // is entered. leave() ends the part that was entered last.
    void enter(const void* part, const std::set<std::string>& names);
    void leave();
    bool inside_part() const { return !entered_.empty(); }
    // The name, if the expression is just a variable; in original Meld a lower-case name that is not a constant counts.
    const std::string* variable_name(const syntax::Expr& e) const;
    // The type of an expression as far as it is known, without reports.
    Type infer(const syntax::Expr& e) const;
    // The typed term; `wanted` is the type that the place requires (Type::Error: any). Reports mismatches, with the place that requires the
    // type, if there is one.
    Term resolve(const syntax::Expr& e, const Type& wanted, const std::string& where, bool anonymous_fits = false, Span declared = {});
    // Whether a term stands in the text where its span is, so that a call may be written around it.
    enum class Written { Here, Otherwise };
    // Converts int to float if required; reports other mismatches.
    Term convert(Term term, const Type& wanted, const std::string& where, Written written = Written::Otherwise, Span declared = {});

    // A call of a function that returns a bool, where a fact could be.
    bool is_function(const std::string& name) const;
    Term condition(const syntax::Atom& atom);

    // ---- patterns (patterns.cpp)

    // Whether it is a list, struct or tuple that contains variables: it can be taken apart as well as built.
    bool is_pattern(const syntax::Expr& e) const;
    // Gives the variables of an expression the types that follow from its type. Returns whether anything became known.
    bool spread_type(const syntax::Expr& e, const Type& type);
    // A pattern as one constructor of variables and known values; anything else in it becomes a variable and a test.
    Term pattern(const syntax::Expr& e, const Type& wanted, std::vector<Clause>& tests);
    // A fresh variable that equals the pattern, for use as an argument.
    Term pattern_variable(const syntax::Expr& e, const Type& wanted, std::vector<Clause>& tests);

  private:
    Type infer_call(const syntax::Call& call) const;
    Type infer_list(const syntax::ListValue& list) const;
    Type infer_let(const syntax::Let& let) const;
    Type infer_chain(const syntax::Chain& c) const;
    // What an operator gives for operands of these types.
    static Type inferred(syntax::BinaryOp op, const Type& left, const Type& right);

    // Each returns the term of one kind of expression; `wanted` determines the type of empty lists and similar values.
    Term untyped(const syntax::Expr& e, const Type& wanted);
    Term constant_name(const syntax::Call& call, Span span);
    using Arguments = std::vector<syntax::ExprPtr>;
    Term call(const std::string& name, const Arguments& arguments, Span span, const Type& wanted);
    Term call_function(FunctionId id, const Arguments& arguments, Span span);
    Term call_library(const LibraryFunction& f, const Arguments& arguments, Span span, const Type& wanted);
    static Term extreme(bool greatest, Span span, const Type& wanted);
    std::optional<Term> scheduling(const std::string& name, const Arguments& arguments, Span span);
    Term unknown_function(const std::string& name, const Arguments& arguments, Span span, const Type& wanted);
    enum class Named { No, Yes };
    std::string parameters(const Arguments& arguments, Named named);
    void wrong_count(const std::string& name, std::size_t needs, std::size_t given, Span span, Span declared);
    Term unary(const syntax::Unary& u, Span span);
    Term binary(const syntax::Binary& b, Span span);
    // The left operand of an operator: its text, or in a chain what stands before the operator as a term.
    struct Left {
        const syntax::Expr* text = nullptr;
        Term made = {};
        Type type = Type::Error;
        Span span = {};
    };
    Term left_operand(Left left, const Type& wanted, const std::string& where);
    Term operation(Op op, Left left, const syntax::Expr& right, Span span);
    Term vector_product(Op op, Left left, const syntax::Expr& right, const Type& right_type, Span span);
    // The common type of what an operator joins; none if that has been reported.
    std::optional<Type> common_type(Op op, const Left& left, const syntax::Expr& right, const Type& right_type, Span span);
    // Operators in a row (chains.cpp).
    Term chain(const syntax::Chain& c, Span span);
    Term chain_from(Term so_far, const syntax::Chain& c, std::size_t begin, std::size_t end);
    Term appended(const syntax::Chain& c, Span span);
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
