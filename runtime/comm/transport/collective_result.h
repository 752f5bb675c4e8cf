// Tells all processes how an operation went that each, or only process 0, did by itself, such as writing a file; or what it came to.
#pragma once

#include <cstring>
#include <span>
#include <type_traits>
#include <vector>

#include "runtime/base/error.h"
#include "runtime/comm/transport/communicator.h"

namespace meld::comm {

// The result of process 0, on every process. Collective; the arguments of the other processes are ignored.
Result<void> outcome_of_first(Communicator& comm, const Result<void>& mine);

// An error if any process has one: that of the process with the lowest number. The same on every process. Collective.
Result<void> outcome_of_all(Communicator& comm, const Result<void>& mine);

// The value of process 0, on every process. Collective; the values of the other processes are ignored.
template <class T>
    requires std::is_trivially_copyable_v<T>
T value_of_first(Communicator& comm, const T& mine) {
    const std::vector<std::byte> all = comm.allgather(std::as_bytes(std::span(&mine, 1)));
    T value;
    std::memcpy(&value, all.data(), sizeof value);
    return value;
}

}  // namespace meld::comm
