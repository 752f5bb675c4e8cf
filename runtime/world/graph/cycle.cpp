#include "runtime/world/graph/cycle.h"

#include <algorithm>

namespace meld::graph {

// Depth first, without recursion: a graph may be one long line.
std::vector<Node> cycle(const Graph& graph) {
    enum class Seen : char { No, OnTheWay, Done };
    std::vector<Seen> seen(graph.nodes(), Seen::No);
    std::vector<std::uint64_t> next(graph.first.begin(), graph.first.end() - 1);
    std::vector<Node> way;
    for (Node start = 0; start < graph.nodes(); ++start) {
        if (seen[start] != Seen::No) continue;
        way.push_back(start);
        seen[start] = Seen::OnTheWay;
        while (!way.empty()) {
            const Node node = way.back();
            if (next[node] == graph.first[node + 1]) {
                seen[node] = Seen::Done;
                way.pop_back();
                continue;
            }
            const std::uint64_t at = next[node]++;
            if (!graph.leads(at)) continue;
            const Node to = graph.to[at];
            if (seen[to] == Seen::OnTheWay) return {std::ranges::find(way, to), way.end()};
            if (seen[to] == Seen::Done) continue;
            seen[to] = Seen::OnTheWay;
            way.push_back(to);
        }
    }
    return {};
}

}  // namespace meld::graph
