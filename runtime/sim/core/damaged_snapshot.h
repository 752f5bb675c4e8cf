// The error of all parts of a snapshot that do not say what they should.
#pragma once

#include <string>

#include "runtime/base/error.h"

namespace meld::sim {

// What: what is wrong with it, as "has 3 bytes too many".
inline tl::unexpected<Error> damaged(const std::string& what) {
    return fail("the snapshot " + what, "It is damaged, or was made by another version", ExitCode::RecordingRefused);
}

}  // namespace meld::sim
