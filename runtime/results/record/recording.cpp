// The layout of a recording: https://docs.vtk.org/en/latest/vtk_file_formats/vtkhdf_file_format, "Temporal Data".
#include "runtime/results/record/recording.h"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <utility>

#include "runtime/base/assert.h"
#include "runtime/results/hdf5/disk_space.h"
#include "runtime/results/hdf5/file_kind.h"
#include "runtime/results/record/recording_state.h"

namespace meld::record {

namespace {

// A chunk holds a step of a small ensemble, or a part of a step of a large one: 64 Ki rows of 8 bytes are half a megabyte.
constexpr std::uint64_t kFewestChunkRows = 1024;
constexpr std::uint64_t kMaxChunkRows = 65536;

// The space that HDF5 itself may need in a step: for each array, the first chunk of its offsets and the tree of its chunks; and for the
// columns of the steps.
constexpr std::uint64_t kTablesBytes = 32 << 10;
constexpr std::uint64_t kTableBytesARow = 1;  // 40 bytes for a chunk, and a chunk has many rows.
constexpr std::uint64_t kReserveBytes = 512 << 10;
constexpr const char* kIds = "id";
// Two ends and their positions, if compression saves nothing.
constexpr std::uint64_t kLineBytes = 3 * sizeof(std::int64_t);

}  // namespace

ElementType element_type(RecordedArray::Type type) {
    switch (type) {
        case RecordedArray::Int64:
        case RecordedArray::Text:
            return ElementType::Int64;
        case RecordedArray::Float64:
            return ElementType::Float64;
        case RecordedArray::UInt8:
            return ElementType::UInt8;
    }
    return ElementType::Int64;
}

// With its first step the file gets its name: the library makes some tables only then, and links to them before they are written.
Result<void> Recording::State::appear() {
    output->note_written();
    if (auto readable = output->appear(); !readable) return readable;
    place = *output->place();
    return {};
}

tl::unexpected<Error> Recording::State::cannot_write(const std::string& why) const {
    std::string cure = why.find("space") == std::string::npos ? "" : "Free some space, record fewer predicates or less often";
    if (steps && steps->steps() > 0 && place != output->target())
        cure += fmt::format("{}{} is unchanged, and the {} steps so far are in {}", cure.empty() ? "" : ". ", path, steps->steps(), place);
    return fail(fmt::format("cannot write {}: {}", path, why), cure, ExitCode::LimitHit);
}

// The most by which the file can grow in a step. A chunk that does not get smaller by compression is stored as it is.
std::uint64_t Recording::State::most_growth(std::uint64_t rows, std::span<const RecordedArray> given,
                                            std::span<const RecordedTable> given_tables) const {
    const std::uint64_t partly_filled_chunk = std::clamp(std::max(rows, most_rows), kFewestChunkRows, kMaxChunkRows);
    std::uint64_t row_bytes = 3 * sizeof(float) + 2 * sizeof(std::int64_t);  // Its position, and its place in a new part.
    for (const RecordedArray& array : given)
        row_bytes += static_cast<std::uint64_t>(array.components) * size_of(element_type(array.type)) + kTableBytesARow;
    std::uint64_t text_bytes = 0;
    for (const auto& [name, table] : texts) text_bytes += table.waiting_bytes();
    std::uint64_t fact_bytes = 0;
    for (const RecordedTable& table : given_tables) fact_bytes += FactSeries::most_growth(table, partly_filled_chunk);
    const std::uint64_t whole = (rows + partly_filled_chunk) * row_bytes, series = given.size() + 1;
    const std::uint64_t changes = (rows / kFewChanges + 2 * kChangesPerChunk) * (row_bytes + series * sizeof(std::uint64_t));
    return fact_bytes + text_bytes + (steps->follows_changes() ? std::max(whole, changes) : whole) + (given.size() + 1) * kTablesBytes +
           kReserveBytes;
}

// Reserves space for a step that needs no more than this, and some for the next ones, which may need less. Returns why that failed, or
// nothing.
std::optional<std::string> Recording::State::reserve(std::uint64_t bytes) {
    const std::uint64_t ahead = hdf5->space_ahead();
    if (ahead >= bytes) return std::nullopt;
    const std::uint64_t more = bytes - ahead + std::min(bytes, kReserveBytes);
    if (auto reason = reserve_growth(place, more)) return reason;
    hdf5->extend(more);
    return std::nullopt;
}

void Recording::State::number_texts(RecordedArray& array, std::uint64_t rows, std::deque<std::vector<std::int64_t>>& numbers) {
    if (array.type != RecordedArray::Text) return;
    array.type = RecordedArray::Int64;
    const auto known = arrays.find(array.name);
    if (array.same && (known == arrays.end() || !known->second.has_changes())) return;
    numbers.push_back(texts_of(array).numbers({static_cast<const std::string*>(array.data), rows}));
    array.data = numbers.back().data();
}

void Recording::State::write_texts() {
    for (auto& [name, table] : texts) table.write(*hdf5, "/meld/texts/" + name);
}

void Recording::State::make_layout(const RecordingInfo& info) {
    hdf5->make_group("/VTKHDF");
    hdf5->set_attribute("/VTKHDF", "Version", std::array<std::int64_t, 2>{2, 0});
    hdf5->set_attribute("/VTKHDF", "Type", std::string_view("PolyData"));
    for (const char* group : {"/VTKHDF/PointData", "/meld", "/meld/texts", "/meld/facts"}) hdf5->make_group(group);
    steps.emplace(*hdf5);
    values = steps->add_column("Values", ElementType::Float64);
    part_offsets = steps->add_column("PartOffsets", ElementType::Int64);
    number_of_parts = steps->add_column("NumberOfParts", ElementType::Int64);
    point_offsets = steps->add_column("PointOffsets", ElementType::Int64);
    cell_offsets = steps->add_column("CellOffsets", ElementType::Int64, 4);
    connectivity_offsets = steps->add_column("ConnectivityIdOffsets", ElementType::Int64, 4);

    digest_low = steps->add_column("StateDigestLow", ElementType::Int64);
    digest_high = steps->add_column("StateDigestHigh", ElementType::Int64);

    parts.emplace(*hdf5);

    hdf5->set_attribute("/meld", "format", kRecordingFormat);
    hdf5->set_attribute("/meld", "version", kWholeVersion);
    hdf5->set_attribute("/meld", "seed", info.seed);
    hdf5->set_attribute("/meld", kRunAttribute, run_hash(info));
    hdf5->set_attribute("/meld", "lattice", std::string_view(info.lattice));
    hdf5->set_attribute("/meld", "radius_metres", info.radius);
    hdf5->write_text("/meld/program", info.program);
    hdf5->write_text("/meld/world", info.world);
    hdf5->write_texts("/meld/arguments", info.arguments);
    hdf5->write_text("/meld/provenance", info.provenance);
    hdf5->write_text("/meld/predicates", info.predicates);
    hdf5->write_text("/meld/made_by", info.made_by);
    hdf5->make_group("/meld/counts");
    hdf5->write_text("/meld/counts/names", fmt::format("{}", fmt::join(info.counts, ",")));
    hdf5->set_attribute("/meld/counts", kCountsKnown, std::int64_t{0});
    for (const std::string& name : info.counts) hdf5->set_attribute("/meld/counts", name, std::int64_t{0});
}

// Columns with a row for each catom are made at the first step, when the size of the ensemble determines the size of a chunk.
void Recording::State::make_point_columns(std::uint64_t rows) {
    if (rows > kMaxChunkRows && !all_whole) follow_changes();
    const std::uint64_t chunk = std::clamp(rows, kFewestChunkRows, kMaxChunkRows);
    points.emplace();
    points->values =
        hdf5->make_column("/VTKHDF/Points", {.type = ElementType::Float32, .components = 3, .chunk_rows = chunk, .compressed = true});
    if (steps->follows_changes()) points->follow_changes(*hdf5, *steps, "/meld/changes/Points", "PointChanges");
}

SeriesColumn Recording::State::make_array(const std::string& name, ElementType type, int components, std::uint64_t rows) {
    const std::uint64_t chunk = std::clamp(std::max(rows, most_rows), kFewestChunkRows, kMaxChunkRows);
    SeriesColumn column;
    column.values = hdf5->make_column(
        "/VTKHDF/PointData/" + name,
        {.type = type, .components = components, .chunk_rows = chunk, .compressed = true, .readable_at_once = steps->steps() > 0});
    // For earlier steps the array begins with rows that are never written; the offsets of those steps read as 0, which is the index of
    // these rows.
    if (steps->steps() > 0) {
        column.leave_blank(*hdf5, most_rows);
        // The tables, which readers see, name only arrays that exist.
        hdf5->flush();
    }
    column.offsets = steps->add_column("PointDataOffsets/" + name, ElementType::Int64);
    // With other catoms the step is whole.
    if (steps->follows_changes() && name != kIds)
        column.follow_changes(*hdf5, *steps, "/meld/changes/PointData/" + name, "PointDataChanges/" + name);
    return column;
}

void Recording::State::write_points(std::span<const RecordedPosition> positions) {
    if (!points) make_point_columns(positions.size());
    points->write(*hdf5, positions.size(), positions.data());
}

void Recording::State::write_array(const RecordedArray& array, std::uint64_t rows) {
    MELD_CHECK(!array.name.empty() && array.name != "." && array.name.find('/') == std::string::npos, "array '{}'", array.name);
    const ElementType type = element_type(array.type);
    auto known = arrays.find(array.name);
    if (known == arrays.end()) known = arrays.emplace(array.name, make_array(array.name, type, array.components, rows)).first;
    const ColumnShape& shape = hdf5->shape(known->second.values);
    MELD_CHECK(shape.type == type && shape.components == array.components, "array '{}' changes its type", array.name);
    if (array.same && !known->second.has_changes())
        known->second.keep(rows);
    else
        known->second.write(*hdf5, rows, array.data);
}

void Recording::State::write_whole(std::span<const RecordedPosition> positions, std::span<const RecordedArray> given,
                                   const RecordedSame& same) {
    if (same.positions && !points->has_changes())
        points->keep(positions.size());
    else
        write_points(positions);
    for (const RecordedArray& array : given) write_array(array, positions.size());
}

void Recording::State::write_row_of_step(double time, const Part& part, const Digest& state) {
    steps->set(digest_low, static_cast<std::int64_t>(state.low()));
    steps->set(digest_high, static_cast<std::int64_t>(state.high()));
    steps->set(values, time);
    steps->set(part_offsets, part.index);
    steps->set(number_of_parts, std::int64_t{1});
    steps->set(point_offsets, static_cast<std::int64_t>(points->last_offset));
    steps->set(cell_offsets, part.cell_offsets);
    steps->set(connectivity_offsets, part.connectivity_offsets);
}

// Every array gets an offset in every step, also those that this step lacks.
void Recording::State::write_array_offsets(std::span<const RecordedArray> given, std::uint64_t rows) {
    for (auto& [name, column] : arrays) {
        const bool is_given = std::ranges::any_of(given, [&](const RecordedArray& array) { return array.name == name; });
        if (!is_given) column.leave_blank(*hdf5, rows);
        steps->set(*column.offsets, static_cast<std::int64_t>(is_given ? column.last_offset : column.blank_offset));
    }
}

void Recording::State::write_table(const RecordedTable& table) {
    // No predicate has this name.
    const std::string name = table.kind == RecordedTable::Kind::Joints ? kJoints : table.name;
    auto known = tables.find(name);
    if (known == tables.end())
        known = tables.emplace(name, FactSeries(*hdf5, *steps, table, std::clamp(most_rows, kFewestChunkRows, kMaxChunkRows))).first;
    known->second.write(*hdf5, *steps, table);
}

Result<void> Recording::State::open_sidecars(const RecordingInfo& info) {
    for (const bool lines : {false, true}) {
        if (lines && !info.lines) continue;
        auto opened = OutputFile::open(path + (lines ? kLinesSidecar : kSidecar), Appears::Whole, info.durability);
        if (!opened) return tl::unexpected(opened.error());
        (lines ? line_sidecar : sidecar).emplace(std::move(*opened));
    }
    return {};
}

Recording::Recording(std::unique_ptr<State> state) : state_(std::move(state)) {}
Recording::Recording(Recording&&) noexcept = default;
Recording& Recording::operator=(Recording&&) noexcept = default;
Recording::~Recording() = default;

Result<Recording> Recording::create(const std::string& path, const RecordingInfo& info) {
    auto state = std::make_unique<State>();
    state->path = path;
    state->all_whole = info.all_whole;
    for (const std::string& file : {path, path + kSidecar, path + kLinesSidecar})
        if (OutputFile::names_stream(file))
            return fail(fmt::format("cannot write {}: a recording is no stream, and this is no regular file", file), "Choose another path");
    auto output = OutputFile::open(path, Appears::OnceReadable, info.durability);
    if (!output) return tl::unexpected(output.error());
    auto place = output->place();
    if (!place) return tl::unexpected(place.error());
    state->output.emplace(std::move(*output));
    state->place = *place;
    state->hdf5 = std::make_unique<Hdf5File>(state->place, info.durability);
    if (const auto reason = state->reserve(kReserveBytes)) return state->cannot_write(*reason);
    state->make_layout(info);
    state->hdf5->flush();
    if (state->hdf5->failed()) return state->cannot_write(state->hdf5->failure());
    if (const auto sidecars = state->open_sidecars(info); !sidecars) return tl::unexpected(sidecars.error());
    return Recording(std::move(state));
}

Result<void> Recording::step(double time, std::span<const RecordedPosition> positions, std::span<const std::uint64_t> ids,
                             std::span<const RecordedArray> arrays, std::span<const RecordedLine> lines,
                             std::span<const RecordedTable> tables, const Digest& digest, const RecordedSame& same) {
    MELD_CHECK(positions.size() == ids.size(), "{} positions of {} catoms", positions.size(), ids.size());
    MELD_EXPECT(std::ranges::is_sorted(ids));
    State& state = *state_;
    if (state.failure) return tl::unexpected(*state.failure);
    if (const Result<void> cut = state.cut(); !cut) return cut;
    const std::uint64_t rows = ids.size();
    // Ids are below 2^63, and readers accept only signed ids.
    std::vector<RecordedArray> all = {{.name = kIds, .type = RecordedArray::Int64, .data = ids.data(), .components = 1, .same = same.ids}};
    all.insert(all.end(), arrays.begin(), arrays.end());
    std::vector<RecordedTable> all_tables(tables.begin(), tables.end());
    std::deque<std::vector<std::int64_t>> numbers;
    const std::optional<std::vector<ChangedSeries>> changed = state.find_changes(positions, all, same, numbers);
    for (RecordedArray& array : all) state.number_texts(array, rows, numbers);
    for (RecordedTable& table : all_tables)
        for (RecordedArray& column : table.columns) column.same = table.same;
    for (RecordedTable& table : all_tables)
        for (RecordedArray& column : table.columns) state.number_texts(column, table.rows, numbers);
    // HDF5 that meets a full disk in the middle of a step leaves a broken file: it must not.
    if (const auto reason = state.reserve(state.most_growth(rows, all, all_tables) + lines.size() * kLineBytes)) {
        for (auto& [name, table] : state.texts) table.forget();
        state.lacks_step = true;
        return state.cannot_write(*reason);
    }

    state.most_rows = std::max(state.most_rows, rows);
    state.write_texts();
    if (changed)
        for (const ChangedSeries& series : *changed) series.column->change(*state.hdf5, series.rows, series.values.data());
    else
        state.write_whole(positions, all, same);
    for (const RecordedTable& table : all_tables) state.write_table(table);
    state.write_row_of_step(time, state.parts->part_with(rows, lines), digest);
    state.write_array_offsets(all, rows);
    if (changed) {
        state.write_ranges(all);
        state.steps->commit_changes();
    } else {
        state.steps->commit_whole();
    }
    if (state.hdf5->failed()) {
        state.failure = state.cannot_write(state.hdf5->failure()).value();
        return tl::unexpected(*state.failure);
    }
    const Result<void> readable = state.appear();
    if (!readable) state.failure = readable.error();
    return readable;
}

void Recording::count(const RunCounts& counts) {
    State& state = *state_;
    // One that an earlier version has begun has no place for them.
    if (state.failure || !state.hdf5->attribute("/meld/counts", kCountsKnown)) return;
    for (const auto& [name, value] : counts)
        if (state.hdf5->attribute("/meld/counts", name)) state.hdf5->change_attribute("/meld/counts", name, value);
    state.hdf5->change_attribute("/meld/counts", kCountsKnown, 1);
}

Result<void> Recording::close() {
    State& state = *state_;
    if (state.failure) return tl::unexpected(*state.failure);
    if (const Result<void> cut = state.cut(); !cut) return cut;
    const Result<void> listed = state.lacks_step ? Result<void>{} : state.write_sidecars();
    state.hdf5->close();
    if (state.hdf5->failed()) {
        state.failure = state.cannot_write(state.hdf5->failure()).value();
        return tl::unexpected(*state.failure);
    }
    Result<void> done;
    if (!state.lacks_step) {
        done = state.output->commit();
        if (done) done = listed;
        if (done) done = state.sidecar->commit();
        if (done && state.line_sidecar) done = state.line_sidecar->commit();
        std::error_code none;
        if (done && !state.line_sidecar) std::filesystem::remove(state.path + kLinesSidecar, none);
    }
    state.failure = Error{"The recording is closed"};
    return done;
}

}  // namespace meld::record
