// The warm-start cache: the impulses of each contact while batches are laid out again, taken from the old batches and found by the new
// ones.
#pragma once

#include <cstddef>
#include <cstdint>
#include <mutex>
#include <span>
#include <vector>

#include "physics/bodies/bodies.h"
#include "physics/bodies/chunks.h"
#include "physics/collision/block_grid.h"
#include "runtime/base/assert.h"

namespace meld::physics {

// One contact's impulses, as seen from the body with the lower id.
struct CachedContact {
    // The body with the lower id, times two, plus one if the two touch: ids have 31 bits.
    std::uint32_t id_and_touch;
    // The other body, or the code of an obstacle's contact.
    std::uint32_t partner;
    float normal_impulse;
    float tangent[3];

    std::uint32_t id() const { return id_and_touch >> 1; }
    bool touching() const { return (id_and_touch & 1) != 0; }
};
static_assert(kMaxBodies == 0x80000000u);

// Cached contacts in the order of the bodies' present slots. Blocks that are laid out ask for their contacts and those of the blocks
// around, and call `done` afterwards. Memory that no block will read again is then freed, so the old contacts disappear while the new ones
// are made.
class WarmStartCache {
  public:
    // Takes the contacts out of the lists and drops those whose body is not in this subdomain. The grid outlives this.
    WarmStartCache(std::vector<Chunks<CachedContact>>& lists, const BlockGrid& grid, const Bodies& bodies, std::size_t blocks_per_job,
                   Workers& workers);

    // The contact of the body in this slot with a partner, or null; `slot` is that of the body with the lower id. Any worker may ask.
    const CachedContact* find(std::uint32_t slot, std::uint32_t partner) const {
        if (contacts_.empty()) return nullptr;
        MELD_EXPECT(slot < end_.size(), "slot {} of {}", slot, end_.size());
        for (std::uint32_t i = slot == 0 ? 0 : end_[slot - 1]; i < end_[slot]; ++i)
            if (contacts_[i].partner == partner) return &contacts_[i];
        return nullptr;
    }
    // The blocks of this job, blocks_per_job from job * blocks_per_job on, are laid out and will not ask again. Any worker may call it.
    void done(std::size_t job);

  private:
    std::span<const Block> blocks_;
    std::size_t blocks_per_job_;
    // Behind the last contact of each slot.
    Buffer<std::uint32_t> end_;
    Buffer<CachedContact> contacts_;

    std::mutex mutex_;
    std::vector<bool> done_;
    // All jobs before this one are done; contacts of blocks before this one are not needed; bytes freed so far.
    std::size_t next_job_ = 0, next_block_ = 0, gone_bytes_ = 0;
};

}  // namespace meld::physics
