// Finds bricks by halving the box of bricks that holds a shape, and leaves out every part that the shape does not reach.
#include "runtime/world/description/populate.h"

#include <algorithm>
#include <bit>
#include <iterator>

#include "runtime/base/assert.h"
#include "runtime/base/process/liveness.h"

namespace meld::world {
namespace {

// Bricks are assigned to shares in runs of this many: neighbours cost about the same, and a run is walked at once.
constexpr std::uint64_t kRun = 16;

// Bricks are listed only until there are this many to count: enough for many threads, and no memory to speak of.
constexpr std::size_t kCountedAtOnce = 8192;

Box positions(const Lattice& lattice, Cell first_brick, Cell last_brick) {
    Box box;
    lattice.positions_covering(lattice.brick_origin(first_brick), lattice.cell_in_brick(last_brick, kBrickCells - 1), box.low, box.high);
    return box;
}

// The longest side of a box of bricks, or nothing if it is one brick.
std::int32_t Cell::* longest_side(Cell first, Cell last) {
    const Cell size = last - first;
    std::int32_t Cell::* longest = &Cell::x;
    if (size.y > size.*longest) longest = &Cell::y;
    if (size.z > size.*longest) longest = &Cell::z;
    return size.*longest > 0 ? longest : nullptr;
}

// Calls f for the halves, along each axis, of a box of cells whose sides are powers of two.
template <class F>
void for_each_part(Cell first, Cell last, const F& f) {
    const Cell size = last - first;
    const Cell half = {(size.x + 1) / 2, (size.y + 1) / 2, (size.z + 1) / 2};
    for (std::int32_t z = 0; z < (half.z > 0 ? 2 : 1); ++z) {
        for (std::int32_t y = 0; y < 2; ++y) {
            for (std::int32_t x = 0; x < 2; ++x) {
                const Cell from = {first.x + x * half.x, first.y + y * half.y, first.z + z * half.z};
                f(from, from + Cell{half.x - 1, half.y - 1, std::max(half.z - 1, 0)});
            }
        }
    }
}

// Sets the bits of the cells of a part of a brick that lie in the shape. A quarter or an eighth of a brick is tested once before its cells
// are: most parts of a brick that a thin wall crosses are empty.
void add_part(const Shape& shape, const Lattice& lattice, Cell first, Cell last, BrickCells& bits) {
    Box box;
    lattice.positions_covering(first, last, box.low, box.high);
    if (!shape.may_touch(box)) return;
    const bool inside = shape.surely_contains(box);
    for (std::int32_t z = first.z; z <= last.z; ++z) {
        for (std::int32_t y = first.y; y <= last.y; ++y) {
            for (std::int32_t x = first.x; x <= last.x; ++x) {
                const Cell cell = {x, y, z};
                if (!inside && !shape.contains(lattice.position(cell))) continue;
                const std::uint32_t number = lattice.number_in_brick(cell);
                bits[number / 64] |= std::uint64_t{1} << number % 64;
            }
        }
    }
}

struct Walk {
    const Shape& shape;
    const Lattice& lattice;
    const std::function<bool(Cell)>& visit;

