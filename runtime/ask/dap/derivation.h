// What a fact rests on, as a call stack: the rule that gave the fact is called by nobody, and "calls" the one that gave a fact of its body.
#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "runtime/ask/dap/message.h"
#include "runtime/ask/dap/rules.h"
#include "runtime/ask/dap/variables.h"

namespace meld::dap {

class Derivation {
  public:
    // From the answer to `why`, of which the first fact is taken.
    explicit Derivation(Json answer) : answer_(std::move(answer)) {}

    struct Frame {
        std::string fact = {};
        const Rule* rule = nullptr;  // Null: it is not among the rules.
        std::size_t node = 0;        // Of the answer.
    };
    // From the fact down: each frame is the first fact in the body before it that a rule has given.
    std::vector<Frame> frames(const Rules& rules) const;
    // What the fact of a frame rests on; each part can be followed, too. The derivation outlives the table's numbers.
    Variables rests_on(std::size_t node, VariableTable& table) const;

  private:
    Variables way(const Json& way, VariableTable& table) const;
    Variable part(const Json& part, VariableTable& table) const;

    Json answer_;
};

}  // namespace meld::dap
