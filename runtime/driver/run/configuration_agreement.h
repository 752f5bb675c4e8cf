// The processes of a run must agree before the first tick: a launcher may start each with a different command, and on another machine a
// file may differ. Without this check they would run together and give a meaningless result.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "runtime/base/error.h"
#include "runtime/comm/transport/communicator.h"

namespace meld::driver {

// A property that must be the same on all processes.
struct Claim {
    std::string name;   // As in messages: "the world".
    std::string shown;  // This process's value, for people.
    std::uint64_t hash = 0;
    ExitCode code = ExitCode::UsageOrWorld;  // The exit code of a run whose processes differ in it.
    bool what_it_is = true;                  // It says what the run is; else only how far it goes, or where its results go.
};

// Compares the properties of all processes, or reports to all that some could not determine theirs. Collective; every process gets the same
// result. Errors: the first error of a process, with its number unless all have it; or what differs, and on which processes. Cost: one
// exchange of a few hundred bytes per process.
Result<void> agree(comm::Communicator& comm, const Result<std::vector<Claim>>& mine);

}  // namespace meld::driver
