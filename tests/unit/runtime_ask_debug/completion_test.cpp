// What a line of a session can go on with.
#include "runtime/ask/debug/completion.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <string>
#include <string_view>
#include <vector>

namespace meld::debug {
namespace {

using testing::Contains;
using testing::ElementsAre;
using testing::IsEmpty;

Vocabulary vocabulary() {
    return {.predicates = {"dist", "source", "dist", "discovered"},
            .rules = {"dist", "a.meld:10"},
            .lines = {"10", "12"},
            .heads = {"dist"},
            .catoms = [](std::string_view digits) { return catoms_that_begin(digits, 130, [](std::uint64_t id) { return id != 12; }); }};
}

Completion of(std::string_view line) { return complete(line, vocabulary()); }

TEST(DebugCompletion, OfCommands) {
    EXPECT_THAT(of("wher").words, ElementsAre("where"));
    EXPECT_EQ(of("  wh").begin, 2U);
    EXPECT_EQ(of("wher").after, " ");
    EXPECT_THAT(of("").words, Contains("step"));
    EXPECT_THAT(of("help wher").words, ElementsAre("where"));
    EXPECT_THAT(of("nonsense d").words, IsEmpty());
    EXPECT_THAT(of("step d").words, IsEmpty());
}

TEST(DebugCompletion, OfWordsAsTheCommandTakesThem) {
    EXPECT_THAT(of("break 1").words, ElementsAre("10", "12"));
    EXPECT_THAT(of("break ").words, ElementsAre("a.meld:10", "dist"));
    EXPECT_THAT(of("break 10 if di").words, ElementsAre("discovered", "dist"));
    EXPECT_THAT(of("rules d").words, ElementsAre("dist"));
    EXPECT_THAT(of("facts @4 d").words, ElementsAre("discovered", "dist"));
    EXPECT_THAT(of("why --").words, ElementsAre("--all", "--depth", "--no-replay"));
    EXPECT_THAT(of("why-not --").words, ElementsAre("--depth"));
}

TEST(DebugCompletion, OfBodies) {
    const Completion found = of("query dist(A, D), not sou");
    EXPECT_THAT(found.words, ElementsAre("source"));
    EXPECT_EQ(found.begin, std::string_view("query dist(A, D), not ").size());
    EXPECT_EQ(found.after, "(");
    EXPECT_THAT(of("query s = \"so").words, IsEmpty());
    EXPECT_THAT(of("query s = \"\\\"\", so").words, ElementsAre("source"));
}

TEST(DebugCompletion, OfCatoms) {
    EXPECT_THAT(of("facts @12").words, ElementsAre("120", "121", "122", "123", "124", "125", "126", "127", "128", "129"));
    EXPECT_EQ(of("facts @12").begin, 7U);
    EXPECT_THAT(of("why dist(@5").words, ElementsAre("5", "50", "51", "52", "53", "54", "55", "56", "57", "58", "59"));
    EXPECT_THAT(of("why dist(@0").words, ElementsAre("0"));
    EXPECT_THAT(of("why dist(@00").words, IsEmpty());
    EXPECT_THAT(of("why dist(@130").words, IsEmpty());
    EXPECT_THAT(of("why dist(@99999999999999999999999").words, IsEmpty());
    EXPECT_EQ(of("why dist(@").words.size(), 129U);
}

TEST(DebugCompletion, OfManyCatomsIsBounded) {
    const auto all = [](std::uint64_t) { return true; };
    EXPECT_EQ(catoms_that_begin("", ~std::uint64_t{0}, all).size(), 200U);
    const std::vector<std::string> far = catoms_that_begin("1844674407370955161", ~std::uint64_t{0}, all);
    EXPECT_THAT(far, ElementsAre("1844674407370955161", "18446744073709551610", "18446744073709551611", "18446744073709551612",
                                 "18446744073709551613", "18446744073709551614"));
}

}  // namespace
}  // namespace meld::debug
