// What one process did alone, such as writing a file, and all must know.
#pragma once

#include "runtime/base/error.h"
#include "runtime/comm/communicator.h"

namespace meld::comm {

// How it went on process 0, on every process. Collective; what the other processes give does not matter.
Result<void> outcome_of_first(Communicator& comm, const Result<void>& mine);

}  // namespace meld::comm
