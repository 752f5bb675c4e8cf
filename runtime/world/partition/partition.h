// Who owns which bricks, and which other processes need a cell. Processes own contiguous ranges of the Hilbert curve, including bricks
// without catoms.
#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <span>
#include <utility>
#include <vector>

#include "runtime/world/ensemble/ensemble.h"
#include "runtime/world/lattice/lattice.h"

namespace meld::partition {

using world::BrickKey;
using world::Cell;

class Partition {
  public:
    // Divides the curve so that each process gets about the same number of catoms. `counts` is sorted by key and the same on every process.
    // With more processes than bricks some processes own empty ranges.
    Partition(const std::vector<std::pair<BrickKey, std::uint32_t>>& counts, int processes);
    int owner(BrickKey key) const;
    int processes() const { return static_cast<int>(starts_.size()); }

  private:
    std::vector<BrickKey> starts_;  // Process p owns the keys from starts_[p] up to starts_[p + 1].
};

// Calls visit(index) for each brick of the list, which is sorted by key, that has bricks of several processes among the 27 around it,
// itself included; with `of`, only where one of these processes is `of`. Ascending. Cost: some 60 walks along the curve for each such
// brick, and nearly nothing for the others, which are left out by large cubes.
void each_border_brick(const Partition& partition, const world::Lattice& lattice,
                       std::span<const std::pair<BrickKey, std::uint32_t>> bricks, std::optional<int> of,
                       const std::function<void(std::size_t index)>& visit);

// The other processes that read a cell: those that own a brick within `reach` cells of it.
class Halo {
  public:
    // reach: 1 if catoms do not move, 2 if they move (a mover must see around its next cell), 3 if they go around others.
    Halo(const world::Ensemble& ensemble, const Partition& partition, int process, int reach);

    // Calls visit(process) once for every other process that needs this site. Cost: nothing for a brick inside. Any thread may call it
    // after prepare() has seen the site's brick.
    template <class Visit>
    void subscribers(std::uint32_t site, const Visit& visit) const {
        const std::uint32_t slot = site >> kBrickCellBits;
        if (slot >= border_.size() || border_[slot] < 0) return;
        visit_border(static_cast<std::size_t>(border_[slot]), site & (kBrickCells - 1), visit);
    }
    // Handles the bricks that were made since the last call.
    void prepare();
    // Cost: a hash lookup, and for a brick that is absent one walk along the curve.
    int owner(Cell cell) const;
    // For the functions below, bricks that are present cost one hash lookup, others 27 walks along the curve.
    // The processes, without this one, that own a brick next to the brick of this cell. Ascending.
    std::vector<int> around(Cell cell) const;
    // All processes that know the cell: its owner and those that read it. Ascending.
    std::vector<int> listeners(Cell cell) const;

    struct Side {
        std::int8_t dx, dy, dz;
        std::int32_t process;
    };
    // The brick itself and those around it, with their owners. Cost: 27 walks along the curve.
    std::vector<Side> sides(Cell brick) const;
    // Whether a cell of the brick is within reach of that side.
    bool near(const Side& side, std::uint32_t cell) const;
    // Whether this process owns a brick that is present, and all around it. After prepare().
    bool inside(world::Slot slot) const { return slot < border_.size() && border_[slot] < 0; }

  private:
    const world::Lattice& lattice() const { return ensemble_.lattice(); }
    // Calls visit(side) for each of them; for a brick in the interior only for itself.
    template <class Visit>
    void each_side(Cell brick, const Visit& visit) const {
        const std::optional<world::Slot> slot = ensemble_.find_slot(brick);
        if (slot && *slot < border_.size()) {
            if (border_[*slot] < 0) return visit(Side{0, 0, 0, process_});
            for (const Side& side : sides_[static_cast<std::size_t>(border_[*slot])]) visit(side);
            return;
        }
        for (const Side& side : sides(brick)) visit(side);
    }

    template <class Visit>
    void visit_border(std::size_t border, std::uint32_t cell, const Visit& visit) const {
        std::uint64_t visited = 0;  // Processes beyond 64 are found by a search: rare, and sides are few.
        std::vector<int> more;
        for (const Side& side : sides_[border]) {
            if (side.process == process_ || !near(side, cell)) continue;
            if (side.process < 64) {
                if (visited >> side.process & 1) continue;
                visited |= std::uint64_t{1} << side.process;
            } else {
                bool again = false;
                for (const int p : more) again = again || p == side.process;
                if (again) continue;
                more.push_back(side.process);
            }
            visit(side.process);
        }
    }

    const world::Ensemble& ensemble_;
    const Partition& partition_;
    int process_;
    int reach_;
    std::vector<std::int32_t> border_;  // By slot: index into sides_, or -1 if it and all bricks around it are ours.
    std::vector<std::vector<Side>> sides_;
};

}  // namespace meld::partition
