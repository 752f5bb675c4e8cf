// What a session of the debugger does with its run as a whole: it goes on with a program that has changed, and is saved as a checkpoint.
#pragma once

#include <string>
#include <utility>
#include <vector>

#include "runtime/ask/debug/answer.h"
#include "runtime/base/error.h"
#include "runtime/comm/transport/communicator.h"
#include "runtime/driver/run/configuration_agreement.h"
#include "runtime/driver/setup/inputs.h"
#include "runtime/driver/setup/options.h"
#include "runtime/results/timeline/timeline.h"
#include "runtime/sim/state/checkpoint_folder.h"

namespace meld::driver {

// A run that somebody walks through. Every process has one and calls all of it at the same time.
class DebuggedRun {
  public:
    // All of it outlives this. `claims` are of the inputs.
    DebuggedRun(const RunOptions& options, Inputs& inputs, std::vector<Claim> claims, comm::Communicator& comm)
        : options_(options), inputs_(inputs), claims_(std::move(claims)), comm_(comm) {}

    // Compiles the program again and goes on with it, if it is another one: facts as `meldsim fork` takes them over. `make` makes a
    // simulation of the inputs as they are then. Errors: the program does not compile, with what the compiler says; facts cannot be taken
    // over; the session's run has no program of its own. Then nothing has changed.
    Result<debug::Reloaded> reload(timeline::Timeline& timeline, const timeline::Timeline::Make& make);

    // Writes the state as a checkpoint into a new folder, of the run that `meldsim run` would be: without what a session has besides, and
    // with `events`, [[event]] tables of a world. Errors: those of a folder for checkpoints; the run cannot be started again as it is.
    Result<debug::Saved> save(sim::Simulation& simulation, const std::string& folder, const std::string& events);

  private:
    // On process 0: what the checkpoint says of the run, and its file of events.
    struct AsRun {
        sim::RunIdentity identity;
        std::string events;
    };
    Result<Module> compile(std::string& messages);
    Result<void> can_save() const;
    Result<AsRun> as_run(const std::string& folder, const std::string& events) const;

    const RunOptions& options_;
    Inputs& inputs_;
    std::vector<Claim> claims_;
    comm::Communicator& comm_;
};

}  // namespace meld::driver
