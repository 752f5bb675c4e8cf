#include "runtime/driver/run/replay_without_outputs.h"

#include <algorithm>

namespace meld::driver {

std::vector<std::string> writing_modules(const RunOptions& options) {
    std::vector<std::string> names;
    if (!options.record.empty()) names.emplace_back("recorder");
    if (options.measured()) names.emplace_back("statistics");
    names.insert(names.end(), {"printer", "watcher"});
    if (std::ranges::any_of(kWatches, [&](const BodiesOption& watch) { return !(options.*watch.bodies).empty(); }))
        names.emplace_back("watches");
    if (!options.digest.empty()) names.emplace_back("digests");
    return names;
}

}  // namespace meld::driver
