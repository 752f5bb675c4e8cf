#include "runtime/driver/setup/memory_check.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstdint>

#include "runtime/base/process/available_memory.h"
#include "runtime/base/units.h"

namespace meld::driver {

namespace {

std::uint64_t whole_bytes(double bytes) { return bytes < 1.8e19 ? static_cast<std::uint64_t>(bytes) : ~std::uint64_t{0}; }

// What all processes of this machine need together.
ByteRange needed(const MemoryNeed& need, const MemoryLimit& limit, int processes_here) {
    const ByteRange one = limit.of_all ? need.peak() : need.made();
    return {one.least * processes_here, one.most * processes_here};
}

}  // namespace

Result<void> check_memory(const world::World& world, const MemoryNeed& need, int processes_here) {
    const MemoryLimit limit = memory_limit(world.limits.memory_bytes);
    const double least = needed(need, limit, processes_here).least;
    if (limit.bytes == 0 || whole_bytes(least) <= limit.bytes) return {};
    return fail(fmt::format("the world needs {} for {} catoms of {:.0f} bytes, and {}", format_bytes(whole_bytes(least)),
                            format_count(need.catoms), need.made().least / std::max(1.0, need.own_catoms), limit.text),
                "Make the body smaller, or run on more machines", ExitCode::LimitHit);
}

std::string warning_of_memory(const world::World& world, const MemoryNeed& need, int processes_here) {
    const MemoryLimit limit = memory_limit(world.limits.memory_bytes);
    const ByteRange bytes = needed(need, limit, processes_here);
    if (limit.bytes == 0 || whole_bytes(bytes.most) <= limit.bytes) return "";
    return fmt::format("the run needs {} to {}, and {}. The larger number assumes {}", format_bytes(whole_bytes(bytes.least)),
                       format_bytes(whole_bytes(bytes.most)), limit.text, kMemoryAssumed);
}

}  // namespace meld::driver
