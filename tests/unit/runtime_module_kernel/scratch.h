// An evaluation for tests of the kernel: scratch memory that grows, and limits that are not met.
#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <memory>
#include <vector>

#include "runtime/module/abi/module_abi.h"

namespace meld {

struct ScratchTest : testing::Test {
    ScratchTest() {
        blocks.clear();
        host.more_arena = [](Eval* eval, u64 bytes) {
            const u64 size = std::max<u64>(bytes, 1 << 20);
            blocks.push_back(std::make_unique<u8[]>(size));
            eval->arena = eval->arena_start = blocks.back().get();
            eval->arena_end = eval->arena + size;
        };
        view.max_facts = view.max_growing_facts = 1'000'000;
        e.host = &host;
        e.subdomain = &view;
    }
    static inline std::vector<std::unique_ptr<u8[]>> blocks;
    Host host{};
    SubdomainView view{};
    Eval e{};
};

}  // namespace meld
