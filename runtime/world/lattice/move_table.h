// Which moves the catoms of a world can make, as data: tables of the literature by their names (moves.def), and moves that a world lists
// itself (docs/moves.md). Each is given once and stands for its rotations and reflections.
#pragma once

#include <compare>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "runtime/world/lattice/lattice.h"

namespace meld::world {

// A way to move: where to, and what the cells around must be. All cells are seen from the mover, and sorted.
struct Move {
    Cell by;
    std::vector<Cell> full = {}, empty = {};            // `by` is among the empty ones.
    std::vector<std::pair<Cell, Cell>> one_empty = {};  // At least one of each two is empty.
    auto operator<=>(const Move&) const = default;
};

enum class Symmetries { None, Rotations, All };

// A move as a table has it, before its symmetries; on the fcc lattice as seen from a cell of an even layer.
struct ListedMove {
    Move move;
    Symmetries symmetries = Symmetries::All;
};

class MoveTable {
  public:
    // How far a move may lead in each coordinate, and how far away the cells may be that it depends on. Processes know what is that near.
    static constexpr std::int32_t kMaxBy = 2, kMaxAway = 4;

    // The names of all tables of a lattice, and the lattices that have a table of this name.
    static std::vector<std::string_view> names(LatticeKind lattice);
    static std::vector<std::string_view> lattices(std::string_view name);
    static std::vector<ListedMove> named(std::string_view name, LatticeKind lattice);

    // `name`: in messages, as `the moves "pivoting"`.
    MoveTable(LatticeKind lattice, std::string name, std::span<const ListedMove> listed);

    const std::string& name() const { return name_; }
    // All moves from a cell, in an order of their own: by where they lead, then by the cells. On the fcc lattice they depend on the layer.
    std::span<const Move> from(Cell cell) const { return layers_[layer(cell)].moves; }
    // The cells on which they depend.
    std::span<const Cell> cells_around(Cell cell) const { return layers_[layer(cell)].cells; }
    // The greatest coordinate of any of these, and the greatest of where moves lead.
    std::int32_t reach() const { return reach_; }
    std::int32_t longest() const { return longest_; }

    // The number of the first move that leads there and fits, in from(cell). `full` says whether a cell is occupied, as seen from there.
    template <class Full>
    std::optional<std::size_t> find(Cell cell, Cell by, const Full& full) const {
        const std::span<const Move> moves = from(cell);
        for (std::size_t i = first_by(cell, by); i < moves.size() && moves[i].by == by; ++i)
            if (fits(moves[i], full)) return i;
        return std::nullopt;
    }
    // Where the moves lead that are possible from a cell, each once, in order. Cost: a look at each cell of cells_around() at most; where
    // all is full, only at those to which moves lead. `known` is memory that may be used again.
    template <class Full>
    void possible(Cell cell, const Full& full, std::vector<std::uint8_t>& known, std::vector<Cell>& found) const {
        found.clear();
        const Layer& here = layers_[layer(cell)];
        // Of each cell: nothing, empty, full.
        known.assign(here.cells.size(), 0);
        const auto is_full = [&](std::uint16_t at) {
            if (known[at] == 0) known[at] = full(here.cells[at]) ? 2 : 1;
            return known[at] == 2;
        };
        for (std::size_t i = 0; i < here.moves.size(); ++i)
            if ((found.empty() || found.back() != here.moves[i].by) && here.looked_at[i].fits(is_full)) found.push_back(here.moves[i].by);
    }

  private:
    // The cells of a move, by their numbers in Layer::cells.
    struct LookedAt {
        std::uint16_t by = 0;
        std::vector<std::uint16_t> full, empty;
        std::vector<std::pair<std::uint16_t, std::uint16_t>> one_empty;
        template <class IsFull>
        bool fits(const IsFull& is_full) const {
            if (is_full(by)) return false;
            for (const std::uint16_t at : empty)
                if (is_full(at)) return false;
            for (const std::uint16_t at : full)
                if (!is_full(at)) return false;
            for (const auto& [one, other] : one_empty)
                if (is_full(one) && is_full(other)) return false;
            return true;
        }
    };
    struct Layer {
        std::vector<Move> moves;  // Sorted.
        std::vector<Cell> cells;  // Sorted.
        std::vector<LookedAt> looked_at;
    };

    template <class Full>
    static bool fits(const Move& move, const Full& full) {
        for (const Cell at : move.empty)
            if (full(at)) return false;
        for (const Cell at : move.full)
            if (!full(at)) return false;
        for (const auto& [one, other] : move.one_empty)
            if (full(one) && full(other)) return false;
        return true;
    }
    std::size_t layer(Cell cell) const { return layers_.size() == 1 ? 0 : static_cast<std::size_t>(cell.z & 1); }
    std::size_t first_by(Cell cell, Cell by) const;
    void add(LatticeKind lattice, const ListedMove& listed);
    void number_cells(Layer& layer);

    std::string name_;
    std::vector<Layer> layers_;  // Of even and odd layers on the fcc lattice, else one for all.
    std::int32_t reach_ = 0, longest_ = 0;
};

}  // namespace meld::world
