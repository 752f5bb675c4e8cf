// `meldc check --fix`: writes the safe fixes of programs into their files.
#pragma once

#include <string>
#include <vector>

#include "compiler/driver/compile.h"
#include "runtime/base/error.h"

namespace meld::driver {

// Applies the safe fixes of all messages about these programs, in their files and in those that they include, and again those that then
// come to light; says on standard error which files have changed. A program that cannot be read has none; whoever checks it afterwards says
// so. Of two fixes that change the same place the second waits until the first is done. Errors: a file cannot be written.
Result<void> apply_fixes(const std::vector<std::string>& programs, const CompileOptions& options);

}  // namespace meld::driver
