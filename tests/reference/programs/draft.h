// A program as the generator and the shrinker handle it: declarations and rules in pieces of text.
#pragma once

#include <string>
#include <vector>

#include "runtime/base/error.h"
#include "tests/retraction/case.h"

namespace meld::reference {

struct Declaration {
    std::string name;
    std::string text;  // type p(node, int).
};

struct DraftRule {
    std::vector<std::string> heads = {};
    std::vector<std::string> body = {};
    bool linear = false;      // -o
    std::string select = {};  // desc => X
};

// How linear facts go to nodes that rules know by value: not at all, in one hop, or over links; the latter two only in graphs.
enum class Reach { None, OneHop, Routes };

struct Draft {
    // The text says so in its first line.
    Reach reach = Reach::None;
    std::vector<Declaration> declarations;
    std::vector<DraftRule> rules;
    // Of a program that was read from a file, instead of the pieces.
    std::string text = {};
    // What cases give and take.
    std::vector<retraction::Given> given;
};

std::string print(const DraftRule& rule);
// What a text says of it.
Reach reach_of(const std::string& text);
inline bool goes_far(const std::string& text) { return reach_of(text) != Reach::None; }
// As a .meld file.
std::string print(const Draft& draft);

// A program and what happens to it: all that is needed to see a failure again.
struct Trial {
    Draft draft;
    retraction::Case world;
};

// One file: the program, with what happens to it as comments; and back.
std::string print(const Trial& trial);
Result<Trial> parse_trial(const std::string& text);

}  // namespace meld::reference
