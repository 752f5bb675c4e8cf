// A recording that is being written. Private to runtime/results/record.
//
// A step is a row of offsets into columns that only grow; these rows are in runtime/results/hdf5/step_tables.h. Points, vertices and lines
// are counted by part (runtime/results/record/part_table.h). Of a large ensemble, a step in which little is new holds only what has changed
// since the step before (runtime/results/record/changed_series.h).
#pragma once

#include <cstdint>
#include <deque>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "runtime/results/hdf5/hdf5_file.h"
#include "runtime/results/hdf5/series_column.h"
#include "runtime/results/hdf5/step_tables.h"
#include "runtime/results/hdf5/text_table.h"
#include "runtime/results/record/changed_series.h"
#include "runtime/results/record/fact_series.h"
#include "runtime/results/record/part_table.h"
#include "runtime/results/record/recording.h"
#include "runtime/results/record/xdmf.h"

namespace meld::record {

// How the values of an array stand in the file.
ElementType element_type(RecordedArray::Type type);

// What the attribute of this name in /meld says of a run: recordings of different runs differ in it.
inline constexpr const char* kRunAttribute = "run";
std::int64_t run_hash(const RecordingInfo& info);

struct Recording::State {
    std::string path;
    std::string place;  // The path of the file while it grows.
    // In this order, so that the library closes its file before the place is released.
    std::optional<OutputFile> output;
    std::unique_ptr<Hdf5File> hdf5;
    std::optional<OutputFile> sidecar, line_sidecar;  // Written at the end.
    std::optional<Error> failure;
    bool all_whole = false;   // No step holds changes alone.
    bool lacks_step = false;  // A step for which there was no space.
    bool to_be_cut = false;   // It has gone on from an earlier state, and what comes after that is still there.

    std::optional<StepTables> steps;
    std::uint64_t most_rows = 0;
    StepColumn values = 0, part_offsets = 0, number_of_parts = 0, point_offsets = 0, cell_offsets = 0, connectivity_offsets = 0;
    StepColumn digest_low = 0, digest_high = 0;
    std::optional<PartTable> parts;
    std::optional<SeriesColumn> points;
    std::map<std::string, SeriesColumn> arrays;
    std::map<std::string, TextTable> texts;

    std::map<std::string, FactSeries> tables;

    void make_layout(const RecordingInfo& info);
    void follow_changes();
    void make_point_columns(std::uint64_t rows);
    SeriesColumn make_array(const std::string& name, ElementType type, int components, std::uint64_t rows);
    void write_points(std::span<const RecordedPosition> positions);
    void write_array(const RecordedArray& array, std::uint64_t rows);
    void write_whole(std::span<const RecordedPosition> positions, std::span<const RecordedArray> given, const RecordedSame& same);
    void write_row_of_step(double time, const Part& part, const Digest& state);
    void write_array_offsets(std::span<const RecordedArray> given, std::uint64_t rows);
    void write_table(const RecordedTable& table);
    // What a step changes of each of its series, if it is to hold changes alone. Arrays of texts may have become arrays of their numbers.
    std::optional<std::vector<ChangedSeries>> find_changes(std::span<const RecordedPosition> positions, std::vector<RecordedArray>& given,
                                                           const RecordedSame& same, std::deque<std::vector<std::int64_t>>& numbers);
    std::optional<ChangedSeries> find_changes(RecordedArray& array, std::uint64_t rows, std::deque<std::vector<std::int64_t>>& numbers);
    std::optional<ChangedSeries> find_moved(std::span<const RecordedPosition> positions, const RecordedSame& same);
    void write_ranges(std::span<const RecordedArray> given);
    void each_step(const std::function<void(const XdmfStep&)>& visit) const;
    Result<void> write_sidecars();

    // Arrays of texts become arrays of their numbers, which stand in `numbers`.
    void number_texts(RecordedArray& array, std::uint64_t rows, std::deque<std::vector<std::int64_t>>& numbers);
    TextTable& texts_of(const RecordedArray& array) { return texts[array.texts.empty() ? array.name : array.texts]; }
    void write_texts();
    std::optional<std::string> reserve(std::uint64_t bytes);
    std::uint64_t most_growth(std::uint64_t rows, std::span<const RecordedArray> given, std::span<const RecordedTable> given_tables) const;
    Result<void> open_sidecars(const RecordingInfo& info);
    // Of a recording that goes on: what was saved of it, whether the file has it, and nothing else.
    void load(ByteReader& saved);
    bool matches();
    Result<void> cut();
    Result<void> appear();
    tl::unexpected<Error> cannot_write(const std::string& why) const;
};

}  // namespace meld::record
