// What goes wrong inside a program while it runs, in words.
#pragma once

#include <cstddef>
#include <string>

#include "runtime/abi/module_abi.h"

namespace meld::eval {

// Chunks of scratch memory double, so an evaluation may have twice this in all. More is a program that runs away by copying,
// which the limit of derivations stops only after the machine's memory is gone.
inline constexpr std::size_t kMaxChunk = std::size_t{1} << 29;

// Copied as it is between processes.
struct Failure {
    Trap trap = Trap::None;
    u32 rule = 0;          // kNone32: of none in particular.
    u32 column = kNone32;  // Where no rule is to blame: what the catom could not keep.
    u64 catom = 0;         // Id
    i64 tick = 0;
    Value left = {}, right = {};  // The operands; of floats where `real`.
    bool real = false;
    char text[kMaxTrapText_bytes] = {};  // Of a text at fault the start; `left` says how many bytes it has.
};

// The problem, with rule, catom, tick and operands.
std::string describe(const ModuleInfo& module, const Failure& failure);
// What to do about it; empty where the message says all.
std::string cure(const Failure& failure);

}  // namespace meld::eval
