// Graphs that have a name.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "runtime/base/error.h"
#include "runtime/base/process/available_memory.h"
#include "runtime/world/graph/graph.h"

namespace meld::graph {

// The graph of a text such as "ring(1000)" or "scale_free(1M, 8)". Nodes are 0 .. n - 1; places are given where the graph has a form of its
// own. The same for a seed on every process. Errors: no such generator, with the nearest name; arguments that make no graph; more nodes or
// links than there may be, or than `room` has place for. Cost: linear in nodes and links.
Result<Graph> generate(std::string_view text, std::uint64_t seed, const MemoryLimit& room = {});

// Whether a text such as "disc(100, 20)" asks for points without links; also if it is wrong.
bool makes_points(std::string_view text);

// "ring(n)", "grid(w, h)", ... with a sentence for each, for messages and the documentation.
struct GeneratorInfo {
    std::string_view name, arguments, meaning;
};
const std::vector<GeneratorInfo>& generators();

}  // namespace meld::graph
