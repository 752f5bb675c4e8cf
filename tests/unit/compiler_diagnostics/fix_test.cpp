#include "compiler/diagnostics/fix.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace meld::diagnostics {
namespace {

using Fit = Edit::Fit;
using testing::IsEmpty;
using testing::SizeIs;

// Where `part` stands in the text, its first place.
Span at(std::string_view text, std::string_view part) {
    const auto begin = static_cast<std::uint32_t>(text.find(part));
    return {0, begin, begin + static_cast<std::uint32_t>(part.size())};
}

// The text after one edit, whose span is the first place of `part`.
std::string edited(const std::string& text, std::string_view part, std::string new_text, Fit fit) {
    source::FileSet files;
    files.add("a.meld", text);
    const std::vector<Fix> fixes =
        exact(files, {{.title = "t", .edits = {{at(text, part), std::move(new_text), fit}}}}, [](std::uint32_t) { return true; });
    Edits edits;
    edits.add(fixes.at(0).edits.at(0));
    return edits.applied(text);
}

TEST(Fix, LeavesOutAWordWithItsBlanks) {
    EXPECT_EQ(edited("type linear action p(node).", "linear", "", Fit::Word), "type action p(node).");
    EXPECT_EQ(edited("p(node, min int D).", "min", "", Fit::Word), "p(node, int D).");
    EXPECT_EQ(edited("p(A) .", ".", "", Fit::Word), "p(A)");
    EXPECT_EQ(edited("$p(A)", "$", "", Fit::Word), "p(A)");
    EXPECT_EQ(edited("p(A).  .\r\nq(A).\r\n", "  .", "", Fit::Word), "p(A).\r\nq(A).\r\n");
}

TEST(Fix, LeavesABlankBetweenWordsOfWhichOneGoes) {
    EXPECT_EQ(edited("d(A) -o !p(A).", "!", "", Fit::Word), "d(A) -o p(A).");
    EXPECT_EQ(edited("p(A), not $d(A)", "$", "", Fit::Word), "p(A), not d(A)");
    EXPECT_EQ(edited("p(A), not!d(A)", "!", "", Fit::Word), "p(A), not d(A)");
    EXPECT_EQ(edited("d(A) -o! p(A).", "!", "", Fit::Word), "d(A) -o p(A).");
}

TEST(Fix, WritesASignBehindWhatStandsBefore) {
    EXPECT_EQ(edited("p(@1) ;", ";", ".", Fit::Sign), "p(@1).");
    EXPECT_EQ(edited("p(@1) /* why */ ;", ";", ".", Fit::Sign), "p(@1) /* why */.");
    EXPECT_EQ(edited("p(@1)  // why\n  ;", ";", ".", Fit::Sign), "p(@1)  // why\n  .");
}

TEST(Fix, ReplacesTheNameThatACallBeginsWith) {
    EXPECT_EQ(edited("p(A, len (L)).", "len (L)", "llength", Fit::Name), "p(A, llength (L)).");
    EXPECT_EQ(edited("p(A) :- m-dist(A, D).", "m-dist(A, D)", "m-dust", Fit::Name), "p(A) :- m-dust(A, D).");
}

TEST(Fix, LeavesOutAnElementWithOneComma) {
    EXPECT_EQ(edited("a(A) -o h(A), b(A).", "h(A)", "1", Fit::Element), "a(A) -o b(A).");
    EXPECT_EQ(edited("a(A) -o b(A),\n    h(A).", "h(A)", "1", Fit::Element), "a(A) -o b(A).");
    EXPECT_EQ(edited("a(A) -o h(A).", "h(A)", "1", Fit::Element), "a(A) -o 1.");
    EXPECT_EQ(edited("a(A) -o b(A), // first,\n    h(A).", "h(A)", "1", Fit::Element), "a(A) -o b(A), // first,\n    1.");
    EXPECT_EQ(edited("a(A) -o h(A), // first,\n    b(A).", "h(A)", "1", Fit::Element), "a(A) -o // first,\n    b(A).");
    EXPECT_EQ(edited("a(A) -o b(A), /* , */ h(A).", "h(A)", "1", Fit::Element), "a(A) -o b(A), /* , */ 1.");
}

TEST(Fix, LeavesOutAnItemWithItsLinesAndNoComment) {
    EXPECT_EQ(edited("a(A).\n  b(A)\n  .  \nc(A).\n", "b(A)", "", Fit::Item), "a(A).\nc(A).\n");
    EXPECT_EQ(edited("a(A). b(A). c(A).\n", "b(A)", "", Fit::Item), "a(A). c(A).\n");
    EXPECT_EQ(edited("// Why.\nb(A).  // how\nc(A).\n", "b(A)", "", Fit::Item), "// Why.\n// how\nc(A).\n");
    EXPECT_EQ(edited("b(A).", "b(A)", "", Fit::Item), "");
    EXPECT_EQ(edited("a(A).\r\nb(A).\r\nc(A).\r\n", "b(A)", "", Fit::Item), "a(A).\r\nc(A).\r\n");
}

TEST(Fix, PutsAnItemOnALineOfItsOwn) {
    EXPECT_EQ(edited("a(A).  // so\nb(A).\n", "a(A)", "n.", Fit::After), "a(A).  // so\nn.\nb(A).\n");
    EXPECT_EQ(edited("a(A).", "a(A)", "n.", Fit::After), "a(A).\nn.");
    EXPECT_EQ(edited("a(A). b(A) :-\n  c(A).\n", "a(A)", "n.", Fit::After), "a(A). n. b(A) :-\n  c(A).\n");
    EXPECT_EQ(edited("a(A).\r\nb(A).\r\n", "a(A)", "n.", Fit::After), "a(A).\r\nn.\r\nb(A).\r\n");
    EXPECT_EQ(edited("a(A).\nb(A).\n", "b(A)", "n.", Fit::Before), "a(A).\nn.\nb(A).\n");
    EXPECT_EQ(edited("a(A). b(A).\n", "b(A)", "n.", Fit::Before), "a(A). n. b(A).\n");
    EXPECT_EQ(edited("b(A).\n", "b(A)", "n.", Fit::Before), "n.\nb(A).\n");
    EXPECT_EQ(edited("a(A).\r\nb(A).\r\n", "b(A)", "n.", Fit::Before), "a(A).\r\nn.\r\nb(A).\r\n");
}

TEST(Fix, IsNoneIfOneOfItsEditsIsInAFileThatStays) {
    source::FileSet files;
    files.add("a.meld", "a");
    files.add("b.meld", "b");
    const std::vector<Fix> fixes = {{.title = "both", .edits = {{{0, 0, 1}, "x"}, {{1, 0, 1}, "y"}}},
                                    {.title = "one", .edits = {{{1, 0, 1}, "y"}}}};
    EXPECT_THAT(exact(files, fixes, [](std::uint32_t) { return true; }), SizeIs(2));
    EXPECT_EQ(exact(files, fixes, [](std::uint32_t file) { return file == 1; }).at(0).title, "one");
    EXPECT_THAT(exact(files, fixes, [](std::uint32_t) { return false; }), IsEmpty());
}

TEST(Edits, CountEqualOnesOnceAndTakeNeighbours) {
    Edits edits;
    EXPECT_EQ(edits.applied("abcdef"), "abcdef");
    for (const Edit& edit : std::vector<Edit>{{{0, 3, 4}, "D"}, {{0, 1, 3}, ""}, {{0, 3, 4}, "D"}, {{0, 6, 6}, "!"}, {{0, 4, 4}, "+"}}) {
        ASSERT_TRUE(edits.fits(edit)) << edit.span.begin;
        edits.add(edit);
    }
    EXPECT_EQ(edits.applied("abcdef"), "aD+ef!");
}

TEST(Edits, DoNotFitWhereAnotherOneIs) {
    Edits edits;
    edits.add({{0, 2, 4}, "x"});
    edits.add({{0, 6, 6}, "y"});
    for (const Edit& edit : std::vector<Edit>{
             {{0, 1, 3}, ""}, {{0, 3, 3}, "z"}, {{0, 2, 4}, "z"}, {{0, 2, 2}, "x"}, {{0, 0, 9}, ""}, {{0, 6, 6}, "z"}, {{0, 5, 7}, ""}})
        EXPECT_FALSE(edits.fits(edit)) << edit.span.begin << " to " << edit.span.end;
    EXPECT_TRUE(edits.fits({{0, 4, 6}, ""}));
}

}  // namespace
}  // namespace meld::diagnostics
