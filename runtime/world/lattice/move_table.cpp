#include "runtime/world/lattice/move_table.h"

#include <algorithm>
#include <array>
#include <cstdlib>
#include <sstream>

#include "runtime/base/assert.h"

namespace meld::world {

namespace {

struct Line {
    std::string_view tables, lattices, by, full, empty, one_empty;
};

constexpr Line kLines[] = {
#define MELD_MOVE(tables, lattices, by, full, empty, one_empty) {tables, lattices, by, full, empty, one_empty},
#include "runtime/world/lattice/moves.def"
};

std::vector<std::string_view> words_of(std::string_view text) {
    std::vector<std::string_view> words;
    for (std::size_t at = text.find_first_not_of(' '); at < text.size(); at = text.find_first_not_of(' ', at)) {
        const std::size_t end = std::min(text.find(' ', at), text.size());
        words.push_back(text.substr(at, end - at));
        at = end;
    }
    return words;
}

bool has_word(std::string_view text, std::string_view word) { return std::ranges::count(words_of(text), word) > 0; }

// "0 -1, 1 -1"
std::vector<Cell> cells_of(std::string_view text) {
    std::vector<Cell> cells;
    for (std::size_t at = 0; at < text.size();) {
        const std::size_t end = std::min(text.find(',', at), text.size());
        std::istringstream numbers{std::string(text.substr(at, end - at))};
        Cell cell;
        numbers >> cell.x >> cell.y;
        MELD_CHECK(!numbers.fail(), "moves.def has the cell {}", text.substr(at, end - at));
        if (!(numbers >> cell.z)) cell.z = 0;
        cells.push_back(cell);
        at = end + 1;
    }
    return cells;
}

Move move_of(const Line& line) {
    Move move{.by = cells_of(line.by).at(0), .full = cells_of(line.full), .empty = cells_of(line.empty)};
    const std::vector<Cell> pairs = cells_of(line.one_empty);
    MELD_CHECK(pairs.size() % 2 == 0, "moves.def has {} cells in pairs", pairs.size());
    for (std::size_t i = 0; i + 1 < pairs.size(); i += 2) move.one_empty.emplace_back(pairs[i], pairs[i + 1]);
    return move;
}

// Cells as vectors that the symmetries of the lattice, which are linear maps, turn into others. Only on the fcc lattice these are not the
// differences of the cells' coordinates: there the vectors are integers with an even sum, and the symmetries are those of a cube.
Cell vector_of(LatticeKind lattice, Cell offset) {
    if (lattice != LatticeKind::Fcc) return offset;
    return {offset.x + offset.y + (offset.z & 1), offset.x - offset.y, offset.z};
}
Cell offset_of(LatticeKind lattice, Cell vector, std::int32_t layer) {
    if (lattice != LatticeKind::Fcc) return vector;
    const std::int32_t shift = layer - ((layer + vector.z) & 1);
    return {(vector.x + vector.y + shift) / 2, (vector.x - vector.y + shift) / 2, vector.z};
}

struct Matrix {
    std::array<Cell, 3> rows;
    Cell operator*(Cell v) const {
        const auto dot = [&](Cell row) { return row.x * v.x + row.y * v.y + row.z * v.z; };
        return {dot(rows[0]), dot(rows[1]), dot(rows[2])};
    }
    std::int32_t determinant() const {
        const auto& [a, b, c] = rows;
        return a.x * (b.y * c.z - b.z * c.y) - a.y * (b.x * c.z - b.z * c.x) + a.z * (b.x * c.y - b.y * c.x);
    }
};

// The rotations by 60 degrees in axial coordinates, and each with the swap of the two axes.
std::vector<Matrix> hexagonal() {
    std::vector<Matrix> all;
    Cell x{1, 0, 0}, y{0, 1, 0};
    for (int turn = 0; turn < 6; ++turn) {
        all.push_back({{Cell{x.x, y.x, 0}, Cell{x.y, y.y, 0}, Cell{0, 0, 1}}});
        all.push_back({{Cell{y.x, x.x, 0}, Cell{y.y, x.y, 0}, Cell{0, 0, 1}}});
        const auto turned = [](Cell c) { return Cell{-c.y, c.x + c.y, 0}; };
        x = turned(x);
        y = turned(y);
    }
    return all;
}

// Those that map axes to axes; of a flat lattice, the third one to itself.
std::vector<Matrix> rectangular(bool flat) {
    std::vector<Matrix> all;
    std::array<std::size_t, 3> order = {0, 1, 2};
    do {
        if (flat && order[2] != 2) continue;
        for (unsigned signs = 0; signs < (flat ? 4u : 8u); ++signs) {
            Matrix m{};
            for (std::size_t row = 0; row < 3; ++row) {
                const std::array<std::int32_t Cell::*, 3> axes = {&Cell::x, &Cell::y, &Cell::z};
                m.rows[row].*axes[order[row]] = (signs >> row & 1) != 0 ? -1 : 1;
            }
            all.push_back(m);
        }
    } while (std::ranges::next_permutation(order).found);
    return all;
}

std::vector<Matrix> symmetries_of(LatticeKind lattice, Symmetries which) {
    if (which == Symmetries::None) return {Matrix{{Cell{1, 0, 0}, Cell{0, 1, 0}, Cell{0, 0, 1}}}};
    const bool flat = lattice == LatticeKind::Square;
    std::vector<Matrix> all = lattice == LatticeKind::Hex ? hexagonal() : rectangular(flat);
    if (which == Symmetries::Rotations) std::erase_if(all, [](const Matrix& m) { return m.determinant() < 0; });
    return all;
}

template <class T>
void sort_once(std::vector<T>& items) {
    std::ranges::sort(items);
    items.erase(std::unique(items.begin(), items.end()), items.end());
}

std::int32_t farthest(Cell cell) { return std::max({std::abs(cell.x), std::abs(cell.y), std::abs(cell.z)}); }

std::vector<Cell> all_cells(const Move& move) {
    std::vector<Cell> cells = move.full;
    cells.insert(cells.end(), move.empty.begin(), move.empty.end());
    for (const auto& [one, other] : move.one_empty) cells.insert(cells.end(), {one, other});
    return cells;
}

}  // namespace

std::vector<std::string_view> MoveTable::names(LatticeKind lattice) {
    std::vector<std::string_view> names;
    for (const Line& line : kLines)
        if (has_word(line.lattices, Lattice(lattice).name()))
            for (const std::string_view name : words_of(line.tables))
                if (std::ranges::count(names, name) == 0) names.push_back(name);
    return names;
}

std::vector<std::string_view> MoveTable::lattices(std::string_view name) {
    std::vector<std::string_view> lattices;
    for (const Line& line : kLines)
        if (has_word(line.tables, name))
            for (const std::string_view lattice : words_of(line.lattices))
                if (std::ranges::count(lattices, lattice) == 0) lattices.push_back(lattice);
    return lattices;
}

std::vector<ListedMove> MoveTable::named(std::string_view name, LatticeKind lattice) {
    std::vector<ListedMove> listed;
    for (const Line& line : kLines)
        if (has_word(line.tables, name) && has_word(line.lattices, Lattice(lattice).name())) listed.push_back({move_of(line)});
    return listed;
}

MoveTable::MoveTable(LatticeKind lattice, std::string name, std::span<const ListedMove> listed)
    : name_(std::move(name)), layers_(lattice == LatticeKind::Fcc ? 2 : 1) {
    for (const ListedMove& one : listed) add(lattice, one);
    for (Layer& layer : layers_) {
        sort_once(layer.moves);
        number_cells(layer);
    }
}

void MoveTable::add(LatticeKind lattice, const ListedMove& listed) {
    for (const Matrix& symmetry : symmetries_of(lattice, listed.symmetries))
        for (std::size_t layer = 0; layer < layers_.size(); ++layer) {
            const auto turned = [&](Cell c) {
                return offset_of(lattice, symmetry * vector_of(lattice, c), static_cast<std::int32_t>(layer));
            };
            Move move{.by = turned(listed.move.by)};
            for (const Cell c : listed.move.full) move.full.push_back(turned(c));
            for (const Cell c : listed.move.empty) move.empty.push_back(turned(c));
            move.empty.push_back(move.by);
            for (const auto& [one, other] : listed.move.one_empty) {
                const auto [first, last] = std::minmax({turned(one), turned(other)});
                move.one_empty.emplace_back(first, last);
            }
            sort_once(move.full);
            sort_once(move.empty);
            sort_once(move.one_empty);
            longest_ = std::max(longest_, farthest(move.by));
            layers_[layer].moves.push_back(std::move(move));
        }
}

void MoveTable::number_cells(Layer& layer) {
    for (const Move& move : layer.moves)
        for (const Cell cell : all_cells(move)) layer.cells.push_back(cell);
    sort_once(layer.cells);
    for (const Cell cell : layer.cells) reach_ = std::max(reach_, farthest(cell));
    const auto number = [&](Cell cell) {
        return static_cast<std::uint16_t>(std::ranges::lower_bound(layer.cells, cell) - layer.cells.begin());
    };
    for (const Move& move : layer.moves) {
        LookedAt& at = layer.looked_at.emplace_back();
        at.by = number(move.by);
        for (const Cell cell : move.full) at.full.push_back(number(cell));
        for (const Cell cell : move.empty) at.empty.push_back(number(cell));
        for (const auto& [one, other] : move.one_empty) at.one_empty.emplace_back(number(one), number(other));
    }
    MELD_ENSURE(layer.looked_at.size() == layer.moves.size(), "{} of {} moves", layer.looked_at.size(), layer.moves.size());
}

std::size_t MoveTable::first_by(Cell cell, Cell by) const {
    const std::span<const Move> moves = from(cell);
    return static_cast<std::size_t>(std::ranges::lower_bound(moves, by, {}, &Move::by) - moves.begin());
}

}  // namespace meld::world
