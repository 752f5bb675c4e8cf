#include "runtime/results/hdf5/series_column.h"

#include <algorithm>
#include <cstring>

#include "runtime/base/assert.h"
#include "runtime/base/hash.h"

namespace meld::record {

namespace {

std::uint64_t next_chunk(const Hdf5File& file, ColumnIndex column) {
    const std::uint64_t chunk = file.shape(column).chunk_rows;
    return (file.rows(column) + chunk - 1) / chunk * chunk;
}

std::size_t size_bytes(const ColumnShape& shape, std::uint64_t rows) {
    return rows * static_cast<std::size_t>(shape.components) * size_of(shape.type);
}

std::uint64_t hash_of_changes(std::uint64_t hash, std::span<const std::uint64_t> rows, const std::byte* values, std::size_t row_bytes) {
    for (std::size_t i = 0; i < rows.size(); ++i)
        hash = hash_combine(hash, hash_combine(rows[i], XXH3_64bits(values + i * row_bytes, row_bytes)));
    return hash;
}

struct ReadChanges {
    std::vector<std::uint64_t> rows;
    std::vector<std::byte> values;
};

ReadChanges read_changes(Hdf5File& file, const SeriesChanges& changes) {
    const std::uint64_t count = changes.end - changes.begin;
    ReadChanges out{std::vector<std::uint64_t>(count), std::vector<std::byte>(size_bytes(file.shape(changes.values), count))};
    file.read_rows(changes.rows, changes.begin, count, out.rows.data());
    file.read_rows(changes.values, changes.begin, count, out.values.data());
    return out;
}

}  // namespace

XXH128_hash_t hash_of_rows(Hdf5File& file, ColumnIndex column, std::uint64_t first_row, std::uint64_t rows) {
    std::vector<std::byte> data(size_bytes(file.shape(column), rows));
    file.read_rows(column, first_row, rows, data.data());
    return XXH3_128bits(data.data(), data.size());
}

void SeriesColumn::write(Hdf5File& file, std::uint64_t rows, const void* data) {
    const XXH128_hash_t hash = XXH3_128bits(data, size_bytes(file.shape(values), rows));
    if (changes) changes->begin = changes->end;
    if (changes) changes->hash = 0;
    if (written && last_rows == rows && XXH128_isEqual(hash, last_hash)) return;
    const std::uint64_t offset = next_chunk(file, values);
    file.write_rows_of_step(values, offset, rows, data);
    last_offset = rows > 0 ? offset : 0;
    last_rows = rows;
    last_hash = hash;
    written = true;
}

void SeriesColumn::keep(std::uint64_t rows) const {
    MELD_CHECK(written && last_rows == rows, "{} rows are to be those of the last step, which has {}", rows, last_rows);
}

void SeriesColumn::leave_blank(Hdf5File& file, std::uint64_t rows) {
    if (rows <= blank_rows) return;
    blank_offset = next_chunk(file, values);
    blank_rows = rows;
    file.lengthen(values, blank_offset + rows);
}

bool SeriesColumn::matches(Hdf5File& file) const {
    if (written && last_rows > 0 && XXH128_isEqual(hash_of_rows(file, values, last_offset, last_rows), last_hash) == 0) return false;
    if (!has_changes()) return true;
    const ReadChanges read = read_changes(file, *changes);
    return hash_of_changes(0, read.rows, read.values.data(), size_bytes(file.shape(values), 1)) == changes->hash;
}

void SeriesColumn::follow_changes(Hdf5File& file, StepTables& steps, const std::string& place, const std::string& range) {
    file.make_group(place);
    ColumnShape shape = {.type = ElementType::Int64, .chunk_rows = kChangesPerChunk, .readable_at_once = true};
    changes.emplace();
    changes->rows = file.make_column(place + "/row", shape);
    shape.type = file.shape(values).type;
    shape.components = file.shape(values).components;
    changes->values = file.make_column(place + "/value", shape);
    changes->range = steps.add_range(range);
}

bool SeriesColumn::too_many_changes(const Hdf5File& file, std::uint64_t more) const {
    const std::uint64_t row_bytes = size_bytes(file.shape(values), 1);
    return (changes->end - changes->begin + more) * (sizeof(std::uint64_t) + row_bytes) > last_rows * row_bytes;
}

void SeriesColumn::change(Hdf5File& file, std::span<const std::uint64_t> rows, const void* new_values) {
    changes->hash = hash_of_changes(changes->hash, rows, static_cast<const std::byte*>(new_values), size_bytes(file.shape(values), 1));
    file.write_rows(changes->rows, changes->end, rows.size(), rows.data());
    file.write_rows(changes->values, changes->end, rows.size(), new_values);
    changes->end += rows.size();
}

std::optional<std::vector<std::uint64_t>> SeriesColumn::differences(Hdf5File& file, const void* data, std::uint64_t most) const {
    const std::uint64_t chunk = file.shape(values).chunk_rows;
    const std::size_t row_bytes = size_bytes(file.shape(values), 1);
    ReadChanges since;
    if (has_changes()) since = read_changes(file, *changes);
    std::vector<std::uint64_t> out;
    std::vector<std::byte> before;
    for (std::uint64_t first = 0; first < last_rows && !file.failed(); first += chunk) {
        const std::uint64_t count = std::min(chunk, last_rows - first);
        before.resize(count * row_bytes);
        file.read_rows(values, last_offset + first, count, before.data());
        for (std::size_t i = 0; i < since.rows.size(); ++i)
            if (since.rows[i] >= first && since.rows[i] < first + count)
                std::memcpy(before.data() + (since.rows[i] - first) * row_bytes, since.values.data() + i * row_bytes, row_bytes);
        const std::byte* const now = static_cast<const std::byte*>(data) + first * row_bytes;
        if (std::memcmp(now, before.data(), before.size()) == 0) continue;
        for (std::uint64_t row = 0; row < count; ++row)
            if (std::memcmp(now + row * row_bytes, before.data() + row * row_bytes, row_bytes) != 0) out.push_back(first + row);
        if (out.size() > most) return std::nullopt;
    }
    return out;
}

}  // namespace meld::record
