// Reading and checking lists of cells.
#include "runtime/world/lists/cells_file.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>

#include "runtime/world/description/world.h"
#include "runtime/world/lists/npy_file.h"
#include "runtime/world/lists/table_lines.h"

namespace meld::world {
namespace {

// The integers of a line; the error contains the column of a field that is not an integer.
Result<std::vector<std::int64_t>> parse_row(const CsvRow& row, const std::string& path, std::size_t line_number) {
    std::vector<std::int64_t> numbers;
    for (std::size_t i = 0; i < row.fields().size(); ++i) {
        const std::string_view field = row.fields()[i];
        const auto [stop, error] = std::from_chars(field.data(), field.data() + field.size(), numbers.emplace_back());
        if (error != std::errc() || stop != field.data() + field.size())
            return fail(fmt::format("{}:{}:{}: '{}' is not a cell coordinate", path, line_number, row.column(i), field.substr(0, 40)),
                        "write whole numbers, x,y,z");
    }
    return numbers;
}

}  // namespace

Result<void> CellList::add(const std::vector<std::int64_t>& coordinates, const std::string& path, std::size_t line, std::size_t column) {
    const std::size_t count = coordinates.size();
    if (count != 3 && !(count == 2 && lattice_.flat())) {
        return fail(fmt::format("a cell of the {} lattice has {} coordinates, here are {}", lattice_.name(),
                                lattice_.flat() ? "2 or 3" : "3", count));
    }
    for (const std::int64_t value : coordinates) {
        if (value < -kCellLimit || value >= kCellLimit) {
            return fail(fmt::format("cell coordinate {} is not between {} and {}", value, -kCellLimit, kCellLimit - 1));
        }
    }
    const auto part = [&coordinates](std::size_t i) { return static_cast<std::int32_t>(coordinates[i]); };
    const Cell cell = {part(0), part(1), count == 3 ? part(2) : 0};
    if (lattice_.flat() && cell.z != 0)
        return fail(fmt::format("z = {} of a cell is not 0, but the {} lattice is flat", cell.z, lattice_.name()));
    if (paths_.empty() || paths_.back() != path) paths_.push_back(path);
    rows_.push_back({lattice_.key(cell), static_cast<std::uint32_t>(paths_.size() - 1), static_cast<std::uint32_t>(line),
                     static_cast<std::uint32_t>(column)});
    return {};
}

Result<void> CellList::add_table(std::string_view bytes, const std::string& path) {
    const Result<NpyTable> table = NpyTable::read(bytes, path);
    if (!table) return tl::unexpected(table.error());
    std::vector<std::int64_t> coordinates(table->columns());
    for (std::size_t row = 0; row < table->rows(); ++row) {
        for (std::size_t i = 0; i < coordinates.size(); ++i) {
            const double value = table->at(row, i);
            // Far beyond the cells that exist, and not yet beyond integers.
            if (!(std::trunc(value) == value && std::abs(value) < 1e15))
                return fail(fmt::format("{}: in row {}, {} is not a cell coordinate", path, row, value), "save whole numbers");
            coordinates[i] = static_cast<std::int64_t>(value);
        }
        const Result<void> added = add(coordinates, path, row, 0);
        if (!added) return fail(fmt::format("{}: in row {}, {}", path, row, added.error().problem), added.error().suggestion);
    }
    return {};
}

Result<void> CellList::add_file(std::string_view text, const std::string& path) {
    if (NpyTable::is_one(text)) return add_table(text, path);
    if (auto plain = NpyTable::check_text(text, path); !plain) return plain;
    return each_row(text, path, [&](const CsvRow& row, std::size_t number) -> Result<void> {
        const Result<std::vector<std::int64_t>> coordinates = parse_row(row, path, number);
        if (!coordinates) return tl::unexpected(coordinates.error());
        const Result<void> added = add(*coordinates, path, number, 0);
        if (!added) return fail(fmt::format("{}:{}: {}", path, number, added.error().problem), added.error().suggestion);
        return {};
    });
}

std::string CellList::place(const Row& row) const {
    return fmt::format("{}:{}{}", paths_[row.path], row.line, row.column == 0 ? "" : fmt::format(":{}", row.column));
}

Result<std::vector<Cell>> CellList::sorted() {
    std::sort(rows_.begin(), rows_.end());
    std::vector<Cell> cells;
    cells.reserve(rows_.size());
    for (std::size_t i = 0; i < rows_.size(); ++i) {
        const Cell cell = lattice_.cell_at(rows_[i].key);
        if (i > 0 && rows_[i - 1].key == rows_[i].key) {
            return fail(fmt::format("{}: cell ({}, {}, {}) is listed twice, first in {}", place(rows_[i]), cell.x, cell.y, cell.z,
                                    place(rows_[i - 1])),
                        "take one of them out");
        }
        cells.push_back(cell);
    }
    return cells;
}

}  // namespace meld::world
