// The catoms of a chunk that a process takes: puts them on their cells, and remembers where they are for the facts that follow.
#pragma once

#include <cstdint>
#include <vector>

#include "runtime/base/error.h"
#include "runtime/engine/tuple/change_log.h"
#include "runtime/sim/catoms/membership.h"
#include "runtime/sim/state/cell_places.h"

namespace meld::sim {

// Where the catoms of a chunk are here: runs of them that follow each other in both.
class PlacedChunk {
  public:
    // The next catoms of the chunk have these indices.
    void add(Catom first, std::uint32_t count, bool owned);
    // The next ones are not here.
    void pass(std::uint32_t count) { passed_ += count; }
    bool any() const { return !runs_.empty(); }
    // All catoms of the chunk, in order.
    void list(std::vector<tuple::SavedCatom>& out) const;

  private:
    struct Run {
        std::uint32_t passed = 0;  // Since the run before.
        Catom first = 0;
        std::uint32_t count = 0;
        bool owned = false;
    };
    std::vector<Run> runs_;
    std::uint32_t passed_ = 0;
};

// Adds the catoms that this process owns or reads, by the partition of the members, and no others. Errors: two catoms are in one cell, or
// one is beyond the world.
Result<void> place_on_cells(Membership& members, const CellPlaces& all, int process, PlacedChunk& placed);

}  // namespace meld::sim
