// Why a fact holds, or why it does not, as data. Each fact is in it once, with the ways by which it came or in which it failed; parts of
// a way refer to the facts that they rest on.
#pragma once

#include <cstdint>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "runtime/module/abi/module_abi.h"

namespace meld::inspect {

struct Explanation {
    struct Part {
        // Of a body: a fact that is there, what is not there, a condition that is met; or what fails, so that the way ends here.
        enum class Is { Fact, Absent, Condition, Fails } is = Is::Fact;
        std::string text = {};  // Meld, with the values of what is bound.
        std::optional<std::size_t> node = {};
        std::optional<std::int64_t> tick = {};  // In which it was so, if not after that of the answer.
        std::string note = {};
    };
    struct Way {
        std::string rule = {}, text = {}, file = {};  // The rule's name, it as Meld, and where it stands; empty: there is none.
        std::uint32_t line = 0;
        std::optional<u64> catom = {};                               // Of a linear rule: where it fired.
        std::vector<std::pair<std::string, std::string>> with = {};  // The rule's variables that have a value, and it as Meld.
        std::vector<Part> parts = {};
        std::string note = {};
    };
    struct Node {
        // Given: from outside, or by the program's text. Combined: an aggregate of all its ways. Made: by a linear rule, and stays or is
        // consumed. Asked: an action. Further: behind the depth that was asked for. Unknown: nothing that can be looked at says why.
        // Missing: it does not hold.
        enum class Is { Given, Sensed, Derived, Combined, Made, Further, Unknown, Missing } is = Is::Unknown;
        std::string fact = {};
        std::int64_t tick = 0;  // After which it holds, or does not.
        std::uint32_t rank = kAbsent;
        std::vector<Way> ways = {};
        std::uint64_t more = 0;                // Ways that are counted only.
        std::vector<std::string> others = {};  // Of a min, max or the like: what would hold if it were not for this.
        std::string note = {};
    };
    std::int64_t tick = 0;
    std::string asked = {};
    std::vector<Node> nodes = {};
    std::vector<std::size_t> roots = {};
    std::uint64_t more = 0;  // Facts that match and are not explained.

    // Notes where a fact rests on itself: only where ranks do not say what rests on what, as along a tree that is none.
    void mark_circles();

    // Lines with two blanks for each step; each fact once.
    std::string to_text() const;
    // A flat list of nodes, whose parts name others by their place in it.
    nlohmann::ordered_json to_json() const;
    // For Graphviz.
    std::string to_dot() const;
};

}  // namespace meld::inspect
