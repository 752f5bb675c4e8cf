// C and C++ files that a program links in, to ELF objects.
#pragma once

#include <string>
#include <vector>

#include "compiler/build/backend/backend.h"
#include "runtime/base/error.h"

namespace meld {

// Compiles one file. It sees <meld/extern.h> and the system's C headers where there are any, and no files beside it. Clang's
// complaints are the user's: ExitCode::ProgramWrong.
Result<ExternObject> compile_extern(const ExternSource& source, const std::string& header, const ObjectOptions& options);

}  // namespace meld
