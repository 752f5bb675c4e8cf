// Worlds that are graphs: lattice = "graph".
#pragma once

#include "runtime/world/file/toml_reader.h"
#include "runtime/world/file/world_file.h"

namespace meld::world {

// The keys at the top of a world file that say which graph it is.
inline constexpr std::string_view kGraphKeys[] = {"graph", "links", "nodes", "directed", "acyclic"};

// graph = "ring(1000)", or links = "edges.csv" with nodes = "nodes.csv"; directed = true. Also reports what makes no sense in a graph.
void read_graph_world(TomlReader& reader, const Section& top, World& world);
// Reports keys of graphs in a world of another kind.
void refuse_graph_keys(TomlReader& reader, const Section& top);

}  // namespace meld::world
