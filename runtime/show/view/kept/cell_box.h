// Numbers of the cells of a lattice within a box that can grow, such that the way to a neighbour is the same difference from every cell.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "runtime/world/lattice/lattice.h"

namespace meld::view {

class CellBox {
  public:
    // From the lowest to the highest coordinates, both within.
    struct Bounds {
        std::array<std::int32_t, 3> low = {0, 0, 0}, high = {-1, -1, -1};
        bool empty() const { return high[0] < low[0]; }
        void include(const Bounds& other);
        bool operator==(const Bounds&) const = default;
    };

    explicit CellBox(world::LatticeKind kind) : shears_(kind == world::LatticeKind::Fcc) {}

    // Of all cells from `first` to `last`, in the coordinates of the box.
    Bounds bounds_of(world::Cell first, world::Cell last) const;
    // From now on the box has these too; numbers are others then, and true is returned.
    bool grow(const Bounds& bounds);

    // How many numbers there are: one behind the last, which may be more than 32 bits hold.
    double size() const;
    std::uint32_t number(world::Cell cell) const;
    world::Cell cell(std::uint32_t number) const;
    // What leads from the number of a cell to those of its neighbours, by port.
    std::vector<std::ptrdiff_t> ways(const world::Lattice& lattice) const;

  private:
    world::Cell straight(world::Cell cell) const;

    // Every second layer of the face-centred lattice is shifted; along a slanted axis it is not.
    bool shears_;
    Bounds bounds_;                                   // Without the margin of a cell on all sides.
    std::array<std::uint32_t, 3> sizes_ = {2, 2, 2};  // With it.
};

}  // namespace meld::view
