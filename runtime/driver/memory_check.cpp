#include "runtime/driver/memory_check.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstdint>

#include "runtime/base/available_memory.h"
#include "runtime/base/units.h"

namespace meld::driver {

namespace {

std::uint64_t whole_bytes(double bytes) { return bytes < 1.8e19 ? static_cast<std::uint64_t>(bytes) : ~std::uint64_t{0}; }

struct Limit {
    std::uint64_t bytes = 0;  // 0: none.
    std::string text;         // "16 GiB are allowed by [limits] memory"
    bool of_all = false;      // It counts what the processes have already.
};

Limit limit_of(const world::World& world) {
    if (const std::uint64_t allowed = world.limits.memory_bytes; allowed > 0)
        return {allowed, fmt::format("{} are allowed by [limits] memory", format_bytes(allowed)), true};
    const AvailableMemory available = available_memory();
    return {
        available.bytes,
        fmt::format("{} are {}", format_bytes(available.bytes), available.by == "the machine" ? "available" : "left by " + available.by),
        false};
}

// What all processes of this machine need together.
ByteRange needed(const MemoryNeed& need, const Limit& limit, int processes_here) {
    const ByteRange one = limit.of_all ? need.peak() : need.made();
    return {one.least * processes_here, one.most * processes_here};
}

}  // namespace

Result<void> check_memory(const world::World& world, const MemoryNeed& need, int processes_here) {
    const Limit limit = limit_of(world);
    const double least = needed(need, limit, processes_here).least;
    if (limit.bytes == 0 || whole_bytes(least) <= limit.bytes) return {};
    return fail(fmt::format("the world needs {} for {} catoms of {:.0f} bytes, and {}", format_bytes(whole_bytes(least)),
                            format_count(need.catoms), need.made().least / std::max(1.0, need.own_catoms), limit.text),
                "Make the body smaller, or run on more machines", ExitCode::LimitHit);
}

std::string warning_of_memory(const world::World& world, const MemoryNeed& need, int processes_here) {
    const Limit limit = limit_of(world);
    const ByteRange bytes = needed(need, limit, processes_here);
    if (limit.bytes == 0 || whole_bytes(bytes.most) <= limit.bytes) return "";
    return fmt::format("the run needs {} to {}, and {}. The larger number assumes {}", format_bytes(whole_bytes(bytes.least)),
                       format_bytes(whole_bytes(bytes.most)), limit.text, kMemoryAssumed);
}

}  // namespace meld::driver
