// Standard input, output and error of a command: they may be closed, full, or a pipe whose reader has left. None of that may end a
// process by a signal, let a file that it opens take their place, or go unnoticed.
#pragma once

#include <cstdio>
#include <string_view>

#include "runtime/base/error.h"

namespace meld {

// The first thing that a program does. A descriptor 0, 1 or 2 that is closed gets a file that can be neither read nor written, so that
// using it is an error. A reader that has left and a file that becomes too large make a write fail and do not end the process.
void prepare_standard_streams();

// Writes to standard output or error and flushes. Does not throw. Errors: it cannot be written.
Result<void> print(std::FILE* stream, std::string_view text);

// The last thing that a program does: the exit code, `code` if all that went to standard output (also through std::cout) is written;
// if not, says so on standard error and, where `code` is 0, returns that of the error.
int end_standard_output(std::string_view program, int code);

}  // namespace meld
