// METIS (Karypis and Kumar, "A fast and high quality multilevel scheme for partitioning irregular graphs", SIAM J. Sci. Comput. 1998).
#include "runtime/graph/divide.h"

#include <metis.h>

#include <algorithm>
#include <csignal>
#include <limits>

#include "runtime/base/assert.h"

namespace meld::graph {
namespace {

constexpr idx_t kSeed = 1;

// Where there are more links than METIS can count: nodes in order, with about the same work in each part.
std::vector<std::int32_t> in_order(const Graph& graph, int parts) {
    std::vector<std::int32_t> out(graph.nodes());
    const double all = static_cast<double>(graph.nodes() + graph.to.size());
    for (Node node = 0; node < graph.nodes(); ++node) {
        const double before = static_cast<double>(node + graph.first[node]);
        out[node] = std::min(parts - 1, static_cast<int>(before / all * parts));
    }
    return out;
}

}  // namespace

std::vector<std::int32_t> divide(const Graph& graph, int parts) {
    MELD_EXPECT(parts > 0, "{} parts", parts);
    const std::uint64_t nodes = graph.nodes();
    if (parts == 1) return std::vector<std::int32_t>(nodes, 0);
    if (nodes < 4 * static_cast<std::uint64_t>(parts) || graph.to.size() > std::numeric_limits<idx_t>::max()) return in_order(graph, parts);
    std::vector<idx_t> first(graph.first.begin(), graph.first.end()), to(graph.to.begin(), graph.to.end()), weights(nodes), part(nodes);
    for (Node node = 0; node < nodes; ++node) weights[node] = static_cast<idx_t>(1 + graph.degree(node));
    idx_t n = static_cast<idx_t>(nodes), constraints = 1, wanted = parts, links_cut = 0;
    idx_t options[METIS_NOPTIONS];
    METIS_SetDefaultOptions(options);
    options[METIS_OPTION_SEED] = kSeed;
    options[METIS_OPTION_NUMBERING] = 0;
    const int done = METIS_PartGraphKway(&n, &constraints, first.data(), to.data(), weights.data(), nullptr, nullptr, &wanted, nullptr,
                                         nullptr, options, &links_cut, part.data());
    // While it runs, METIS takes SIGTERM for an error of its own. Who has sent it meant the process.
    if (done == METIS_ERROR) std::raise(SIGTERM);
    if (done != METIS_OK) return in_order(graph, parts);
    return {part.begin(), part.end()};
}

std::uint64_t cut(const Graph& graph, const std::vector<std::int32_t>& part) {
    std::uint64_t count = 0;
    for (Node node = 0; node < graph.nodes(); ++node)
        for (const Node other : graph.neighbours(node)) count += node < other && part[node] != part[other] ? 1 : 0;
    return count;
}

}  // namespace meld::graph
