// What an HDF5 file holds, by its attributes "format" and "version".
#pragma once

#include <cstdint>
#include <string>
#include <string_view>

namespace meld::record {

inline constexpr std::string_view kRecordingFormat = "claymeld recording", kFactsFormat = "claymeld facts";
// An attribute of /meld/counts: whether its numbers are known.
inline constexpr const char* kCountsKnown = "known";

// The versions that are written and read; files of others are refused.
inline constexpr std::int64_t kRecordingVersion = 2, kFactsVersion = 1;
// Of a recording in which no step holds changes alone: it is as it was before there were such steps, and earlier programs read it.
inline constexpr std::int64_t kWholeVersion = 1;

enum class Hdf5Kind { Recording, Facts, Other };

// A file that cannot be opened is Other.
Hdf5Kind kind_of_hdf5(const std::string& path);

}  // namespace meld::record
