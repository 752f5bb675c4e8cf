// Memory for what grows while a catom is evaluated: pages that the machine provides when they are written to (Host::reserve).
#pragma once

#include <vector>

#include "runtime/module/abi/module_abi.h"

namespace meld::eval {

// Of one catom at a time.
class Reserved {
  public:
    Reserved() = default;
    Reserved(const Reserved&) = delete;
    Reserved& operator=(const Reserved&) = delete;
    ~Reserved() { clear(); }

    // What another catom has is given back. Null: the machine has no room for it.
    void* take(u32 catom, u64 bytes);
    // Memory that is not from here stays as it is.
    void give_back(void* memory);
    // The same, but nothing else begins there until all is given back.
    void empty(void* memory);
    void clear();

  private:
    struct Pages {
        void* memory;
        u64 bytes;
    };
    std::vector<Pages>::iterator find(void* memory);

    std::vector<Pages> all_;
    u32 catom_ = kNone32;
};

}  // namespace meld::eval
