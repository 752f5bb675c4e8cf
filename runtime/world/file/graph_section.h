// Worlds that are graphs: lattice = "graph".
#pragma once

#include "runtime/world/description/world.h"
#include "runtime/world/file/toml_reader.h"

namespace meld::world {

// The keys at the top of a world file that say which graph it is.
inline constexpr std::string_view kGraphKeys[] = {"graph", "links", "nodes", "directed", "acyclic"};

inline constexpr std::uint64_t kMaxGraph_bytes = std::uint64_t{16} << 30;

// graph = "ring(1000)", or links = "edges.csv" with nodes = "nodes.csv"; directed = true. Also reports what makes no sense in a graph.
void read_graph_world(TomlReader& reader, const Section& top, World& world);
// Reports what only worlds with cells have; returns whether there was nothing.
bool refuse_cells(TomlReader& reader, const Section& top);
// Reports keys of graphs in a world of another kind.
void refuse_graph_keys(TomlReader& reader, const Section& top);

}  // namespace meld::world
