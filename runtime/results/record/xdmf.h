// The XDMF sidecars: XML files that tell older readers which rows of the recording belong to which step. They are written at its end,
// from its own tables. Private to runtime/results/record.
#pragma once

#include <cstdint>
#include <functional>
#include <span>
#include <string>
#include <vector>

#include "runtime/base/files/output_file.h"
#include "runtime/results/hdf5/hdf5_file.h"

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

// A step as a sidecar shows it. Of what a sidecar of lines shows, `ends` are the two places of each line.
struct XdmfStep {
    double time = 0;
    std::uint64_t rows = 0;
    XdmfSlab points;
    std::vector<XdmfSlab> arrays;
    XdmfSlab ends;
    std::uint64_t lines = 0;
};

// The steps of a recording, in order: calls what it is given with each.
using XdmfSteps = std::function<void(const std::function<void(const XdmfStep&)>&)>;

enum class XdmfShows { Catoms, Lines };

// Writes the whole sidecar; `data_file` is the recording's name without directory. Steps without catoms (or lines), which some readers take
// for an error, are left out, and so are steps that look like the one before, which readers then show. Of the others as many are listed, at
// equal distances, as fit into `most_bytes`; the first and the last always are. The steps are gone through twice.
void write_sidecar(OutputFile& file, const std::string& data_file, XdmfShows shows, const XdmfSteps& steps, std::uint64_t most_bytes);

}  // namespace meld::record
