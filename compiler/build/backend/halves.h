// Optimizes and compiles the two halves of a long module in parallel, in little more than half the time.
#pragma once

#include <string>
#include <vector>

#include "compiler/build/backend/backend.h"
#include "runtime/base/error.h"

namespace meld {

// Makes two ELF objects, to be linked together, from a module in LLVM's bitcode as Clang's front end leaves it. Functions that may not be
// inlined (MELD_STEP) are divided between them; everything else goes with its users, into both objects if both use it. The same bitcode is
// always divided in the same way. Uses two threads; may be called from several at once.
Result<std::vector<std::string>> compile_halves(const std::string& bitcode, const ObjectOptions& options);

}  // namespace meld
