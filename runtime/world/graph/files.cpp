#include "runtime/world/graph/files.h"

#include <fmt/format.h>

namespace meld::graph {

Result<Graph> read_graph(const FileText& links, const std::optional<FileText>& nodes, std::optional<bool> directed,
                         const MemoryLimit& room) {
    const auto ends_in = [&](std::string_view ending) { return links.path.ends_with(ending); };
    for (const std::string_view ending : {".graphml", ".gml", ".gexf", ".pajek", ".net", ".xlsx", ".gz", ".zip", ".npz"})
        if (ends_in(ending))
            return fail(fmt::format("{} is no form of graphs that is read here", links.path),
                        "write a list of links, or with networkx json.dump(networkx.node_link_data(G), file) to a file .json");
    Result<Table> table = ends_in(".mtx") ? read_matrix_market(links) : ends_in(".json") ? read_node_link(links) : read_list(links);
    if (!table) return tl::unexpected<Error>(table.error());
    if (nodes)
        if (const auto added = read_nodes(*nodes, *table); !added) return tl::unexpected<Error>(added.error());
    return graph_of(std::move(*table), directed, room);
}

Result<Graph> read_graph(const FileText& list, std::uint64_t nodes, std::optional<bool> directed, const MemoryLimit& room) {
    Result<Table> table = read_list(list);
    if (!table) return tl::unexpected<Error>(table.error());
    table->node_count = nodes;
    return graph_of(std::move(*table), directed, room);
}

Result<Graph> read_points(const FileText& nodes, const MemoryLimit& room) {
    Table table;
    table.path = nodes.path;
    if (auto read = read_nodes(nodes, table); !read) return tl::unexpected<Error>(read.error());
    Result<Graph> graph = graph_of(std::move(table), std::nullopt, room);
    if (graph && graph->places.empty())
        return fail(nodes.path + " has no columns x and y of numbers, so its nodes have no places",
                    "let its first line be x,y or node,x,y,z");
    return graph;
}

}  // namespace meld::graph
