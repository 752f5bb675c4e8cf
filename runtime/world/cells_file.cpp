// Reading and checking lists of cells.
#include "runtime/world/cells_file.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>

#include "runtime/world/world_file.h"

namespace meld::world {
namespace {

std::string_view trimmed(std::string_view text) {
    const std::size_t first = text.find_first_not_of(" \t\r");
    return first == std::string_view::npos ? text.substr(0, 0) : text.substr(first, text.find_last_not_of(" \t\r") - first + 1);
}

bool is_header(std::string_view line) {
    const char c = line[0] | 0x20;
    return c >= 'a' && c <= 'z' && line.starts_with("nan") == false && line.starts_with("inf") == false;
}

// The integers of a line; the column of what is none of them is in the error.
Result<std::vector<std::int64_t>> parse_line(std::string_view line, const std::string& place) {
    std::vector<std::int64_t> numbers;
    for (std::size_t at = 0; at <= line.size();) {
        const std::size_t end = std::min(line.find(',', at), line.size());
        const std::string_view field = trimmed(line.substr(at, end - at));
        std::int64_t number = 0;
        const auto [stop, error] = std::from_chars(field.data(), field.data() + field.size(), number);
        if (error != std::errc() || stop != field.data() + field.size()) {
            const std::size_t column = field.empty() ? at + 1 : static_cast<std::size_t>(field.data() - line.data()) + 1;
            return fail(fmt::format("{}:{}: '{}' is not a cell coordinate", place, column, field.substr(0, 40)), "write whole numbers, x,y,z");
        }
        numbers.push_back(number);
        at = end + 1;
    }
    return numbers;
}

}  // namespace

Result<Cell> checked_cell(const std::vector<std::int64_t>& coordinates, const Lattice& lattice) {
    const std::size_t count = coordinates.size();
    if (count != 3 && !(count == 2 && lattice.flat())) {
        return fail(fmt::format("a cell of the {} lattice has {} coordinates, here are {}", lattice.name(), lattice.flat() ? "2 or 3" : "3", count));
    }
    for (const std::int64_t value : coordinates) {
        if (value < -kCellLimit || value >= kCellLimit) {
            return fail(fmt::format("cell coordinate {} is not between {} and {}", value, -kCellLimit, kCellLimit - 1));
        }
    }
    const auto part = [&coordinates](std::size_t i) { return static_cast<std::int32_t>(coordinates[i]); };
    const Cell cell = {part(0), part(1), count == 3 ? part(2) : 0};
    if (lattice.flat() && cell.z != 0) return fail(fmt::format("z = {} of a cell is not 0, but the {} lattice is flat", cell.z, lattice.name()));
    return cell;
}

Result<std::vector<ListedCell>> parse_cells(std::string_view text, const std::string& path, const Lattice& lattice) {
    std::vector<ListedCell> cells;
    std::size_t number = 0;
    bool first = true;
    while (!text.empty()) {
        const std::size_t end = std::min(text.find('\n'), text.size());
        const std::string_view line = text.substr(0, end);
        text.remove_prefix(std::min(end + 1, text.size()));
        ++number;
        const std::string_view content = trimmed(line);
        if (content.empty() || content[0] == '#') continue;
        const bool header = first && is_header(content);
        first = false;
        if (header) continue;
        const std::string place = fmt::format("{}:{}", path, number);
        const Result<std::vector<std::int64_t>> coordinates = parse_line(line, place);
        if (!coordinates) return tl::unexpected(coordinates.error());
        const Result<Cell> cell = checked_cell(*coordinates, lattice);
        if (!cell) return fail(fmt::format("{}: {}", place, cell.error().problem), cell.error().suggestion);
        cells.push_back({*cell, place});
    }
    return cells;
}

Result<std::vector<Cell>> sorted_cells(std::vector<ListedCell> listed, const Lattice& lattice) {
    std::stable_sort(listed.begin(), listed.end(),
                     [&lattice](const ListedCell& a, const ListedCell& b) { return lattice.key(a.cell) < lattice.key(b.cell); });
    std::vector<Cell> cells;
    for (std::size_t i = 0; i < listed.size(); ++i) {
        const Cell cell = listed[i].cell;
        if (i > 0 && listed[i - 1].cell == cell) {
            return fail(fmt::format("{}: cell ({}, {}, {}) is listed twice, first in {}", listed[i].place, cell.x, cell.y, cell.z, listed[i - 1].place),
                        "take one of them out");
        }
        cells.push_back(cell);
    }
    return cells;
}

void sort_cells(std::vector<Cell>& cells, const Lattice& lattice) {
    std::sort(cells.begin(), cells.end(), [&lattice](Cell a, Cell b) { return lattice.key(a) < lattice.key(b); });
    cells.erase(std::unique(cells.begin(), cells.end()), cells.end());
}

}  // namespace meld::world
