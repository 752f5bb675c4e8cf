// Input nobody meant: rubbish, extremes and broken texts give messages and never a crash.
#include <gtest/gtest.h>

#include <random>

#include "parsed.h"

namespace meld::syntax {
namespace {

using diagnostics::Kind;

std::string repeated(const std::string& text, int count) {
    std::string result;
    for (int i = 0; i < count; ++i) result += text;
    return result;
}

void one_error(const std::string& text, Kind kind, std::uint32_t line, std::uint32_t column) {
    const Parsed program = parsed(text);
    const auto messages = program.messages();
    ASSERT_EQ(messages.size(), 1u) << program.brief();
    EXPECT_EQ(messages[0].kind, kind) << program.brief();
    EXPECT_EQ(program.files.begin(messages[0].span).line, line);
    EXPECT_EQ(program.files.begin(messages[0].span).column, column);
    EXPECT_FALSE(program.rendered().empty());
}

TEST(BadInput, BytesThatAreNoText) {
    one_error(std::string("p(A).\nq(\0).", 11), Kind::InvalidText, 2, 3);
    one_error("p(A).\nq(\xff).", Kind::InvalidText, 2, 3);
    one_error("\xc0\x80", Kind::InvalidText, 1, 1);
    one_error("// \xed\xa0\x80", Kind::InvalidText, 1, 4);
    one_error("p(\"\xe2\x82", Kind::InvalidText, 1, 4);
    one_error("\xf4\x90\x80\x80", Kind::InvalidText, 1, 1);
}

TEST(BadInput, CommentsAndTextsWithoutEnd) {
    one_error("p(A).\n/* never", Kind::UnterminatedComment, 2, 1);
    one_error("/* outer /* inner */", Kind::UnterminatedComment, 1, 1);
    one_error("/* outer /* inner", Kind::UnterminatedComment, 1, 10);
    one_error("p(A, \"abc).\n", Kind::UnterminatedString, 1, 6);
}

TEST(BadInput, AnUnclosedTextEndsWithItsLine) {
    const Parsed program = parsed("p(A) :- \"abc\n  , q(A).\nr(A).");
    EXPECT_EQ(program.brief(), "1:9 UnterminatedString this string has no closing quote\n");
    EXPECT_EQ(program.tree.items.size(), 2u);
}

TEST(BadInput, StrangeCharacters) {
    one_error("p(A) & q(A).", Kind::UnexpectedCharacter, 1, 6);
    one_error("p(A, 12abc).", Kind::UnexpectedCharacter, 1, 6);
    one_error("p(A, \"a\\qb\").", Kind::UnexpectedCharacter, 1, 8);
    one_error("p(@arg0).", Kind::UnexpectedCharacter, 1, 3);
    one_error("p(A)@+2min.", Kind::UnexpectedCharacter, 1, 5);
}

TEST(BadInput, NumbersThatDoNotFit) {
    one_error("p(A, 99999999999999999999).", Kind::NumberOutOfRange, 1, 6);
    one_error("p(A, " + std::string(1000000, '9') + ").", Kind::NumberOutOfRange, 1, 6);
    one_error("p(A, " + std::string(1000, '9') + ".5).", Kind::NumberOutOfRange, 1, 6);
    one_error("p(@99999999999999999999).", Kind::NumberOutOfRange, 1, 3);
    one_error("p(A)@+" + std::string(1000, '9') + "s.", Kind::NumberOutOfRange, 1, 5);
}

TEST(BadInput, RubbishIsReportedBriefly) {
    EXPECT_LE(parsed(repeated("& ", 100000)).messages().size(), 50u);
    EXPECT_LE(parsed(repeated(". ", 100000)).messages().size(), 101u);
    EXPECT_LE(parsed(repeated(") p . ", 100000)).messages().size(), 101u);
    EXPECT_LE(parsed(repeated("\"\n", 100000)).messages().size(), 200000u);
}

TEST(BadInput, GiganticTokens) {
    const Parsed name = parsed(std::string(3000000, 'a') + "(A).");
    EXPECT_FALSE(name.report.has_errors());
    const Parsed error = parsed("p(A) " + std::string(3000000, 'a') + ".");
    ASSERT_EQ(error.messages().size(), 1u);
    EXPECT_LT(error.rendered().size(), 2000u);
    EXPECT_FALSE(parsed("/*" + std::string(3000000, '*') + "*/ p(A, \"" + std::string(3000000, 'x') + "\").").report.has_errors());
}

TEST(BadInput, LongListsAreNoNesting) {
    std::string list = "const l = [0";
    for (int i = 1; i < 100000; ++i) list += ", -" + std::to_string(i);
    const Parsed program = parsed(list + "].\n" + "p(A) :- q(A" + repeated(", X + 1", 20000) + ").\n");
    EXPECT_EQ(program.brief(), "");
}

TEST(BadInput, NestingIsLimitedEverywhere) {
    const int deep = 100000;
    const std::vector<std::string> programs = {
        "p(A, " + repeated("(", deep) + "1" + repeated(")", deep) + ").",
        "p(A, " + repeated("[", deep) + repeated("]", deep) + ").",
        "p(A, " + repeated("f(", deep) + "1" + repeated(")", deep) + ").",
        "p(A, " + repeated("- ", deep) + "1).",
        "p(A, " + repeated("~", deep) + "X).",
        "p(A, 1" + repeated(" ^ 1", deep) + ").",
        "p(A, " + repeated("if X then 1 else ", deep) + "2" + repeated(" end", deep) + ").",
        "p(A, " + repeated("let X = 1 in ", deep) + "2" + repeated(" end", deep) + ").",
        "p(A) :- " + repeated("not (", deep) + "q(A)" + repeated(")", deep) + ".",
        "p(A) -o " + repeated("{ | q(A) | ", deep) + "r(A)" + repeated("}", deep) + ".",
        "p(A) -o " + repeated("(if X then ", deep) + "r(A)" + repeated(" end)", deep) + ".",
        "p(A) -o " + repeated("if X then ", deep) + "r(A)" + repeated(" end", deep) + ".",
        "p(A) -o " + repeated("exists X. (", deep) + "r(A)" + repeated(")", deep) + ".",
        "type p(node, " + repeated("list ", deep) + "int).",
        "type p(node, int" + repeated(" list", deep) + ").",
        "type p(node, " + repeated(":(", deep) + "int" + repeated(")", deep) + ").",
        "type " + repeated("(", deep) + "int.",
        "p(A, " + repeated("(1 + ", deep) + "1" + repeated(") + 1", deep) + ").",
    };
    for (const std::string& text : programs) {
        const Parsed program = parsed(text + "\nq(A).");
        ASSERT_EQ(program.messages().size(), 1u) << text.substr(0, 60) << program.brief().substr(0, 500);
        EXPECT_EQ(program.messages()[0].kind, Kind::NestingTooDeep) << text.substr(0, 60);
        EXPECT_EQ(program.tree.items.size(), 1u) << "reading goes on behind it";
    }
}

TEST(BadInput, NestingBelowTheLimitIsReadPrintedAndDestroyed) {
    const int deep = 900;
    for (const std::string& text :
         {"p(A, " + repeated("(1 - ", deep / 2) + "1" + repeated(")", deep / 2) + ").",
          "p(A, " + repeated("f(", deep) + "1" + repeated(")", deep) + ").",
          "p(A) -o " + repeated("{ | q(A) | ", deep) + "r(A)" + repeated("}", deep) + ".",
          "p(A) -o " + repeated("exists X. (", deep) + "r(A)" + repeated(")", deep) + ".", "p(A, 1" + repeated(" + 1", deep) + ")."}) {
        const Parsed program = parsed(text);
        ASSERT_EQ(program.brief(), "") << text.substr(0, 60);
        EXPECT_EQ(parsed(print(program.tree)).brief(), "");
    }
}

TEST(BadInput, ManyItemsWithoutFullStopsTakeLinearTime) {
    const Parsed program = parsed(repeated("p(A) :- q(A)\n", 200000));
    EXPECT_EQ(program.messages().size(), 100u);
}

// Cuts, doubles and swaps pieces of a program at random. Whatever comes out must be parsed, reported and printed.
TEST(BadInput, RandomDamageNeverCrashes) {
    const std::string good =
        "type route neighbor(node, node, int Port).\ntype p(node, sum float [<- neighbor], :(int, int) S).\nconst a = [1, -2 | @arg1].\n"
        "fun f(int X) : int = let Y = X in if Y > 0 then Y else -Y end end.\nimport linear p(node) as q from \"f\".\npriority p < q @asc.\n"
        "p(A, X)@+2s :- neighbor(A, B, _), forall q(A, B)[r(B)], not (s(A), t(A)), S = sum X : { p(A, X) }, delta(X; p(A, X)) > 1.\n"
        "[desc => X | !p(A, X), $q(A)] -o { Y | p(Y) | q(Y) }, [sum => S | X | p(X) | q(S)], exists Z. (r(Z)), (if A = B then p(A) "
        "otherwise 1 end).\n"
        "#include \"none\"\n/* c /* d */ */ p(A, \"x\\n\").\n";
    std::mt19937 random(7);
    for (int round = 0; round < 3000; ++round) {
        std::string text = good;
        for (unsigned edit = 0; edit <= random() % 4; ++edit) {
            const std::size_t at = random() % text.size();
            const std::size_t length = random() % 20;
            switch (random() % 4) {
                case 0:
                    text.erase(at, length);
                    break;
                case 1:
                    text.insert(random() % text.size(), text.substr(at, length));
                    break;
                case 2:
                    text[at] = static_cast<char>(random() % 256);
                    break;
                default:
                    text.insert(at, 1, "()[]{}|.,:;-!?$@#\"=<>~"[random() % 22]);
                    break;
            }
            if (text.empty()) text = " ";
        }
        const Parsed program = parsed(text);
        const std::string page = program.rendered() + diagnostics::render_json(program.files, program.messages());
        const std::string printed = print(program.tree);
        // The damage may be in the name of a file, which then is not there.
        const Parsed again = parsed(printed, {.follow_includes = false});
        EXPECT_FALSE(again.report.has_errors()) << printed << again.rendered() << "from\n" << text;
    }
}

}  // namespace
}  // namespace meld::syntax
