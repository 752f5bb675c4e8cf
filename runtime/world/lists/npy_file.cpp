// The header of an .npy file is a Python dictionary: {'descr': '<f8', 'fortran_order': False, 'shape': (4, 3), }.
#include "runtime/world/lists/npy_file.h"

#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <charconv>
#include <cstdint>
#include <cstring>
#include <optional>
#include <tuple>
#include <utility>

#include "runtime/world/lists/table_lines.h"

namespace meld::world {
namespace {

constexpr std::string_view kCure = "save it with numpy.save(file, array), where array.shape is (catoms, 3)";

std::size_t little_endian(std::string_view bytes) {
    std::size_t value = 0;
    for (std::size_t i = bytes.size(); i-- > 0;) value = value << 8 | static_cast<unsigned char>(bytes[i]);
    return value;
}

// What stands behind a key of the dictionary; empty if it is missing.
std::string_view value_of(std::string_view header, std::string_view key) {
    for (const char quote : {'\'', '"'}) {
        const std::string quoted = quote + std::string(key) + quote;
        const std::size_t at = header.find(quoted);
        if (at == std::string_view::npos) continue;
        const std::string_view rest = trimmed(header.substr(at + quoted.size()));
        if (rest.starts_with(':')) return trimmed(rest.substr(1));
    }
    return {};
}

// "(4, 3)" or "(4,)".
std::optional<std::pair<std::size_t, std::size_t>> table_shape(std::string_view text) {
    if (!text.starts_with('(')) return std::nullopt;
    text = text.substr(1, text.find(')') - 1);
    std::size_t sides[2] = {};
    for (std::size_t& side : sides) {
        text = trimmed(text);
        const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), side);
        if (error != std::errc()) return std::nullopt;
        text = trimmed(text.substr(static_cast<std::size_t>(end - text.data())));
        if (text.starts_with(',')) text.remove_prefix(1);
    }
    if (!trimmed(text).empty()) return std::nullopt;
    return std::pair(sides[0], sides[1]);
}

}  // namespace

Result<void> NpyTable::check_text(std::string_view bytes, std::string_view path) {
    if (bytes.starts_with("PK\x03\x04"))
        return fail(fmt::format("{} is an archive of files", path), fmt::format("{}, not numpy.savez", kCure));
    if (!path.ends_with(".npy")) return {};
    return fail(fmt::format("{} has the name of a NumPy file, and is none", path), fmt::format("Call a table of text .csv, or {}", kCure));
}

Result<NpyTable> NpyTable::read(std::string_view bytes, const std::string& path) {
    const auto wrong = [&path](std::string_view why) { return fail(fmt::format("{} {}", path, why), std::string(kCure)); };
    if (!is_one(bytes)) return wrong("is not a NumPy file");
    const int version = bytes.size() > 6 ? bytes[6] : 0;
    if (version < 1 || version > 3) return wrong(fmt::format("has version {} of the NumPy format, known are 1 to 3", version));
    const std::size_t length_bytes = version == 1 ? 2 : 4;
    if (bytes.size() < 8 + length_bytes) return wrong("ends too early");
    const std::size_t header_bytes = little_endian(bytes.substr(8, length_bytes));
    if (bytes.size() - 8 - length_bytes < header_bytes) return wrong("ends too early");
    const std::string_view header = bytes.substr(8 + length_bytes, header_bytes);

    NpyTable table;
    table.data_ = bytes.substr(8 + length_bytes + header_bytes);
    const std::string_view type = value_of(header, "descr");
    const bool plain = type.size() >= 5 && (type[0] == '\'' || type[0] == '"') && type[4] == type[0];
    if (!plain) return wrong("does not hold plain numbers");
    table.big_endian_ = type[1] == '>';
    table.kind_ = type[2];
    table.item_bytes_ = static_cast<std::size_t>(type[3] - '0');
    const bool size_fits = std::has_single_bit(table.item_bytes_) && table.item_bytes_ <= 8;
    const bool whole = table.kind_ == 'i' || table.kind_ == 'u';
    if (!(size_fits && (whole || (table.kind_ == 'f' && table.item_bytes_ >= 4))))
        return wrong(fmt::format("holds numbers of type {}, known are i1 to i8, u1 to u8, f4 and f8", type.substr(1, 3)));
    table.by_columns_ = value_of(header, "fortran_order").starts_with("True");
    const auto shape = table_shape(value_of(header, "shape"));
    if (!shape) return wrong("is not a table of rows and columns");
    std::tie(table.rows_, table.columns_) = *shape;
    const std::size_t items = table.data_.size() / table.item_bytes_;
    if (table.columns_ == 0 || table.columns_ > 16) return wrong(fmt::format("has {} columns", table.columns_));
    if (table.rows_ > items / table.columns_) return wrong("ends too early");
    return table;
}

double NpyTable::at(std::size_t row, std::size_t column) const {
    const std::size_t item = by_columns_ ? column * rows_ + row : row * columns_ + column;
    unsigned char raw[8] = {};
    std::memcpy(raw, data_.data() + item * item_bytes_, item_bytes_);
    if (big_endian_) std::reverse(raw, raw + item_bytes_);
    std::uint64_t bits = 0;
    for (std::size_t i = item_bytes_; i-- > 0;) bits = bits << 8 | raw[i];
    if (kind_ == 'f') return item_bytes_ == 8 ? std::bit_cast<double>(bits) : std::bit_cast<float>(static_cast<std::uint32_t>(bits));
    if (kind_ == 'u') return static_cast<double>(bits);
    const int unused = 64 - 8 * static_cast<int>(item_bytes_);
    return static_cast<double>(static_cast<std::int64_t>(bits << unused) >> unused);
}

}  // namespace meld::world
