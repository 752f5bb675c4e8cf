// The part of HDF5 that a recording needs: groups, attributes, strings, and columns that grow. Hides <hdf5.h>, which includes MPI.
// Private to runtime/results.
#pragma once

#include <xxhash.h>

#include <cstdint>
#include <initializer_list>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "runtime/base/bytes.h"
#include "runtime/base/error.h"
#include "runtime/base/files/output_file.h"
#include "runtime/results/hdf5/chunk_packer.h"

namespace meld::record {

enum class ElementType { Int64, Float32, Float64, UInt8 };

std::size_t size_of(ElementType type);

// The shape of a column: rows of `components` elements, stored in chunks of `chunk_rows`. Rows never written read as zero,
// floats as NaN, and take no space as long as their whole chunk is unwritten.
struct ColumnShape {
    ElementType type = ElementType::Int64;
    int components = 1;
    std::uint64_t chunk_rows = 1;
    bool two_dimensional = false;  // Stored as rows × components also when components is 1.
    bool compressed = false;
    bool readable_at_once = false;  // Readers may open it before its first rows are complete: its index is written before them.
};

using ColumnIndex = std::size_t;

// After the first failure every later call does nothing, and error() reports it, so a caller checks once, at the end.
class Hdf5File {
  public:
    // Creates the file; `durability` is that of flush().
    Hdf5File(const std::string& path, Durability durability);
    // Opens the file again, with the columns that save() has noted, under the same indices and with as many rows; it may have more, and
    // nothing of it changes before extend(). Reports a column that is missing or shorter as a failure.
    Hdf5File(const std::string& path, Durability durability, ByteReader& saved);
    void save(ByteWriter& out) const;
    ~Hdf5File();
    Hdf5File(const Hdf5File&) = delete;
    Hdf5File& operator=(const Hdf5File&) = delete;

    bool failed() const { return failure_.has_value(); }
    // Why the first failed call failed, in the system's words.
    const std::string& failure() const { return *failure_; }
    // What has been read of it is not what was written: a failure like any other.
    void refuse(const std::string& why) {
        if (!failed()) failure_ = why;
    }

    void make_group(const std::string& path);
    void set_attribute(const std::string& group, const std::string& name, std::string_view text);
    void set_attribute(const std::string& group, const std::string& name, std::span<const std::int64_t> values);
    void set_attribute(const std::string& group, const std::string& name, std::int64_t value);
    void set_attribute(const std::string& group, const std::string& name, std::uint64_t value);
    void set_attribute(const std::string& group, const std::string& name, double value);
    void change_attribute(const std::string& group, const std::string& name, std::int64_t value);
    // Of numbers; none if there is none of this name.
    std::optional<std::int64_t> attribute(const std::string& group, const std::string& name) const;
    void write_text(const std::string& path, std::string_view text);
    void write_texts(const std::string& path, const std::vector<std::string>& texts);

    // From now on the name `name` of a group means the object at this path, with one write to the file.
    void link(const std::string& group, const std::string& name, const std::string& object);
    // What it means now; empty if it is no such name.
    std::string linked(const std::string& group, const std::string& name) const;

    // A column with this many rows. It gets its path once it is in the file, so the group never names anything that is not there.
    ColumnIndex make_column(const std::string& path, const ColumnShape& shape, std::uint64_t rows = 0);
    // Writes rows from `first_row` on, also beyond the end.
    void write_rows(ColumnIndex column, std::uint64_t first_row, std::uint64_t rows, const void* data);
    // The same of rows that begin a chunk: the chunks that are as they were in the last of these calls take the packed bytes from there. So
    // a change costs its chunk, and all else a hash and a copy of few bytes. The file is one that write_rows() could have made.
    void write_rows_of_step(ColumnIndex column, std::uint64_t first_row, std::uint64_t rows, const void* data);
    // Rows that are there.
    void read_rows(ColumnIndex column, std::uint64_t first_row, std::uint64_t rows, void* data);
    void lengthen(ColumnIndex column, std::uint64_t rows);
    // Cuts off what a column has beyond so many rows. The library writes the chunk with the last row anew.
    void shorten(ColumnIndex column, std::uint64_t rows);
    ColumnIndex columns() const { return columns_.size(); }
    std::uint64_t rows(ColumnIndex column) const { return columns_[column].rows; }
    const ColumnShape& shape(ColumnIndex column) const { return columns_[column].shape; }

    // Hands everything written to the system, or to the disk; or what stands in a group alone, its names.
    void flush();
    void flush_names(const std::string& group);
    // Moves the end of the file, which must already be that long on the disk. A step that takes no more than the space ahead of it leaves a
    // file that can be read after each of its writes: the library writes the position of the end last, and readers refuse data behind it.
    void extend(std::uint64_t bytes);
    std::uint64_t space_ahead() const;
    // How large it would be if it were closed now.
    std::uint64_t size_bytes() const;
    // What the columns take of it: the same for the same rows, in whatever steps they were written.
    std::uint64_t stored_bytes() const;
    void close();

  private:
    struct Column {
        std::int64_t dataset = -1;
        ColumnShape shape;
        std::uint64_t rows = 0;
        std::string path = {};
        // Of the last write_rows_of_step(): its rows, and the hash of each of its chunks.
        std::uint64_t step_first = 0, step_rows = 0;
        std::vector<XXH128_hash_t> step_hashes = {};
    };

    void check(std::int64_t result);
    void begin();
    void open_column(const std::string& path, std::uint64_t rows);
    void make_chunk_index(ColumnIndex column);
    void copy_chunk(ColumnIndex column, std::uint64_t from_row, std::uint64_t to_row);
    void write_chunk(ColumnIndex column, std::uint64_t first_row, std::uint64_t rows, const std::byte* data);
    void sync();
    void notice_end();
    void cut_end();
    void write_attribute(const std::string& group, const std::string& name, std::int64_t type, std::int64_t space, const void* data);

    Durability durability_;
    std::int64_t file_ = -1;
    void* driver_file_ = nullptr;
    std::vector<Column> columns_;
    ChunkPacker packer_;
    bool changed_ = false;
    std::optional<std::string> failure_;
};

}  // namespace meld::record
