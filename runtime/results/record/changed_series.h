// What a step changes of a series. Private to runtime/results/record.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "runtime/results/hdf5/series_column.h"

namespace meld::record {

// A step that changes more than one row of so many of a series is whole.
inline constexpr std::uint64_t kFewChanges = 4;

struct ChangedSeries {
    SeriesColumn* column = nullptr;
    std::vector<std::uint64_t> rows = {};
    std::vector<std::byte> values = {};  // Of these rows.
};

}  // namespace meld::record
