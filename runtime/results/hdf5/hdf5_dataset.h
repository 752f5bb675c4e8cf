// Rows of numbers in HDF5: how they stand in memory, and a dataset that is only read. Private to runtime/results, and included by sources
// alone.
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <utility>

#include "runtime/base/error.h"
#include "runtime/results/hdf5/hdf5_file.h"
#include "runtime/results/hdf5/hdf5_library.h"

namespace meld::record {

inline hid_t memory_type(ElementType type) {
    switch (type) {
        case ElementType::Int64:
            return H5T_NATIVE_INT64;
        case ElementType::Float32:
            return H5T_NATIVE_FLOAT;
        case ElementType::Float64:
            return H5T_NATIVE_DOUBLE;
        case ElementType::UInt8:
            return H5T_NATIVE_UINT8;
    }
    return -1;
}

// Rows of a dataset, as they stand in the file and in memory.
struct Selection {
    Handle in_file, in_memory;
    herr_t fine = 0;

    Selection(hid_t dataset, bool two_dimensional, int components, std::uint64_t first_row, std::uint64_t rows)
        : Selection(dataset, two_dimensional, {first_row, 0}, {rows, static_cast<hsize_t>(components)}) {}

  private:
    Selection(hid_t dataset, bool two_dimensional, const std::array<hsize_t, 2>& begin, const std::array<hsize_t, 2>& count)
        : in_file(H5Dget_space(dataset), H5Sclose), in_memory(H5Screate_simple(two_dimensional ? 2 : 1, count.data(), nullptr), H5Sclose) {
        fine = H5Sselect_hyperslab(in_file, H5S_SELECT_SET, begin.data(), nullptr, count.data(), nullptr);
    }
};

// Of one dimension or two.
class Dataset {
  public:
    // Nothing if there is none at this path, or none of numbers that we write.
    static std::optional<Dataset> open(hid_t file, const std::string& path) {
        if (H5Lexists(file, path.c_str(), H5P_DEFAULT) <= 0) return std::nullopt;
        Dataset out;
        out.id_ = std::make_unique<Handle>(H5Dopen2(file, path.c_str(), H5P_DEFAULT), H5Dclose);
        if (*out.id_ < 0) return std::nullopt;
        const Handle space(H5Dget_space(*out.id_), H5Sclose), type(H5Dget_type(*out.id_), H5Tclose);
        std::array<hsize_t, 2> extent{};
        const int dimensions = H5Sget_simple_extent_ndims(space);
        if (dimensions < 1 || dimensions > 2 || H5Sget_simple_extent_dims(space, extent.data(), nullptr) < 0) return std::nullopt;
        out.rows_ = extent[0];
        out.two_dimensional_ = dimensions == 2;
        if (dimensions == 2 && (extent[1] < 1 || extent[1] > kMaxComponents)) return std::nullopt;
        if (dimensions == 2) out.components_ = static_cast<int>(extent[1]);
        const bool real = H5Tget_class(type) == H5T_FLOAT, whole = H5Tget_class(type) == H5T_INTEGER;
        const std::size_t size = H5Tget_size(type);
        if (real && (size == 4 || size == 8))
            out.type_ = size == 4 ? ElementType::Float32 : ElementType::Float64;
        else if (whole && (size == 1 || size == 8))
            out.type_ = size == 1 ? ElementType::UInt8 : ElementType::Int64;
        else
            return std::nullopt;
        return out;
    }

    std::uint64_t rows() const { return rows_; }
    int components() const { return components_; }
    ElementType type() const { return type_; }

    // Errors, in the words of the library: there are not so many rows, or they are damaged.
    Result<void> read(std::uint64_t first, std::uint64_t count, void* to) const {
        if (count == 0) return {};
        if (first > rows_ || count > rows_ - first) return fail("a step refers to rows that are not there");
        const Selection rows(*id_, two_dimensional_, components_, first, count);
        if (rows.fine < 0 || H5Dread(*id_, memory_type(type_), rows.in_memory, rows.in_file, H5P_DEFAULT, to) < 0)
            return fail(text_of_last_error());
        return {};
    }

  private:
    static constexpr hsize_t kMaxComponents = 16;

    std::unique_ptr<Handle> id_;
    std::uint64_t rows_ = 0;
    int components_ = 1;
    bool two_dimensional_ = false;
    ElementType type_ = ElementType::Int64;
};

}  // namespace meld::record
