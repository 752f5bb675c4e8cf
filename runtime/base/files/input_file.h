// The one way to read a file from outside: whole, up to a maximum size, and never from a source without end.
#pragma once

#include <cstdint>
#include <string>

#include "runtime/base/error.h"

namespace meld {

// The kinds of file allowed at a path. A file that another file names must be on disk; a user may also type the name of a pipe, such as the
// shell's <(command).
enum class InputKind { File, FileOrPipe };

// The content of the file. Never waits for a pipe without a writer unless pipes are allowed. Errors (ExitCode::UsageOrWorld): the file does
// not exist, may not be read, is a folder, device or socket, or is larger than most_bytes, or the disk fails. ExitCode::LimitHit: there is
// not so much memory.
Result<std::string> read_input(const std::string& path, std::uint64_t most_bytes, InputKind kind = InputKind::File);

}  // namespace meld
