// Nodes of a graph from a snapshot, which says which of them are left, and which rules have made; their links follow from the graph.
#include <fmt/format.h>

#include <vector>

#include "runtime/comm/transport/collective_result.h"
#include "runtime/sim/core/setup/graph_setup.h"
#include "runtime/sim/state/loader.h"
#include "runtime/sim/state/reading.h"

namespace meld::sim {

Result<FreePlaces> Loader::nodes(std::size_t share, std::size_t chunk) {
    const Result<BlockView> block = shares_.places(share, chunk, room_);
    if (!block) return tl::unexpected<Error>(block.error());
    ByteReader in = reader(*block, "the nodes of a snapshot");
    Result<FreePlaces> all = FreePlaces::read(in);
    if (auto whole = read_to_its_end(in, "its nodes"); !whole) return tl::unexpected<Error>(whole.error());
    return all;
}

Result<void> Loader::add_nodes() {
    Nodes& all_nodes = *subdomain_.members_.nodes;
    for (const Failed::Made& made : failed_.made()) all_nodes.add(made.id, made.maker);
    std::vector<bool> left(all_nodes.count());
    Result<void> known = failed_.check_joined(all_nodes);
    if (known && subdomain_.world.has_moving_nodes()) known = failed_.place(all_nodes);
    if (known)
        known = each_chunk([&](std::size_t share, std::size_t chunk) -> Result<void> {
            const Result<FreePlaces> all = nodes(share, chunk);
            if (!all) return tl::unexpected<Error>(all.error());
            for (const graph::Node node : all->ids()) {
                if (node >= left.size()) return damaged(fmt::format("has node number {}, and the graph has {}", node, left.size()));
                if (left[node]) return damaged(fmt::format("has catom @{} twice", all_nodes.id(node)));
                left[node] = true;
            }
            return {};
        });
    // They place the nodes together.
    if (auto all = comm::outcome_of_all(subdomain_.comm, known); !all) return all;
    populate_graph(subdomain_.members_, *subdomain_.world.graph, subdomain_.comm, &left, failed_.joined());
    return each_chunk([&](std::size_t share, std::size_t chunk) -> Result<void> {
        const Result<FreePlaces> all = nodes(share, chunk);
        if (!all) return tl::unexpected<Error>(all.error());
        PlacedChunk& found = found_[share].emplace_back();
        for (const graph::Node node : all->ids())
            if (const std::optional<Catom> catom = subdomain_.ensemble.find(all_nodes.id(node)))
                found.add(*catom, 1, subdomain_.owned(*catom));
            else
                found.pass(1);
        return {};
    });
}

}  // namespace meld::sim
