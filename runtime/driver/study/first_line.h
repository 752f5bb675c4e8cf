// What of a message is shown in a table or in a line of progress.
#pragma once

#include <string>

namespace meld::driver {

inline std::string first_line(const std::string& text) { return text.substr(0, text.find('\n')); }

}  // namespace meld::driver
