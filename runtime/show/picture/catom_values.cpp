#include "runtime/show/picture/catom_values.h"

#include <algorithm>

namespace meld::picture {

std::optional<CatomValues> catom_values(std::span<const inspect::Table::Column> columns) {
    using Kind = check::Type::Kind;
    const auto catom = std::ranges::find(columns, Kind::Node, [](const inspect::Table::Column& column) { return column.type.kind; });
    if (catom == columns.end()) return std::nullopt;
    CatomValues out{.catom = static_cast<std::size_t>(catom - columns.begin())};
    if (columns.size() == 1) return out;
    out.value = out.catom + 1 == columns.size() ? columns.size() - 2 : columns.size() - 1;
    const Kind kind = columns[*out.value].type.kind;
    out.kind = kind == Kind::Int ? CatomValues::Kind::Whole : kind == Kind::Float ? CatomValues::Kind::Real : CatomValues::Kind::Text;
    return out;
}

}  // namespace meld::picture
