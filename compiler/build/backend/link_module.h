// One ELF object to a shared object, with LLVM's linker as a library.
#pragma once

#include <string>

#include "runtime/base/error.h"

namespace meld {

// Links the object file into the shared object `output_path`, which is replaced. Symbols the object leaves open (memcpy,
// sqrt) are found in the process that opens the module. Calls are serialised: the linker keeps global state.
Result<void> link_module(const std::string& object_path, const std::string& output_path);

}  // namespace meld
