// What an HDF5 file holds, by its attributes "format" and "version".
#pragma once

#include <cstdint>
#include <string>
#include <string_view>

namespace meld::record {

inline constexpr std::string_view kRecordingFormat = "claymeld recording", kFactsFormat = "claymeld facts";
// The versions that are written and read; files of others are refused.
// An attribute of /meld/counts: whether its numbers are known.
inline constexpr const char* kCountsKnown = "known";

inline constexpr std::int64_t kRecordingVersion = 1, kFactsVersion = 1;

enum class Hdf5Kind { Recording, Facts, Other };

// A file that cannot be opened is Other.
Hdf5Kind kind_of_hdf5(const std::string& path);

}  // namespace meld::record
