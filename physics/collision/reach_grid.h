// Places that each reach so far, in grids of cells, so that a point looks only at those that may reach it.
#pragma once

#include <compare>
#include <cstdint>
#include <vector>

#include "physics/bodies/types.h"

namespace meld::physics {

class ReachGrid {
  public:
    // A place gets the next number, from 0 on. Its reach may be infinite.
    void add(Vec3 place_m, double reach_m);
    // After the last one, before anything is found.
    void sort();
    // The numbers of those that reach a point, and perhaps of a few that nearly do, in their order. Cost: 27 cells for each power of two
    // among the reaches, and the places that are there; threads may ask at once.
    void find(Vec3 at_m, std::vector<std::uint32_t>& found) const;

  private:
    // Of side 2^level, or a little more.
    struct Cell {
        int level;
        std::int64_t x, y, z;
        auto operator<=>(const Cell&) const = default;
    };
    struct Place {
        Vec3 at_m;
        double reach_m;
        std::uint32_t number;
    };
    struct Entry {
        Cell cell;
        Place place;
    };
    // The first of the places in a cell.
    struct First {
        Cell cell;
        std::uint32_t place;
    };
    static Cell cell_at(int level, Vec3 at_m);

    std::uint32_t count_ = 0;
    std::vector<std::uint32_t> everywhere_;
    // Until they are sorted.
    std::vector<Entry> entries_;
    // Sorted by cell; places by cell and number.
    std::vector<First> cells_;
    std::vector<Place> places_;
    std::vector<int> levels_;
};

}  // namespace meld::physics
