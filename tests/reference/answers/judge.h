// Judges answers of `why` and `why-not` about a run: whether every word of them is so. Shares nothing with runtime/ask; it knows the
// program, and what there was after every tick.
#pragma once

#include <string>

#include "tests/reference/answers/answer.h"
#include "tests/reference/evaluator/bodies.h"

namespace meld::reference {

// What was asked for.
struct AskedFor {
    std::string fact = {};
    std::int64_t tick = 0;
    std::size_t depth = 0;  // 0: to the end.
    bool all = false;
};

// How much of it was looked at.
struct Judged {
    std::uint64_t nodes = 0, ways = 0, parts = 0;
    std::uint64_t unranked = 0;  // Facts of which the answer says that ranks do not say what they rest on.
    std::uint64_t unknown = 0;   // Facts that rest on what cannot be looked up.
    std::uint64_t combined = 0, made = 0, quarantines = 0;
    void add(const Judged& other);
};

// What is wrong with an answer to why(asked), where the fact holds; empty: nothing. Every fact holds in the tick that is named, and its
// rule gives it from facts, absences and conditions that are so; ranks fall; nothing rests on itself; leaves are given, sensed, or made by
// a linear rule in the tick that is named; of combined values nothing is left out; what a best value has beaten is worse.
std::string judge_why(const Past& past, const Answer& answer, const AskedFor& asked, Judged& judged);

// The same of why_not(asked), where the fact does not hold. Every head that gives such facts is there, with parts that can be met together
// and one that then cannot, whatever the variables that are left; what would hold otherwise is asked about in turn; and what is said
// where that ends is so: given or sensed, a better value, or a quarantine.
std::string judge_why_not(const Past& past, const Answer& answer, const AskedFor& asked, Judged& judged);

}  // namespace meld::reference
