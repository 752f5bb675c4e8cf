// How a command ends with an error.
#pragma once

#include <string_view>

#include "runtime/base/error.h"

namespace meld::driver {

// Prints the error after the name of the program or command, unless it has no text: it was printed, or needs none. Returns its exit code.
int print_error(const Error& error, std::string_view program = "meldsim");

}  // namespace meld::driver
