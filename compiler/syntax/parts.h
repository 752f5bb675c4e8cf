// What the grammar builds before it knows whether it is in a body or in a head, and the actions that build the tree.
//
// A rule's left side is a body before -o and a head before :- or a full stop, which is known only at the arrow. So the grammar reads
// `parts`, and the arrow's action turns them into clauses or head items, with its own messages for parts that do not belong there.
#pragma once

#include <optional>
#include <set>
#include <string>
#include <variant>
#include <vector>

#include "compiler/diagnostics/diagnostics.h"
#include "compiler/syntax/tokens.h"
#include "compiler/syntax/tree.h"

namespace meld::syntax {

struct Part;

// [ sum => S, count => C | X | body | head ], [desc => X | body], [:min X | body]: its sections tell which it is.
struct Bracketed {
    std::vector<HeadAggregate> selections = {};
    std::vector<std::vector<Part>> sections = {};
};

struct Part {
    std::variant<ExprPtr, Atom, Not, Forall, Element, Delta, BodyAggregate, Comprehension, Bracketed, Exists, HeadIf> node;
    std::optional<Delay> delay = {};
    Span span = {};
};

// One word or bracket of a declaration: `route`, `D`, "file", 3, (node, int), :(int, int), [<- neighbor].
struct DeclarationWord {
    enum class Form { Name, Variable, Text, Number, Group, Struct, Neighbour, OutNeighbour } form = Form::Name;
    std::string text = {};
    std::vector<std::vector<DeclarationWord>> arguments = {};
    Span span = {};
    std::int64_t integer = 0;  // Number
};
using DeclarationWords = std::vector<DeclarationWord>;

// The semantic actions of one file. Each reports mistakes and still returns something to continue with.
class Builder {
  public:
    Builder(const source::File& file, std::uint32_t file_index) : file_(file), file_index_(file_index) {}

    // Expressions.
    ExprPtr literal(const Token& token);
    ExprPtr name(const Token& token) const;
    ExprPtr at_name(const Token& token);
    ExprPtr call(Atom atom) const;
    ExprPtr negate(ExprPtr operand, Span span);
    ExprPtr positive(const Token& number, Span span);
    ExprPtr binary(BinaryOp op, ExprPtr left, ExprPtr right, Span span) const;
    ExprPtr cons(ExprPtr first, ExprPtr rest, Span span) const;
    ExprPtr paren_or_tuple(std::vector<ExprPtr> fields, Span span) const;
    template <class Node>
    ExprPtr expr(Node node, Span span) const {
        return std::make_unique<Expr>(Expr{std::move(node), span});
    }

    // Converts parts to what the place requires.
    std::vector<Clause> clauses(std::vector<Part> parts);
    std::vector<HeadItem> heads(std::vector<Part> parts);
    std::vector<Name> variables(std::vector<Part> parts);
    Comprehension comprehension(std::vector<std::vector<Part>> sections, Span span);
    Part element(ExprPtr value, ExprPtr list, Span span) const;
    BodyAggregate body_aggregate(ExprPtr result, const Token& op, ExprPtr parameter, ExprPtr value, std::vector<Clause> body);
    // min_k(3) => L
    HeadAggregate sized_aggregate(Atom call, const Token& result);
    Delay delay(const Token& token) const;

    // Items.
    void rule(Arrow arrow, std::vector<Part> body, std::vector<Part> head_parts, Span span);
    void type_item(DeclarationWords words, Span span);
    void extern_item(DeclarationWords words, Span span);
    void import_item(DeclarationWords words, Span span);
    void function(const Token& name, std::vector<DeclarationWords> parameters, DeclarationWords result, ExprPtr body, Span span);
    void hint(const Token& directive, const std::vector<const Token*>& words, Span span);
    void item(Item item) { item_ = std::move(item); }

    // Whether a NeighbourOpen is [-> and not [<-.
    bool is_outgoing(const Token& token) const { return file_.text()[token.span.end - 1] == '>'; }
    static Name to_name(const Token& token) { return {token.text, token.span}; }

    // Ends an item. Moves its mistakes to the report; if there are none, and the grammar accepted the item, returns it.
    std::optional<Item> finish(diagnostics::Reporter& report);
    // Drops an item that the grammar refused; only that is reported.
    void discard();

  private:
    Clause clause(Part part);
    void count_proved(ExprPtr& condition, std::vector<Clause>& out);
    HeadItem head(Part part);
    void bracketed_head(Bracketed bracketed, HeadItem& item);
    std::optional<Selector> selector(const Bracketed& bracketed, Span span);
    diagnostics::Diagnostic& wrong(Span span, std::string message, std::string help = {});

    const source::File& file_;
    std::uint32_t file_index_;
    // The mistakes of the item being read.
    diagnostics::Reporter report_;
    std::optional<Item> item_;
    // The places of literals 2^63 without a minus so far.
    std::set<std::uint32_t> lone_minimums_;
    int proved_ = 0;  // The number of counts by proved(A, p) so far.
};

// The words of a declaration read as arguments, types and names (declarations.cpp).
class DeclarationReader {
  public:
    explicit DeclarationReader(diagnostics::Reporter& report) : report_(report) {}

    std::vector<Argument> arguments(const std::vector<DeclarationWords>& groups);
    Argument argument(const DeclarationWords& words);
    // All of the words as one type.
    Type whole_type(const DeclarationWords& words, Span span);

  private:
    Type type(const DeclarationWords& words, std::size_t& at);
    Type base_type(const DeclarationWords& words, std::size_t& at);
    bool starts_with_aggregate(const DeclarationWords& words) const;
    void parameter(const DeclarationWord& group, Argument& argument);

    diagnostics::Reporter& report_;
};

}  // namespace meld::syntax
