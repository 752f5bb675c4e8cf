// Opens the library that contains Clang.
#pragma once

#include "compiler/build/backend/backend.h"

namespace meld {

// Opened at the first call and kept until the process ends. Searched in ../lib relative to the program, then where the system keeps
// libraries. Any thread may call it.
Result<const Backend*> load_backend();

}  // namespace meld
