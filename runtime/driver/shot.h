// `meldsim shot`: a picture of a run at one tick or at several.
#pragma once

#include <functional>

#include "runtime/base/error.h"
#include "runtime/comm/communicator.h"
#include "runtime/driver/options.h"
#include "runtime/record/drawing.h"
#include "runtime/timeline/timeline.h"
#include "runtime/world/world_file.h"

namespace meld::driver {

// The last tick that is asked for; -1: only the end of the run. Errors: what is wrong with the options, before anything is run.
Result<std::int64_t> last_tick_of(const ShotOptions& options);

// Goes to each tick and takes the picture. `drawing` gives that of the timeline's present run. Every process calls it.
Result<int> take_shot(const RunOptions& options, const world::World& world, comm::Communicator& comm, timeline::Timeline& timeline,
                      const std::function<record::Drawing&()>& drawing);

// Errors: what is wrong with the options of a picture.
Result<void> check_view(const ShotOptions& options);

// Takes a picture of a run that has been started and has no program.
Result<void> shoot_start(const ShotOptions& shot, const world::World& world, sim::Subdomain& subdomain, record::Drawing& drawing);

}  // namespace meld::driver
