#include "runtime/results/record/fact_series.h"

#include <algorithm>

#include "runtime/base/assert.h"
#include "runtime/results/hdf5/series_column.h"
#include "runtime/results/record/recording_state.h"

namespace meld::record {

namespace {

// What HDF5 may need to find a column's chunks, in a step.
constexpr std::uint64_t kIndexBytes = 32 << 10;
constexpr std::uint64_t kIndexBytesARow = 1;

std::uint64_t row_bytes(const RecordedArray& column) { return static_cast<std::uint64_t>(column.components) * sizeof(std::uint64_t); }

// Where a table is in the file, and its columns of the steps.
struct TablePlace {
    std::string group, offsets, counts;
};
TablePlace place_of(const RecordedTable& table) {
    if (table.kind == RecordedTable::Kind::Joints) return {kJoints, kJointOffsets, kJointCount};
    return {"/meld/facts/" + table.name, "FactOffsets/" + table.name, "FactCounts/" + table.name};
}

}  // namespace

FactSeries::FactSeries(Hdf5File& file, StepTables& steps, const RecordedTable& table, std::uint64_t chunk_rows) : chunk_rows_(chunk_rows) {
    MELD_CHECK(steps.steps() == 0, "table '{}' comes late", table.name);
    const TablePlace place = place_of(table);
    file.make_group(place.group);
    steps.make_group(place.offsets);
    for (const RecordedArray& column : table.columns) {
        MELD_CHECK(column.type != RecordedArray::UInt8 && column.name.find('/') == std::string::npos, "column '{}'", column.name);
        const ColumnShape shape = {.type = element_type(column.type),
                                   .components = column.components,
                                   .chunk_rows = chunk_rows,
                                   .compressed = true,
                                   .readable_at_once = true};
        columns_.push_back({.values = file.make_column(place.group + "/" + column.name, shape),
                            .offsets = steps.add_column(place.offsets + "/" + column.name, ElementType::Int64)});
    }
    counts_ = steps.add_column(place.counts, ElementType::Int64);
}

FactSeries::FactSeries(ByteReader& saved) {
    chunk_rows_ = saved.read<std::uint64_t>();
    counts_ = saved.read<StepColumn>();
    last_rows_ = saved.read<std::uint64_t>();
    for (auto left = saved.read_count(sizeof(Column)); left > 0; --left) columns_.push_back(saved.read<Column>());
}

void FactSeries::save(ByteWriter& out) const {
    out.write(chunk_rows_);
    out.write(counts_);
    out.write(last_rows_);
    out.write_count(columns_.size());
    for (const Column& column : columns_) out.write(column);
}

bool FactSeries::matches(Hdf5File& file) const {
    return last_rows_ == 0 || std::ranges::all_of(columns_, [&](const Column& column) {
               return XXH128_isEqual(hash_of_rows(file, column.values, column.last_offset, last_rows_), column.last_hash) != 0;
           });
}

std::uint64_t FactSeries::most_growth(const RecordedTable& table, std::uint64_t chunk_rows) {
    std::uint64_t bytes = 0;
    for (const RecordedArray& column : table.columns)
        bytes += (table.rows + chunk_rows) * (row_bytes(column) + kIndexBytesARow) + 2 * kIndexBytes;
    return bytes + kIndexBytes;
}

void FactSeries::write(Hdf5File& file, StepTables& steps, const RecordedTable& table) {
    MELD_CHECK(table.columns.size() == columns_.size(), "table '{}' changes its columns", table.name);
    for (std::size_t i = 0; i < columns_.size(); ++i) {
        Column& column = columns_[i];
        const RecordedArray& given = table.columns[i];
        MELD_CHECK(!table.same || table.rows == last_rows_, "{} rows are to be those of the last step, which has {}", table.rows,
                   last_rows_);
        if (table.same) {
            steps.set(column.offsets, static_cast<std::int64_t>(table.rows > 0 ? column.last_offset : 0));
            continue;
        }
        const XXH128_hash_t hash = XXH3_128bits(given.data, table.rows * row_bytes(given));
        if (table.rows > 0 && (table.rows != last_rows_ || !XXH128_isEqual(hash, column.last_hash))) {
            column.last_offset = (file.rows(column.values) + chunk_rows_ - 1) / chunk_rows_ * chunk_rows_;
            file.write_rows_of_step(column.values, column.last_offset, table.rows, given.data);
        }
        column.last_hash = hash;
        steps.set(column.offsets, static_cast<std::int64_t>(table.rows > 0 ? column.last_offset : 0));
    }
    last_rows_ = table.rows;
    steps.set(counts_, static_cast<std::int64_t>(table.rows));
}

}  // namespace meld::record
