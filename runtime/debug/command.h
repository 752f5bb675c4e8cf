// What can be typed in a session of the debugger, and what it means.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <variant>

#include "runtime/base/error.h"

namespace meld::debug {

struct Step {
    std::int64_t ticks = 1;
};
struct Back {
    std::int64_t ticks = 1;
};
struct To {
    std::int64_t tick = 0;
};
struct Run {};
struct Facts {
    std::optional<std::uint64_t> catom = {};
    std::string name = {};  // Of a predicate; empty: all.
};
struct Where {};
struct Diff {
    std::optional<std::int64_t> since = {};  // Otherwise where the last command that moved came from.
};
struct Help {
    std::string text;
};
struct Quit {};

using Command = std::variant<Step, Back, To, Run, Facts, Where, Diff, Help, Quit>;

// A line with a command; not an empty one. Errors say what is wrong with it and how the command is written.
Result<Command> parse_command(std::string_view line);

}  // namespace meld::debug
