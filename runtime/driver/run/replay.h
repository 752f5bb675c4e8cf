// `meldsim replay`: makes the run of a recording again, from what the recording carries, and compares it with what was recorded.
//
// It is a run that records, into a folder of its own that goes at the end: the digest of the whole state is compared in every recorded
// step, and the two recordings tell which catom and which fact are behind a difference.
#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "runtime/base/error.h"
#include "runtime/comm/transport/communicator.h"
#include "runtime/driver/setup/options.h"
#include "runtime/driver/setup/scratch_folder.h"
#include "runtime/module/load/module.h"
#include "runtime/results/record/provenance.h"
#include "runtime/sim/simulation.h"
#include "runtime/world/description/world.h"

namespace meld::driver {

struct ReplayOptions {
    std::string recording = {};
    std::optional<std::int64_t> to = {};                  // The last tick; else that of the recording.
    std::vector<std::string> link = {}, extensions = {};  // Code that is not where it was.
    RunOptions run = {};                                  // Processes, threads, outputs; and how the processes are started.
    std::string scratch = {};                             // The folder, passed to the processes by the command that started them.
};

// The options of the run that is made again. Its files are in `own`, a folder that is made with this name, or in the one that the options
// name. Errors: the recording does not say how it was made, or is of another version; code that it names is not there.
Result<RunOptions> run_again(const ReplayOptions& options, std::string_view name, Scratch& own);

// Returns the exit code: 3 if the run is another than the recorded one. Prints its own messages.
int replay_command(const ReplayOptions& options);

// What a recording of this run must carry. Errors: a file that it was made of has changed since it was read.
Result<record::Provenance> provenance(const RunOptions& options, const ModuleInfo& module, const world::World& world);

// The world of a recording.
Result<world::World> recorded_world(const std::string& recording);

// Makes modules that compare the digest of each recorded step; the first that differs ends the run, with exit code 3. One for each
// simulation of the run.
using MakeModule = std::function<std::unique_ptr<sim::SimModule>()>;
Result<MakeModule> make_check(const std::string& recording);

// After the run: compares the two recordings and prints the outcome. The same on all processes. Errors: a difference, unless it was
// printed as JSON; that it was interrupted; and those of the run.
Result<int> end_replay(const RunOptions& options, const Result<void>& ran, std::int64_t tick, bool interrupted, comm::Communicator& comm);

}  // namespace meld::driver
