// What the tree holds: fields and spans of the nodes others rely on.
#include <gtest/gtest.h>

#include "parsed.h"

namespace meld::syntax {
namespace {

template <class T>
const T& item(const Parsed& program, std::size_t index = 0) {
    return std::get<T>(program.tree.items.at(index));
}

TEST(Tree, DeclarationsKnowTheirArguments) {
    const Parsed program =
        parsed("type route linear p(node, min int D, sum float [<- neighbor], avg int Mean, first node, kind K, int list L).");
    ASSERT_EQ(program.brief(), "");
    const auto& p = item<Declaration>(program);
    ASSERT_EQ(p.modifiers.size(), 2u);
    EXPECT_EQ(p.modifiers[1].text, "linear");
    EXPECT_EQ(p.name.text, "p");
    ASSERT_EQ(p.arguments.size(), 7u);
    EXPECT_EQ(p.arguments[1].aggregate, "min");
    EXPECT_EQ(p.arguments[1].type.name, "int");
    EXPECT_EQ(p.arguments[1].name->text, "D");
    EXPECT_EQ(program.files.text(p.arguments[1].aggregate_span), "min");
    EXPECT_EQ(program.files.text(p.arguments[1].span), "min int D");
    EXPECT_TRUE(p.arguments[2].neighbour_complete);
    EXPECT_EQ(p.arguments[2].neighbour_link.text, "neighbor");
    EXPECT_EQ(p.arguments[3].aggregate, "avg");
    EXPECT_EQ(p.arguments[4].aggregate, "first");
    EXPECT_FALSE(p.arguments[4].name.has_value());
    EXPECT_EQ(p.arguments[5].type.name, "kind");
    EXPECT_EQ(p.arguments[6].type.name, "list");
    EXPECT_EQ(p.arguments[6].type.arguments.at(0).name, "int");
    EXPECT_FALSE(p.repeats);
    EXPECT_TRUE(item<Declaration>(parsed("type action p(node) while.")).repeats);
}

TEST(Tree, RulesKnowTheirParts) {
    const Parsed program = parsed("  p(A)@+2s, !q(B) :- r(A, B), A <> B, not s(A).");
    ASSERT_EQ(program.brief(), "");
    const auto& rule = item<Rule>(program);
    EXPECT_EQ(rule.arrow, Arrow::View);
    EXPECT_EQ(program.files.text(rule.span), "p(A)@+2s, !q(B) :- r(A, B), A <> B, not s(A)");
    ASSERT_EQ(rule.head.size(), 2u);
    const auto& first = std::get<HeadFact>(rule.head[0].node);
    EXPECT_EQ(first.delay->amount, 2);
    EXPECT_EQ(first.delay->unit, Delay::Unit::Seconds);
    EXPECT_EQ(program.files.text(first.atom.span), "p(A)");
    EXPECT_EQ(program.files.text(first.atom.name.span), "p");
    EXPECT_EQ(std::get<HeadFact>(rule.head[1].node).atom.sigil, Sigil::Persistent);
    EXPECT_EQ(program.files.text(rule.head[1].span), "!q(B)");
    ASSERT_EQ(rule.body.size(), 3u);
    EXPECT_TRUE(std::holds_alternative<Atom>(rule.body[0].node));
    EXPECT_TRUE(std::holds_alternative<Constraint>(rule.body[1].node));
    EXPECT_EQ(program.files.text(rule.body[1].span), "A <> B");
    EXPECT_EQ(program.files.text(rule.body[2].span), "not s(A)");
}

TEST(Tree, SelectorsStandBesideTheBody) {
    const Parsed program = parsed("[desc => X | p(A, X), q(A)] -o r(A).");
    const auto& rule = item<Rule>(program);
    ASSERT_TRUE(rule.selector.has_value());
    EXPECT_EQ(rule.selector->order, Selector::Order::Descending);
    EXPECT_EQ(rule.selector->variable.text, "X");
    EXPECT_EQ(rule.body.size(), 2u);
}

TEST(Tree, AggregatesWithOneHeadDeriveItWithTheResults) {
    const Parsed program = parsed("p(A) -o [sum => S | X, Y | q(A, X, Y) | r(A, S)].");
    const auto& aggregate = std::get<RuleAggregate>(item<Rule>(program).head[0].node);
    EXPECT_EQ(aggregate.variables.size(), 2u);
    EXPECT_TRUE(aggregate.each.empty());
    EXPECT_EQ(aggregate.result.size(), 1u);
}

TEST(Tree, HintsAreRememberedAsWritten) {
    const Parsed program = parsed("priority p  <\n q-r.");
    const auto& hint = item<Hint>(program);
    EXPECT_EQ(hint.directive.text, "priority");
    EXPECT_EQ(hint.text, "p < q-r");
    ASSERT_EQ(hint.names.size(), 2u);
    EXPECT_EQ(hint.names[1].text, "q-r");
}

TEST(Tree, ImportsKnowBothNames) {
    const Parsed program = parsed("import linear p(node, int) as q from file. import r from \"x.meld\".");
    ASSERT_EQ(program.brief(), "");
    EXPECT_EQ(item<Import>(program).predicate.text, "p");
    EXPECT_EQ(item<Import>(program).as.text, "q");
    EXPECT_EQ(item<Import>(program).path, "file");
    EXPECT_EQ(item<Import>(program).declaration->arguments.size(), 2u);
    EXPECT_EQ(item<Import>(program, 1).as.text, "r");
    EXPECT_FALSE(item<Import>(program, 1).declaration.has_value());
}

TEST(Tokens, ArePrintedWithPlaceAndKind) {
    source::FileSet files;
    diagnostics::Reporter report;
    EXPECT_EQ(print_tokens(files, files.add("a.meld", "p(A) :-\n  end(A)@+2s."), report),
              "1:1 Name p\n1:2 LeftParen (\n1:3 Variable A\n1:4 RightParen )\n1:6 ViewArrow :-\n"
              "2:3 Name end\n2:6 LeftParen (\n2:7 Variable A\n2:8 RightParen )\n2:9 Delay @+2s\n2:13 Period .\n2:14 End\n");
}

}  // namespace
}  // namespace meld::syntax
