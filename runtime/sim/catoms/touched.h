// The catoms of a process of which something may have changed since one reader looked last: what they hold, where they are, whether they
// are there, who their neighbours are. A reader that keeps something for each catom, such as a digest, looks at these instead of at all.
// One bit for each catom, in blocks as those of the agenda.
#pragma once

#include <atomic>
#include <bit>
#include <cstddef>
#include <vector>

#include "runtime/base/assert.h"
#include "runtime/module/abi/module_abi.h"

namespace meld::sim {

// What a reader is told of.
enum class Follows { WhatIsSeen, WhatIsHeld };

class Touched {
  public:
    // At first nothing is known, so everything is touched.
    explicit Touched(std::size_t catoms, Follows what = Follows::WhatIsSeen) : follows_(what) { resize(catoms); }
    Follows follows() const { return follows_; }

    // New ones are touched.
    void resize(std::size_t catoms) {
        words_.resize((catoms + kGroup - 1) / kGroup, 0);
        summary_.resize((words_.size() + kGroup - 1) / kGroup, 0);
        for (std::size_t from = count_; from < catoms && !everything_; ++from) add(static_cast<u32>(from));
        count_ = catoms;
    }
    // Not while other threads add, unless catoms of other blocks (Agenda::kBlock).
    void add(u32 catom) {
        const u32 group = catom / kGroup;
        words_[group] |= u64{1} << (catom % kGroup);
        summary_[group / kGroup] |= u64{1} << (group % kGroup);
    }
    // From several threads at once.
    void add_shared(u32 catom) {
        const u32 group = catom / kGroup;
        const u64 mine = u64{1} << (catom % kGroup), its = u64{1} << (group % kGroup);
        if (std::atomic_ref<u64>(words_[group]).fetch_or(mine, std::memory_order_relaxed) != 0) return;
        std::atomic_ref<u64>(summary_[group / kGroup]).fetch_or(its, std::memory_order_relaxed);
    }
    void add_all() { everything_ = true; }
    bool everything() const { return everything_; }

    // Calls visit(catom) for each, ascending; from then on none is touched. Cost: those, and a bit for each 4,096 catoms.
    template <class Visit>
    void take(const Visit& visit) {
        for (std::size_t s = 0; s < summary_.size(); ++s) {
            for (u64 groups = summary_[s]; groups != 0 && !everything_; groups &= groups - 1) {
                const std::size_t group = s * kGroup + static_cast<std::size_t>(std::countr_zero(groups));
                for (u64 left = words_[group]; left != 0; left &= left - 1)
                    visit(static_cast<u32>(group * kGroup + static_cast<std::size_t>(std::countr_zero(left))));
                words_[group] = 0;
            }
            if (!everything_) summary_[s] = 0;
        }
        if (!everything_) return;
        words_.assign(words_.size(), 0);
        summary_.assign(summary_.size(), 0);
        everything_ = false;
        for (std::size_t catom = 0; catom < count_; ++catom) visit(static_cast<u32>(catom));
    }

    std::size_t bytes() const { return (words_.capacity() + summary_.capacity()) * sizeof(u64); }

  private:
    static constexpr std::size_t kGroup = 64;
    std::vector<u64> words_;    // By group of catoms: who is touched.
    std::vector<u64> summary_;  // By group of groups: where a word is not 0.
    std::size_t count_ = 0;
    bool everything_ = true;
    Follows follows_;
};

}  // namespace meld::sim
