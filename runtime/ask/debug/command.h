// What can be typed in a session of the debugger, and what it means.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

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
struct Reverse {};  // Back to where a break or a watch ended a way, or would have.
struct Until {
    std::string body = {};  // In Meld.
};
struct Break {
    std::string rule = {};       // 12, gradient.meld:12 or dist.
    std::string condition = {};  // In Meld, with the variables of the rule; empty: none.
};
struct Watch {
    std::string body = {};  // In Meld.
};
struct Breaks {};  // Those that there are, and watches.
struct Delete {
    std::optional<std::uint64_t> number = {};  // Otherwise all.
};
struct Change {
    std::string fact = {};  // In Meld, without variables.
    bool gives = true;      // Otherwise it is taken.
};
// Catoms fail: kill, hang, restart.
struct Kill {
    std::string verb = "kill";
    std::vector<std::uint64_t> catoms = {};
    std::string body = {};  // Otherwise those for which it holds, in Meld: the first variable that is a catom.
};
// Links fail: cut, heal, jam.
struct StrikeLinks {
    std::string verb = "cut";
    std::int64_t ticks = 0;  // Of a jam.
    // All links of one catom, or that of two. `around`: the links between these catoms, or those for which the body holds, and all others.
    std::vector<std::uint64_t> catoms = {};
    bool around = false;
    std::string body = {};
};
struct Events {};  // Those that were made by hand.
struct SaveEvents {
    std::string path = {};
};
struct Fork {
    std::string name = {};
};
struct BranchList {};  // Those that there are.
struct Switch {
    std::string name = {};
};
struct Reload {};  // The program, as its file is now.
struct Save {
    std::string folder = {};
};
struct Facts {
    std::optional<std::uint64_t> catom = {};
    std::string name = {};  // Of a predicate; empty: all.
};
struct Query {
    std::string body = {};  // In Meld.
};
struct Why {
    std::string fact = {};  // In Meld.
    bool holds = true;      // Otherwise why it does not.
    std::optional<std::uint64_t> depth = {};
    bool all = false;
    bool replay = true;  // What made linear facts is looked for, by making the run again.
};
struct History {
    std::string fact = {};  // In Meld.
};
struct Messages {
    std::optional<std::uint64_t> catom = {};  // Otherwise over all links.
};
struct Depends {
    std::string fact = {};                   // In Meld, without variables.
    std::optional<std::int64_t> ticks = {};  // So many at most.
};
struct Rules {
    std::string predicate = {};  // Whose facts they give; empty: all.
};
struct Predicates {};
struct Where {};
struct Diff {
    std::optional<std::int64_t> since = {};  // Otherwise where the last command that moved came from.
};
struct Help {
    std::string text;
};
struct Quit {};

using Command = std::variant<Step, Back, To, Run, Reverse, Until, Break, Watch, Breaks, Delete, Change, Kill, StrikeLinks, Events,
                             SaveEvents, Fork, BranchList, Switch, Reload, Save, Facts, Query, Why, History, Messages, Depends, Rules,
                             Predicates, Where, Diff, Help, Quit>;

// A line with a command; not an empty one. Errors say what is wrong with it and how the command is written.
Result<Command> parse_command(std::string_view line);

// For completion: what there is, and how the words after the name are written, such as "RULE [if BODY]"; empty: there are none, or there is
// no such command.
std::span<const std::string_view> command_names();
std::string_view arguments_of(std::string_view command);

}  // namespace meld::debug
