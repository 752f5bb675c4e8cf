// `meldsim bisect`: the first tick in which a Meld body holds at some catom, or no longer does.
#pragma once

#include <functional>
#include <memory>
#include <string>

#include "runtime/base/error.h"
#include "runtime/comm/transport/communicator.h"
#include "runtime/driver/setup/options.h"
#include "runtime/results/timeline/timeline.h"
#include "runtime/sim/state/checkpoint_folder.h"

namespace meld::driver {

// Of a program, a recording or a folder of checkpoints, as debug_command() takes them. Returns the exit code; prints its own messages.
int bisect_command(RunOptions options, std::string scratch, const ParseRun& parse);

// What is searched.
struct Searched {
    using Running = std::unique_ptr<timeline::Timeline>;
    // The run from this checkpoint on, or from its first tick.
    std::function<Result<Running>(const sim::OpenCheckpoint* from, std::size_t history_bytes)> begin;
    // The newest checkpoint of the run before a tick, or the newest one of all; nothing if none is asked for. Errors: there is none.
    std::function<Result<std::unique_ptr<sim::OpenCheckpoint>>(std::optional<std::int64_t> before)> checkpoint;
};

// Searches a run for the answer to its question, and prints it. Of a checkpoint in which the body holds already, it begins with the one
// before, if there is one. Every process calls it. Returns the exit code: 0 if there is such a tick, 3 if the run ends without one or it
// is not after the checkpoint. Errors: those of the run and of the body; it was interrupted. Cost: one run, with a search around what has
// changed after every tick; for the derivation of the witness a second run to that tick, with snapshots. Process 0 keeps all ways in which
// the body holds.
Result<int> find_tick(const RunOptions& options, const Searched& searched, comm::Communicator& comm);

}  // namespace meld::driver
