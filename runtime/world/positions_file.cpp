// Reading lists of positions.
#include "runtime/world/positions_file.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>

#include "runtime/world/table_lines.h"

namespace meld::world {
namespace {

Result<Vec3> parse_line(std::string_view line, const std::string& path, std::size_t line_number) {
    Vec3 position{};
    std::size_t count = 0;
    for (std::size_t at = 0; at <= line.size(); ++count) {
        const std::size_t end = std::min(line.find(',', at), line.size());
        const std::string_view field = trimmed(line.substr(at, end - at));
        double number = 0;
        const auto [stop, error] = std::from_chars(field.data(), field.data() + field.size(), number);
        if (error != std::errc() || stop != field.data() + field.size() || !std::isfinite(number))
            return fail(fmt::format("{}:{}:{}: '{}' is not a coordinate", path, line_number, at + 1, field.substr(0, 40)), "write numbers, x,y,z");
        if (count < 3) position[count] = number;
        at = end + 1;
    }
    if (count != 3) return fail(fmt::format("{}:{}: a position has 3 coordinates, here are {}", path, line_number, count));
    return position;
}

}  // namespace

Result<void> add_positions(std::string_view text, const std::string& path, std::vector<Vec3>& positions) {
    return each_row(text, [&](std::string_view line, std::size_t number) -> Result<void> {
        const Result<Vec3> position = parse_line(line, path, number);
        if (!position) return tl::unexpected(position.error());
        positions.push_back(*position);
        return {};
    });
}

}  // namespace meld::world
