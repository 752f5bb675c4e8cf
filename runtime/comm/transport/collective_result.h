// What a process did by itself, such as writing a file, and all must know.
#pragma once

#include "runtime/base/error.h"
#include "runtime/comm/transport/communicator.h"

namespace meld::comm {

// The result of process 0, on every process. Collective; the arguments of the other processes are ignored.
Result<void> outcome_of_first(Communicator& comm, const Result<void>& mine);

// How it went on all processes, on every process: the error of the first that has one. Collective.
Result<void> outcome_of_all(Communicator& comm, const Result<void>& mine);

}  // namespace meld::comm
