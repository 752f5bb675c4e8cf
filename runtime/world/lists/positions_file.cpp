// Reading lists of positions.
#include "runtime/world/lists/positions_file.h"

#include <fmt/format.h>

#include <charconv>
#include <cmath>

#include "runtime/base/did_you_mean.h"
#include "runtime/world/lists/npy_file.h"
#include "runtime/world/lists/table_lines.h"

namespace meld::world {
namespace {

enum class Column { X, Y, Z, Radius, Mass };

// A file without names has only the coordinates.
const std::vector<Column> kPlace{Column::X, Column::Y, Column::Z};

constexpr std::string_view kSizes[] = {"radius", "mass"};

Result<std::vector<Column>> parse_names(const CsvRow& row, const std::string& path, std::size_t line_number) {
    std::vector<Column> columns;
    for (std::size_t i = 0; i < row.fields().size(); ++i) {
        const std::string_view name = row.fields()[i];
        // The first three are the coordinates, whatever they are called.
        if (columns.size() < kPlace.size())
            columns.push_back(kPlace[columns.size()]);
        else if (name == kSizes[0])
            columns.push_back(Column::Radius);
        else if (name == kSizes[1])
            columns.push_back(Column::Mass);
        else
            return fail(
                fmt::format("{}:{}:{}: a list of positions has no column '{}'", path, line_number, row.column(i), name.substr(0, 40)),
                did_you_mean(name, kSizes));
    }
    // A heading of a word or two is not a line of column names.
    return columns.size() < kPlace.size() ? kPlace : columns;
}

Result<PlacedCatom> parse_row(const CsvRow& row, const std::vector<Column>& columns, const std::string& path, std::size_t line_number) {
    PlacedCatom placed;
    const std::size_t count = row.fields().size();
    for (std::size_t i = 0; i < count; ++i) {
        const std::string_view field = row.fields()[i];
        const bool place = i >= columns.size() || columns[i] < Column::Radius;
        double number = 0;
        const auto [stop, error] = std::from_chars(field.data(), field.data() + field.size(), number);
        if (error != std::errc() || stop != field.data() + field.size() || !std::isfinite(number))
            return fail(fmt::format("{}:{}:{}: '{}' is not a {}", path, line_number, row.column(i), field.substr(0, 40),
                                    place ? "coordinate" : "number"),
                        place ? "write numbers, x,y,z" : "");
        if (!place && number <= 0)
            return fail(fmt::format("{}:{}:{}: {} is not a number above zero", path, line_number, row.column(i), field.substr(0, 40)));
        if (i >= columns.size()) continue;
        if (place)
            placed.position[i] = number;
        else
            (columns[i] == Column::Radius ? placed.radius : placed.mass) = number;
    }
    if (count == columns.size()) return placed;
    if (columns.size() == kPlace.size())
        return fail(fmt::format("{}:{}: a position has 3 coordinates, here are {}", path, line_number, count));
    return fail(fmt::format("{}:{}: here are {} numbers, and the first line names {} columns", path, line_number, count, columns.size()));
}

// Rows are counted from 0, as NumPy does.
Result<void> add_table(std::string_view bytes, const std::string& path, std::vector<PlacedCatom>& placed) {
    const Result<NpyTable> table = NpyTable::read(bytes, path);
    if (!table) return tl::unexpected(table.error());
    if (table->columns() != 3 && table->columns() != 5)
        return fail(fmt::format("{} has {} columns", path, table->columns()), "save x, y and z, or x, y, z, radius and mass");
    for (std::size_t row = 0; row < table->rows(); ++row) {
        PlacedCatom& catom = placed.emplace_back();
        for (std::size_t i = 0; i < table->columns(); ++i) {
            const double value = table->at(row, i);
            if (!std::isfinite(value) || (i >= 3 && value <= 0))
                return fail(fmt::format("{}: in row {}, {} is not a {}", path, row, value, i < 3 ? "coordinate" : "number above zero"));
            if (i < 3)
                catom.position[i] = value;
            else
                (i == 3 ? catom.radius : catom.mass) = value;
        }
    }
    return {};
}

}  // namespace

Result<void> add_positions(std::string_view text, const std::string& path, std::vector<PlacedCatom>& placed) {
    if (NpyTable::is_one(text)) return add_table(text, path, placed);
    if (auto plain = NpyTable::check_text(text, path); !plain) return plain;
    std::vector<Column> columns = kPlace;
    const auto name_columns = [&](const CsvRow& row, std::size_t number) -> Result<void> {
        auto named = parse_names(row, path, number);
        if (!named) return tl::unexpected(named.error());
        columns = std::move(*named);
        return {};
    };
    const auto place = [&](const CsvRow& row, std::size_t number) -> Result<void> {
        auto catom = parse_row(row, columns, path, number);
        if (!catom) return tl::unexpected(catom.error());
        placed.push_back(*catom);
        return {};
    };
    return each_row(text, path, place, name_columns);
}

}  // namespace meld::world
