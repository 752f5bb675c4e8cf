#include "runtime/driver/memory_check.h"

#include <fmt/format.h>

#include "runtime/base/available_memory.h"
#include "runtime/base/units.h"

namespace meld::driver {

namespace {

// Id, site, state, dirty word, agenda and brick cell of a catom, with room for bricks that are not full.
constexpr double kBookkeeping = 30;
// A body with its contacts and the copy of its state (measured in blocks of 64,000 and 216,000 that touch), its places and links.
constexpr double kBodyBytes = 550;
// The rows that a predicate with rows storage is likely to have: one, in a block of 16 bytes or more.
constexpr double kRowBytes = 32;

}  // namespace

Result<std::uint64_t> check_memory(const world::World& world, const ModuleInfo& module, int processes, int processes_here) {
    const Result<world::WorldSize> size = world::measure(world);
    if (!size) return tl::unexpected<Error>(size.error());
    double bytes = kBookkeeping + (world.is_free() ? kBodyBytes : 0);
    for (u32 i = 0; i < module.column_count; ++i) bytes += module.columns[i].stride + (module.columns[i].rows ? kRowBytes : 0);
    const double here = size->cells_estimate * bytes * static_cast<double>(processes_here) / static_cast<double>(processes);
    const AvailableMemory available = available_memory();
    const bool allowed = world.limits.memory_bytes > 0;
    const std::uint64_t limit = allowed ? world.limits.memory_bytes : available.bytes;
    const auto needed = here < 1.8e19 ? static_cast<std::uint64_t>(here) : ~std::uint64_t{0};
    if (limit > 0 && needed > limit)
        return fail(fmt::format("the world needs {} for {} catoms of {:.0f} bytes, and {} are {}", format_bytes(needed),
                                format_count(size->cells_estimate), bytes, format_bytes(limit),
                                allowed                         ? "allowed by [limits] memory"
                                : available.by == "the machine" ? "available"
                                                                : "left by " + available.by),
                    "Make the body smaller, or run on more machines", ExitCode::LimitHit);
    return static_cast<std::uint64_t>(static_cast<double>(needed) / processes_here);
}

}  // namespace meld::driver
