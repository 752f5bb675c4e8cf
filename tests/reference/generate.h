// Random programs, made rule by rule: each new rule has results on a sample world, so that programs do not die out.
#pragma once

#include "draft.h"
#include "value.h"

namespace meld::reference {

struct Generated {
    Draft draft;
    // What the compiler says where it refuses a program that the generator holds to be right.
    std::string refused = {};
    std::uint64_t tried = 0, kept = 0;  // Blocks of rules.
};

Generated make_program(std::uint64_t seed);

}  // namespace meld::reference
