// The catoms of a world where they start, with their links: for those who name them one by one.
#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <unordered_map>
#include <utility>
#include <vector>

#include "runtime/world/description/world.h"

namespace meld::driver {

class StartCatoms {
  public:
    // Those on a lattice or in a graph, by their numbers; of bodies there are none. Cost: linear in catoms.
    static StartCatoms of(const world::World& world);

    struct One {
        std::uint64_t id = 0;
        world::Cell cell = {};
        world::Vec3 position = {};
    };
    const std::vector<One>& all() const { return all_; }
    // By their places in all(), each once.
    const std::vector<std::pair<std::size_t, std::size_t>>& links() const { return links_; }
    bool in_graph() const { return graph_; }
    const One* find(std::uint64_t id) const;
    // The place in all() of the one that stands on a cell of a lattice.
    std::optional<std::size_t> at(const world::Cell& cell) const;
    std::vector<std::size_t> in(const world::Region& region) const;

  private:
    std::vector<One> all_;
    std::vector<std::pair<std::size_t, std::size_t>> links_;
    std::unordered_map<std::uint64_t, std::size_t> by_id_;
    std::map<world::Cell, std::size_t> by_cell_;  // On a lattice.
    bool graph_ = false;
};

}  // namespace meld::driver
