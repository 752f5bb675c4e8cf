#include "runtime/sim/state/placed_chunk.h"

#include <fmt/format.h>

#include <algorithm>
#include <optional>
#include <utility>

#include "runtime/base/assert.h"
#include "runtime/sim/state/reading.h"

namespace meld::sim {

void PlacedChunk::add(Catom first, std::uint32_t count, bool owned) {
    Run* const last = runs_.empty() || passed_ > 0 ? nullptr : &runs_.back();
    if (last != nullptr && last->owned == owned && first == last->first + last->count)
        last->count += count;
    else
        runs_.push_back({std::exchange(passed_, 0), first, count, owned});
}

void PlacedChunk::list(std::vector<tuple::SavedCatom>& out) const {
    out.clear();
    for (const Run& run : runs_) {
        out.resize(out.size() + run.passed);
        for (std::uint32_t i = 0; i < run.count; ++i) out.push_back({run.first + i, run.owned});
    }
    out.resize(out.size() + passed_);
}

Result<void> place_on_cells(Membership& members, const CellPlaces& all, int process, PlacedChunk& placed) {
    MELD_EXPECT(members.partition && members.halo, "catoms are placed before anybody owns anything");
    const world::Lattice& lattice = members.ensemble.lattice();
    const bool alone = members.partition->processes() == 1;
    const auto twice = [&](Cell cell) { return damaged(fmt::format("has two catoms in cell ({}, {}, {})", cell.x, cell.y, cell.z)); };
    // Where catoms have moved, a run is of one catom, and the next one is mostly in the same brick.
    std::optional<world::BrickKey> last;
    Cell brick;
    bool ours = false;
    // The sides of that brick on which this process owns a brick. Its cells near one of them are ghosts here.
    std::vector<partition::Halo::Side> toward_us;
    return all.each_in_brick([&](const CellPlaces::Run& run) -> Result<void> {
        const world::BrickKey key = run.first >> kBrickCellBits;
        const auto number = static_cast<std::uint32_t>(run.first & (kBrickCells - 1));
        if (last != key) {
            last = key;
            brick = lattice.brick_at(key);
            if (!lattice.brick_in_range(brick)) return damaged(fmt::format("has catoms beyond the world, in brick {}", key));
            ours = members.partition->owner(key) == process;
            toward_us.clear();
            if (!ours && !alone) toward_us = members.halo->sides(brick);
            std::erase_if(toward_us, [&](const partition::Halo::Side& side) { return side.process != process; });
        }
        if (ours) {
            const world::Slot slot = members.ensemble.slot(brick);
            if (!members.ensemble.empty(slot, number, run.count)) return twice(lattice.cell_in_brick(brick, number));
            if (members.ensemble.has_no_gaps()) {
                placed.add(members.ensemble.add_run(run.id, slot, number, run.count, kCatomOwned), run.count, true);
                return {};
            }
        }
        for (std::uint32_t i = 0; i < run.count; ++i) {
            if (!ours && std::ranges::none_of(toward_us, [&](const auto& side) { return members.halo->near(side, number + i); })) {
                placed.pass(1);
                continue;
            }
            const Cell cell = lattice.cell_in_brick(brick, number + i);
            if (members.ensemble.at(cell)) return twice(cell);
            placed.add(members.ensemble.add(run.id + i, cell, ours ? kCatomOwned : kCatomGhost), 1, ours);
        }
        return {};
    });
}

}  // namespace meld::sim
