#include "runtime/results/profile/table.h"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "runtime/base/assert.h"

namespace meld::profile {

void Table::add(std::vector<std::string> cells) {
    MELD_CHECK(cells.size() == rows_[0].size(), "{} cells in {} columns", cells.size(), rows_[0].size());
    rows_.push_back(std::move(cells));
}

std::string Table::text() const {
    std::vector<std::size_t> widths(rows_[0].size(), 0);
    for (const auto& row : rows_) {
        for (std::size_t i = 0; i < row.size(); ++i) widths[i] = std::max(widths[i], row[i].size());
    }
    std::string text;
    for (const auto& row : rows_) {
        for (std::size_t i = 0; i + 1 < row.size(); ++i) text += fmt::format("  {:>{}}", row[i], widths[i]);
        text += fmt::format("  {}\n", row.back());
    }
    return text;
}

}  // namespace meld::profile
