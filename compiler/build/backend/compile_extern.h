// C and C++ files that a program links in, to ELF objects.
#pragma once

#include <string>
#include <vector>

#include "compiler/build/backend/backend.h"
#include "runtime/base/error.h"

namespace meld {

// Compiles one file. It sees <meld/extern.h> and the system's C headers if there are any, but no files beside it. Errors that Clang reports
// are the user's: ExitCode::ProgramWrong.
Result<ExternObject> compile_extern(const ExternSource& source, const std::string& header, const ObjectOptions& options);

}  // namespace meld
