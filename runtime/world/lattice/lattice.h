// The four lattices: their cells, ports, distances and bricks. Unit of length: the catom diameter.
#pragma once

#include <array>
#include <compare>
#include <cstdint>
#include <optional>
#include <string_view>
#include <vector>

#include "runtime/module/abi/geometry_abi.h"
#include "runtime/module/abi/port_numbers.h"

namespace meld::world {

struct Cell {
    std::int32_t x = 0, y = 0, z = 0;
    auto operator<=>(const Cell&) const = default;
    Cell operator+(Cell o) const { return {x + o.x, y + o.y, z + o.z}; }
    Cell operator-(Cell o) const { return {x - o.x, y - o.y, z - o.z}; }
};

using Vec3 = std::array<double, 3>;

enum class LatticeKind { Square, Hex, Cubic, Fcc };

// A cell's position in the order that all processes share: the Hilbert index of its brick, then its number in the brick. The owner of a
// range of keys owns those bricks.
using CellKey = std::uint64_t;
using BrickKey = std::uint64_t;

// Cell coordinates must lie in [-kCellLimit, kCellLimit).
inline constexpr std::int32_t kCellLimit = 1 << 20;

class Lattice {
  public:
    // `numbers`: those of a robot on this lattice, whose program runs here; null: our own. Ports differ in their numbers only.
    explicit Lattice(LatticeKind kind, const PortNumbers* numbers = nullptr);
    static std::optional<LatticeKind> kind_named(std::string_view name);  // "square", "hex", "cubic", "fcc"
    static std::vector<std::string_view> kind_names();
    std::string_view name() const;
    LatticeKind kind() const { return kind_; }
    bool flat() const { return kind_ == LatticeKind::Square || kind_ == LatticeKind::Hex; }

    // Cell (0,0,0) is centred on the origin on every lattice. hex: axial coordinates, row y shifted by y/2. fcc: layers
    // sqrt(1/2) apart, odd layers shifted by (1/2, 1/2); so the cells of a neighbour depend on the parity of z.
    // Ports are numbered so that docs/reference/worlds.md can print the table; square: E N W S; hex: 0..5 counter-clockwise from
    // east (axial coordinates); cubic: +x -x +y -y +z -z; fcc: the 4 of the layer (E N W S), 4 above and 4
    // below (each NE NW SW SE).
    int ports() const { return ports_; }
    // The number that a port has on the lattice itself, whatever its robot calls it.
    int own_number(int port) const { return own_[static_cast<std::size_t>(port)]; }
    Cell neighbour(Cell cell, int port) const;
    int opposite(int port) const { return opposite_[static_cast<std::size_t>(port)]; }
    // The centre of a cell, in catom diameters.
    Vec3 position(Cell cell) const;
    // The smallest box of cells whose centres cover the box of positions [low, high], grown by one cell on each side.
    void cells_covering(Vec3 low, Vec3 high, Cell& first, Cell& last) const;

    // The box of positions that holds the centres of all cells from `first` to `last`.
    void positions_covering(Cell first, Cell last, Vec3& low, Vec3& high) const;
    static bool in_range(Cell cell);  // Whether all coordinates lie in [-kCellLimit, kCellLimit).

    // Bricks: 8x8x8 cells in space, 32x16x1 in the plane.
    const std::array<std::int32_t, 3>& brick_bits() const { return brick_bits_; }
    Cell brick_of(Cell cell) const;       // Brick coordinates.
    Cell brick_origin(Cell brick) const;  // Its first cell.
    std::uint32_t number_in_brick(Cell cell) const;
    Cell cell_in_brick(Cell brick, std::uint32_t number) const;
    bool brick_in_range(Cell brick) const;
    // The 27 bricks around a brick, including itself, are numbered (dx + 1) + 3 (dy + 1) + 9 (dz + 1).
    static Cell brick_offset(u32 neighbour);
    BrickKey brick_key(Cell brick) const;  // Hilbert index; brick coordinates as brick_of gives them.
    Cell brick_at(BrickKey key) const;
    CellKey key(Cell cell) const { return brick_key(brick_of(cell)) << kBrickCellBits | number_in_brick(cell); }
    Cell cell_at(CellKey key) const {
        return cell_in_brick(brick_at(key >> kBrickCellBits), static_cast<std::uint32_t>(key & (kBrickCells - 1)));
    }

    // The Geometry::step table of this lattice, ports * 512 entries.
    const std::vector<u16>& step_table() const { return step_; }

  private:
    LatticeKind kind_;
    int ports_ = 0;
    std::array<int, kMaxPorts> own_{};
    std::array<int, kMaxPorts> opposite_{};
    std::array<std::int32_t, 3> brick_bits_{};
    std::vector<u16> step_;
};

}  // namespace meld::world
