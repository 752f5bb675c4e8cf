// ELF objects to a shared object, with LLVM's linker as a library.
#pragma once

#include <string>
#include <vector>

#include "runtime/base/error.h"

namespace meld {

// Links the object files into the shared object `output_path`, which is replaced. Symbols that the objects leave undefined (memcpy, sqrt)
// are found in the process that opens the module. Calls are serialized: the linker has global state.
Result<void> link_module(const std::vector<std::string>& object_paths, const std::string& output_path);

}  // namespace meld
