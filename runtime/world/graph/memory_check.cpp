#include "runtime/world/graph/memory_check.h"

#include <fmt/format.h>

#include <cstdint>

#include "runtime/base/units.h"

namespace meld::graph {

Result<void> check_memory(const std::string& what, double nodes, double links, double need_bytes, const MemoryLimit& room) {
    if (room.bytes == 0 || need_bytes <= static_cast<double>(room.bytes)) return {};
    return fail(fmt::format("{}: {} nodes and about {} links take {} to make, and {}", what, format_count(nodes), format_count(links),
                            format_bytes(static_cast<std::uint64_t>(need_bytes)), room.text),
                "make it smaller", ExitCode::LimitHit);
}

}  // namespace meld::graph
