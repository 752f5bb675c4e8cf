// Reading lists of positions.
#include "runtime/world/lists/positions_file.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <optional>
#include <utility>

#include "runtime/base/did_you_mean.h"
#include "runtime/world/lists/npy_file.h"
#include "runtime/world/lists/table_lines.h"

namespace meld::world {
namespace {

// What a file may say about each position beside its coordinates.
struct Columns {
    std::string_view list;               // What it is a list of.
    std::vector<std::string_view> more;  // Names of columns.
    std::string_view npy_choice;         // Of the columns of NumPy files, in words.
    bool positive = true;                // Whether their numbers are above zero.
};
const Columns kOfCatoms{"positions", {"radius", "mass"}, "save x, y and z, or x, y, z, radius and mass", true};
const Columns kOfRobots{
    "places of robots", {"turned_x", "turned_y", "turned_z"}, "save x, y and z, or x, y, z, turned_x, turned_y and turned_z", false};

constexpr std::size_t kCoordinates = 3, kMostColumns = 6;

// A row of a file: coordinates, then what its columns say, in the order of Columns::more.
struct PositionRow {
    std::array<std::optional<double>, kMostColumns> numbers{};

    Vec3 position() const { return {*numbers[0], *numbers[1], *numbers[2]}; }
};

// Where the fields of a line go: their places in PositionRow::numbers.
using Order = std::vector<std::size_t>;
// A file without names has only the coordinates.
const Order kPlace{0, 1, 2};

Result<Order> parse_names(const CsvRow& row, const Columns& columns, const std::string& path, std::size_t line_number) {
    Order order;
    for (std::size_t i = 0; i < row.fields().size(); ++i) {
        const std::string_view name = row.fields()[i];
        const auto known = std::ranges::find(columns.more, name);
        // The first three are the coordinates, whatever they are called.
        if (order.size() < kCoordinates)
            order.push_back(order.size());
        else if (known != columns.more.end())
            order.push_back(kCoordinates + static_cast<std::size_t>(known - columns.more.begin()));
        else
            return fail(fmt::format("{}:{}:{}: a list of {} has no column '{}'", path, line_number, row.column(i), columns.list,
                                    name.substr(0, 40)),
                        did_you_mean(name, columns.more));
    }
    // A heading of a word or two is not a line of column names.
    return order.size() < kCoordinates ? kPlace : order;
}

Result<PositionRow> parse_row(const CsvRow& row, const Columns& columns, const Order& order, const std::string& path,
                              std::size_t line_number) {
    PositionRow found;
    const std::size_t count = row.fields().size();
    for (std::size_t i = 0; i < count; ++i) {
        const std::string_view field = row.fields()[i];
        const bool place = i >= order.size() || order[i] < kCoordinates;
        double number = 0;
        const auto [stop, error] = std::from_chars(field.data(), field.data() + field.size(), number);
        if (error != std::errc() || stop != field.data() + field.size() || !std::isfinite(number))
            return fail(fmt::format("{}:{}:{}: '{}' is not a {}", path, line_number, row.column(i), field.substr(0, 40),
                                    place ? "coordinate" : "number"),
                        place ? "write numbers, x,y,z" : "");
        if (!place && columns.positive && number <= 0)
            return fail(fmt::format("{}:{}:{}: {} is not a number above zero", path, line_number, row.column(i), field.substr(0, 40)));
        if (i < order.size()) found.numbers[order[i]] = number;
    }
    if (count == order.size()) return found;
    if (order.size() == kCoordinates)
        return fail(fmt::format("{}:{}: a position has 3 coordinates, here are {}", path, line_number, count));
    return fail(fmt::format("{}:{}: here are {} numbers, and the first line names {} columns", path, line_number, count, order.size()));
}

// Rows are counted from 0, as NumPy does.
template <class Add>
Result<void> each_of_table(std::string_view bytes, const Columns& columns, const std::string& path, const Add& add) {
    const Result<NpyTable> table = NpyTable::read(bytes, path);
    if (!table) return tl::unexpected(table.error());
    if (table->columns() != kCoordinates && table->columns() != kCoordinates + columns.more.size())
        return fail(fmt::format("{} has {} columns", path, table->columns()), std::string(columns.npy_choice));
    for (std::size_t row = 0; row < table->rows(); ++row) {
        PositionRow found;
        for (std::size_t i = 0; i < table->columns(); ++i) {
            const double value = table->at(row, i);
            if (!std::isfinite(value) || (i >= kCoordinates && columns.positive && value <= 0))
                return fail(fmt::format("{}: in row {}, {} is not a {}", path, row, value,
                                        i < kCoordinates   ? "coordinate"
                                        : columns.positive ? "number above zero"
                                                           : "number"));
            found.numbers[i] = value;
        }
        add(found);
    }
    return {};
}

// Calls add(row) for each row of a file.
template <class Add>
Result<void> each_position(std::string_view text, const Columns& columns, const std::string& path, const Add& add) {
    if (NpyTable::is_one(text)) return each_of_table(text, columns, path, add);
    if (auto plain = NpyTable::check_text(text, path); !plain) return plain;
    Order order = kPlace;
    const auto name_columns = [&](const CsvRow& row, std::size_t number) -> Result<void> {
        auto named = parse_names(row, columns, path, number);
        if (!named) return tl::unexpected(named.error());
        order = std::move(*named);
        return {};
    };
    const auto place = [&](const CsvRow& row, std::size_t number) -> Result<void> {
        auto found = parse_row(row, columns, order, path, number);
        if (!found) return tl::unexpected(found.error());
        add(*found);
        return {};
    };
    return each_row(text, path, place, name_columns);
}

}  // namespace

Result<void> add_positions(std::string_view text, const std::string& path, std::vector<PlacedCatom>& placed) {
    return each_position(text, kOfCatoms, path, [&](const PositionRow& row) {
        placed.push_back({.position = row.position(), .radius = row.numbers[kCoordinates], .mass = row.numbers[kCoordinates + 1]});
    });
}

Result<void> add_robot_places(std::string_view text, const std::string& path, std::vector<RobotPlace>& places) {
    return each_position(text, kOfRobots, path, [&](const PositionRow& row) {
        RobotPlace& place = places.emplace_back(RobotPlace{row.position(), {}});
        for (std::size_t i = 0; i < kCoordinates; ++i) place.turned[i] = row.numbers[kCoordinates + i].value_or(0);
    });
}

}  // namespace meld::world
