// Gathers bytes of all processes at process 0.
#pragma once

#include <cstddef>
#include <vector>

#include "runtime/comm/transport/communicator.h"

namespace meld::comm {

// Collective. Process 0 receives every process's argument, ordered by process number; the others receive an empty list.
std::vector<std::vector<std::byte>> gather_to_root(Communicator& comm, std::vector<std::byte> mine);

}  // namespace meld::comm
