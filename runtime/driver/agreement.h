// The processes of a run must be of one mind before the first tick: a launcher may start each with a command of its own, and on
// another machine a file may be another one. Without this they would run together and give a result that belongs to no program.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "runtime/base/error.h"
#include "runtime/comm/communicator.h"

namespace meld::driver {

// Something that all processes must have alike.
struct Claim {
    std::string name;   // As messages have it: "the world".
    std::string shown;  // What this process has, for people.
    std::uint64_t hash = 0;
    ExitCode code = ExitCode::UsageOrWorld;  // Of a run whose processes differ in it.
};

// Compares what all processes have, or tells all of them that some could not even find out. Collective; every process gets the same
// result. Errors: the first error of a process, with its number if not all have it; or what differs, and on which processes.
// Cost: one exchange of a few hundred bytes a process.
Result<void> agree(comm::Communicator& comm, const Result<std::vector<Claim>>& mine);

}  // namespace meld::driver
