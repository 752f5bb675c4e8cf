// What an HDF5 file holds, by its attributes.
#pragma once

#include <string>

namespace meld::record {

enum class Hdf5Kind { Recording, Facts, Other };

// A file that cannot be opened is Other.
Hdf5Kind kind_of_hdf5(const std::string& path);

}  // namespace meld::record
