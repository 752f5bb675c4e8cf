// What can be typed, and what is said of what cannot.
#include "runtime/ask/debug/command.h"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <array>
#include <limits>
#include <string_view>

namespace meld::debug {
namespace {

template <class Kind>
Kind read(std::string_view line) {
    const Result<Command> command = parse_command(line);
    EXPECT_TRUE(command.has_value()) << line << ": " << command.error().message();
    EXPECT_TRUE(command && std::holds_alternative<Kind>(*command)) << line;
    return command && std::holds_alternative<Kind>(*command) ? std::get<Kind>(*command) : Kind{};
}

TEST(DebugCommand, Moves) {
    EXPECT_EQ(read<Step>("step").ticks, 1);
    EXPECT_EQ(read<Step>(" \t step   12 \r").ticks, 12);
    EXPECT_EQ(read<Back>("back").ticks, 1);
    EXPECT_EQ(read<Back>("back 9223372036854775807").ticks, std::numeric_limits<std::int64_t>::max());
    EXPECT_EQ(read<To>("to 0").tick, 0);
    read<debug::Run>("run");
    read<Quit>("quit");
}

TEST(DebugCommand, Questions) {
    EXPECT_FALSE(read<Facts>("facts").catom);
    EXPECT_EQ(read<Facts>("facts dist").name, "dist");
    for (const std::string_view line : {"facts @42 dist", "facts dist @42"}) {
        EXPECT_EQ(read<Facts>(line).catom, 42U);
        EXPECT_EQ(read<Facts>(line).name, "dist");
    }
    EXPECT_EQ(read<Facts>("facts @18446744073709551615").catom, std::numeric_limits<std::uint64_t>::max());
    EXPECT_EQ(read<Query>("query  dist(A, D),  D > 9 ").body, "dist(A, D),  D > 9");
    read<Where>("where");
    read<Where>("catoms");
    EXPECT_FALSE(read<Diff>("diff").since);
    EXPECT_EQ(read<Diff>("diff 7").since, 7);
}

TEST(DebugCommand, Breaks) {
    EXPECT_EQ(read<Until>("until dist(A, D),  D > 9").body, "dist(A, D),  D > 9");
    EXPECT_EQ(read<Watch>("watch dist(A, 9)").body, "dist(A, 9)");
    EXPECT_EQ(read<Break>("break gradient.meld:12").rule, "gradient.meld:12");
    EXPECT_EQ(read<Break>("break dist").condition, "");
    EXPECT_EQ(read<Break>("break dist if D > 3,  D < 9").condition, "D > 3,  D < 9");
    read<Breaks>("breaks");
    EXPECT_EQ(read<Delete>("delete 3").number, 3U);
    EXPECT_FALSE(read<Delete>("delete all").number);
}

TEST(DebugCommand, ByHand) {
    EXPECT_EQ(read<Change>("give token(@3,  7).").fact, "token(@3,  7).");
    EXPECT_TRUE(read<Change>("give wall(@1)").gives);
    EXPECT_FALSE(read<Change>("take wall(@1)").gives);
    read<Events>("events");
    EXPECT_EQ(read<SaveEvents>("save-events by hand.toml").path, "by hand.toml");
}

TEST(DebugCommand, HelpTellsAll) {
    const std::string all = read<Help>("help").text;
    for (const std::string_view name : {"step", "back", "to", "run", "until", "break", "watch", "breaks", "delete", "facts", "query",
                                        "where", "catoms", "diff", "help", "quit"}) {
        const std::string one = read<Help>(fmt::format("help {}", name)).text;
        EXPECT_TRUE(one.starts_with(name)) << one;
        EXPECT_THAT(all, testing::HasSubstr(one));
    }
}

TEST(DebugCommand, MistakesNameTheCure) {
    struct Case {
        std::string_view line, message;
    };
    constexpr std::array kCases = {
        Case{"stp", "there is no command 'stp'. Did you mean 'step'?"},
        Case{"brake 12", "there is no command 'brake'. Did you mean 'break'?"},
        Case{"break", "break: the rule is missing. Write break RULE [if BODY]"},
        Case{"break 12 when D > 3", "break: 'when' is too much. Write break RULE [if BODY]"},
        Case{"break 12 if", "break: the body behind if is missing. Write break RULE [if BODY]"},
        Case{"watch", "watch: the body is missing. Write watch BODY"},
        Case{"delete 0", "delete: '0' is no whole number from 1 on. Write delete N"},
        Case{"help bakc", "there is no command 'bakc'. Did you mean 'back'?"},
        Case{"step 0", "step: '0' is no whole number from 1 on. Write step [N]"},
        Case{"step 3x", "step: '3x' is no whole number from 1 on. Write step [N]"},
        Case{"back -1", "back: '-1' is no whole number from 1 on. Write back [N]"},
        Case{"to", "to: the tick is missing. Write to T"},
        Case{"to -1", "to: '-1' is no whole number from 0 on. Write to T"},
        Case{"to 3 4", "to: '4' is too much. Write to T"},
        Case{"to 9223372036854775808", "to: 9223372036854775808 is too large. Write to T"},
        Case{"run 3", "run: '3' is too much. Write run"},
        Case{"facts a b", "facts: 'b' is a second name. Write facts [@N] [NAME]"},
        Case{"facts @1 @2", "facts: @2 is a second catom. Write facts [@N] [NAME]"},
        Case{"facts @", "facts: '' is no whole number from 0 on. Write facts [@N] [NAME]"},
        Case{"facts @x", "facts: 'x' is no whole number from 0 on. Write facts [@N] [NAME]"},
        Case{"diff x", "diff: 'x' is no whole number from 0 on. Write diff [T]"},
    };
    for (const Case& each : kCases) {
        const Result<Command> command = parse_command(each.line);
        ASSERT_FALSE(command) << each.line;
        EXPECT_EQ(command.error().message(), each.message);
        EXPECT_EQ(command.error().code, ExitCode::UsageOrWorld);
    }
}

}  // namespace
}  // namespace meld::debug
