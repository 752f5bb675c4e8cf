// Standard input, output and error of a command: they may be closed, full, or a pipe whose reader has left. None of these may end a process
// by a signal, let an opened file take the place of a stream, or remain unnoticed.
#pragma once

#include <cstdio>
#include <string_view>

#include "runtime/base/error.h"

namespace meld {

// Call this first in a program. A descriptor 0, 1 or 2 that is closed gets a file that can be neither read nor written, so that using it is
// an error. A reader that has left or a file that becomes too large makes a write fail and does not end the process.
void prepare_standard_streams();

// Writes to standard output or error and flushes. Does not throw. Errors: it cannot be written.
Result<void> print(std::FILE* stream, std::string_view text);

// Call this last in a program. Returns the exit code: `code` if everything sent to standard output (also through std::cout) has been
// written; if not, prints an error on standard error, unless the reader has left, and returns its code if `code` is 0.
int end_standard_output(std::string_view program, int code);

}  // namespace meld
