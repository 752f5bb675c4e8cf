// An array of a recording with a row for each catom. What a step adds to it begins on a chunk boundary, so that writing it never touches
// what an earlier one has written. Private to runtime/results.
#pragma once

#include <xxhash.h>

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "runtime/results/hdf5/hdf5_file.h"
#include "runtime/results/hdf5/step_tables.h"

namespace meld::record {

// Of rows that are in the file.
XXH128_hash_t hash_of_rows(Hdf5File& file, ColumnIndex column, std::uint64_t first_row, std::uint64_t rows);

inline constexpr std::uint64_t kChangesPerChunk = 4096;

// What has changed in a column since it was last written as a whole: numbers of rows within a step, and what is in them now; of one row
// the last counts.
struct SeriesChanges {
    ColumnIndex rows = 0, values = 0;
    StepColumn range = 0;
    std::uint64_t begin = 0, end = 0;
    std::uint64_t hash = 0;
};

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
    std::optional<SeriesChanges> changes;

    // From now on the column can be changed in some of its rows; `place` is the group for these, and `range` the column of the steps.
    void follow_changes(Hdf5File& file, StepTables& steps, const std::string& place, const std::string& range);
    bool has_changes() const { return changes && changes->end > changes->begin; }
    // Whether so many more changes would take more than writing the column as a whole.
    bool too_many_changes(const Hdf5File& file, std::uint64_t more) const;
    // The values are those of these rows, one after the other.
    void change(Hdf5File& file, std::span<const std::uint64_t> rows, const void* values);
    // The rows in which the data differ from those that were written last, or none if these are more than `most`. Reads them.
    std::optional<std::vector<std::uint64_t>> differences(Hdf5File& file, const void* data, std::uint64_t most) const;

    void write(Hdf5File& file, std::uint64_t rows, const void* data);
    // The rows are those of the last step.
    void keep(std::uint64_t rows) const;
    void leave_blank(Hdf5File& file, std::uint64_t rows);
    // Whether the file has the rows that were written last.
    bool matches(Hdf5File& file) const;
};

}  // namespace meld::record
