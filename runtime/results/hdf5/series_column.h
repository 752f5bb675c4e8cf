// An array of a recording with a row for each catom. What a step adds to it begins on a chunk boundary, so that writing it never touches
// what an earlier one has written. Private to runtime/results.
#pragma once

#include <xxhash.h>

#include <cstdint>
#include <optional>

#include "runtime/results/hdf5/hdf5_file.h"
#include "runtime/results/hdf5/step_table.h"

namespace meld::record {

// Of rows that are in the file.
XXH128_hash_t hash_of_rows(Hdf5File& file, ColumnIndex column, std::uint64_t first_row, std::uint64_t rows);

// The content of the column in the last step, and its offset: the same content is not written again.
struct SeriesColumn {
    ColumnIndex values = 0;
    std::optional<StepColumn> offsets;  // In Steps/PointDataOffsets; points have theirs in Steps itself.
    std::uint64_t last_offset = 0;
    std::uint64_t last_rows = 0;
    XXH128_hash_t last_hash = {};
    bool written = false;
    // Unused rows, for steps without this array.
    std::uint64_t blank_offset = 0;
    std::uint64_t blank_rows = 0;

    void write(Hdf5File& file, std::uint64_t rows, const void* data);
    // The rows are those of the last step.
    void keep(std::uint64_t rows) const;
    void leave_blank(Hdf5File& file, std::uint64_t rows);
    // Whether the file has the rows that were written last.
    bool matches(Hdf5File& file) const;
};

}  // namespace meld::record
