// `meldsim export RECORDING -o FILE.vtkhdf`: a recording in which every step is whole.
#pragma once

#include "runtime/driver/setup/options.h"

namespace meld::driver {

// Whether the file that is asked for is a recording.
bool is_recording_name(const std::string& path);
// Writes it, and prints what it is or what is wrong; no run is made. Returns the exit code.
int export_recording(const RunOptions& options);

}  // namespace meld::driver
