// Opens the library that has what pictures and the viewer need.
#pragma once

#include "runtime/base/error.h"

namespace meld::show {

// Before a picture is made or a page is served. Searched in ../lib/claymeld relative to the program, then where the system keeps libraries.
// Errors: it is not there, or one of the libraries that it needs. Any thread may call it.
Result<void> need_view();

}  // namespace meld::show
