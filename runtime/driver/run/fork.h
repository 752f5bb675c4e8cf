// `meldsim fork`: a run that branches off from a checkpoint, with another program, other constants, another seed or other events.
//
// It is the run of the checkpoint's command, with what is given anew, and with outputs of its own. The folder of the checkpoint and the
// files of its run are only read.
#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "runtime/base/error.h"
#include "runtime/driver/setup/options.h"
#include "runtime/sim/simulation.h"
#include "runtime/sim/state/checkpoint_folder.h"

namespace meld::driver {

// Where a run has branched off, and with what.
struct Forked {
    std::string folder;
    std::int64_t tick = 0;
    std::string digest;                // Of the state in the checkpoint.
    std::vector<std::string> changed;  // What is not as it was, as people know it.
    bool anew = false;                 // What rules derive is derived anew.
    sim::TakenOver facts;              // What became of the facts then.
};

struct ForkOptions {
    std::string folder = {};
    RunOptions run = {};  // What is given anew; the rest is empty.
};

// Returns the exit code. Prints its own messages. `parse` reads a command line of `meldsim run`.
int fork_command(ForkOptions options, const ParseRun& parse);

// Sets a simulation up from the newest checkpoint in a folder; `now` is the run that branches off. Every process calls it. Errors: there is
// no checkpoint that is whole, or it is of another version; something differs that cannot; facts cannot be taken over.
Result<Forked> branch_off(const std::string& folder, const sim::RunIdentity& now, sim::Simulation& simulation,
                          const sim::Registry& registry);

// "tick 60 of kept; the program is not as it was"
std::string describe(const Forked& forked);
// "3 facts of got and 1 of token are dropped"
std::string describe_dropped(const Forked& forked);

}  // namespace meld::driver