    // Whether to continue. `inside`: the bricks are known to lie wholly in the shape.
    bool over(Cell first, Cell last, bool inside) const {
        if (!inside) {
            const Box box = positions(lattice, first, last);
            if (!shape.may_touch(box)) return true;
            inside = shape.surely_contains(box);
        }
        std::int32_t Cell::* side = longest_side(first, last);
        if (!side) return visit(first);
        const std::int32_t middle = first.*side + (last.*side - first.*side) / 2;
        Cell below = last, above = first;
        below.*side = middle;
        above.*side = middle + 1;
        return over(first, below, inside) && over(above, last, inside);
    }
};

BrickCells listed_cells(const World& world, const Lattice& lattice, BrickKey brick) {
    BrickCells bits{};
    const CellKey first = brick << kBrickCellBits;
    const auto before = [&lattice](Cell cell, CellKey key) { return lattice.key(cell) < key; };
    for (auto at = std::lower_bound(world.cells.begin(), world.cells.end(), first, before); at != world.cells.end(); ++at) {
        const CellKey key = lattice.key(*at);
        if (key - first >= kBrickCells) break;
        bits[(key - first) / 64] |= std::uint64_t{1} << (key - first) % 64;
    }
    return bits;
}

// The bricks with listed cells, ascending; the cells are sorted by key, so those of a brick are adjacent.
std::vector<BrickKey> bricks_of_list(const World& world, const Lattice& lattice) {
    std::vector<BrickKey> bricks;
    for (const Cell cell : world.cells) {
        const BrickKey key = lattice.brick_key(lattice.brick_of(cell));
        if (bricks.empty() || bricks.back() != key) bricks.push_back(key);
    }
    return bricks;
}

}  // namespace

BrickCells cells_of_body(const World& world, const Lattice& lattice, Cell brick) {
    liveness::beat();
    BrickCells bits = cells_in_shape(world.body, lattice, brick);
    if (world.cells.empty()) return bits;
    const BrickCells listed = listed_cells(world, lattice, lattice.brick_key(brick));
    for (std::size_t i = 0; i < bits.size(); ++i) bits[i] |= listed[i];
    return bits;
}

namespace {

std::uint32_t bit_count(const BrickCells& bits) {
    std::uint32_t count = 0;
    for (const std::uint64_t word : bits) count += static_cast<std::uint32_t>(std::popcount(word));
    return count;
}

}  // namespace

BrickCells cells_in_shape(const Shape& shape, const Lattice& lattice, Cell brick) {
    BrickCells bits{};
    const Cell first = lattice.brick_origin(brick), last = lattice.cell_in_brick(brick, kBrickCells - 1);
    Box box;
    lattice.positions_covering(first, last, box.low, box.high);
    if (!shape.may_touch(box)) return bits;
    if (shape.surely_contains(box)) {
        bits.fill(~std::uint64_t{0});
    } else {
        for_each_part(first, last, [&](Cell part_first, Cell part_last) { add_part(shape, lattice, part_first, part_last, bits); });
    }
    return bits;
}

void for_each_brick(const Shape& shape, const Lattice& lattice, const std::function<bool(Cell brick)>& visit) {
    const Box box = shape.bounds();
    if (box.empty()) return;
    Cell first, last;
    lattice.cells_covering(box.low, box.high, first, last);
    Walk{shape, lattice, visit}.over(lattice.brick_of(first), lattice.brick_of(last), false);
}

std::vector<std::pair<BrickKey, std::uint32_t>> count_bricks(const World& world, const Lattice& lattice, int share, int shares,
                                                             Workers* workers) {
    MELD_EXPECT(shares > 0 && share >= 0 && share < shares, "share {} of {}", share, shares);
    std::vector<std::pair<BrickKey, std::uint32_t>> counts;
    std::uint64_t turn = 0;
    const auto mine = [&turn, share, shares] {
        return turn++ / kRun % static_cast<std::uint64_t>(shares) == static_cast<std::uint64_t>(share);
    };
    std::vector<Cell> waiting;
    std::vector<std::pair<BrickKey, std::uint32_t>> counted;
    const auto count_waiting = [&] {
        counted.resize(waiting.size());
        const auto count_part = [&](int, std::size_t part) {
            for (std::size_t i = part * kRun; i < std::min(waiting.size(), (part + 1) * kRun); ++i)
                counted[i] = {lattice.brick_key(waiting[i]), bit_count(cells_of_body(world, lattice, waiting[i]))};
        };
        const std::size_t parts = (waiting.size() + kRun - 1) / kRun;
        if (workers != nullptr)
            workers->run(parts, count_part);
        else
            for (std::size_t part = 0; part < parts; ++part) count_part(0, part);
        std::ranges::copy_if(counted, std::back_inserter(counts), [](const auto& brick) { return brick.second > 0; });
        waiting.clear();
    };
    const auto count = [&](Cell brick) {
        waiting.push_back(brick);
        if (waiting.size() == kCountedAtOnce) count_waiting();
    };
    const std::vector<BrickKey> listed = bricks_of_list(world, lattice);
    for_each_brick(world.body, lattice, [&](Cell brick) {
        if (!listed.empty() && std::binary_search(listed.begin(), listed.end(), lattice.brick_key(brick))) return true;
        if (mine()) count(brick);
        return true;
    });
    for (const BrickKey key : listed) {
        if (mine()) count(lattice.brick_at(key));
    }
    count_waiting();
    std::sort(counts.begin(), counts.end());
    return counts;
}

void cells_of_brick(const World& world, const Lattice& lattice, BrickKey brick, std::vector<std::uint32_t>& cells) {
    cells.clear();
    const BrickCells bits = cells_of_body(world, lattice, lattice.brick_at(brick));
    for (std::uint32_t word = 0; word < bits.size(); ++word) {
        for (std::uint64_t rest = bits[word]; rest != 0; rest &= rest - 1) {
            cells.push_back(word * 64 + static_cast<std::uint32_t>(std::countr_zero(rest)));
        }
    }
}

std::uint64_t count_catoms(const World& world, const Lattice& lattice) {
    if (world.is_graph()) return world.graph->nodes();
    std::uint64_t total = 0;
    for (const auto& [brick, cells] : count_bricks(world, lattice, 0, 1)) total += cells;
    return total + world.placed.size();
}

}  // namespace meld::world
