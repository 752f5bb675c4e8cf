// Reading lists of positions.
#include "runtime/world/positions_file.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>

namespace meld::world {
namespace {

std::string_view trimmed(std::string_view text) {
    const std::size_t first = text.find_first_not_of(" \t\r");
    return first == std::string_view::npos ? text.substr(0, 0) : text.substr(first, text.find_last_not_of(" \t\r") - first + 1);
}

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
    std::size_t number = 0;
    bool first = true;
    while (!text.empty()) {
        const std::size_t end = std::min(text.find('\n'), text.size());
        const std::string_view line = text.substr(0, end);
        text.remove_prefix(std::min(end + 1, text.size()));
        ++number;
        const std::string_view content = trimmed(line);
        if (content.empty() || content[0] == '#') continue;
        const char letter = content[0] | 0x20;
        const bool header = first && letter >= 'a' && letter <= 'z' && !content.starts_with("nan") && !content.starts_with("inf");
        first = false;
        if (header) continue;
        const Result<Vec3> position = parse_line(line, path, number);
        if (!position) return tl::unexpected(position.error());
        positions.push_back(*position);
    }
    return {};
}

}  // namespace meld::world
