// The files that a run writes: checks that they are distinct, and that only this run writes them.
#pragma once

#include <optional>
#include <string>

#include "runtime/base/output_file.h"
#include "runtime/driver/options.h"

namespace meld::driver {

// `world` is the path of the world, empty if there is none. Errors: two options name one file or one stream.
Result<void> check_outputs(const RunOptions& options, const std::string& world);

struct Outputs {
    std::optional<OutputFile> facts;
    std::optional<OutputFile> digest;
};

// Opens them before the run, so that a long run does not find out at its end that they cannot be written.
Result<void> open_outputs(const RunOptions& options, Outputs& outputs);

// Whether results go to standard output, and everything else to standard error.
bool results_at_standard_output(const RunOptions& options);

}  // namespace meld::driver
