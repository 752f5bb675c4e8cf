// Tells all processes how an operation went that each, or only process 0, did by itself, such as writing a file.
#pragma once

#include "runtime/base/error.h"
#include "runtime/comm/transport/communicator.h"

namespace meld::comm {

// The result of process 0, on every process. Collective; the arguments of the other processes are ignored.
Result<void> outcome_of_first(Communicator& comm, const Result<void>& mine);

// An error if any process has one: that of the process with the lowest number. The same on every process. Collective.
Result<void> outcome_of_all(Communicator& comm, const Result<void>& mine);

}  // namespace meld::comm
