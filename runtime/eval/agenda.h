// Which catoms have new input, and what: a dirty word per catom and a two-level bitmap over them, so that an empty agenda costs nothing and
// a full one is visited in the order of memory.
#pragma once

#include <atomic>
#include <bit>
#include <cstdint>
#include <vector>

#include "runtime/abi/module_abi.h"
#include "runtime/base/assert.h"

namespace meld::eval {

class Agenda {
  public:
    void resize(std::size_t catoms) {
        MELD_EXPECT(catoms >= dirty_.size(), "{} catoms after {}", catoms, dirty_.size());
        dirty_.resize(catoms, 0);
        words_.resize((catoms + 63) / 64, 0);
        summary_.resize((words_.size() + 63) / 64, 0);
    }
    std::size_t bytes() const { return dirty_.capacity() * 4 + words_.capacity() * 8 + summary_.capacity() * 8; }
    static std::size_t bytes_for(std::size_t catoms) { return catoms * 4 + catoms / 8 + catoms / 512; }

    // Adds bits to a catom's dirty word. Not while other threads mark.
    void mark(u32 catom, u64 bits) {
        MELD_EXPECT(catom < dirty_.size() && bits != 0 && bits >> 32 == 0, "catom {}, bits {:x}", catom, bits);
        const u32 before = dirty_[catom];
        dirty_[catom] = before | static_cast<u32>(bits);
        if (before != 0) return;
        words_[catom / 64] |= u64{1} << (catom % 64);
        summary_[catom / 4096] |= u64{1} << (catom / 64 % 64);
    }
    // The same from several threads at once; the result does not depend on their order.
    void mark_shared(u32 catom, u64 bits) {
        MELD_EXPECT(catom < dirty_.size() && bits != 0 && bits >> 32 == 0, "catom {}, bits {:x}", catom, bits);
        const std::atomic_ref<u32> word(dirty_[catom]);
        if ((word.load(std::memory_order_relaxed) & bits) == bits) return;
        if (word.fetch_or(static_cast<u32>(bits), std::memory_order_relaxed) != 0) return;
        std::atomic_ref<u64>(words_[catom / 64]).fetch_or(u64{1} << (catom % 64), std::memory_order_relaxed);
        // Usually another catom of its word has set it.
        const std::atomic_ref<u64> summary(summary_[catom / 4096]);
        const u64 bit = u64{1} << (catom / 64 % 64);
        if ((summary.load(std::memory_order_relaxed) & bit) == 0) summary.fetch_or(bit, std::memory_order_relaxed);
    }
    u64 dirty(u32 catom) const { return dirty_[catom]; }
    // Forgets a catom that is removed or has migrated to another process.
    void forget(u32 catom) {
        MELD_EXPECT(catom < dirty_.size(), "catom {}", catom);
        dirty_[catom] = 0;
    }
    bool empty() const {
        for (const u64 s : summary_)
            if (s != 0) return false;
        return true;
    }

    // Calls visit(catom) for each catom that has new input.
    template <class Visit>
    void each(const Visit& visit) const {
        for (std::size_t w = 0; w < words_.size(); ++w)
            for (u64 bits = words_[w]; bits != 0; bits &= bits - 1) {
                const u32 catom = static_cast<u32>(w * 64 + static_cast<std::size_t>(std::countr_zero(bits)));
                if (dirty_[catom] != 0) visit(catom);
            }
    }
    // Returns the agenda and empties it, catoms ascending; those for which keep(catom) is false are dropped.
    template <class Keep>
    void take(std::vector<u32>& catoms, std::vector<u64>& dirty, const Keep& keep) {
        catoms.clear();
        dirty.clear();
        // All are awake in the first tick: arrays that grow step by step would leave as much memory behind again.
        std::size_t most = 0;
        for (std::size_t s = 0; s < summary_.size(); ++s)
            for (u64 words = summary_[s]; words != 0; words &= words - 1)
                most += static_cast<std::size_t>(std::popcount(words_[s * 64 + static_cast<std::size_t>(std::countr_zero(words))]));
        catoms.reserve(most);
        dirty.reserve(most);
        for (std::size_t s = 0; s < summary_.size(); ++s) {
            for (u64 words = summary_[s]; words != 0; words &= words - 1) {
                const std::size_t w = s * 64 + static_cast<std::size_t>(std::countr_zero(words));
                for (u64 bits = words_[w]; bits != 0; bits &= bits - 1) {
                    const u32 catom = static_cast<u32>(w * 64 + static_cast<std::size_t>(std::countr_zero(bits)));
                    if (dirty_[catom] != 0 && keep(catom)) {
                        catoms.push_back(catom);
                        dirty.push_back(dirty_[catom]);
                    }
                    dirty_[catom] = 0;
                }
                words_[w] = 0;
            }
            summary_[s] = 0;
        }
        MELD_ENSURE(empty() && catoms.size() == dirty.size(), "{} catoms, {} dirty words", catoms.size(), dirty.size());
    }

  private:
    std::vector<u32> dirty_;
    std::vector<u64> words_, summary_;
};

}  // namespace meld::eval
