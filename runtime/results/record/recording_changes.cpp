// Steps that hold changes alone: which they are, and what is in them.
//
// They are those of an ensemble of more than a chunk in which no catom is new or gone, at most a quarter of the rows of each series has
// changed, and the changes of each since the last whole step take less than the series itself. So reading a step never takes more than
// twice what it takes to read a whole one. Which rows have changed is a matter of their content alone, not of who says so: a run of any
// number of processes, and one that has gone on from a checkpoint, writes the same file.
#include <algorithm>
#include <cstring>
#include <type_traits>
#include <utility>

#include "runtime/base/assert.h"
#include "runtime/results/hdf5/file_kind.h"
#include "runtime/results/record/recording_state.h"

namespace meld::record {

namespace {

void append(std::vector<std::byte>& values, const void* data, std::size_t bytes) {
    const auto* const from = static_cast<const std::byte*>(data);
    values.insert(values.end(), from, from + bytes);
}

void gather(ChangedSeries& changed, const void* data, std::size_t row_bytes) {
    changed.values.resize(changed.rows.size() * row_bytes);
    const auto* const from = static_cast<const std::byte*>(data);
    std::byte* to = changed.values.data();
    const auto copy = [&](auto bytes) {
        for (const std::uint64_t row : changed.rows) std::memcpy(std::exchange(to, to + bytes), from + row * bytes, bytes);
    };
    // A copy of a length known at compile time is an instruction.
    if (row_bytes == sizeof(std::uint64_t))
        copy(std::integral_constant<std::size_t, sizeof(std::uint64_t)>());
    else
        copy(row_bytes);
}

}  // namespace

RecordedPosition narrow(const std::array<double, 3>& position) {
    return {static_cast<float>(position[0]), static_cast<float>(position[1]), static_cast<float>(position[2])};
}

void Recording::State::follow_changes() {
    hdf5->change_attribute("/meld", "version", kRecordingVersion);
    steps->follow_changes();
    hdf5->make_group("/meld/changes/PointData");
}

std::optional<ChangedSeries> Recording::State::find_moved(std::span<const RecordedPosition> positions, const RecordedSame& same) {
    ChangedSeries moved{.column = &*points};
    if (same.positions) return moved;
    if (same.moved != nullptr) {
        moved.rows = *same.moved;
    } else {
        auto rows = points->differences(*hdf5, positions.data(), positions.size() / kFewChanges);
        if (!rows) return std::nullopt;
        moved.rows = std::move(*rows);
    }
    gather(moved, positions.data(), sizeof positions[0]);
    return moved;
}

std::optional<ChangedSeries> Recording::State::find_changes(RecordedArray& array, std::uint64_t rows,
                                                            std::deque<std::vector<std::int64_t>>& numbers) {
    ChangedSeries changed{.column = &arrays.at(array.name)};
    if (array.same) return changed;
    if (array.changed != nullptr && array.type == RecordedArray::Text) {
        changed.rows = *array.changed;
        std::vector<std::string> some;
        for (const std::uint64_t at : changed.rows) some.push_back(static_cast<const std::string*>(array.data)[at]);
        const std::vector<std::int64_t> of_some = texts_of(array).numbers(some);
        append(changed.values, of_some.data(), of_some.size() * sizeof of_some[0]);
        return changed;
    }
    number_texts(array, rows, numbers);
    if (array.changed != nullptr) {
        changed.rows = *array.changed;
    } else {
        auto found = changed.column->differences(*hdf5, array.data, rows / kFewChanges);
        if (!found) return std::nullopt;
        changed.rows = std::move(*found);
    }
    gather(changed, array.data, static_cast<std::size_t>(array.components) * size_of(element_type(array.type)));
    return changed;
}

std::optional<std::vector<ChangedSeries>> Recording::State::find_changes(std::span<const RecordedPosition> positions,
                                                                         std::vector<RecordedArray>& given, const RecordedSame& same,
                                                                         std::deque<std::vector<std::int64_t>>& numbers) {
    const std::uint64_t rows = positions.size();
    if (!steps->follows_changes() || steps->steps() == 0 || points->last_rows != rows) return std::nullopt;
    if (same.moved != nullptr && same.moved->size() > rows / kFewChanges) return std::nullopt;
    for (const RecordedArray& array : given) {
        const auto known = arrays.find(array.name);
        if (known == arrays.end() || !known->second.written || known->second.last_rows != rows) return std::nullopt;
        if (array.changed != nullptr && array.changed->size() > rows / kFewChanges) return std::nullopt;
    }
    std::vector<ChangedSeries> out;
    for (std::size_t i = 0; i <= given.size(); ++i) {
        std::optional<ChangedSeries> one = i < given.size() ? find_changes(given[i], rows, numbers) : find_moved(positions, same);
        const bool follows = one && (one->rows.empty() || (one->column->changes && one->rows.size() <= rows / kFewChanges &&
                                                           !one->column->too_many_changes(*hdf5, one->rows.size())));
        if (!follows) return std::nullopt;
        if (!one->rows.empty()) out.push_back(std::move(*one));
    }
    return out;
}

// Of every series; what this step lacks has none.
void Recording::State::write_ranges(std::span<const RecordedArray> given) {
    const auto write = [&](const SeriesColumn& column, bool is_given) {
        if (!column.changes) return;
        const bool any = is_given && column.has_changes();
        steps->set_range(column.changes->range, any ? static_cast<std::int64_t>(column.changes->begin) : 0,
                         any ? static_cast<std::int64_t>(column.changes->end) : 0);
    };
    write(*points, true);
    for (const auto& [name, column] : arrays)
        write(column, std::ranges::any_of(given, [&](const RecordedArray& array) { return array.name == name; }));
}

}  // namespace meld::record
