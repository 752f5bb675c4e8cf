// What a person reads of a profile.
#pragma once

#include <string>

#include "runtime/results/profile/file/profile_file.h"

namespace meld::profile {

// Reads a profile of which everything can be printed: what somebody has changed is refused as a whole.
// Errors: as read_profile(), and parts that are missing or of another kind.
Result<Profile> read_whole_profile(const std::string& path);

// All tables of it; of a profile from read_whole_profile().
std::string describe(const Profile& profile);

}  // namespace meld::profile
