// A module in LLVM's memory to an ELF object.
#pragma once

#include <llvm/IR/Module.h>

#include <string>

#include "compiler/build/backend/backend.h"
#include "runtime/base/error.h"

namespace meld {

// Optimizes the module, which Clang's front end has left as it is, and generates its code. Errors are ours: ExitCode::OurBug.
Result<std::string> generate_object(llvm::Module& module, const ObjectOptions& options, CodePasses passes);

// The error of what Clang made and LLVM refuses.
tl::unexpected<Error> module_does_not_compile(const std::string& why);

}  // namespace meld
