#include "runtime/driver/shrink/start_catoms.h"

#include "runtime/world/description/populate.h"
#include "runtime/world/graph/part.h"
#include "runtime/world/shapes/nearest_cell.h"

namespace meld::driver {

StartCatoms StartCatoms::of(const world::World& world) {
    StartCatoms out;
    if (world.is_free()) return out;
    out.graph_ = world.is_graph();
    if (out.graph_) {
        const graph::Graph& graph = *world.graph;
        for (graph::Node node = 0; node < graph.nodes(); ++node) {
            const world::Vec3 at = {graph.places[node][0], graph.places[node][1], 0};
            out.all_.push_back({graph.id(node), world::nearest_cell(at), at});
        }
        for (const graph::Entry& link : graph::entries(graph)) out.links_.emplace_back(link.node, graph.to[link.at]);
    } else {
        const world::Lattice lattice(world.lattice);
        std::vector<std::uint32_t> numbers;
        for (const auto& [brick, count] : world::count_bricks(world, lattice, 0, 1)) {
            world::cells_of_brick(world, lattice, brick, numbers);
            for (const std::uint32_t number : numbers) {
                const world::Cell cell = lattice.cell_in_brick(lattice.brick_at(brick), number);
                out.by_cell_[cell] = out.all_.size();
                out.all_.push_back({out.all_.size(), cell, lattice.position(cell)});
            }
        }
        for (std::size_t i = 0; i < out.all_.size(); ++i)
            for (int port = 0; port < lattice.ports(); ++port) {
                const std::optional<std::size_t> beside = out.at(lattice.neighbour(out.all_[i].cell, port));
                if (beside && *beside > i) out.links_.emplace_back(i, *beside);
            }
    }
    for (std::size_t i = 0; i < out.all_.size(); ++i) out.by_id_[out.all_[i].id] = i;
    return out;
}

const StartCatoms::One* StartCatoms::find(std::uint64_t id) const {
    const auto found = by_id_.find(id);
    return found == by_id_.end() ? nullptr : &all_[found->second];
}

std::optional<std::size_t> StartCatoms::at(const world::Cell& cell) const {
    const auto found = by_cell_.find(cell);
    return found == by_cell_.end() ? std::nullopt : std::optional(found->second);
}

std::vector<std::size_t> StartCatoms::in(const world::Region& region) const {
    std::vector<std::size_t> out;
    for (std::size_t i = 0; i < all_.size(); ++i)
        if (region.contains(all_[i].id, all_[i].cell, all_[i].position)) out.push_back(i);
    return out;
}

}  // namespace meld::driver
