// Mistakes: what is said about each, that each is said, and that none causes another.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "compiler/diagnostics/explain.h"
#include "parsed.h"

namespace meld::syntax {
namespace {

using testing::HasSubstr;

std::string brief(const std::string& text) { return parsed(text).brief(); }

TEST(MissingPeriod, IsPutAtTheEndOfTheItem) {
    const Parsed program = parsed("type p(node).\np(A) :- q(A)\nr(A) :- p(A).\n");
    EXPECT_EQ(program.brief(), "2:13 MissingPeriod this rule has no full stop\n");
    EXPECT_THAT(program.rendered(), HasSubstr("2 | p(A) :- q(A)\n  |             ^\n3 | r(A) :- p(A).\n  | - the next one starts here\n"));
    EXPECT_EQ(program.tree.items.size(), 3u) << "both rules are read";
}

TEST(MissingPeriod, IsSeenBehindEveryKindOfItem) {
    for (const char* item :
         {"type p(node)", "type linear p(node, int)", "type list int v", "const a = 1", "const a = b", "fun f(int X) : int = X",
          "extern float f(int)", "node kind", "import p from \"f\"", "export p", "module m", "priority p < q", "data p \"f\"", "p(A)",
          "p(A) :- q(A), X > 1", "p(A), q(A)\n   -o r(A)", "p(A) -o { X | q(A, X) | r(A, X) }"}) {
        for (const char* next : {"q(A, B) :- r(A).", "type q(node).", "const c = 2.", "!q(A) -o r(A).", "fun g(int X) : int = X."}) {
            const Parsed program = parsed(std::string(item) + "\n" + next + "\n");
            ASSERT_EQ(program.messages().size(), 1u) << item << "\n" << next << "\n" << program.rendered();
            EXPECT_EQ(program.messages()[0].kind, diagnostics::Kind::MissingPeriod) << item << "\n" << next << "\n" << program.rendered();
            EXPECT_EQ(program.tree.items.size(), 2u);
        }
    }
}

TEST(MissingPeriod, IsSeenAtTheEndOfTheFile) {
    EXPECT_EQ(brief("p(A) :- q(A)"), "1:13 MissingPeriod this rule has no full stop\n");
    EXPECT_EQ(brief("type p(node)   \n\n"), "1:13 MissingPeriod this declaration has no full stop\n");
}

TEST(MissingPeriod, OfTwoItemsIsTwoMessages) {
    EXPECT_EQ(brief("p(A) :- q(A)\nr(A) :- s(A)\nt(A).\n"),
              "1:13 MissingPeriod this rule has no full stop\n2:13 MissingPeriod this rule has no full stop\n");
}

TEST(SyntaxError, SaysWhatIsExpected) {
    EXPECT_EQ(brief("p(A B)."), "1:5 SyntaxError expected `,` or `)`, found `B`\n");
    EXPECT_EQ(brief("p(A) q(A)."), "1:6 SyntaxError expected `,`, `:-`, `-o` or `.`, found `q`\n");
    EXPECT_EQ(brief("p(A) :- ."), "1:9 SyntaxError expected a fact or a condition, found `.`\n");
    EXPECT_EQ(brief("p(A) :- X > ."), "1:13 SyntaxError expected an expression, found `.`\n");
    EXPECT_EQ(brief("const = 1."), "1:7 SyntaxError expected a name or a variable, found `=`\n");
    EXPECT_EQ(brief("const a 1."), "1:9 SyntaxError expected `=`, found `1`\n");
    EXPECT_EQ(brief("type p(node, 3)."), "1:14 SyntaxError expected a type, found `3`\n");
    EXPECT_EQ(brief("type p(node,)."), "1:13 SyntaxError expected a type, found `)`\n");
    EXPECT_EQ(brief("p(A) :- if A = B then q(A) end."), "1:9 SyntaxError `if` with heads belongs in a head, not in a body\n");
}

TEST(SyntaxError, ShowsTheBracketThatIsOpen) {
    const Parsed program = parsed("p(A, (B :- q(A).");
    ASSERT_EQ(program.messages().size(), 1u);
    ASSERT_EQ(program.messages()[0].labels.size(), 1u);
    EXPECT_EQ(program.messages()[0].labels[0].text, "this `(` is not closed");
    EXPECT_EQ(program.messages()[0].labels[0].span.begin, 5u);
    EXPECT_EQ(brief("p(A)) :- q(A)."), "1:5 SyntaxError this `)` closes nothing\n");
}

TEST(SyntaxError, KnowsCommonMistakes) {
    EXPECT_EQ(brief("P(A) :- q(A)."), "1:1 SyntaxError `P` is a variable, and a variable has no arguments\n");
    EXPECT_EQ(brief("p(A) :- q(A), r(B) :- s(B)."), "1:20 SyntaxError a second arrow in one rule\n");
    EXPECT_EQ(brief("p(A, 3 % @cores)."), "1:10 SyntaxError `@cores` means nothing here\n");
    EXPECT_EQ(brief("p(A)@2s."), "1:5 SyntaxError a delay is written with a plus sign\n");
    EXPECT_EQ(brief("include other."), "1:1 SyntaxError `include` names a file in quotes\n");
    EXPECT_EQ(brief("const x = let X = 3."), "1:20 SyntaxError expected `in`, found `.`\n");
    EXPECT_THAT(parsed("p(A) := q(A).").rendered(), HasSubstr("help: write head :- body"));
    EXPECT_EQ(brief(".. p(A)."), "1:1 SyntaxError there is nothing before this full stop\n");
    EXPECT_EQ(brief("type p(min D)."), "1:12 SyntaxError a type is expected after `min`\n");
    EXPECT_EQ(brief("type p(D int)."), "1:8 SyntaxError a type is expected here\n");
}

TEST(SyntaxError, TellsHeadsFromBodies) {
    EXPECT_EQ(brief("p(A), X > 1 :- q(A)."), "1:7 SyntaxError a head is made of facts, and this is not one\n");
    EXPECT_EQ(brief("p(A) :- q(A)@+2s."), "1:13 SyntaxError a body cannot wait\n");
    EXPECT_EQ(brief("p(A) -o not q(A)."), "1:9 SyntaxError `not` belongs in a body, not in a head\n");
    EXPECT_EQ(brief("p(A) :- { X | q(X) | r(X) }."), "1:9 SyntaxError a comprehension belongs in a head, not in a body\n");
    EXPECT_EQ(brief("p(A) -o { X | q(X) }."), "1:9 SyntaxError a comprehension has three parts, this has 2\n");
    EXPECT_EQ(brief("[up => X | p(A, X)] -o q(A)."), "1:1 SyntaxError `up` selects nothing\n");
    EXPECT_EQ(brief("p(A) -o { 3 | q(A) | r(A) }."), "1:11 SyntaxError only variables come before the first `|`\n");
    EXPECT_EQ(brief("p(A) :- S = sum : { q(A) }."), "1:13 SyntaxError `sum` needs something to work on\n");
}

TEST(SyntaxError, FiveMistakesGiveFiveMessagesInOrder) {
    const Parsed program = parsed(
        "type p(node).\n"
        "p(A :- q(A).\n"
        "type q(node\n"
        "type r(node).\n"
        "r(A) :- \"abc.\n"
        "  , p(A).\n"
        "const = 3.\n"
        "s(A) :- p(A)\n"
        "t(A).\n");
    EXPECT_EQ(program.brief(),
              "2:5 SyntaxError expected `,` or `)`, found `:-`\n"
              "4:1 SyntaxError expected `,` or `)`, found `type`\n"
              "5:9 UnterminatedString this string has no closing quote\n"
              "7:7 SyntaxError expected a name or a variable, found `=`\n"
              "8:13 MissingPeriod this rule has no full stop\n");
    EXPECT_EQ(print(program.tree), "type p(node).\ntype r(node).\nr(A) :- \"abc.\", p(A).\ns(A) :- p(A).\nt(A).\n");
}

TEST(SyntaxError, OneItemIsOneMessage) { EXPECT_EQ(parsed("p(A :- q(A, r(B), ), X >, ] } -o :- .\ns(A).").messages().size(), 1u); }

TEST(Explanation, CuresParse) {
    using diagnostics::Kind;
    for (const Kind kind :
         {Kind::UnexpectedCharacter, Kind::UnterminatedComment, Kind::UnterminatedString, Kind::NumberOutOfRange, Kind::SyntaxError,
          Kind::MissingPeriod, Kind::BadAggregate, Kind::SingleUse, Kind::LinearElsewhere, Kind::TreeRecursion, Kind::LinearInView,
          Kind::HintIgnored, Kind::ActionInBody, Kind::DuplicateDeclaration, Kind::NegativeRecursion, Kind::InfiniteLinear}) {
        const std::string page = diagnostics::explanation(kind);
        std::string cure;
        for (std::size_t end = page.size() - 1; end != std::string::npos;) {
            const std::size_t begin = page.rfind('\n', end - 1) + 1;
            const std::string line = page.substr(begin, end - begin + 1);
            if (!line.starts_with("    ")) break;
            cure.insert(0, line);
            end = begin - 1;
        }
        EXPECT_NE(cure, "");
        EXPECT_EQ(parsed(cure).rendered(), "") << cure;
    }
}

}  // namespace
}  // namespace meld::syntax
