// A long module is optimised and made machine code in two halves at once, which takes little more than half the time.
#pragma once

#include <string>
#include <vector>

#include "compiler/build/backend/backend.h"
#include "runtime/base/error.h"

namespace meld {

// Makes two ELF objects, to be linked together, of a module in LLVM's bitcode as Clang's front end leaves it. Functions that
// may not be inlined (MELD_STEP) are shared out; everything else goes with whatever uses it, into both where both do. The
// same bitcode is always divided in the same way. Uses two threads; may be called from several at once.
Result<std::vector<std::string>> compile_halves(const std::string& bitcode, const ObjectOptions& options);

}  // namespace meld
