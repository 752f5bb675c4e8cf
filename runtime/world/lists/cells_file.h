// Lists of cells in CSV and NumPy files.
#pragma once

#include <compare>
#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "runtime/base/error.h"
#include "runtime/world/lattice/lattice.h"

namespace meld::world {

// The listed cells, each with its place in the file (its line, or in a NumPy file its row, counted from 0), for messages about two of them.
class CellList {
  public:
    explicit CellList(const Lattice& lattice) : lattice_(lattice) {}
    const Lattice& lattice() const { return lattice_; }

    // Adds the rows of a NumPy file, or of a CSV file: lines of three integers separated by commas, or two on a flat lattice; skips
    // a first line of words, empty lines, and lines that start with '#'. `path` is for messages. Errors name line and column.
    Result<void> add_file(std::string_view text, const std::string& path);

    // Adds the cell with these coordinates. Errors say why it is not a cell of the lattice, without the place; column 0: none.
    Result<void> add(const std::vector<std::int64_t>& coordinates, const std::string& path, std::size_t line, std::size_t column);

    // The cells in the order of World::cells. Errors: a cell is listed twice, with both places.
    Result<std::vector<Cell>> sorted();

  private:
    struct Row {
        CellKey key = 0;
        std::uint32_t path = 0, line = 0, column = 0;
        auto operator<=>(const Row&) const = default;
    };
    Result<void> add_table(std::string_view bytes, const std::string& path);
    std::string place(const Row& row) const;

    const Lattice& lattice_;
    std::vector<std::string> paths_;
    std::vector<Row> rows_;
};

}  // namespace meld::world
