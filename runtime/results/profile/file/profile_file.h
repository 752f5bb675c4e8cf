// A profile in a file: JSON of what the run was, what it did and where its time went.
#pragma once

#include <nlohmann/json.hpp>
#include <string>

#include "runtime/base/error.h"

namespace meld::profile {

// The text of the file. run: what is said of the run as a whole; statistics: to_json() with add_times().
std::string file_text(const nlohmann::ordered_json& run, const nlohmann::ordered_json& statistics);

struct Profile {
    nlohmann::ordered_json run, statistics;
};
// Whether the parts are what they should be, their readers find out.
// Errors: the file cannot be read, or is no whole profile of this version.
Result<Profile> read_profile(const std::string& path);

// The error of a file that is read as a profile, and why it is none.
tl::unexpected<Error> no_profile(const std::string& path, const std::string& why);

// A reader of the parts found one missing, or of another kind; to be called with what it has thrown.
tl::unexpected<Error> part_missing(const std::string& path, const nlohmann::json::exception& error);

}  // namespace meld::profile
