// Computes the size of a world before it is made.
#include "runtime/world/description/measure.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <deque>
#include <limits>
#include <numbers>

#include "runtime/base/hash.h"
#include "runtime/world/shapes/nearest_cell.h"
#include "runtime/world/shapes/shape_tree.h"

namespace meld::world {
namespace {

// The number of pieces into which space is divided: fine enough to tell a shell from a solid, fast enough for each start.
constexpr std::size_t kPieces = 20'000;
// Cells tested in each piece for the estimate: its error is then about a percent even for a thin shell.
constexpr int kSamples = 8;

double cells_between(Cell first, Cell last) {
    return (double{1} + last.x - first.x) * (double{1} + last.y - first.y) * (double{1} + last.z - first.z);
}

// How many of the points offset + step * k, k an integer, lie in [low, high).
double points_between(double low, double high, double offset, double step) {
    return std::max(0.0, std::ceil((high - offset) / step) - std::ceil((low - offset) / step));
}

// The box that a shape is, if it is an axis-aligned box.
std::optional<Box> plain_box(const Shape& shape) {
    if (!shape.root()) return std::nullopt;
    const Solid& solid = shape.root()->solid;
    if (std::holds_alternative<BoxSolid>(solid)) return shape.bounds();
    if (const auto* moved = std::get_if<Moved>(&solid); moved && plain_box(moved->solid)) return shape.bounds();
    if (const auto* scaled = std::get_if<Scaled>(&solid); scaled && plain_box(scaled->solid)) return shape.bounds();
    return std::nullopt;
}

double cells_in_box(const Lattice& lattice, const Box& box) {
    const auto points = [&box](std::size_t axis, double offset, double step) {
        return points_between(box.low[axis], box.high[axis], offset, step);
    };
    const bool at_zero = box.low[2] <= 0 && 0 < box.high[2];
    switch (lattice.kind()) {
        case LatticeKind::Square:
            return at_zero ? points(0, 0, 1) * points(1, 0, 1) : 0;
        case LatticeKind::Hex: {
            const double height = std::numbers::sqrt3 / 2;
            const double even = points(1, 0, 2 * height) * points(0, 0, 1), odd = points(1, height, 2 * height) * points(0, 0.5, 1);
            return at_zero ? even + odd : 0;
        }
        case LatticeKind::Cubic:
            return points(0, 0, 1) * points(1, 0, 1) * points(2, 0, 1);
        case LatticeKind::Fcc:
            break;
    }
    const double even = points(2, 0, std::numbers::sqrt2) * points(0, 0, 1) * points(1, 0, 1);
    const double odd = points(2, std::numbers::sqrt2 / 2, std::numbers::sqrt2) * points(0, 0.5, 1) * points(1, 0.5, 1);
    return even + odd;
}

struct Piece {
    Cell first, last;
};

struct Count {
    double at_most = 0, about = 0;
};

// How many of a few cells, spread over a piece in a fixed way, lie in the shape.
double share_inside(const Shape& shape, const Lattice& lattice, const Piece& piece, std::uint64_t seed) {
    int inside = 0;
    for (int i = 0; i < kSamples; ++i) {
        std::uint64_t random = mix64(seed * kSamples + static_cast<std::uint64_t>(i));
        Cell cell = piece.first;
        for (const auto side : {&Cell::x, &Cell::y, &Cell::z}) {
            const auto size = static_cast<std::uint64_t>(piece.last.*side - piece.first.*side) + 1;
            // A coordinate has at most 21 bits.
            cell.*side += static_cast<std::int32_t>((random & 0x1fffff) * size >> 21);
            random >>= 21;
        }
        inside += shape.contains(lattice.position(cell));
    }
    return static_cast<double>(inside) / kSamples;
}

// Halves the largest pieces until there are enough of them, dropping those that the shape does not reach.
Count count_cells(const Shape& shape, const Lattice& lattice, Piece all) {
    std::deque<Piece> pieces = {all};
    Count count;
    while (!pieces.empty() && pieces.size() < kPieces) {
        const Piece piece = pieces.front();
        pieces.pop_front();
        Box box;
        lattice.positions_covering(piece.first, piece.last, box.low, box.high);
        if (!shape.may_touch(box)) continue;
        if (shape.surely_contains(box)) {
            count.at_most += cells_between(piece.first, piece.last);
            count.about += cells_between(piece.first, piece.last);
            continue;
        }
        const Cell size = piece.last - piece.first;
        std::int32_t Cell::* side = size.x >= size.y && size.x >= size.z ? &Cell::x : size.y >= size.z ? &Cell::y : &Cell::z;
        if (size.*side == 0) {
            const double inside = shape.contains(lattice.position(piece.first)) ? 1 : 0;
            count.at_most += inside;
            count.about += inside;
            continue;
        }
        Piece below = piece, above = piece;
        below.last.*side = piece.first.*side + size.*side / 2;
        above.first.*side = below.last.*side + 1;
        pieces.push_back(below);
        pieces.push_back(above);
    }
    for (std::size_t i = 0; i < pieces.size(); ++i) {
        const double cells = cells_between(pieces[i].first, pieces[i].last);
        count.at_most += cells;
        count.about += cells * share_inside(shape, lattice, pieces[i], i);
    }
    return count;
}

bool at_the_edge(Cell cell) {
    const auto edge = [](std::int32_t value) { return value == -kCellLimit || value == kCellLimit - 1; };
    return edge(cell.x) || edge(cell.y) || edge(cell.z);
}

void widen(WorldSize& size, Cell first, Cell last) {
    const bool empty = size.cells_upper_bound == 0;
    for (const auto side : {&Cell::x, &Cell::y, &Cell::z}) {
        size.first.*side = empty ? first.*side : std::min(size.first.*side, first.*side);
        size.last.*side = empty ? last.*side : std::max(size.last.*side, last.*side);
    }
}

Error too_wide(const Box& box, double cells) {
    double reach = 0;
    for (std::size_t i = 0; i < 3; ++i) reach = std::max({reach, std::abs(box.low[i]), std::abs(box.high[i])});
    return {fmt::format("the body has up to {:.3g} cells and reaches {:.3g} catom diameters from the origin, but cells lie within {}",
                        cells, reach, kCellLimit),
            "make it smaller"};
}

}  // namespace

Cell nearest_cell(const Vec3& position) {
    const auto nearest = [](double x) { return static_cast<std::int32_t>(std::clamp(std::round(x), -1e6, 1e6)); };
    return {nearest(position[0]), nearest(position[1]), nearest(position[2])};
}

Result<WorldSize> measure(const World& world) {
    const Lattice lattice(world.lattice);
    WorldSize size;
    if (world.is_graph()) {
        size.cells_upper_bound = size.cells_estimate = static_cast<double>(world.graph->nodes());
        return size;
    }
    if (const Box box = world.body.bounds(); !box.empty()) {
        Cell first, last;
        lattice.cells_covering(box.low, box.high, first, last);
        const bool plain = plain_box(world.body).has_value();
        if (at_the_edge(first) || at_the_edge(last)) return tl::unexpected(too_wide(box, cells_in_box(lattice, box)));
        const double in_box = cells_in_box(lattice, box);
        const Count count = plain ? Count{in_box, in_box} : count_cells(world.body, lattice, {first, last});
        widen(size, first, last);
        size.cells_upper_bound = count.at_most;
        size.cells_estimate = count.about;
    }
    for (const Cell cell : world.cells) {
        widen(size, cell, cell);
        size.cells_upper_bound += 1;
        size.cells_estimate += 1;
    }
    for (const PlacedCatom& placed : world.placed) {
        const Cell cell = nearest_cell(placed.position);
        widen(size, cell, cell);
        size.cells_upper_bound += 1;
        size.cells_estimate += 1;
    }
    if (size.cells_upper_bound == 0) {
        return fail("no catom: the body is empty", world.body.root() ? "make its shape larger" : "add a [[body]] with a shape or cells");
    }
    return size;
}

}  // namespace meld::world
