// The tables of the four lattices, and the arithmetic of bricks.
#include "runtime/world/lattice/lattice.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "runtime/base/assert.h"
#include "runtime/world/lattice/hilbert.h"

namespace meld::world {
namespace {

// Layers of spheres in a face-centred cubic lattice, and rows of discs in a hexagonal one, are this far apart.
constexpr double kLayerHeight = std::numbers::sqrt2 / 2;
constexpr double kRowHeight = std::numbers::sqrt3 / 2;
// Brick coordinates lie in [-2^17, 2^17), the Hilbert curve's in [0, 2^18).
constexpr std::int32_t kBrickOffset = 1 << (kHilbertBits - 1);

struct Names {
    LatticeKind kind;
    std::string_view name;
};
constexpr std::array<Names, 4> kNames = {{
    {LatticeKind::Square, "square"},
    {LatticeKind::Hex, "hex"},
    {LatticeKind::Cubic, "cubic"},
    {LatticeKind::Fcc, "fcc"},
}};

struct Ports {
    int count;
    std::array<Cell, kMaxPorts> offset;
    std::array<int, kMaxPorts> opposite;
};

constexpr Ports kSquare = {4, {{{1, 0, 0}, {0, 1, 0}, {-1, 0, 0}, {0, -1, 0}}}, {2, 3, 0, 1}};
constexpr Ports kHex = {6, {{{1, 0, 0}, {0, 1, 0}, {-1, 1, 0}, {-1, 0, 0}, {0, -1, 0}, {1, -1, 0}}}, {3, 4, 5, 0, 1, 2}};
constexpr Ports kCubic = {6, {{{1, 0, 0}, {-1, 0, 0}, {0, 1, 0}, {0, -1, 0}, {0, 0, 1}, {0, 0, -1}}}, {1, 0, 3, 2, 5, 4}};
// On an even layer. On an odd one the cells above and below lie one further in x and y.
constexpr Ports kFcc = {12,
                        {{{1, 0, 0},
                          {0, 1, 0},
                          {-1, 0, 0},
                          {0, -1, 0},
                          {0, 0, 1},
                          {-1, 0, 1},
                          {-1, -1, 1},
                          {0, -1, 1},
                          {0, 0, -1},
                          {-1, 0, -1},
                          {-1, -1, -1},
                          {0, -1, -1}}},
                        {2, 3, 0, 1, 10, 11, 8, 9, 6, 7, 4, 5}};

const Ports& ports_of(LatticeKind kind) {
    switch (kind) {
        case LatticeKind::Square:
            return kSquare;
        case LatticeKind::Hex:
            return kHex;
        case LatticeKind::Cubic:
            return kCubic;
        case LatticeKind::Fcc:
            break;
    }
    return kFcc;
}

// A coordinate as a cell number near the range of the world, whatever the double was.
std::int32_t clamped(double value) {
    return static_cast<std::int32_t>(std::clamp(value, static_cast<double>(-kCellLimit), static_cast<double>(kCellLimit - 1)));
}

}  // namespace

Lattice::Lattice(LatticeKind kind, const PortNumbers* numbers) : kind_(kind), ports_(ports_of(kind).count) {
    MELD_EXPECT(numbers == nullptr || numbers->lattice == name(), "the ports of {}", numbers->name);
    for (int port = 0; port < ports_; ++port)
        own_[static_cast<std::size_t>(port)] = numbers == nullptr ? port : numbers->sides[static_cast<std::size_t>(port)].port;
    for (int port = 0; port < ports_; ++port) {
        const int opposite = ports_of(kind).opposite[static_cast<std::size_t>(own_number(port))];
        opposite_[static_cast<std::size_t>(port)] = static_cast<int>(std::ranges::find(own_, opposite) - own_.begin());
    }
    brick_bits_ = flat() ? std::array<std::int32_t, 3>{5, 4, 0} : std::array<std::int32_t, 3>{3, 3, 3};
    step_.resize(static_cast<std::size_t>(ports_) * kBrickCells);
    for (int port = 0; port < ports_; ++port) {
        for (u32 number = 0; number < kBrickCells; ++number) {
            // A brick's first layer is even, so the table of the brick at the origin is valid for all of them.
            const Cell there = neighbour(cell_in_brick({}, number), port);
            const Cell brick = brick_of(there);
            const u32 place = static_cast<u32>((brick.x + 1) + 3 * (brick.y + 1) + 9 * (brick.z + 1));
            step_[static_cast<std::size_t>(port) * kBrickCells + number] =
                static_cast<u16>(place << kBrickCellBits | number_in_brick(there));
        }
    }
}

std::optional<LatticeKind> Lattice::kind_named(std::string_view name) {
    for (const Names& row : kNames) {
        if (row.name == name) return row.kind;
    }
    return std::nullopt;
}

std::vector<std::string_view> Lattice::kind_names() {
    std::vector<std::string_view> names;
    for (const Names& row : kNames) names.push_back(row.name);
    return names;
}

std::string_view Lattice::name() const { return kNames[static_cast<std::size_t>(kind_)].name; }

Cell Lattice::neighbour(Cell cell, int port) const {
    MELD_EXPECT(port >= 0 && port < ports_, "port {} of {}", port, ports_);
    const Cell offset = ports_of(kind_).offset[static_cast<std::size_t>(own_number(port))];
    const std::int32_t shift = kind_ == LatticeKind::Fcc && offset.z != 0 ? cell.z & 1 : 0;
    return {cell.x + offset.x + shift, cell.y + offset.y + shift, cell.z + offset.z};
}

Vec3 Lattice::position(Cell cell) const {
    const double x = cell.x, y = cell.y, z = cell.z;
    switch (kind_) {
        case LatticeKind::Square:
            return {x, y, 0};
        case LatticeKind::Hex:
            return {x + y / 2, y * kRowHeight, 0};
        case LatticeKind::Cubic:
            return {x, y, z};
        case LatticeKind::Fcc:
            break;
    }
    const double shift = cell.z & 1 ? 0.5 : 0;
    return {x + shift, y + shift, z * kLayerHeight};
}

void Lattice::cells_covering(Vec3 low, Vec3 high, Cell& first, Cell& last) const {
    Vec3 from = low, to = high;
    if (kind_ == LatticeKind::Hex) {
        from[1] = low[1] / kRowHeight;
        to[1] = high[1] / kRowHeight;
        from[0] = low[0] - (to[1] + 1) / 2;
        to[0] = high[0] - (from[1] - 1) / 2;
    } else if (kind_ == LatticeKind::Fcc) {
        from = {low[0] - 0.5, low[1] - 0.5, low[2] / kLayerHeight};
        to[2] = high[2] / kLayerHeight;
    }
    first = {clamped(std::floor(from[0]) - 1), clamped(std::floor(from[1]) - 1), clamped(std::floor(from[2]) - 1)};
    last = {clamped(std::ceil(to[0]) + 1), clamped(std::ceil(to[1]) + 1), clamped(std::ceil(to[2]) + 1)};
    if (flat()) first.z = last.z = 0;
}

void Lattice::positions_covering(Cell first, Cell last, Vec3& low, Vec3& high) const {
    low = {static_cast<double>(first.x), static_cast<double>(first.y), static_cast<double>(first.z)};
    high = {static_cast<double>(last.x), static_cast<double>(last.y), static_cast<double>(last.z)};
    switch (kind_) {
        case LatticeKind::Square:
            low[2] = high[2] = 0;
            break;
        case LatticeKind::Hex:
            low = {low[0] + low[1] / 2, low[1] * kRowHeight, 0};
            high = {high[0] + high[1] / 2, high[1] * kRowHeight, 0};
            break;
        case LatticeKind::Cubic:
            break;
        case LatticeKind::Fcc:
            low[2] *= kLayerHeight;
            high = {high[0] + 0.5, high[1] + 0.5, high[2] * kLayerHeight};
            break;
    }
}

bool Lattice::in_range(Cell cell) {
    const auto inside = [](std::int32_t value) { return value >= -kCellLimit && value < kCellLimit; };
    return inside(cell.x) && inside(cell.y) && inside(cell.z);
}

Cell Lattice::brick_of(Cell cell) const { return {cell.x >> brick_bits_[0], cell.y >> brick_bits_[1], cell.z >> brick_bits_[2]}; }

Cell Lattice::brick_origin(Cell brick) const {
    return {brick.x * (1 << brick_bits_[0]), brick.y * (1 << brick_bits_[1]), brick.z * (1 << brick_bits_[2])};
}

std::uint32_t Lattice::number_in_brick(Cell cell) const {
    const auto low = [](std::int32_t value, std::int32_t bits) { return static_cast<u32>(value) & ((1u << bits) - 1); };
    return low(cell.x, brick_bits_[0]) | low(cell.y, brick_bits_[1]) << brick_bits_[0] |
           low(cell.z, brick_bits_[2]) << (brick_bits_[0] + brick_bits_[1]);
}

Cell Lattice::cell_in_brick(Cell brick, std::uint32_t number) const {
    MELD_EXPECT(number < kBrickCells, "cell {}", number);
    const auto part = [number](std::int32_t shift, std::int32_t bits) {
        return static_cast<std::int32_t>(number >> shift & ((1u << bits) - 1));
    };
    const Cell inside = {part(0, brick_bits_[0]), part(brick_bits_[0], brick_bits_[1]),
                         part(brick_bits_[0] + brick_bits_[1], brick_bits_[2])};
    return brick_origin(brick) + inside;
}

bool Lattice::brick_in_range(Cell brick) const {
    const auto inside = [](std::int32_t value, std::int32_t bits) { return value >= -(kCellLimit >> bits) && value < kCellLimit >> bits; };
    // A flat world has one layer of bricks.
    if (flat() && brick.z != 0) return false;
    return inside(brick.x, brick_bits_[0]) && inside(brick.y, brick_bits_[1]) && inside(brick.z, brick_bits_[2]);
}

Cell Lattice::brick_offset(u32 neighbour) {
    MELD_EXPECT(neighbour < kBrickNeighbours, "neighbour {}", neighbour);
    const auto n = static_cast<std::int32_t>(neighbour);
    return {n % 3 - 1, n / 3 % 3 - 1, n / 9 - 1};
}

BrickKey Lattice::brick_key(Cell brick) const {
    MELD_EXPECT(brick_in_range(brick), "brick {} {} {}", brick.x, brick.y, brick.z);
    return hilbert_index(
        {static_cast<u32>(brick.x + kBrickOffset), static_cast<u32>(brick.y + kBrickOffset), static_cast<u32>(brick.z + kBrickOffset)});
}

Cell Lattice::brick_at(BrickKey key) const {
    const std::array<u32, 3> place = hilbert_place(key);
    return {static_cast<std::int32_t>(place[0]) - kBrickOffset, static_cast<std::int32_t>(place[1]) - kBrickOffset,
            static_cast<std::int32_t>(place[2]) - kBrickOffset};
}

}  // namespace meld::world
