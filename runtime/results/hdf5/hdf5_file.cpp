// The library is a build for parallel use, but is used by one process like any serial one.
#include "runtime/results/hdf5/hdf5_file.h"

#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstring>
#include <limits>
#include <system_error>
#include <utility>

#include "runtime/base/assert.h"
#include "runtime/results/hdf5/hdf5_dataset.h"
#include "runtime/results/hdf5/hdf5_driver.h"
#include "runtime/results/hdf5/hdf5_library.h"

namespace meld::record {

static_assert(sizeof(hid_t) == sizeof(std::int64_t), "handles are kept as 64-bit integers");

namespace {

// In rows that nobody has written; other types have 0.
constexpr double kNoNumber = std::numeric_limits<double>::quiet_NaN();
constexpr unsigned kMostCompactLinks = 60'000;  // Of 65,535.
constexpr std::size_t kFewestPackedBytes = 64 << 10;
constexpr std::uint32_t kWithoutFilters = 3;  // A bit for each of the two.
// Room for this many names in the header of a group; further names go to a second block.
constexpr unsigned kExpectedLinks = 32;
constexpr unsigned kExpectedNameBytes = 24;

hid_t stored_type(ElementType type) {
    switch (type) {
        case ElementType::Int64:
            return H5T_STD_I64LE;
        case ElementType::Float32:
            return H5T_IEEE_F32LE;
        case ElementType::Float64:
            return H5T_IEEE_F64LE;
        case ElementType::UInt8:
            return H5T_STD_U8LE;
    }
    return -1;
}

template <class Number>
void fill(std::span<std::byte> bytes, Number number) {
    for (std::size_t at = 0; at < bytes.size(); at += sizeof number) std::memcpy(bytes.data() + at, &number, sizeof number);
}

// As the library has rows that nobody has written.
std::vector<std::byte> rows_of_nothing(ElementType type, std::size_t bytes) {
    std::vector<std::byte> out(bytes);
    if (type == ElementType::Float64) fill(std::span(out), kNoNumber);
    if (type == ElementType::Float32) fill(std::span(out), static_cast<float>(kNoNumber));
    return out;
}

bool is_two_dimensional(const ColumnShape& shape) { return shape.components > 1 || shape.two_dimensional; }

// A fixed-length string type; HDF5 has none of length zero.
Handle text_type(std::string_view text, H5T_cset_t characters) {
    const hid_t type = H5Tcopy(H5T_C_S1);
    H5Tset_size(type, std::max<std::size_t>(1, text.size()));
    H5Tset_strpad(type, H5T_STR_NULLPAD);
    H5Tset_cset(type, characters);
    return {type, H5Tclose};
}

}  // namespace

std::size_t size_of(ElementType type) {
    switch (type) {
        case ElementType::Int64:
        case ElementType::Float64:
            return 8;
        case ElementType::Float32:
            return 4;
        case ElementType::UInt8:
            return 1;
    }
    return 0;
}

namespace {

Handle file_access() {
    const hid_t access = H5Pcreate(H5P_FILE_ACCESS);
    H5Pset_driver(access, append_driver(), nullptr);
    H5Pset_libver_bounds(access, H5F_LIBVER_V18, H5F_LIBVER_LATEST);
    return {access, H5Pclose};
}

}  // namespace

// The layout ensures that a process killed at any moment leaves a file that can be read
// (docs/reference/internals.md, "Files that survive a kill"):
// - The indexes of chunks are those of version 1.10, in which an entry never moves. The B-trees of earlier versions split, and for a moment
// no chunk of the dataset can be found.
// - The superblock is that of 1.8: one of 1.10 says that the file is being written, and a killed process would leave it saying so.
// - Space that becomes free is not used again, neither by the library's free-space tracking nor by the driver.
Hdf5File::Hdf5File(const std::string& path, Durability durability) : durability_(durability) {
    set_up_library_once();
    const Handle access = file_access();
    const Handle creation(H5Pcreate(H5P_FILE_CREATE), H5Pclose);
    check(H5Pset_file_space_strategy(creation, H5F_FSPACE_STRATEGY_NONE, 0, 1));
    check(H5Pset_link_phase_change(creation, kMostCompactLinks, kMostCompactLinks));
    if (!failed()) file_ = H5Fcreate(path.c_str(), H5F_ACC_TRUNC, creation, access);
    changed_ = true;
    begin();
}

// The file is as before until extend(): what is not to go on is not touched.
Hdf5File::Hdf5File(const std::string& path, Durability durability, ByteReader& saved) : durability_(durability) {
    set_up_library_once();
    const Handle access = file_access();
    if (!failed()) file_ = H5Fopen(path.c_str(), H5F_ACC_RDWR, access);
    begin();
    for (auto left = saved.read_count(sizeof(std::uint32_t) + sizeof(std::uint64_t)); left > 0; --left) {
        const std::string name = saved.read_string();
        open_column(name, saved.read<std::uint64_t>());
    }
}

void Hdf5File::begin() {
    check(file_);
    if (!failed()) driver_file_ = last_opened();
    if (!failed()) check(H5Fset_libver_bounds(file_, H5F_LIBVER_V110, H5F_LIBVER_LATEST));
}

void Hdf5File::save(ByteWriter& out) const {
    out.write_count(columns_.size());
    for (const Column& column : columns_) {
        out.write_string(column.path);
        out.write(column.rows);
    }
}

// Its shape is that of the dataset.
void Hdf5File::open_column(const std::string& path, std::uint64_t rows) {
    columns_.push_back({.dataset = -1, .shape = {}, .rows = rows, .path = path});
    if (failed()) return;
    Column& column = columns_.back();
    column.dataset = H5Dopen2(file_, path.c_str(), H5P_DEFAULT);
    check(column.dataset);
    if (failed()) return;
    const Handle type(H5Dget_type(column.dataset), H5Tclose), space(H5Dget_space(column.dataset), H5Sclose);
    const Handle properties(H5Dget_create_plist(column.dataset), H5Pclose);
    std::array<hsize_t, 2> extent = {0, 1}, chunk = {0, 1};
    const int dimensions = H5Sget_simple_extent_ndims(space);
    std::optional<ElementType> element;
    for (const ElementType each : {ElementType::Int64, ElementType::Float32, ElementType::Float64, ElementType::UInt8})
        if (H5Tequal(type, stored_type(each)) > 0) element = each;
    if (!element || dimensions < 1 || dimensions > 2 || H5Pget_layout(properties) != H5D_CHUNKED ||
        H5Pget_chunk(properties, 2, chunk.data()) != dimensions || H5Sget_simple_extent_dims(space, extent.data(), nullptr) < 0) {
        failure_ = path + " is none of its columns";
        return;
    }
    if (extent[0] < rows) failure_ = fmt::format("{} has {} rows, and had {}", path, extent[0], rows);
    column.shape = {.type = *element,
                    .components = static_cast<int>(extent[1]),
                    .chunk_rows = chunk[0],
                    .two_dimensional = dimensions == 2,
                    .compressed = H5Pget_nfilters(properties) > 0};
}

void Hdf5File::shorten(ColumnIndex index, std::uint64_t rows) {
    if (failed()) return;
    Column& column = columns_[index];
    const std::array<hsize_t, 2> extent = {rows, static_cast<hsize_t>(column.shape.components)};
    check(H5Dset_extent(column.dataset, extent.data()));
    column.rows = rows;
    column.step_hashes.clear();
}

Hdf5File::~Hdf5File() { close(); }

void Hdf5File::check(std::int64_t result) {
    if (result < 0 && !failed()) failure_ = text_of_last_error();
}

void Hdf5File::make_group(const std::string& path) {
    if (failed()) return;
    // All names are in the header of the group, which is written at once.
    const Handle creation(H5Pcreate(H5P_GROUP_CREATE), H5Pclose);
    check(H5Pset_link_phase_change(creation, kMostCompactLinks, kMostCompactLinks));
    check(H5Pset_est_link_info(creation, kExpectedLinks, kExpectedNameBytes));
    const Handle group(H5Gcreate2(file_, path.c_str(), H5P_DEFAULT, creation, H5P_DEFAULT), H5Gclose);
    check(group);
}

void Hdf5File::link(const std::string& group, const std::string& name, const std::string& object) {
    if (failed()) return;
    const Handle opened(H5Gopen2(file_, group.c_str(), H5P_DEFAULT), H5Gclose);
    check(opened);
    if (failed()) return;
    // Nothing of the group is written between the two changes.
    check(H5Odisable_mdc_flushes(opened));
    if (H5Lexists(opened, name.c_str(), H5P_DEFAULT) > 0) check(H5Ldelete(opened, name.c_str(), H5P_DEFAULT));
    check(H5Lcreate_soft(object.c_str(), opened, name.c_str(), H5P_DEFAULT, H5P_DEFAULT));
    check(H5Oenable_mdc_flushes(opened));
}

std::string Hdf5File::linked(const std::string& group, const std::string& name) const {
    std::array<char, 64> object{};
    const std::string path = group + "/" + name;
    const bool read = !failed() && H5Lget_val(file_, path.c_str(), object.data(), object.size() - 1, H5P_DEFAULT) >= 0;
    return read ? object.data() : "";
}

void Hdf5File::write_attribute(const std::string& group, const std::string& name, std::int64_t type, std::int64_t space, const void* data) {
    if (failed()) return;
    Handle object(H5Oopen(file_, group.c_str(), H5P_DEFAULT), H5Oclose);
    Handle attribute(H5Acreate2(object, name.c_str(), type, space, H5P_DEFAULT, H5P_DEFAULT), H5Aclose);
    check(attribute);
    if (!failed()) check(H5Awrite(attribute, type, data));
    check(attribute.close());
    check(object.close());
}

void Hdf5File::set_attribute(const std::string& group, const std::string& name, std::string_view text) {
    const Handle space(H5Screate(H5S_SCALAR), H5Sclose);
    const bool ascii = std::ranges::all_of(text, [](char c) { return static_cast<unsigned char>(c) < 0x80; });
    const Handle type = text_type(text, ascii ? H5T_CSET_ASCII : H5T_CSET_UTF8);
    write_attribute(group, name, type, space, text.empty() ? "" : text.data());
}

void Hdf5File::set_attribute(const std::string& group, const std::string& name, std::span<const std::int64_t> values) {
    const hsize_t count = values.size();
    const Handle space(H5Screate_simple(1, &count, nullptr), H5Sclose);
    write_attribute(group, name, H5T_NATIVE_INT64, space, values.data());
}

void Hdf5File::set_attribute(const std::string& group, const std::string& name, std::int64_t value) {
    const Handle space(H5Screate(H5S_SCALAR), H5Sclose);
    write_attribute(group, name, H5T_NATIVE_INT64, space, &value);
}

void Hdf5File::set_attribute(const std::string& group, const std::string& name, std::uint64_t value) {
    const Handle space(H5Screate(H5S_SCALAR), H5Sclose);
    write_attribute(group, name, H5T_NATIVE_UINT64, space, &value);
}

void Hdf5File::set_attribute(const std::string& group, const std::string& name, double value) {
    const Handle space(H5Screate(H5S_SCALAR), H5Sclose);
    write_attribute(group, name, H5T_NATIVE_DOUBLE, space, &value);
}

std::optional<std::int64_t> Hdf5File::attribute(const std::string& group, const std::string& name) const {
    if (failed() || H5Aexists_by_name(file_, group.c_str(), name.c_str(), H5P_DEFAULT) <= 0) return std::nullopt;
    const Handle found(H5Aopen_by_name(file_, group.c_str(), name.c_str(), H5P_DEFAULT, H5P_DEFAULT), H5Aclose);
    const Handle space(H5Aget_space(found), H5Sclose);
    std::int64_t value = 0;
    if (H5Sget_simple_extent_type(space) != H5S_SCALAR || H5Aread(found, H5T_NATIVE_INT64, &value) < 0) return std::nullopt;
    return value;
}

void Hdf5File::change_attribute(const std::string& group, const std::string& name, std::int64_t value) {
    if (failed()) return;
    const Handle object(H5Oopen(file_, group.c_str(), H5P_DEFAULT), H5Oclose);
    const Handle attribute(H5Aopen(object, name.c_str(), H5P_DEFAULT), H5Aclose);
    check(attribute);
    if (!failed()) check(H5Awrite(attribute, H5T_NATIVE_INT64, &value));
}

void Hdf5File::write_text(const std::string& path, std::string_view text) {
    if (failed()) return;
    const Handle space(H5Screate(H5S_SCALAR), H5Sclose);
    const Handle type = text_type(text, H5T_CSET_UTF8);
    Handle dataset(H5Dcreate2(file_, path.c_str(), type, space, H5P_DEFAULT, H5P_DEFAULT, H5P_DEFAULT), H5Dclose);
    check(dataset);
    if (!failed()) check(H5Dwrite(dataset, type, H5S_ALL, H5S_ALL, H5P_DEFAULT, text.empty() ? "" : text.data()));
    check(dataset.close());
}

void Hdf5File::write_texts(const std::string& path, const std::vector<std::string>& texts) {
    if (failed()) return;
    const hsize_t count = texts.size();
    const Handle space(H5Screate_simple(1, &count, nullptr), H5Sclose);
    const Handle type(H5Tcopy(H5T_C_S1), H5Tclose);
    H5Tset_size(type, H5T_VARIABLE);
    H5Tset_cset(type, H5T_CSET_UTF8);
    Handle dataset(H5Dcreate2(file_, path.c_str(), type, space, H5P_DEFAULT, H5P_DEFAULT, H5P_DEFAULT), H5Dclose);
    check(dataset);
    std::vector<const char*> pointers;
    for (const std::string& text : texts) pointers.push_back(text.c_str());
    if (!failed() && count > 0) check(H5Dwrite(dataset, type, H5S_ALL, H5S_ALL, H5P_DEFAULT, pointers.data()));
    check(dataset.close());
}

ColumnIndex Hdf5File::make_column(const std::string& path, const ColumnShape& shape, std::uint64_t rows) {
    columns_.push_back({.dataset = -1, .shape = shape, .rows = rows, .path = path});
    const ColumnIndex index = columns_.size() - 1;
    if (failed()) return index;
    const auto components = static_cast<hsize_t>(shape.components);
    const int dimensions = is_two_dimensional(shape) ? 2 : 1;
    const std::array<hsize_t, 2> extent = {rows, components};
    const std::array<hsize_t, 2> limits = {H5S_UNLIMITED, components};
    const std::array<hsize_t, 2> chunk = {shape.chunk_rows, components};
    const Handle space(H5Screate_simple(dimensions, extent.data(), limits.data()), H5Sclose);
    const Handle properties(H5Pcreate(H5P_DATASET_CREATE), H5Pclose);
    check(H5Pset_chunk(properties, dimensions, chunk.data()));
    if (shape.compressed) {
        check(H5Pset_shuffle(properties));
        check(H5Pset_deflate(properties, 1));
    }
    if (shape.type == ElementType::Float32 || shape.type == ElementType::Float64) {
        check(H5Pset_fill_value(properties, H5T_NATIVE_DOUBLE, &kNoNumber));
    }
    check(H5Pset_obj_track_times(properties, false));
    const hid_t dataset = H5Dcreate_anon(file_, stored_type(shape.type), space, properties, H5P_DEFAULT);
    columns_[index].dataset = dataset;
    check(dataset);
    if (shape.readable_at_once) make_chunk_index(index);
    if (!failed()) check(H5Dflush(dataset));
    if (!failed()) check(H5Olink(dataset, file_, path.c_str(), H5P_DEFAULT, H5P_DEFAULT));
    return index;
}

// The library makes it with the first chunk, and keeps it when the chunk is released.
void Hdf5File::make_chunk_index(ColumnIndex index) {
    Column& column = columns_[index];
    const std::uint64_t rows = std::exchange(column.rows, 0);
    const std::vector<std::byte> row(static_cast<std::size_t>(column.shape.components) * size_of(column.shape.type));
    write_rows(index, 0, 1, row.data());
    for (const std::uint64_t extent : {std::uint64_t{0}, rows}) {
        const std::array<hsize_t, 2> size = {extent, static_cast<hsize_t>(column.shape.components)};
        if (!failed()) check(H5Dset_extent(column.dataset, size.data()));
    }
    column.rows = rows;
}

void Hdf5File::lengthen(ColumnIndex index, std::uint64_t rows) {
    Column& column = columns_[index];
    if (failed() || rows <= column.rows) return;
    const std::array<hsize_t, 2> extent = {rows, static_cast<hsize_t>(column.shape.components)};
    check(H5Dset_extent(column.dataset, extent.data()));
    column.rows = rows;
}

void Hdf5File::read_rows(ColumnIndex index, std::uint64_t first_row, std::uint64_t rows, void* data) {
    if (failed() || rows == 0) return;
    const Column& column = columns_[index];
    const Selection selected(column.dataset, is_two_dimensional(column.shape), column.shape.components, first_row, rows);
    check(selected.fine);
    if (!failed()) check(H5Dread(column.dataset, memory_type(column.shape.type), selected.in_memory, selected.in_file, H5P_DEFAULT, data));
}

void Hdf5File::write_rows(ColumnIndex index, std::uint64_t first_row, std::uint64_t rows, const void* data) {
    lengthen(index, first_row + rows);
    if (failed() || rows == 0) return;
    const Column& column = columns_[index];
    const Selection selected(column.dataset, is_two_dimensional(column.shape), column.shape.components, first_row, rows);
    check(selected.fine);
    if (!failed()) check(H5Dwrite(column.dataset, memory_type(column.shape.type), selected.in_memory, selected.in_file, H5P_DEFAULT, data));
}

void Hdf5File::write_rows_of_step(ColumnIndex index, std::uint64_t first_row, std::uint64_t rows, const void* data) {
    lengthen(index, first_row + rows);
    if (failed()) return;
    Column& column = columns_[index];
    const std::uint64_t chunk_rows = column.shape.chunk_rows;
    const std::size_t row_bytes = static_cast<std::size_t>(column.shape.components) * size_of(column.shape.type);
    MELD_EXPECT(first_row % chunk_rows == 0, "row {} of chunks of {}", first_row, chunk_rows);
    std::vector<XXH128_hash_t> hashes;
    for (std::uint64_t at = 0; at < rows && !failed(); at += chunk_rows) {
        const std::uint64_t count = std::min(chunk_rows, rows - at);
        const std::byte* const from = static_cast<const std::byte*>(data) + at * row_bytes;
        hashes.push_back(XXH3_128bits(from, count * row_bytes));
        const std::size_t chunk = hashes.size() - 1;
        const bool same = chunk < column.step_hashes.size() && count == std::min(chunk_rows, column.step_rows - at) &&
                          XXH128_isEqual(hashes.back(), column.step_hashes[chunk]) != 0;
        // A column in which all is alike is packed once.
        const bool repeats = chunk > 0 && count == chunk_rows && XXH128_isEqual(hashes[chunk], hashes[chunk - 1]) != 0;
        if (same)
            copy_chunk(index, column.step_first + at, first_row + at);
        else if (repeats)
            copy_chunk(index, first_row + at - chunk_rows, first_row + at);
        else
            write_chunk(index, first_row + at, count, from);
    }
    column.step_first = first_row;
    column.step_rows = rows;
    column.step_hashes = std::move(hashes);
}

// Of rows that begin a chunk of the column's end. Short chunks are left to the library: each of their planes would take some bytes more.
void Hdf5File::write_chunk(ColumnIndex index, std::uint64_t first_row, std::uint64_t rows, const std::byte* data) {
    const Column& column = columns_[index];
    const std::size_t row_bytes = static_cast<std::size_t>(column.shape.components) * size_of(column.shape.type);
    const std::size_t chunk_bytes = column.shape.chunk_rows * row_bytes;
    if (!column.shape.compressed || chunk_bytes < kFewestPackedBytes) return write_rows(index, first_row, rows, data);
    std::span<const std::byte> chunk(data, chunk_bytes);
    std::vector<std::byte> whole;
    // What the library fills up a chunk with that is cut, so that a recording that has gone on has the same bytes.
    if (rows < column.shape.chunk_rows) {
        whole = rows_of_nothing(column.shape.type, chunk_bytes);
        std::memcpy(whole.data(), data, rows * row_bytes);
        chunk = whole;
    }
    const std::vector<std::byte> packed = packer_.pack(chunk, size_of(column.shape.type));
    const std::span<const std::byte> stored = packed.empty() ? chunk : std::span<const std::byte>(packed);
    const std::array<hsize_t, 2> to = {first_row, 0};
    check(H5Dwrite_chunk(column.dataset, H5P_DEFAULT, packed.empty() ? kWithoutFilters : 0, to.data(), stored.size(), stored.data()));
}

// As it stands in the file, packed.
void Hdf5File::copy_chunk(ColumnIndex index, std::uint64_t from_row, std::uint64_t to_row) {
    const Column& column = columns_[index];
    const std::array<hsize_t, 2> from = {from_row, 0}, to = {to_row, 0};
    hsize_t bytes = 0;
    check(H5Dget_chunk_storage_size(column.dataset, from.data(), &bytes));
    if (failed()) return;
    std::vector<std::byte> packed(bytes);
    std::uint32_t filters = 0;
    check(H5Dread_chunk(column.dataset, H5P_DEFAULT, from.data(), &filters, packed.data()));
    if (!failed()) check(H5Dwrite_chunk(column.dataset, H5P_DEFAULT, filters, to.data(), packed.size(), packed.data()));
}

void Hdf5File::flush() {
    if (!failed()) check(H5Fflush(file_, H5F_SCOPE_GLOBAL));
    sync();
}

void Hdf5File::flush_names(const std::string& group) {
    const Handle opened(failed() ? H5I_INVALID_HID : H5Gopen2(file_, group.c_str(), H5P_DEFAULT), H5Gclose);
    if (!failed()) check(H5Gflush(opened));
    sync();
}

void Hdf5File::sync() {
    if (failed() || durability_ == Durability::Process) return;
    void* descriptor = nullptr;
    check(H5Fget_vfd_handle(file_, H5P_DEFAULT, &descriptor));
    if (!failed() && fsync(*static_cast<const int*>(descriptor)) != 0) failure_ = std::generic_category().message(errno);
}

std::uint64_t Hdf5File::space_ahead() const {
    if (failed()) return 0;
    auto* const file = static_cast<H5FD_t*>(driver_file_);
    return H5FDget_eoa(file, H5FD_MEM_DEFAULT) - next_address(file);
}

std::uint64_t Hdf5File::size_bytes() const { return failed() ? 0 : next_address(static_cast<H5FD_t*>(driver_file_)); }

std::uint64_t Hdf5File::stored_bytes() const {
    std::uint64_t bytes = 0;
    for (const Column& column : columns_)
        if (!failed()) bytes += H5Dget_storage_size(column.dataset);
    return bytes;
}

// The library notices a new end of the file when it asks for space.
void Hdf5File::notice_end() {
    const Handle nothing(H5Gcreate_anon(file_, H5P_DEFAULT, H5P_DEFAULT), H5Gclose);
    check(nothing);
}

void Hdf5File::extend(std::uint64_t bytes) {
    if (failed()) return;
    auto* const file = static_cast<H5FD_t*>(driver_file_);
    changed_ = true;
    check(H5FDset_eoa(file, H5FD_MEM_DEFAULT, H5FDget_eoa(file, H5FD_MEM_DEFAULT) + bytes));
    notice_end();
    flush();
}

void Hdf5File::cut_end() {
    auto* const file = static_cast<H5FD_t*>(driver_file_);
    notice_end();
    check(H5FDset_eoa(file, H5FD_MEM_DEFAULT, next_address(file)));
}

// After a failure the library may refuse to close what it could not write; that tells nothing new.
void Hdf5File::close() {
    if (file_ >= 0 && changed_ && !failed()) cut_end();
    for (Column& column : columns_) {
        if (column.dataset >= 0) check(H5Dclose(std::exchange(column.dataset, -1)));
    }
    if (file_ >= 0) check(H5Fclose(std::exchange(file_, -1)));
}

}  // namespace meld::record
