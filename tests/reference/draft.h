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

struct Draft {
    // Linear facts go to nodes that rules know by value, each in one hop; only in graphs. The text says so in its first line.
    bool far = false;
    std::vector<Declaration> declarations;
    std::vector<DraftRule> rules;
    // Of a program that was read from a file, instead of the pieces.
    std::string text = {};
    // What cases give and take.
    std::vector<retraction::Given> given;
};

std::string print(const DraftRule& rule);
// Whether a text is of such a draft.
bool goes_far(const std::string& text);
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
