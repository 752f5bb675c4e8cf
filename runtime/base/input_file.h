// The one way to read a file that somebody else wrote: whole, up to a size, and from nothing that has no end.
#pragma once

#include <cstdint>
#include <string>

#include "runtime/base/error.h"

namespace meld {

// What may stand at a path. What a file names must be a file on disk; a user may also type the name of a pipe, as the shell's
// <(command) is one.
enum class InputKind { File, FileOrPipe };

// The content of the file. Never waits for a pipe that nobody writes to unless pipes are allowed. Errors (ExitCode::UsageOrWorld):
// it is not there, may not be read, is a folder, device or socket, is larger than most_bytes, or the disk fails.
Result<std::string> read_input(const std::string& path, std::uint64_t most_bytes, InputKind kind = InputKind::File);

}  // namespace meld
