#include "runtime/base/units.h"

#include <fmt/format.h>
#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <limits>
#include <span>

#include "runtime/base/csv_row.h"

namespace meld {

namespace {

struct Suffix {
    std::string_view text;
    double factor;
};

constexpr double kKibi = 1024.0;
constexpr auto kMultiples = std::to_array<Suffix>({
    {"", 1},
    {"k", 1e3},
    {"K", 1e3},
    {"M", 1e6},
    {"G", 1e9},
    {"T", 1e12},
    {"P", 1e15},
    {"Ki", kKibi},
    {"Mi", kKibi* kKibi},
    {"Gi", kKibi* kKibi* kKibi},
    {"Ti", kKibi* kKibi* kKibi* kKibi},
    {"Pi", kKibi* kKibi* kKibi* kKibi* kKibi},
});
constexpr auto kTimes = std::to_array<Suffix>({
    {"", 1},
    {"ns", 1e-9},
    {"us", 1e-6},
    {"µs", 1e-6},
    {"ms", 1e-3},
    {"s", 1},
    {"min", 60},
    {"m", 60},
    {"h", 3600},
    {"d", 86400},
});

// The parts of a written number. `digits` holds the value exactly if the number is whole and fits in 64 bits.
struct Written {
    double value = 0;
    std::uint64_t digits = 0;
    bool exact = false;
    double factor = 1;
};

Result<Written> read(std::string_view text, std::span<const Suffix> suffixes, std::string_view what) {
    const std::string_view body = trimmed(text);
    Written written;
    const char* const end = body.data() + body.size();
    const auto number = std::from_chars(body.data(), end, written.value);
    if (number.ec == std::errc::result_out_of_range) return fail(fmt::format("'{}' is out of range for {}", text, what));
    if (number.ec != std::errc{} || !std::isfinite(written.value)) return fail(fmt::format("'{}' is not {}", text, what));
    const auto digits = std::from_chars(body.data(), end, written.digits);
    written.exact = digits.ec == std::errc{} && digits.ptr == number.ptr;

    const std::string_view suffix = trimmed({number.ptr, static_cast<std::size_t>(end - number.ptr)});
    const auto found = std::ranges::find(suffixes, suffix, &Suffix::text);
    if (found == suffixes.end()) {
        std::string known;
        for (const Suffix& candidate : suffixes.subspan(1)) known += fmt::format("{}{}", known.empty() ? "" : ", ", candidate.text);
        return fail(fmt::format("'{}' has the unknown suffix '{}'", text, suffix), fmt::format("Known are {}", known));
    }
    written.factor = found->factor;
    return written;
}

enum class Fraction { Refuse, Round };

Result<std::uint64_t> whole(const Written& written, std::string_view text, std::string_view what, Fraction fraction) {
    if (written.value < 0) return fail(fmt::format("'{}' is negative, but {} cannot be", text, what));
    const auto out_of_range = [&] { return fail(fmt::format("'{}' is too large for {}", text, what)); };
    if (written.exact) {
        std::uint64_t result = 0;
        if (__builtin_mul_overflow(written.digits, static_cast<std::uint64_t>(written.factor), &result)) return out_of_range();
        return result;
    }
    const double value = written.value * written.factor;
    if (value >= 0x1p64) return out_of_range();
    const double rounded = std::round(value);
    if (fraction == Fraction::Refuse && std::abs(value - rounded) > 1e-9 * std::max(1.0, value))
        return fail(fmt::format("'{}' is not a whole number, but {} is one", text, what));
    return static_cast<std::uint64_t>(rounded);
}

// The number of digits after the point that shows about three significant digits, without zeros at the end.
std::string short_number(double value) {
    const int decimals = std::abs(value) >= 99.95 ? 0 : std::abs(value) >= 9.995 ? 1 : 2;
    std::string text = fmt::format("{:.{}f}", value, decimals);
    if (decimals > 0) {
        text.erase(text.find_last_not_of('0') + 1);
        if (text.back() == '.') text.pop_back();
    }
    return text;
}

// The value in the largest unit in which it is at least one; the next unit if it would be shown as a full one.
std::string in_units(double value, double step, std::span<const std::string_view> units) {
    std::size_t unit = 0;
    while (unit + 1 < units.size() && std::abs(value) >= step - 0.5) {
        value /= step;
        ++unit;
    }
    const std::string number = short_number(value);
    return units[unit].empty() ? number : fmt::format("{} {}", number, units[unit]);
}

}  // namespace

Result<double> parse_number(std::string_view text) {
    return read(text, kMultiples, "a number").map([](const Written& written) { return written.value * written.factor; });
}

Result<std::uint64_t> parse_count(std::string_view text) {
    return read(text, kMultiples, "a count").and_then([&](const Written& written) {
        return whole(written, text, "a count", Fraction::Refuse);
    });
}

Result<std::uint64_t> parse_bytes(std::string_view text) {
    std::string_view body = trimmed(text);
    if (body.ends_with('B')) body.remove_suffix(1);
    return read(body, kMultiples, "a size in bytes").and_then([&](const Written& written) {
        return whole(written, text, "a size in bytes", Fraction::Round);
    });
}

Result<double> parse_duration(std::string_view text) {
    return read(text, kTimes, "a duration").and_then([&](const Written& written) -> Result<double> {
        if (written.value < 0) return fail(fmt::format("'{}' is negative, but a duration cannot be", text));
        return written.value * written.factor;
    });
}

std::string format_bytes(std::uint64_t bytes) {
    static constexpr std::string_view units[] = {"B", "KiB", "MiB", "GiB", "TiB", "PiB", "EiB"};
    return in_units(static_cast<double>(bytes), kKibi, units);
}

std::string format_count(double count) {
    static constexpr std::string_view units[] = {"", "k", "M", "G", "T", "P"};
    // Beyond the units, and infinity.
    return count < 1e18 ? in_units(count, 1000, units) : fmt::format("{:.3g}", count);
}

std::string grouped(std::uint64_t n) {
    std::string text = std::to_string(n);
    for (std::ptrdiff_t i = static_cast<std::ptrdiff_t>(text.size()) - 3; i > 0; i -= 3) text.insert(static_cast<std::size_t>(i), ",");
    return text;
}

std::string format_duration(double seconds) {
    if (!std::isfinite(seconds) || seconds < 0) return "?";
    if (seconds < 59.95) {
        static constexpr std::string_view units[] = {"ns", "us", "ms"};
        return seconds < 0.9995 ? in_units(seconds * 1e9, 1000, units) : short_number(seconds) + " s";
    }
    const auto total = seconds < 9e18 ? static_cast<std::uint64_t>(std::llround(seconds)) : std::numeric_limits<std::uint64_t>::max();
    const std::uint64_t minutes = total / 60;
    if (minutes < 60) return fmt::format("{} min {:02} s", minutes, total % 60);
    if (minutes < 24 * 60) return fmt::format("{} h {:02} min", minutes / 60, minutes % 60);
    return fmt::format("{} d {:02} h", minutes / (24 * 60), minutes / 60 % 24);
}

}  // namespace meld
