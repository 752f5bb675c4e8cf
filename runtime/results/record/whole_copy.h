// A copy of a recording in which every step is whole, for programs that do not know of steps that hold changes alone.
#pragma once

#include <cstddef>
#include <functional>
#include <string>

#include "runtime/base/error.h"
#include "runtime/results/record/recording_reader.h"

namespace meld::record {

// Writes the copy to a file. Calls before(step) before each step, and ends with its error if it has one. Errors: the recording is damaged
// (6), or the copy cannot be written. Memory: one step.
Result<void> copy_whole(RecordingReader& recording, const std::string& path, const std::function<Result<void>(std::size_t)>& before);

}  // namespace meld::record
