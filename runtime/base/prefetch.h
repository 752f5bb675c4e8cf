// Memory that is needed soon is asked for ahead, so that loops over what lies anywhere in it need not wait for each place.
#pragma once

namespace meld {

// The empty statement keeps compilers from taking a function that does nothing else for one that does nothing.
[[gnu::always_inline]] inline void ask_for(const void* memory) {
    __builtin_prefetch(memory);
    asm volatile("");
}

}  // namespace meld
