// `meldsim export`: what is shown of a run, for other programs.
#pragma once

#include "runtime/base/error.h"
#include "runtime/driver/pictures/frame_observer.h"
#include "runtime/driver/setup/options.h"

namespace meld::driver {

// Goes to each tick and writes what is there; ticks are in the file in their order. Every process calls it.
Result<int> export_run(const RunOptions& options, Onlooker& onlooker);

}  // namespace meld::driver
