// The XDMF sidecar: an XML file that tells older readers which rows of the recording belong to which step.
// Private to runtime/record.
#pragma once

#include <cstdint>
#include <span>
#include <string>

#include "runtime/base/output_file.h"
#include "runtime/record/hdf5_file.h"

namespace meld::record {

// Rows of one column of the recording.
struct XdmfSlab {
    std::string name;  // As shown to the user.
    std::string path;  // In the HDF5 file.
    ElementType type = ElementType::Int64;
    int components = 1;
    std::uint64_t first_row = 0;
    std::uint64_t rows_in_file = 0;
};

class XdmfSidecar {
  public:
    // `data_file` is the recording's name without directory; `path` is not a stream. Errors: it cannot be written.
    static Result<XdmfSidecar> create(const std::string& path, const std::string& data_file, Durability durability);

    // Adds a step of `rows` points; the file is well-formed after each one.
    Result<void> add_step(double time, std::uint64_t rows, const XdmfSlab& points, std::span<const XdmfSlab> arrays);
    // The same for `lines` lines between the points: `ends` are the two indices of each.
    Result<void> add_lines(double time, std::uint64_t rows, const XdmfSlab& points, const XdmfSlab& ends, std::uint64_t lines);

    // The file is complete and takes its place.
    Result<void> commit() { return file_.commit(); }

  private:
    XdmfSidecar(OutputFile file, std::string data_file) : file_(std::move(file)), data_file_(std::move(data_file)) {}
    Result<void> append(std::string text);

    OutputFile file_;
    std::string data_file_;
    std::uint64_t end_of_steps_ = 0;
};

}  // namespace meld::record
