// Where catoms on a lattice are in a snapshot. Catoms are numbered in the order of their cells when a run begins, so they are written as
// runs: many of a world that has not moved are one, and at worst each catom is.
#pragma once

#include <algorithm>
#include <cstdint>
#include <span>
#include <vector>

#include "runtime/base/bytes.h"
#include "runtime/world/ensemble/ensemble.h"

namespace meld::sim {

class CellPlaces {
  public:
    // Catoms with consecutive numbers on consecutive cells of the curve that all processes share.
    struct Run {
        world::CellKey first = 0;
        std::uint64_t id = 0;
        std::uint32_t count = 0;
    };
    static void save(const world::Ensemble& ensemble, std::span<const world::Catom> catoms, ByteWriter& out);
    // Errors: runs of more catoms than a chunk has, or of cells that are nowhere.
    static Result<CellPlaces> read(ByteReader& in);

    const std::vector<Run>& runs() const { return runs_; }
    std::uint32_t count() const { return count_; }
    // Calls visit(run), which may fail, for each part of a run that is in one brick.
    template <class Visit>
    Result<void> each_in_brick(const Visit& visit) const {
        for (Run left : runs_)
            while (left.count > 0) {
                const auto room = static_cast<std::uint32_t>(kBrickCells - (left.first & (kBrickCells - 1)));
                const Run part{left.first, left.id, std::min(left.count, room)};
                if (Result<void> done = visit(part); !done) return done;
                left = {left.first + part.count, left.id + part.count, left.count - part.count};
            }
        return {};
    }

  private:
    std::vector<Run> runs_;
    std::uint32_t count_ = 0;
};

}  // namespace meld::sim
