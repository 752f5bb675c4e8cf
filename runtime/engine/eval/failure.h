// Descriptions of failures of a program while it runs.
#pragma once

#include <cstddef>
#include <string>

#include "runtime/module/abi/module_abi.h"

namespace meld::eval {

// Chunks of scratch memory double, so an evaluation may use up to twice this. More means that a program copies without end, which the limit
// of derivations would stop only after the machine's memory is used up.
inline constexpr std::size_t kMaxChunk = std::size_t{1} << 29;

// Copied unchanged between processes.
struct Failure {
    Trap trap = Trap::None;
    u32 rule = 0;          // kNone32: no particular rule.
    u32 column = kNone32;  // If no rule is the cause: the column that the catom could not store.
    u64 catom = 0;         // Id
    i64 tick = 0;
    Value left = {}, right = {};  // The operands; floats if `real`.
    bool real = false;
    char text[kMaxTrapText_bytes] = {};  // The start of the string at fault; `left` is its length in bytes.
};

// The problem, with rule, catom, tick and operands.
std::string describe(const ModuleInfo& module, const Failure& failure);
// What to do about it; empty if the message says everything.
std::string cure(const Failure& failure);

}  // namespace meld::eval
