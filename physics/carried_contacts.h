// The memory of contacts while their batches are laid out anew: what is carried from the old batches, and how the new ones find it.
#pragma once

#include <cstddef>
#include <cstdint>
#include <mutex>
#include <span>
#include <vector>

#include "physics/block_grid.h"
#include "physics/bodies.h"
#include "physics/chunks.h"

namespace meld::physics {

// One contact's memory, as seen from the body with the lower id.
struct CarriedContact {
    // That body, times two, and one more if the two touch: numbers of bodies have 31 bits.
    std::uint32_t id_and_touch;
    // A body, or the code of an obstacle's contact.
    std::uint32_t partner;
    float normal_impulse;
    float tangent[3];

    std::uint32_t id() const { return id_and_touch >> 1; }
    bool touching() const { return (id_and_touch & 1) != 0; }
};
static_assert(kMaxBodies == 0x80000000u);

// Carried contacts in the order of the bodies' present slots. Blocks that are laid out ask for their contacts and those of the
// blocks around, and say when they are done; then memory that nobody will ask for is given back, so that the old contacts
// go while the new ones come.
class FormerContacts {
  public:
    // Takes the contacts out of the lists; those whose body is not here end. The grid outlives this.
    FormerContacts(std::vector<Chunks<CarriedContact>>& lists, const BlockGrid& grid, const Bodies& bodies, std::size_t blocks_per_job,
                   Workers& workers);

    // The contact of the body in this slot with a partner, or null; `slot` is that of the body with the lower id. Any worker may ask.
    const CarriedContact* find(std::uint32_t slot, std::uint32_t partner) const {
        if (contacts_.empty()) return nullptr;
        for (std::uint32_t i = slot == 0 ? 0 : end_[slot - 1]; i < end_[slot]; ++i)
            if (contacts_[i].partner == partner) return &contacts_[i];
        return nullptr;
    }
    // The blocks of this job, blocks_per_job from job * blocks_per_job on, ask no more. Any worker may say so.
    void done(std::size_t job);

  private:
    std::span<const Block> blocks_;
    std::size_t blocks_per_job_;
    // Behind the last contact of each slot.
    Buffer<std::uint32_t> end_;
    Buffer<CarriedContact> contacts_;

    std::mutex mutex_;
    std::vector<bool> done_;
    // All jobs before this one are done; nobody asks for contacts of blocks before this one; so many bytes are gone.
    std::size_t next_job_ = 0, next_block_ = 0, gone_bytes_ = 0;
};

}  // namespace meld::physics
