#include "runtime/world/graph/part.h"

#include <algorithm>
#include <utility>

namespace meld::graph {
namespace {

Column rows_of(const Column& column, const std::vector<std::size_t>& rows) {
    Column out{.name = column.name, .values = column.values};
    std::visit(
        [&](const auto& all) {
            std::decay_t<decltype(all)> some;
            some.reserve(rows.size());
            for (const std::size_t row : rows) some.push_back(all[row]);
            out.values = std::move(some);
        },
        column.values);
    return out;
}

}  // namespace

std::vector<Entry> entries(const Graph& graph) {
    std::vector<Entry> out;
    for (Node node = 0; node < graph.nodes(); ++node)
        for (std::uint64_t at = graph.first[node]; at < graph.first[node + 1]; ++at)
            if (graph.directed ? graph.leads(at) : graph.to[at] > node) out.push_back({node, at});
    return out;
}

Graph part(const Graph& graph, const std::vector<Node>& nodes, const std::vector<Entry>& links) {
    std::vector<Node> number(graph.nodes(), static_cast<Node>(kMaxNodes));
    for (std::size_t i = 0; i < nodes.size(); ++i) number[nodes[i]] = static_cast<Node>(i);
    std::vector<Link> kept;
    std::vector<std::size_t> rows;
    for (const Entry& link : links) {
        const Node from = number[link.node], to = number[graph.to[link.at]];
        if (from == kMaxNodes || to == kMaxNodes) continue;
        kept.push_back({from, to});
        rows.push_back(graph.row.empty() ? 0 : graph.row[link.at]);
    }
    std::vector<Column> columns;
    for (const Column& column : graph.columns) columns.push_back(rows_of(column, rows));
    Graph out = make(nodes.size(), std::move(kept), graph.directed, std::move(columns)).graph;
    const std::vector<std::size_t> which(nodes.begin(), nodes.end());
    for (const Column& column : graph.node_columns) out.node_columns.push_back(rows_of(column, which));
    for (const Node node : nodes) {
        out.ids.push_back(graph.id(node));
        if (!graph.places.empty()) out.places.push_back(graph.places[node]);
    }
    return out;
}

}  // namespace meld::graph
