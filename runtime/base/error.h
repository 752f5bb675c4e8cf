// The error value for a problem outside the program (a file, a disk, a version, a number of processes).
#pragma once

#include <string>
#include <tl/expected.hpp>
#include <utility>

namespace meld {

// The exit codes every command documents.
enum class ExitCode : int {
    Fine = 0,
    ProgramWrong = 1,
    UsageOrWorld = 2,
    PropertyFailed = 3,
    LimitHit = 4,
    ModuleRefused = 5,
    RecordingRefused = 6,
    OurBug = 70,
    Interrupted = 130,
};

// problem: what is wrong and why, a clause without a full stop; suggestion: what to do, may be empty.
struct Error {
    std::string problem;
    std::string suggestion = {};
    ExitCode code = ExitCode::UsageOrWorld;

    // "problem. suggestion." as it is shown to the user.
    std::string message() const { return suggestion.empty() ? problem : problem + ". " + suggestion; }
};

template <class T>
using Result = tl::expected<T, Error>;

inline tl::unexpected<Error> fail(std::string problem, std::string suggestion = {}, ExitCode code = ExitCode::UsageOrWorld) {
    return tl::unexpected<Error>(Error{std::move(problem), std::move(suggestion), code});
}

}  // namespace meld
