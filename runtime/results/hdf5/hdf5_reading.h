// What readers of HDF5 files from outside need besides datasets: names in a group, attributes, texts. Private to runtime/results, and
// included by sources alone.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "runtime/base/error.h"
#include "runtime/results/hdf5/hdf5_library.h"

namespace meld::record {

// The names in a group, in order; none if there is no such group. Errors, in the words of the library: it cannot be read.
Result<std::vector<std::string>> names_in(hid_t file, const std::string& group);

// An attribute of a group as text; a number in its shortest form. Empty if there is none.
std::string attribute(hid_t file, const std::string& group, const std::string& name);
// An attribute that is a whole number; a negative one is 0. Nothing if there is none, or it is anything else.
std::optional<std::uint64_t> number_attribute(hid_t file, const std::string& group, const std::string& name);

// A dataset that is one text; empty if there is none.
std::string text_at(hid_t file, const std::string& path);
// A dataset of texts of any length; none if there is none, or it is anything else.
std::vector<std::string> texts_at(hid_t file, const std::string& path);

}  // namespace meld::record
