// The virtual cluster: processes that take turns in an order drawn by a seed, over messages that come as late and as mixed as MPI allows.
// What differs between two divisions of an ensemble, or hangs once in a thousand runs, is found here first and can be repeated.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <limits>

#include "runtime/comm/transport/communicator.h"

namespace meld::comm {

struct ClusterOptions {
    int processes = 1;
    std::uint64_t seed = 0;
    // The process that acts in this step is killed, and with it the run.
    std::uint64_t kill_at_step = std::numeric_limits<std::uint64_t>::max();
    // Packets longer than this travel as several messages.
    std::size_t chunk_bytes = 1024;
};

struct ClusterRun {
    std::uint64_t steps = 0;  // ClusterScheduler that were taken.
    std::uint64_t trace = 0;  // A hash of who took them: equal for equal options and bodies.
    int killed = -1;          // The process that was killed; -1: none.
};

// Runs body(communicator) for each process until all have returned or one is killed. Only one of them runs at a time, and hands over only
// while it communicates; each has a thread of its own, but nothing depends on threads. Who is next, how fast each is for a while, when
// a message can be seen, whether a send waits for its receiver, and which protocol an exchange follows are drawn by the seed.
// Rethrows the first exception of a body. Processes that wait for each other for ever, or call different operations, are a
// std::logic_error. Cost: some microseconds a turn, and some ten turns for each operation and process.
ClusterRun run_cluster(const ClusterOptions& options, const std::function<void(Communicator&)>& body);

}  // namespace meld::comm
