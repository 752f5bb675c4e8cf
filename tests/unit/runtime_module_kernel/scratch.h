// An evaluation for tests of the kernel: scratch memory that grows, and limits that are not met.
#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <map>
#include <memory>
#include <utility>
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
        reserved.clear();
        most_reserved_bytes = reservations = 0;
        none_left = false;
        host.reserve = [](Eval*, u64 bytes, u64) -> void* {
            if (none_left) return nullptr;
            ++reservations;
            auto memory = std::make_unique<u8[]>(bytes);
            void* const at = memory.get();
            reserved[at] = {std::move(memory), bytes};
            u64 all = 0;
            for (const auto& [_, one] : reserved) all += one.second;
            most_reserved_bytes = std::max(most_reserved_bytes, all);
            return at;
        };
        host.give_back = [](Eval*, void* memory) { reserved.erase(memory); };
        // The place stays taken.
        host.empty = [](Eval*, void* memory) {
            const auto found = reserved.find(memory);
            if (found == reserved.end()) return;
            std::fill_n(found->second.first.get(), found->second.second, u8{0xa5});
            found->second.second = 0;
        };
        view.max_facts = view.max_growing_facts = 1'000'000;
        e.host = &host;
        e.subdomain = &view;
    }
    static inline std::vector<std::unique_ptr<u8[]>> blocks;
    static inline std::map<void*, std::pair<std::unique_ptr<u8[]>, u64>> reserved;
    static inline u64 most_reserved_bytes = 0;  // At once.
    static inline u64 reservations = 0;
    static inline bool none_left = false;
    Host host{};
    SubdomainView view{};
    Eval e{};
};

}  // namespace meld
