// Diagnostics as people and editors see them.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "compiler/diagnostics/diagnostics.h"

namespace meld::diagnostics {
namespace {

using testing::HasSubstr;

std::string rendered(const std::string& text, const Diagnostic& diagnostic) {
    source::FileSet files;
    files.add("a.meld", text);
    return render_text(files, {diagnostic}, Colour::Never);
}

TEST(RenderText, ShowsPlaceLineCaretsLabelsAndHelp) {
    const std::string text = "type dist(node, int).\n\ndist(A) :- root(A).\n";
    EXPECT_EQ(
        rendered(text, {Kind::ArityMismatch, {0, 23, 30}, "`dist` has 2 arguments, not 1", {{{0, 5, 20}, "declared here"}}, "dist(A, _)"}),
        R"(error[E0303]: `dist` has 2 arguments, not 1
 --> a.meld:3:1
  |
1 | type dist(node, int).
  |      --------------- declared here
...
3 | dist(A) :- root(A).
  | ^^^^^^^
  |
  = help: dist(A, _)
)");
}

TEST(RenderText, PutsALabelOfAnotherFileBehind) {
    source::FileSet files;
    files.add("a.meld", "p(A).");
    files.add("b.meld", "type p(node, int).");
    const std::string page = render_text(files, {{Kind::ArityMismatch, {0, 0, 4}, "wrong", {{{1, 5, 6}, "declared here"}}}}, Colour::Never);
    EXPECT_THAT(page, HasSubstr(" ::: b.meld:1\n1 | type p(node, int).\n  |      - declared here\n"));
}

TEST(RenderText, AlignsCaretsUnderTabs) {
    EXPECT_THAT(rendered("\tp(\tA).", {Kind::SyntaxError, {0, 4, 5}, "m"}), HasSubstr("|     p(  A).\n  |         ^\n"));
}

TEST(RenderText, CountsCharactersAndNotBytes) {
    EXPECT_THAT(rendered("p(\"\xc3\xa9\xc3\xa9\", A).", {Kind::SyntaxError, {0, 10, 11}, "m"}), HasSubstr("\n  |         ^\n"));
}

TEST(RenderText, MarksBothEndsOfASpanOverLines) {
    const std::string page = rendered("p(A) :-\n  q(A),\n  r(A).\n", {Kind::SyntaxError, {0, 5, 22}, "m"});
    EXPECT_THAT(page, HasSubstr("1 | p(A) :-\n  |      ^^ from here ...\n"));
    EXPECT_THAT(page, HasSubstr("3 |   r(A).\n  |   ^^^^ ... to here\n"));
}

TEST(RenderText, PointsBehindTheLastCharacter) {
    EXPECT_THAT(rendered("p(A)", {Kind::MissingPeriod, {0, 4, 4}, "m"}), HasSubstr("1 | p(A)\n  |     ^\n"));
    EXPECT_THAT(rendered("p(A)\n", {Kind::MissingPeriod, {0, 5, 5}, "m"}), HasSubstr("2 | \n  | ^\n"));
    EXPECT_THAT(rendered("", {Kind::SyntaxError, {0, 0, 0}, "m"}), HasSubstr("a.meld:1:1\n"));
}

TEST(RenderText, CutsLongLinesAroundTheSpan) {
    const std::string text = std::string(5000, 'a') + "XYZ" + std::string(5000, 'b');
    const std::string page = rendered(text, {Kind::SyntaxError, {0, 5000, 5003}, "m"});
    EXPECT_LT(page.size(), 400u);
    EXPECT_THAT(page, HasSubstr("aXYZb"));
    EXPECT_THAT(page, HasSubstr("1 | ...aaa"));
    const std::size_t source = page.find("XYZ") - page.rfind('\n', page.find("XYZ"));
    const std::size_t carets = page.find("^^^") - page.rfind('\n', page.find("^^^"));
    EXPECT_EQ(source, carets);
}

TEST(RenderText, CutsALongSpanOnALongLine) {
    EXPECT_LT(rendered(std::string(100000, 'a'), {Kind::SyntaxError, {0, 0, 100000}, "m"}).size(), 500u);
}

TEST(RenderText, ShowsNoControlCharacters) {
    const std::string page = rendered(std::string("p(\x1b[31mA).\x01", 10), {Kind::SyntaxError, {0, 2, 3}, "m"});
    EXPECT_EQ(page.find('\x1b'), std::string::npos);
}

TEST(RenderText, ColoursOnlyWhenAsked) {
    source::FileSet files;
    files.add("a.meld", "p(A).");
    const Diagnostic diagnostic{Kind::SyntaxError, {0, 0, 1}, "m"};
    EXPECT_THAT(render_text(files, {diagnostic}, Colour::Always), HasSubstr("\x1b[1;31merror[E0110]"));
    EXPECT_EQ(render_text(files, {diagnostic}, Colour::Never).find('\x1b'), std::string::npos);
}

TEST(RenderText, SetsDiagnosticsApartByOneEmptyLine) {
    source::FileSet files;
    files.add("a.meld", "p(A).");
    const Diagnostic diagnostic{Kind::SyntaxError, {0, 0, 1}, "m"};
    EXPECT_THAT(render_text(files, {diagnostic, diagnostic}, Colour::Never), HasSubstr("^\n\nerror"));
}

TEST(RenderJson, HasEveryField) {
    source::FileSet files;
    files.add("a.meld", "p(A).\nq(B).\n");
    const std::string text = render_json(files, {{Kind::SingleUse, {0, 2, 3}, "once", {{{0, 8, 9}, "here"}}, "write `_`"}});
    const auto array = nlohmann::json::parse(text);
    ASSERT_EQ(array.size(), 1u);
    EXPECT_EQ(array[0]["code"], "W0402");
    EXPECT_EQ(array[0]["severity"], "warning");
    EXPECT_EQ(array[0]["message"], "once");
    EXPECT_EQ(array[0]["path"], "a.meld");
    EXPECT_EQ(array[0]["line"], 1);
    EXPECT_EQ(array[0]["column"], 3);
    EXPECT_EQ(array[0]["end_line"], 1);
    EXPECT_EQ(array[0]["end_column"], 4);
    EXPECT_EQ(array[0]["labels"][0]["line"], 2);
    EXPECT_EQ(array[0]["labels"][0]["text"], "here");
    EXPECT_EQ(array[0]["help"], "write `_`");
}

TEST(RenderJson, HasTheFixesOfFilesOnDisk) {
    source::FileSet files;
    files.add("a.meld", "p(A, X).\nq(B).\n", source::File::From::Disk);
    files.add("library.meld", "r(A).\n");
    Diagnostic diagnostic{Kind::SingleUse, {0, 5, 6}, "once"};
    diagnostic.fixes = {safe(write({0, 5, 6}, "_")), write({1, 0, 1}, "s"), leave_out({0, 9, 13}, "it", Edit::Fit::Item)};
    const auto fixes = nlohmann::json::parse(render_json(files, {diagnostic}))[0]["fixes"];
    ASSERT_EQ(fixes.size(), 2u);
    EXPECT_EQ(fixes[0], nlohmann::json::parse(R"({"title": "Write `_`", "safe": true, "edits": [{"path": "a.meld", "line": 1, "column": 6,
                                                  "end_line": 1, "end_column": 7, "text": "_"}]})"));
    EXPECT_EQ(fixes[1]["safe"], false);
    EXPECT_EQ(fixes[1]["edits"][0]["end_line"], 3);
}

TEST(RenderJson, JoinsTheMessagesOfPrograms) {
    source::FileSet first, second;
    first.add("a.meld", "p(A).");
    second.add("b.meld", "q(A).");
    JsonMessages messages;
    messages.add(first, {{Kind::SyntaxError, {0, 0, 1}, "one"}, {Kind::SyntaxError, {0, 1, 2}, "two"}});
    messages.add(second, {});
    messages.add(second, {{Kind::SyntaxError, {0, 0, 1}, "three"}});
    const auto array = nlohmann::json::parse(messages.text());
    ASSERT_EQ(array.size(), 3u);
    EXPECT_EQ(array[1]["message"], "two");
    EXPECT_EQ(array[2]["path"], "b.meld");
}

TEST(RenderJson, SurvivesTextThatIsNoUtf8) {
    source::FileSet files;
    files.add("\xff.meld", "p");
    EXPECT_NO_THROW(static_cast<void>(render_json(files, {{Kind::SyntaxError, {0, 0, 1}, "\xff"}})));
    EXPECT_EQ(nlohmann::json::parse(render_json(files, {})).size(), 0u);
}

}  // namespace
}  // namespace meld::diagnostics
