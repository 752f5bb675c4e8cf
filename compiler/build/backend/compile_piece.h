// The pieces of a very long module: C++ text to one ELF object each. All of them begin with the same declarations, which are parsed once.
#pragma once

#include <string>
#include <utility>
#include <vector>

#include "compiler/build/backend/backend.h"
#include "runtime/base/error.h"

namespace meld {

// Parses the declarations, which see the given headers, and returns what Clang knows of them: a precompiled header in its own format, which
// depends on the text, the headers, the options and Clang's version.
Result<std::string> compile_shared(const std::string& text, const std::vector<std::pair<std::string, std::string>>& headers,
                                   const ObjectOptions& options);

// Compiles a piece after these declarations, with the same headers and options. What pieces use of each other is visible in the module
// alone. May be called from several threads at once. Errors are ours: ExitCode::OurBug.
Result<std::string> compile_piece(const std::string& text, const SharedPart& shared,
                                  const std::vector<std::pair<std::string, std::string>>& headers, CodePasses passes,
                                  const ObjectOptions& options);

}  // namespace meld
