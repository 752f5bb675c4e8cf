#include "runtime/base/terminal/terminal_text.h"

#include <gtest/gtest.h>

namespace meld {
namespace {

TEST(TerminalText, LeavesTextAsItIs) {
    for (const char* text : {"", "plain", "Größe π ☃ 🤖", "two\nlines\tand a tab", "a \\ b", "עברית"}) EXPECT_EQ(visible(text), text);
}

TEST(TerminalText, EscapesWhatATerminalObeys) {
    EXPECT_EQ(visible("\x1b[31mred\x1b[0m"), "\\x1b[31mred\\x1b[0m");
    EXPECT_EQ(visible("a\rb\bc\x7f"), "a\\x0db\\x08c\\x7f");
    EXPECT_EQ(visible(std::string_view("a\0b", 3)), "a\\x00b");
    EXPECT_EQ(visible("C1: \xc2\x9b"
                      "2J"),
              "C1: \\xc2\\x9b2J");
}

TEST(TerminalText, EscapesWhatTurnsTheDirectionOfReading) {
    for (const char* text : {"\u202a", "\u202e", "\u2066", "\u2069"}) EXPECT_EQ(visible(text).substr(0, 7), "\\xe2\\x8") << text;
    EXPECT_EQ(visible("\u2029\u202f\u2065"), "\u2029\u202f\u2065");
}

TEST(TerminalText, EscapesBytesThatAreNoText) {
    EXPECT_EQ(visible("\xff"), "\\xff");
    EXPECT_EQ(visible("\x9b"), "\\x9b");
    EXPECT_EQ(visible("cut \xe2\x98"), "cut \\xe2\\x98");
    EXPECT_EQ(visible("\xed\xa0\x80 surrogate"), "\\xed\\xa0\\x80 surrogate");
    EXPECT_EQ(visible("\xc1\x9b overlong"), "\\xc1\\x9b overlong");
}

TEST(TerminalText, LeavesWhatItMade) {
    const std::string once = visible("\x1b\xff\u202e");
    EXPECT_EQ(visible(once), once);
}

}  // namespace
}  // namespace meld
