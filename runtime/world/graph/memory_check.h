// Checks whether a graph fits into memory before it is made.
#pragma once

#include <string>

#include "runtime/base/error.h"
#include "runtime/base/process/available_memory.h"

namespace meld::graph {

// What make() takes for a link and for a node of an undirected graph without columns: the list of links beside the first table of ends,
// then that table beside the sorted one.
inline constexpr double kMaking_link = 16;
inline constexpr double kMaking_node = 24;

// Of all graphs.
inline constexpr double kMaxLinks = 2e9;

// `what` as a message begins: "complete(100000)", "web.mtx". The need is a lower bound.
Result<void> check_memory(const std::string& what, double nodes, double links, double need_bytes, const MemoryLimit& room);

}  // namespace meld::graph
