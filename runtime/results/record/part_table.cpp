#include "runtime/results/record/part_table.h"

#include <fmt/format.h>

#include <algorithm>
#include <numeric>
#include <string>

namespace meld::record {

namespace {

// The order in which the format lists the kinds of cells; catoms are vertices, and the last two stay empty.
constexpr std::array<const char*, 4> kCellKinds = {"Vertices", "Lines", "Polygons", "Strips"};
constexpr std::uint64_t kPartsPerChunk = 1024;
// Of vertices: those of a large ensemble are packed as its other arrays are.
constexpr std::uint64_t kFewestVertexRows = 4096, kMostVertexRows = 65536;

}  // namespace

PartTable::PartTable(Hdf5File& file) : file_(file) {
    const ColumnShape one_a_part = {.type = ElementType::Int64, .components = 1, .chunk_rows = kPartsPerChunk};
    columns_.number_of_points = file_.make_column("/VTKHDF/NumberOfPoints", one_a_part);
    for (std::size_t kind = 0; kind < kCellKinds.size(); ++kind) {
        const std::string group = fmt::format("/VTKHDF/{}", kCellKinds[kind]);
        file_.make_group(group);
        columns_.number_of_cells[kind] = file_.make_column(group + "/NumberOfCells", one_a_part);
        columns_.number_of_connectivity_ids[kind] = file_.make_column(group + "/NumberOfConnectivityIds", one_a_part);
        if (kind > 0) make_ids(kind, kFewestVertexRows);
    }
}

void PartTable::make_ids(std::size_t kind, std::uint64_t chunk_rows) {
    const std::string group = fmt::format("/VTKHDF/{}", kCellKinds[kind]);
    const ColumnShape ids = {.type = ElementType::Int64, .components = 1, .chunk_rows = chunk_rows, .compressed = true};
    columns_.offsets[kind] = file_.make_column(group + "/Offsets", ids);
    columns_.connectivity[kind] = file_.make_column(group + "/Connectivity", ids);
}

// In the order in which they were made, so that each gets the place it has.
PartTable::PartTable(Hdf5File& file, ByteReader& saved) : file_(file) {
    columns_ = saved.read<Columns>();
    const Sizes all = sizes();
    std::int64_t next_vertex = 0, next_end = 0;
    for (std::size_t i = 0; i < all.points.size(); ++i) {
        const auto left = static_cast<std::int64_t>(file_.rows(line_ends())) - next_end;
        if (all.points[i] < 0 || all.lines[i] < 0 || all.lines[i] > left / 2) {
            file_.refuse(fmt::format("its part {} has other catoms or lines than were written", i));
            return;
        }
        const auto rows = static_cast<std::uint64_t>(all.points[i]);
        std::vector<RecordedLine> lines(static_cast<std::size_t>(all.lines[i]));
        file_.read_rows(line_ends(), static_cast<std::uint64_t>(next_end), 2 * lines.size(), lines.data());
        const auto [vertices, is_new] = connectivity_of_rows_.emplace(rows, next_vertex);
        if (is_new) next_vertex += all.points[i];
        parts_.emplace(key_of(rows, lines), Part{.index = static_cast<std::int64_t>(i),
                                                 .cell_offsets = {next_cell_offset_, next_line_offset_},
                                                 .connectivity_offsets = {vertices->second, next_end}});
        next_end += 2 * all.lines[i];
        next_cell_offset_ += std::max<std::int64_t>(all.points[i], 1);
        next_line_offset_ += all.lines[i];
    }
}

void PartTable::save(ByteWriter& out) const { out.write(columns_); }

PartTable::Sizes PartTable::sizes() const {
    const auto read = [&](ColumnIndex column) {
        std::vector<std::int64_t> numbers(file_.rows(column));
        file_.read_rows(column, 0, numbers.size(), numbers.data());
        return numbers;
    };
    return {read(columns_.number_of_points), read(columns_.number_of_cells[1])};
}

PartTable::Key PartTable::key_of(std::uint64_t rows, std::span<const RecordedLine> lines) {
    return {rows, lines.size(), XXH3_128bits(lines.data(), lines.size_bytes())};
}

const Part& PartTable::part_with(std::uint64_t rows, std::span<const RecordedLine> lines) {
    const Key key = key_of(rows, lines);
    if (const auto known = parts_.find(key); known != parts_.end()) return known->second;
    const auto index = static_cast<std::uint64_t>(parts_.size());
    Part part = {.index = static_cast<std::int64_t>(index)};
    write_vertices(rows, part);
    write_lines(lines, part);
    const auto points_here = static_cast<std::int64_t>(rows), lines_here = static_cast<std::int64_t>(lines.size());
    const std::array<std::int64_t, 4> cells = {points_here, lines_here, 0, 0}, ids = {points_here, 2 * lines_here, 0, 0};
    const std::int64_t none = 0;
    file_.write_rows(columns_.number_of_points, index, 1, &points_here);
    for (std::size_t kind = 0; kind < kCellKinds.size(); ++kind) {
        file_.write_rows(columns_.number_of_cells[kind], index, 1, &cells[kind]);
        file_.write_rows(columns_.number_of_connectivity_ids[kind], index, 1, &ids[kind]);
        if (kind > 1) file_.write_rows(columns_.offsets[kind], index, 1, &none);
    }
    return parts_.emplace(key, part).first->second;
}

// Appends 0, 1, 2 and so on.
void PartTable::count_up(ColumnIndex column, std::uint64_t numbers) {
    const std::uint64_t chunk_rows = file_.shape(column).chunk_rows;
    std::vector<std::int64_t> some;
    for (std::uint64_t next = 0; next < numbers; next += some.size()) {
        const std::uint64_t first = file_.rows(column);
        some.resize(std::min(chunk_rows - first % chunk_rows, numbers - next));
        std::iota(some.begin(), some.end(), static_cast<std::int64_t>(next));
        if (first % chunk_rows == 0)
            file_.write_rows_of_step(column, first, some.size(), some.data());
        else
            file_.write_rows(column, first, some.size(), some.data());
    }
}

// Readers of VTK up to 9.3 find the Offsets of a part at its cell offset plus its index; later ones at its cell offset plus the
// number of parts it takes to reach that offset. Counting an empty part as one cell, with a row of Offsets to spare, makes both
// come out at the same row.
void PartTable::write_vertices(std::uint64_t rows, Part& part) {
    if (parts_.empty()) make_ids(0, std::clamp(rows, kFewestVertexRows, kMostVertexRows));
    const auto [known, is_new] = connectivity_of_rows_.emplace(rows, static_cast<std::int64_t>(file_.rows(columns_.connectivity[0])));
    if (is_new) count_up(columns_.connectivity[0], rows);
    part.connectivity_offsets[0] = known->second;
    part.cell_offsets[0] = next_cell_offset_;
    count_up(columns_.offsets[0], rows + 1);
    if (rows == 0) count_up(columns_.offsets[0], 1);
    next_cell_offset_ += static_cast<std::int64_t>(std::max<std::uint64_t>(rows, 1));
}

// Most parts may be without lines. So all cell offsets are one too large, after a row that is nobody's: no number of earlier
// parts reaches them, and both kinds of readers come to the part's index.
void PartTable::write_lines(std::span<const RecordedLine> lines, Part& part) {
    const std::int64_t nobodys = 0;
    if (file_.rows(columns_.offsets[1]) == 0) file_.write_rows(columns_.offsets[1], 0, 1, &nobodys);
    std::vector<std::int64_t> ends;
    for (std::size_t i = 0; i <= lines.size(); ++i) ends.push_back(static_cast<std::int64_t>(2 * i));
    part.connectivity_offsets[1] = static_cast<std::int64_t>(file_.rows(columns_.connectivity[1]));
    part.cell_offsets[1] = next_line_offset_;
    file_.write_rows(columns_.connectivity[1], file_.rows(columns_.connectivity[1]), 2 * lines.size(), lines.data());
    file_.write_rows(columns_.offsets[1], file_.rows(columns_.offsets[1]), ends.size(), ends.data());
    next_line_offset_ += static_cast<std::int64_t>(lines.size());
}

}  // namespace meld::record
