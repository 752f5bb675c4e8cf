// What all processes know, brought to the one that speaks for them.
#pragma once

#include <cstddef>
#include <vector>

#include "runtime/comm/transport/communicator.h"

namespace meld::comm {

// On process 0 what each has given, in the order of processes; on others nothing. Every process calls it.
std::vector<std::vector<std::byte>> at_first(Communicator& comm, std::vector<std::byte> mine);

}  // namespace meld::comm
