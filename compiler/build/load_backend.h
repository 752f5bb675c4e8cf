// Opens the library with Clang in it.
#pragma once

#include "compiler/build/backend/backend.h"

namespace meld {

// Opened at the first call and kept until the process ends. Looked for in ../lib as seen from the program, then where the
// system keeps libraries. Any thread may call it.
Result<const Backend*> load_backend();

}  // namespace meld
