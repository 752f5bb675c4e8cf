#include "runtime/base/csv_row.h"

#include <fmt/format.h>

#include <algorithm>

namespace meld {
namespace {

constexpr std::string_view kBlanks = " \t\r";

}  // namespace

std::string_view trimmed(std::string_view text) {
    const std::size_t first = text.find_first_not_of(kBlanks);
    return first == std::string_view::npos ? text.substr(0, 0) : text.substr(first, text.find_last_not_of(kBlanks) - first + 1);
}

std::string_view without_byte_order_mark(std::string_view text) {
    constexpr std::string_view kMark = "\xEF\xBB\xBF";
    return text.starts_with(kMark) ? text.substr(kMark.size()) : text;
}

std::string csv_field(std::string_view text) {
    // Lines that begin with # or % are remarks in some files.
    const bool plain = text.find_first_of(",\"\r\n") == std::string_view::npos && trimmed(text) == text && !text.starts_with('#') &&
                       !text.starts_with('%');
    if (plain) return std::string(text);
    std::string out = "\"";
    for (const char c : text) {
        if (c == '"') out += '"';
        out += c;
    }
    return out + '"';
}

char CsvRow::separator_of(std::string_view line) {
    for (const char separator : {',', ';', '\t'}) {
        bool inside = false;
        for (const char c : line) {
            if (c == '"') inside = !inside;
            if (c == separator && !inside) return separator;
        }
    }
    return ' ';
}

Result<std::span<const std::string_view>> CsvRow::split(std::string_view line, std::string_view path, std::size_t number) {
    fields_.clear(), columns_.clear(), unquoted_.clear();
    if (auto done = read(line); !done)
        return fail(fmt::format("{}:{}:{}: {}", path, number, done.error().at + 1, done.error().problem), std::move(done.error().cure));
    return std::span<const std::string_view>(fields_);
}

tl::expected<void, CsvRow::Mistake> CsvRow::read(std::string_view line) {
    while (line.ends_with('\r')) line.remove_suffix(1);
    for (std::size_t at = 0; at <= line.size();) {
        // A tab may be what separates.
        const std::size_t begin = std::min(line.find_first_not_of(separator_ == '\t' ? " " : " \t", at), line.size());
        if (separator_ == ' ' && begin == line.size()) break;
        const auto next = begin < line.size() && line[begin] == '"' ? quoted(line, begin) : plain(line, separator_ == ' ' ? begin : at);
        if (!next) return tl::unexpected(next.error());
        at = *next;
    }
    return {};
}

tl::expected<std::size_t, CsvRow::Mistake> CsvRow::quoted(std::string_view line, std::size_t begin) {
    std::size_t close = line.find('"', begin + 1);
    bool quotes_inside = false;
    while (close != std::string_view::npos && line.substr(close + 1).starts_with('"')) {
        quotes_inside = true;
        close = line.find('"', close + 2);
    }
    if (close == std::string_view::npos)
        return tl::unexpected(
            Mistake{begin, "this quote is not closed",
                    "end the field with a quote on the same line, and write a quote inside it twice: \"say \"\"hi\"\"\""});
    const std::string_view inside = line.substr(begin + 1, close - begin - 1);
    const std::size_t after = std::min(line.find_first_not_of(separator_ == '\t' ? " " : " \t", close + 1), line.size());
    const bool ended = after == line.size() || (separator_ == ' ' ? after > close + 1 : line[after] == separator_);
    if (!ended)
        return tl::unexpected(
            Mistake{after, "text follows the quote that ends a field", "write a quote inside a quoted field twice: \"say \"\"hi\"\"\""});
    fields_.push_back(inside);
    columns_.push_back(begin + 2);
    if (quotes_inside) {
        std::string& text = unquoted_.emplace_back();
        for (std::size_t i = 0; i < inside.size(); ++i) {
            text += inside[i];
            if (inside[i] == '"') ++i;
        }
        fields_.back() = text;
    }
    return separator_ == ' ' ? after : after + 1;
}

tl::expected<std::size_t, CsvRow::Mistake> CsvRow::plain(std::string_view line, std::size_t begin) {
    const std::size_t end = std::min(separator_ == ' ' ? line.find_first_of(" \t", begin) : line.find(separator_, begin), line.size());
    const std::string_view text = line.substr(begin, end - begin), field = trimmed(text);
    if (const std::size_t quote = text.find('"'); quote != std::string_view::npos)
        return tl::unexpected(Mistake{begin + quote, "a quote inside a field that does not begin with one",
                                      "put the whole field in quotes, and write a quote inside it twice: \"say \"\"hi\"\"\""});
    fields_.push_back(field);
    columns_.push_back(field.empty() ? begin + 1 : static_cast<std::size_t>(field.data() - line.data()) + 1);
    return end + 1;
}

}  // namespace meld
