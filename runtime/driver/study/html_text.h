// Text of programs, worlds and files in pages.
#pragma once

#include <string>

namespace meld::driver {

// For an element or the value of an attribute in quotes; it is shown, whatever it is, and does nothing.
std::string html(const std::string& text);

}  // namespace meld::driver
