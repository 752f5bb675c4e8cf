// A table of facts, or of joints, of a recording, in which those of a step are rows of their own. Private to runtime/results/record.
#pragma once

#include <xxhash.h>

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "runtime/results/hdf5/hdf5_file.h"
#include "runtime/results/hdf5/step_tables.h"
#include "runtime/results/record/recording.h"

namespace meld::record {

// In the file: /meld/facts/NAME, a group of one array for each column. In the step table, FactCounts/NAME is how many rows a step has, and
// FactOffsets/NAME/COLUMN where they begin in a column, on a chunk boundary. A column that is as in the last step is not written again.
// Those of joints are /meld/joints, JointCount and JointOffsets/COLUMN.
class FactSeries {
  public:
    // Before the first step. Columns of texts hold numbers.
    FactSeries(Hdf5File& file, StepTables& steps, const RecordedTable& table, std::uint64_t chunk_rows);

    // Of a file that is opened again, in the state that save() wrote.
    explicit FactSeries(ByteReader& saved);
    void save(ByteWriter& out) const;
    // Whether the file has the rows of the last step.
    bool matches(Hdf5File& file) const;

    // What a step with this table can add to the file at most, as bytes, if chunks have at most so many rows.
    static std::uint64_t most_growth(const RecordedTable& table, std::uint64_t chunk_rows);
    // The rows of the step that is being made.
    void write(Hdf5File& file, StepTables& steps, const RecordedTable& table);

  private:
    struct Column {
        ColumnIndex values;
        StepColumn offsets;
        std::uint64_t last_offset = 0;
        XXH128_hash_t last_hash = {};
    };
    std::vector<Column> columns_;
    std::uint64_t chunk_rows_;
    StepColumn counts_;
    std::uint64_t last_rows_ = 0;
};

}  // namespace meld::record
