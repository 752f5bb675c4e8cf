// How a command ends with an error.
#pragma once

#include "runtime/base/error.h"

namespace meld::driver {

// Prints the error, unless that has been done and it has no text; returns its exit code.
int print_error(const Error& error);

}  // namespace meld::driver
