#include "runtime/sim/lattice/ties.h"

#include <algorithm>
#include <array>
#include <cstdlib>

#include "runtime/base/assert.h"

namespace meld::sim {

namespace {

using world::Cell;
using world::Lattice;

// The cells within the reach, numbered.
class NearCells {
  public:
    explicit NearCells(Cell centre) : centre_(centre) {}
    static bool near(Cell offset) { return std::max({std::abs(offset.x), std::abs(offset.y), std::abs(offset.z)}) <= kTieReach; }
    bool has(Cell cell) const { return near(cell - centre_); }
    // The cell before this one on the path to it; kNone before it is reached.
    std::int8_t& before(Cell cell) {
        const Cell at = cell - centre_;
        MELD_EXPECT(near(at), "the cell {} {} {} away", at.x, at.y, at.z);
        return before_[static_cast<std::size_t>((at.x + kTieReach) + kSide * ((at.y + kTieReach) + kSide * (at.z + kTieReach)))];
    }
    static constexpr std::int8_t kUnknown = -1, kStart = -2, kTaken = -3;

  private:
    static constexpr std::int32_t kSide = 2 * kTieReach + 1;
    Cell centre_;
    std::array<std::int8_t, static_cast<std::size_t>(kSide) * kSide * kSide> before_ = [] {
        std::array<std::int8_t, static_cast<std::size_t>(kSide) * kSide * kSide> none;
        none.fill(kUnknown);
        return none;
    }();
};

}  // namespace

std::optional<std::vector<Cell>> ties(const Lattice& lattice, const std::function<bool(Cell)>& full, Cell from, Cell to) {
    MELD_EXPECT(NearCells::near(to - from) && to != from, "a move by {} {} {}", to.x - from.x, to.y - from.y, to.z - from.z);
    std::vector<Cell> left;
    for (int port = 0; port < lattice.ports(); ++port)
        if (const Cell cell = lattice.neighbour(from, port); cell != to && full(cell)) left.push_back(cell);
    // Breadth first from the new cell, until all are reached. Of each cell, the port through which its path came is known.
    NearCells seen(from);
    seen.before(to) = NearCells::kStart;
    std::vector<Cell> reached{to};
    std::size_t missing = left.size();
    for (std::size_t i = 0; i < reached.size() && missing > 0; ++i)
        for (int port = 0; port < lattice.ports(); ++port) {
            const Cell next = lattice.neighbour(reached[i], port);
            if (next == from || !seen.has(next) || seen.before(next) != NearCells::kUnknown || !full(next)) continue;
            seen.before(next) = static_cast<std::int8_t>(lattice.opposite(port));
            reached.push_back(next);
            missing -= std::ranges::find(left, next) != left.end() ? 1 : 0;
        }
    if (missing > 0) return std::nullopt;
    std::vector<Cell> tree;
    for (Cell cell : left)
        for (std::int8_t port = seen.before(cell); port >= 0; port = seen.before(cell)) {
            seen.before(cell) = NearCells::kTaken;
            tree.push_back(cell);
            cell = lattice.neighbour(cell, port);
        }
    return tree;
}

}  // namespace meld::sim
