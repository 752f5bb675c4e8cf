// Expressions: precedence, literals, and that every tree prints to text that gives the same tree.
#include <gtest/gtest.h>

#include <limits>
#include <random>

#include "parsed.h"

namespace meld::syntax {
namespace {

std::string value_outline(const std::string& text) {
    const Parsed program = parsed("const x = " + text + ".");
    if (program.report.has_errors()) return program.brief();
    return outline(constant_value(program));
}

TEST(Expr, BindsAsInMathematics) {
    EXPECT_EQ(value_outline("A + B * C"), value_outline("A + (B * C)"));
    EXPECT_EQ(value_outline("A - B - C"), value_outline("(A - B) - C"));
    EXPECT_EQ(value_outline("A ^ B ^ C"), value_outline("A ^ (B ^ C)"));
    EXPECT_EQ(value_outline("-A ^ 2"), value_outline("-(A ^ 2)"));
    EXPECT_EQ(value_outline("-A * B"), value_outline("(-A) * B"));
    EXPECT_EQ(value_outline("A ++ B ++ C"), value_outline("A ++ (B ++ C)"));
    EXPECT_EQ(value_outline("A = 1 && B < 2 || C > 3"), value_outline("((A = 1) && (B < 2)) || (C > 3)"));
    EXPECT_EQ(value_outline("~A = B && C"), value_outline("(~(A = B)) && C"));
    EXPECT_EQ(value_outline("X::Y::R"), value_outline("X::(Y::R)"));
    EXPECT_EQ(value_outline("X + 1::R"), value_outline("[X + 1 | R]"));
}

TEST(Expr, TellsNamesWithDashesFromDifferences) {
    EXPECT_EQ(value_outline("a-b"), "(a-b)");
    EXPECT_EQ(value_outline("A-B"), "(binary1 A B)");
    EXPECT_EQ(value_outline("N-1"), "(binary1 N (int 1))");
    EXPECT_EQ(value_outline("a - b"), "(binary1 (a) (b))");
    EXPECT_EQ(value_outline("A -1"), "(binary1 A (int 1))");
    EXPECT_EQ(value_outline("f(A)-1"), "(binary1 (f() A) (int 1))");
    EXPECT_EQ(value_outline("done?'"), "(done?')");
}

TEST(Expr, ReadsLiterals) {
    EXPECT_EQ(value_outline("12"), "(int 12)");
    EXPECT_EQ(value_outline("-3"), "(int -3)");
    EXPECT_EQ(value_outline("0.5"), "(float 0x1p-1)");
    EXPECT_EQ(value_outline("1e3"), "(float 0x1.f4p+9)");
    EXPECT_EQ(value_outline("1e-3"), value_outline("0.001"));
    EXPECT_EQ(value_outline("true"), "true");
    EXPECT_EQ(value_outline(R"("a\n\"\\\x41")"), "(text a\n\"\\A)");
    EXPECT_EQ(value_outline("@7"), "(catom 7)");
    EXPECT_EQ(value_outline("#7"), "(catom 7)");
    EXPECT_EQ(value_outline("@world"), "world");
    EXPECT_EQ(value_outline("@arg1"), "(arg 1)");
    EXPECT_EQ(value_outline("nil"), value_outline("[]"));
    EXPECT_EQ(value_outline("[1, 2 | Rest]"), "((list (int 1) (int 2))Rest)");
    EXPECT_EQ(value_outline(":(1, 2.0)"), "(struct (int 1) (float 0x1p+1))");
    EXPECT_EQ(value_outline("(1, X)"), "(tuple (int 1) X)");
    EXPECT_EQ(value_outline("((X))"), "X");
}

TEST(Expr, ReadsTheSmallestAndTheLargestInt) {
    EXPECT_EQ(value_outline("9223372036854775807"), "(int 9223372036854775807)");
    EXPECT_EQ(value_outline("-9223372036854775808"), "(int -9223372036854775808)");
    EXPECT_EQ(parsed("const x = 9223372036854775808.").brief(), "1:11 NumberOutOfRange this number does not fit\n");
    EXPECT_EQ(parsed("const x = 1 - 9223372036854775808.").brief(), "1:15 NumberOutOfRange this number does not fit\n");
    EXPECT_EQ(parsed("const x = 1e999.").brief(), "1:11 NumberOutOfRange this number does not fit\n");
    EXPECT_EQ(value_outline("1e-999"), "(float 0x0p+0)");
}

TEST(Expr, EndsAnItemBehindANumber) {
    const Parsed program = parsed("const a = 1. const b = 2.5. p(@1,@2).");
    EXPECT_EQ(program.brief(), "");
    EXPECT_EQ(program.tree.items.size(), 3u);
}

// Random trees, so that every operator meets every other on both sides.
class RandomExpr {
  public:
    explicit RandomExpr(unsigned seed) : random_(seed) {}

    ExprPtr make(int depth) {
        const auto one = [&] { return make(depth - 1); };
        const int choice = depth == 0 ? static_cast<int>(random_() % 9) : 9 + static_cast<int>(random_() % 30);
        switch (choice) {
            case 0:
                return node(IntLiteral{static_cast<std::int64_t>(random_() % 7) - 3});
            case 1:
                return node(FloatLiteral{(static_cast<double>(random_() % 7) - 3) / 4 - 0.1});
            case 2:
                return node(Variable{"X"});
            case 3:
                return node(Call{"a-b", {}, false});
            case 4:
                return node(StringLiteral{"q\"\\\n\x01\xff\xc3\xa9"});
            case 5:
                return node(BoolLiteral{true});
            case 6:
                return node(CatomLiteral{3});
            case 7:
                return node(IntLiteral{std::numeric_limits<std::int64_t>::min()});
            case 8:
                return node(FloatLiteral{-0.0});
            case 9:
                return node(Unary{UnaryOp::Negate, one()});
            case 10:
                return node(Unary{UnaryOp::Not, one()});
            case 11:
                return node(Conditional{one(), one(), one()});
            case 12:
                return node(Let{{"Y", {}}, one(), one()});
            case 13:
                return node(ListValue{some(depth), one()});
            case 14:
                return node(StructValue{some(depth)});
            case 15:
                return node(TupleValue{some(depth)});
            case 16:
                return node(Call{"f", some(depth), true});
            case 17:
                return node(ListValue{some(depth), nullptr});
            case 18:
                return node(Unary{UnaryOp::Negate, make(0)});
            default:
                return node(Binary{static_cast<BinaryOp>(random_() % 15), one(), one()});
        }
    }

  private:
    template <class Node>
    ExprPtr node(Node value) {
        return std::make_unique<Expr>(Expr{std::move(value), {}});
    }
    std::vector<ExprPtr> some(int depth) {
        std::vector<ExprPtr> list;
        list.push_back(make(depth - 1));
        list.push_back(make(depth - 1));
        return list;
    }
    std::mt19937 random_;
};

// -(3) is the literal -3 once it is read; a tree the parser cannot make is none of ours.
bool negates_literal(const std::string& outlined) {
    for (std::size_t at = 0; (at = outlined.find("(unary0 (", at)) != std::string::npos; ++at) {
        const std::string_view operand = std::string_view(outlined).substr(at + 9);
        if ((operand.starts_with("int ") && operand[4] != '-') || (operand.starts_with("float ") && operand[6] != '-')) return true;
    }
    return false;
}

TEST(Expr, PrintsTextThatGivesTheSameTree) {
    int compared = 0;
    for (unsigned seed = 0; seed < 4000; ++seed) {
        RandomExpr random(seed);
        const ExprPtr expr = random.make(static_cast<int>(seed % 5));
        const std::string expected = outline(*expr);
        if (negates_literal(expected)) continue;
        const std::string text = print(*expr);
        EXPECT_EQ(value_outline(text), expected) << text;
        ++compared;
    }
    EXPECT_GT(compared, 1000);
}

TEST(Expr, PrintsNoNeedlessBrackets) {
    for (const char* text :
         {"A + B * C", "A - B - C", "A - (B - C)", "(A + B) * C", "-X ^ 2", "(-X) ^ 2", "-3 + X", "X * -3", "~A = B && C", "[X | R]",
          "if A = 1 then 2 else 3 end", "let X = 1 in X + 1 end", "f(A, (1, 2), :(3, 4.0))", "A = 1 && (B = 2 || C)"}) {
        EXPECT_EQ(print(constant_value(parsed(std::string("const x = ") + text + "."))), text);
    }
}

}  // namespace
}  // namespace meld::syntax
