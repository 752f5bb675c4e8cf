#include "runtime/world/description/world.h"

#include <algorithm>

namespace meld::world {

std::int64_t Event::latest(std::int64_t now) const {
    if (now < tick) return 0;
    return every == 0 ? tick : tick + std::min(times - 1, (now - tick) / every) * every;
}

bool World::expects_after(std::int64_t tick) const {
    return std::ranges::any_of(events, [&](const Event& event) { return event.last() > tick; }) ||
           std::ranges::any_of(faults, [&](const Faults& one) { return one.until > tick; });
}

void sort_cells(std::vector<Cell>& cells, const Lattice& lattice) {
    std::vector<CellKey> keys;
    for (const Cell cell : cells) keys.push_back(lattice.key(cell));
    std::sort(keys.begin(), keys.end());
    keys.erase(std::unique(keys.begin(), keys.end()), keys.end());
    cells.clear();
    for (const CellKey key : keys) cells.push_back(lattice.cell_at(key));
}

}  // namespace meld::world
