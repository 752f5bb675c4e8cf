// Where catoms stand on a lattice, as bits: which of them others surround on all sides.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "runtime/show/render/cell_bits.h"
#include "runtime/show/render/scene.h"

namespace meld::render {

// From a cube to those that it has a face with.
inline const std::array<Vec, 6> kAxes = {-Vec::UnitX(), Vec::UnitX(), -Vec::UnitY(), Vec::UnitY(), -Vec::UnitZ(), Vec::UnitZ()};

class Cells {
  public:
    // Of a scene whose catoms stand where `ways`, of length 1 and in pairs of opposite ones, lead from one to another. Nothing if they do
    // not, or if they are so far apart that bits for all cells between them would take more memory than the scene.
    // Cost: some 10 ns a catom, and 8 bytes.
    static std::optional<Cells> of(const Scene& scene, std::span<const Vec> ways);
    // Whether so many catoms stand so and are near enough to each other, of which these places are those at least that have no neighbour on
    // some side.
    static bool fits(std::span<const Vec> places, std::span<const Vec> ways, std::size_t catoms) {
        return box_of(places, ways, catoms).has_value();
    }

    // Whether there is a catom next to this one, on the way of this number.
    bool has_next(std::size_t catom, std::size_t way) const { return bits_.has_next(at_[catom], way); }
    // How many catoms one has to go through from each to the nearest place without one, counted up to `most`: 0 where there is such a place
    // next to it. Cost: a nanosecond a catom and layer.
    std::vector<std::uint8_t> depths(int most) const;

  private:
    // Cells are counted along three ways.
    struct Box {
        Eigen::Matrix3f to_cells;
        Eigen::Array3f low = Eigen::Array3f::Zero(), high = low;
        Eigen::Array3f cell(const Vec& from_first) const { return Eigen::Array3f(to_cells * from_first); }
        // With a margin of a cell on all sides.
        Eigen::Array3d size() const { return (high - low).round().cast<double>() + 3; }
    };
    static std::optional<Box> box_of(std::span<const Vec> places, std::span<const Vec> ways, std::size_t catoms);

    CellBits bits_;
    std::vector<std::ptrdiff_t> at_;  // Of catoms, the number of their cell.
};

}  // namespace meld::render
