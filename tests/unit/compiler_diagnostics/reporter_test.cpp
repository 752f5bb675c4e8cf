// The table of kinds, the collector, and suggestions of names.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <set>

#include "compiler/diagnostics/diagnostics.h"
#include "compiler/diagnostics/explain.h"

namespace meld::diagnostics {
namespace {

TEST(Kinds, HaveCodesThatOccurOnceAndSayTheirSeverity) {
    std::set<std::string_view> codes;
    for (const KindInfo& row : all_kinds()) {
        EXPECT_TRUE(codes.insert(row.code).second) << row.code;
        const char letter = row.severity == Severity::Error ? 'E' : row.severity == Severity::Warning ? 'W' : 'N';
        EXPECT_EQ(row.code[0], letter) << row.code;
        EXPECT_EQ(row.code.size(), 5u) << row.code;
    }
}

TEST(Kinds, AreFoundByCodeAndByName) {
    ASSERT_NE(find_kind("E0301"), nullptr);
    EXPECT_EQ(find_kind("E0301")->name, "UnknownPredicate");
    EXPECT_EQ(find_kind("UnknownPredicate"), find_kind("E0301"));
    EXPECT_EQ(find_kind("E9999"), nullptr);
}

TEST(Explanation, HasMeaningExampleAndCureForEachKind) {
    for (std::size_t i = 0; i < all_kinds().size(); ++i) {
        const std::string page = explanation(static_cast<Kind>(i));
        EXPECT_THAT(page, testing::StartsWith(std::string(all_kinds()[i].code)));
        EXPECT_GT(std::count(page.begin(), page.end(), '\n'), 6) << page;
        EXPECT_THAT(page, testing::HasSubstr("\n    ")) << page;
    }
}

TEST(Reporter, SortsByPlaceAndDropsRepeats) {
    Reporter report;
    report.add(Kind::SyntaxError, {0, 9, 10}, "later");
    report.add(Kind::SyntaxError, {0, 3, 4}, "first");
    report.add(Kind::SyntaxError, {0, 9, 10}, "later again");
    report.add(Kind::SingleUse, {0, 9, 10}, "another kind");
    report.add(Kind::SyntaxError, {1, 0, 1}, "another file");
    const std::vector<Diagnostic> sorted = report.sorted();
    ASSERT_EQ(sorted.size(), 4u);
    EXPECT_EQ(sorted[0].message, "first");
    EXPECT_EQ(sorted[1].message, "later");
    EXPECT_EQ(sorted[2].message, "another kind");
    EXPECT_EQ(sorted[3].message, "another file");
    EXPECT_EQ(report.error_count(), 3u);
}

TEST(Reporter, CountsNoWarningsAsErrors) {
    Reporter report;
    report.add(Kind::SingleUse, {0, 0, 1}, "once").help = "write `_`";
    EXPECT_FALSE(report.has_errors());
    EXPECT_EQ(report.sorted()[0].help, "write `_`");
}

TEST(NearestName, SuggestsASlipOfTheHand) {
    const std::vector<std::string> names = {"neighbor", "distance", "setColor", "p"};
    EXPECT_EQ(nearest_name("nieghbor", names), "neighbor");
    EXPECT_EQ(nearest_name("distnace", names), "distance");
    EXPECT_EQ(nearest_name("neighbour", names), "neighbor");
    EXPECT_EQ(nearest_name("setcolor", names), "setColor");
    EXPECT_EQ(nearest_name("bodies", {"body", "nodes"}), "body");
    EXPECT_EQ(nearest_name("body", {"bodies", "boddle"}), "bodies");
    EXPECT_EQ(nearest_name("copies", {"bodies", "body"}), "bodies");
}

TEST(NearestName, SuggestsNothingFarAway) {
    EXPECT_EQ(nearest_name("colour", {"distance", "p", "q"}), "");
    EXPECT_EQ(nearest_name("q", {"p", "r"}), "");
    EXPECT_EQ(nearest_name("", {"p"}), "");
    EXPECT_EQ(nearest_name("dist", {}), "");
    EXPECT_EQ(nearest_name(std::string(100000, 'x'), {"x"}), "");
}

TEST(NearestName, TakesTheFirstInOrderAmongEquallyNear) { EXPECT_EQ(nearest_name("lever", {"levet", "level"}), "level"); }

}  // namespace
}  // namespace meld::diagnostics
