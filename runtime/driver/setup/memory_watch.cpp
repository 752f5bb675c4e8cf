#include "runtime/driver/setup/memory_watch.h"

#include <fmt/format.h>

#include <algorithm>

#include "runtime/base/process/available_memory.h"
#include "runtime/base/units.h"
#include "runtime/comm/transport/collective_result.h"
#include "runtime/sim/core/subdomain.h"

namespace meld::driver {

namespace {

// Fewer have room in any process.
constexpr std::uint64_t kMany = 1000;
// By how much those of a tick may be expected to be more than those of the tick before.
constexpr double kMostTimes = 4;
// Arrays are copied when they grow: the peak of a tick in which all of them double is three times what was there, and the last peak, by
// which those to come are judged, was half as much again as there is now.
constexpr double kCopies = 1.5;

}  // namespace

Result<void> RoomToGrow::start(sim::Subdomain& subdomain) {
    start_bytes_ = resident_memory().now;
    start_catoms_ = catoms_ = subdomain.world.is_graph() ? subdomain.world.graph->nodes() : subdomain.next_id();
    return {};
}

Result<void> RoomToGrow::after(sim::Subdomain& subdomain) {
    const std::uint64_t catoms = subdomain.totals.catoms, came = catoms - std::min(catoms, catoms_), before = came_;
    catoms_ = catoms;
    came_ = came;
    // A single burst, after which it is quiet, has been survived.
    if (came < kMany || before == 0 || catoms <= start_catoms_) return {};
    const double times = std::min(kMostTimes, static_cast<double>(came) / static_cast<double>(before));
    return comm::outcome_of_all(subdomain.comm, check(subdomain, static_cast<std::uint64_t>(times * static_cast<double>(came))));
}

Result<void> RoomToGrow::check(const sim::Subdomain& subdomain, std::uint64_t expected) const {
    const ResidentMemory has = resident_memory();
    const auto grown_bytes = static_cast<double>(has.peak - std::min(has.peak, start_bytes_));
    const double each = grown_bytes / static_cast<double>(catoms_ - start_catoms_);
    const auto needed = static_cast<std::uint64_t>(std::min(1e18, kCopies * each * static_cast<double>(expected) * processes_here_));
    const MemoryLimit limit = memory_limit(subdomain.world.limits.memory_bytes);
    const std::uint64_t taken = limit.of_all ? has.now * static_cast<std::uint64_t>(processes_here_) : 0;
    if (limit.bytes == 0 || has.peak == 0 || taken + needed <= limit.bytes) return {};
    return fail(
        fmt::format("{} catoms came in tick {}, and there are {}; as fast as they come, the next tick takes {} more, and {}",
                    format_count(static_cast<double>(came_)), subdomain.tick(), format_count(static_cast<double>(catoms_)),
                    format_bytes(needed), limit.text),
        limit.of_all ? "Let the program make fewer, or raise [limits] memory" : "Let the program make fewer, or run on more machines",
        ExitCode::LimitHit);
}

}  // namespace meld::driver
