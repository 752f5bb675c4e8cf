#include "runtime/ask/query/table.h"

#include <fmt/format.h>

#include <algorithm>
#include <nlohmann/json.hpp>
#include <numeric>
#include <utility>

#include "runtime/base/assert.h"
#include "runtime/base/csv_row.h"
#include "runtime/engine/tuple/value_text.h"

namespace meld::inspect {

using Json = nlohmann::ordered_json;

namespace {

Json json_of(tuple::Type type, Value v) {
    switch (type.kind()) {
        case ValueType::Int:
            return v.integer;
        case ValueType::Float:
            return v.real;
        case ValueType::Bool:
            return v.integer != 0;
        case ValueType::Node:
            return v.catom;
        case ValueType::String:
            return std::string(tuple::bytes_of(v.list));
        default:
            break;
    }
    Json items = Json::array();
    for (std::size_t i = 0; i < tuple::length(v.list); ++i) items.push_back(json_of(type.item(i), tuple::item(v.list, i)));
    return items;
}

std::string csv_cell(tuple::Type type, Value v) {
    if (type.kind() == ValueType::Node) return std::to_string(v.catom);
    if (!type.compound()) return tuple::print_value(type, v);
    return csv_field(tuple::print_plain(type, v));
}

}  // namespace

Value Table::copied(tuple::Type type, Value v, tuple::Arena& lists) const {
    if (!type.compound()) return v;
    ByteWriter packed;
    tuple::pack(type, v, packed);
    ByteReader in(packed.view(), "an answer");
    return tuple::unpack(type, in, lists);
}

void Table::add(const std::vector<Value>& row) {
    MELD_EXPECT(row.size() == columns_.size(), "{} values for {} columns", row.size(), columns_.size());
    for (std::size_t i = 0; i < row.size(); ++i) {
        const tuple::Type t = type(i);
        values_.push_back(copied(t, tuple::normal(t.kind(), row[i]), lists_));
    }
    if (++rows_ < next_finish_) return;
    finish();
    next_finish_ = std::max(kLeastFinished, 2 * rows_);
}

void Table::finish() {
    const std::size_t width = columns_.size();
    if (width == 0) {
        rows_ = std::min<std::uint64_t>(rows_, 1);
        return;
    }
    std::vector<tuple::Type> types;
    for (std::size_t i = 0; i < width; ++i) types.push_back(type(i));
    const auto compared = [&](std::size_t a, std::size_t b) {
        for (std::size_t i = 0; i < width; ++i)
            if (const int c = tuple::compare(types[i], cell(a, i), cell(b, i))) return c;
        return 0;
    };
    std::vector<std::size_t> order(rows_);
    std::iota(order.begin(), order.end(), std::size_t{0});
    const auto less = [&](std::size_t a, std::size_t b) { return compared(a, b) < 0; };
    if (!std::ranges::is_sorted(order, less)) std::ranges::sort(order, less);
    const auto again = std::ranges::unique(order, [&](std::size_t a, std::size_t b) { return compared(a, b) == 0; });
    order.erase(again.begin(), again.end());
    std::vector<Value> kept;
    kept.reserve(order.size() * width);
    // Lists of rows that are dropped end with the arena in which they are.
    const bool fewer = order.size() < rows_;
    tuple::Arena lists;
    for (const std::size_t row : order)
        for (std::size_t i = 0; i < width; ++i) kept.push_back(fewer ? copied(types[i], cell(row, i), lists) : cell(row, i));
    values_ = std::move(kept);
    if (fewer) lists_ = std::move(lists);
    rows_ = order.size();
}

std::string Table::text(std::size_t row, std::size_t column) const { return tuple::print_value(type(column), cell(row, column)); }

std::string Table::plain(std::size_t row, std::size_t column) const {
    const tuple::Type t = type(column);
    return t.kind() == ValueType::String ? tuple::print_plain(t, cell(row, column)) : text(row, column);
}

std::string Table::to_text(std::uint64_t most_rows) const {
    if (columns_.empty()) return rows_ > 0 ? "yes\n" : "no\n";
    if (rows_ == 0) return "no rows\n";
    const std::size_t shown = std::min(rows_, most_rows), last = columns_.size() - 1;
    // The last column may be as wide as it is.
    std::vector<std::size_t> widths(last);
    for (std::size_t i = 0; i < last; ++i) {
        widths[i] = columns_[i].name.size();
        for (std::size_t row = 0; row < shown; ++row) widths[i] = std::max(widths[i], text(row, i).size());
    }
    std::string out;
    for (std::size_t i = 0; i < last; ++i) out += fmt::format("{:<{}}  ", columns_[i].name, widths[i]);
    out += columns_[last].name + "\n";
    for (std::size_t row = 0; row < shown; ++row) {
        for (std::size_t i = 0; i < last; ++i) out += fmt::format("{:<{}}  ", text(row, i), widths[i]);
        out += text(row, last) + "\n";
    }
    if (shown < rows_) out += fmt::format("... and {} more\n", rows_ - shown);
    return out + fmt::format("{} row{}\n", rows_, rows_ == 1 ? "" : "s");
}

std::string Table::to_csv(std::uint64_t most_rows) const {
    std::string out;
    for (std::size_t i = 0; i < columns_.size(); ++i) out += (i == 0 ? "" : ",") + columns_[i].name;
    if (!columns_.empty()) out += "\n";
    for (std::size_t row = 0; row < std::min(rows_, most_rows); ++row) {
        for (std::size_t i = 0; i < columns_.size(); ++i) out += (i == 0 ? "" : ",") + csv_cell(type(i), cell(row, i));
        if (!columns_.empty()) out += "\n";
    }
    return out;
}

Json Table::columns_json() const {
    Json out = Json::array();
    for (const Column& column : columns_) out.push_back({{"name", column.name}, {"type", check::type_name(column.type)}});
    return out;
}

Json Table::rows_json(std::uint64_t most_rows) const {
    Json out = Json::array();
    for (std::size_t row = 0; row < std::min(rows_, most_rows); ++row) {
        Json line = Json::array();
        for (std::size_t i = 0; i < columns_.size(); ++i) line.push_back(json_of(type(i), cell(row, i)));
        out.push_back(std::move(line));
    }
    return out;
}

}  // namespace meld::inspect
