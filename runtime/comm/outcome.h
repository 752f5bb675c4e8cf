// The result of an operation that one process did alone, such as writing a file, for all processes.
#pragma once

#include "runtime/base/error.h"
#include "runtime/comm/communicator.h"

namespace meld::comm {

// The result of process 0, on every process. Collective; the arguments of the other processes are ignored.
Result<void> outcome_of_first(Communicator& comm, const Result<void>& mine);

}  // namespace meld::comm
