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
// Errors: the file cannot be read, or is no whole profile of this version.
Result<Profile> read_profile(const std::string& path);

// What a person reads of it.
std::string describe(const Profile& profile);

}  // namespace meld::profile
