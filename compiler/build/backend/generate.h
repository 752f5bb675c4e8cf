// A module in LLVM's memory to an ELF object.
#pragma once

#include <llvm/IR/Module.h>

#include <string>

#include "compiler/build/backend/backend.h"
#include "runtime/base/error.h"

namespace meld {

// All: the passes of LLVM for the level of optimisation. Few: those that matter most, for very long modules. Quick: the same, and code that
// is generated instruction by instruction, in a fifth of the time. None: such code without passes, for tables of data.
enum class CodePasses { All, Few, Quick, None };

// Optimizes the module, which Clang's front end has left as it is, and generates its code. Errors are ours: ExitCode::OurBug.
Result<std::string> generate_object(llvm::Module& module, const ObjectOptions& options, CodePasses passes);

}  // namespace meld
