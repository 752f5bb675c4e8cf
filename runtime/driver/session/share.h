// `meldsim view --share`: a run as a page of its own.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "runtime/base/error.h"
#include "runtime/comm/transport/communicator.h"
#include "runtime/driver/setup/options.h"
#include "runtime/results/record/drawing.h"
#include "runtime/results/timeline/timeline.h"
#include "runtime/world/description/world.h"

namespace CLI {
class App;
}

namespace meld::driver {

// The options of such a page.
void add_share(CLI::App& app, ShareOrder& order);
// The same, as the processes of a run get them.
void add_share_arguments(const ShareOrder& order, std::vector<std::string>& words);

// Writes the page. Every process calls it; returns the exit code.
Result<int> share_run(const RunOptions& options, const world::World& world, comm::Communicator& comm, timeline::Timeline& timeline,
                      const std::function<record::Drawing&()>& drawing);

}  // namespace meld::driver
