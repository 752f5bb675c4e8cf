// Which catoms a process knows: its own and ghosts of those next to them, their positions, and their owners.
#pragma once

#include <algorithm>
#include <cstdint>
#include <optional>
#include <vector>

#include "runtime/comm/transport/communicator.h"
#include "runtime/module/abi/module_abi.h"
#include "runtime/sim/catoms/nodes.h"
#include "runtime/world/description/world.h"
#include "runtime/world/ensemble/ensemble.h"
#include "runtime/world/ensemble/target.h"
#include "runtime/world/partition/partition.h"

namespace meld::sim {

using world::Catom;
using world::Cell;
using world::CellKey;

// The cell whose centre is nearest to a position in diameters.
Cell nearest_cell(const world::Vec3& position);

class Membership {
  public:
    Membership(const ModuleInfo& module, const world::World& world, const world::Target& target, const comm::Communicator& comm);

    bool owned(Catom catom) const { return ensemble.state(catom) == kCatomOwned; }
    // The process that owns this catom.
    int owner_of(Catom catom) const;
    // Calls visit(process) once for each other process that reads what this catom exports.
    template <class Visit>
    void subscribers(Catom catom, std::uint32_t site, const Visit& visit) const;

    // Catoms at arbitrary positions. A ghost has an owner.
    Catom add_freely(std::uint64_t id, const world::Vec3& position, CatomState state, int owner);
    // The other owners of catoms that this process knows.
    void set_owner(Catom catom, int owner);

    // The position that programs sense for a catom without a cell: it follows the catom in steps, as the world says.
    bool senses_positions() const { return senses_positions_; }
    world::Vec3 sensed_position(Catom catom) const {
        return sensed_positions_.empty() ? ensemble.position(catom) : sensed_positions_[catom];
    }
    void sense_position(Catom catom, const world::Vec3& position);
    // The cell in which a catom that moves freely starts; available until motion has started.
    bool has_start_cell(Catom catom) const { return catom < start_cells_.size(); }
    Cell start_cell(Catom catom) const;
    void forget_start_cells();
    // For regions: the catom's cell; if catoms move freely, the one in which it starts, later the one whose centre is nearest.
    Cell cell_in_regions(Catom catom) const;
    bool in_region(const world::Region& region, Catom catom) const {
        return region.contains(ensemble.id(catom), cell_in_regions(catom), ensemble.position(catom));
    }

    // Makes room for catoms at arbitrary positions, and places one of them at its start.
    void reserve_freely(std::size_t start, std::size_t room);
    void reserve_nodes(std::size_t catoms, std::size_t ports);
    void start_freely(std::uint64_t id, Cell cell, const world::Vec3& position);

    std::size_t bytes() const;

    world::Ensemble ensemble;
    // The owners of bricks, and the processes that read which cells; available from the set-up on.
    std::optional<partition::Partition> partition;
    std::optional<partition::Halo> halo;
    std::uint64_t next_id = 0;   // Of the whole ensemble.
    std::optional<Nodes> nodes;  // In a graph world.

  private:
    const int rank_, ranks_;
    const bool senses_positions_;
    std::vector<world::Vec3> sensed_positions_;  // By catom; empty where no rule reads positions.
    std::vector<std::int32_t> owners_;           // By catom at an arbitrary position; empty on one process.
    std::vector<Cell> start_cells_;              // By catom.
};

template <class Visit>
void Membership::subscribers(Catom catom, std::uint32_t site, const Visit& visit) const {
    if (!ensemble.is_free()) return halo->subscribers(site, visit);
    if (owners_.empty()) return;
    // The owners of its neighbours, each once; those beyond 64 by a search.
    std::uint64_t visited = 0;
    std::vector<int> more;
    ensemble.each_neighbour(catom, [&](Catom other) {
        if (owned(other)) return;
        const int owner = owners_[other];
        if (owner < 64) {
            if (visited >> owner & 1) return;
            visited |= std::uint64_t{1} << owner;
        } else {
            if (std::find(more.begin(), more.end(), owner) != more.end()) return;
            more.push_back(owner);
        }
        visit(owner);
    });
}

}  // namespace meld::sim
