#include "runtime/results/hdf5/series_column.h"

#include <vector>

#include "runtime/base/assert.h"

namespace meld::record {

namespace {

std::uint64_t next_chunk(const Hdf5File& file, ColumnIndex column) {
    const std::uint64_t chunk = file.shape(column).chunk_rows;
    return (file.rows(column) + chunk - 1) / chunk * chunk;
}

std::size_t size_bytes(const ColumnShape& shape, std::uint64_t rows) {
    return rows * static_cast<std::size_t>(shape.components) * size_of(shape.type);
}

}  // namespace

XXH128_hash_t hash_of_rows(Hdf5File& file, ColumnIndex column, std::uint64_t first_row, std::uint64_t rows) {
    std::vector<std::byte> data(size_bytes(file.shape(column), rows));
    file.read_rows(column, first_row, rows, data.data());
    return XXH3_128bits(data.data(), data.size());
}

void SeriesColumn::write(Hdf5File& file, std::uint64_t rows, const void* data) {
    const XXH128_hash_t hash = XXH3_128bits(data, size_bytes(file.shape(values), rows));
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
    return !written || last_rows == 0 || XXH128_isEqual(hash_of_rows(file, values, last_offset, last_rows), last_hash) != 0;
}

}  // namespace meld::record
