// Words of a command as a shell reads them.
#pragma once

#include <string>
#include <vector>

namespace meld::driver {

// With quotes around those that need them.
std::string shell_words(const std::vector<std::string>& words);

}  // namespace meld::driver
