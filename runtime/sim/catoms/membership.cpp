#include "runtime/sim/catoms/membership.h"

#include <algorithm>
#include <cmath>

#include "runtime/base/assert.h"
#include "runtime/base/hash.h"
#include "runtime/base/release_memory.h"
#include "runtime/engine/tuple/facts.h"
#include "runtime/module/abi/senses.h"
#include "runtime/world/shapes/nearest_cell.h"

namespace meld::sim {

namespace {

// Draws of compasses are not those of anything else.
constexpr std::uint64_t kCompassDraw = 0x636f6d70617373ull;

bool reads_positions(const ModuleInfo& module) {
    for (const auto& [name, arity, source] : sense_names()) {
        if (!info(source).has(SenseInfo::kCentre)) continue;
        const std::optional<u32> p = tuple::find_sensed(module, name, arity);
        if (p && module.predicates[*p].storage == Storage::World && module.predicates[*p].read) return true;
    }
    return false;
}

// The compass of an amoebot, by the seed and its id, as Geometry has it.
std::function<std::uint8_t(std::uint64_t)> compasses(const world::World& world) {
    return [seed = world.seed, options = world.motion.amoebots](std::uint64_t id) {
        const std::uint64_t drawn = hash_combine(hash_combine(seed, kCompassDraw), id);
        const auto first = options.own_compass ? static_cast<std::uint8_t>((drawn >> 8) % kDirections) : std::uint8_t{0};
        const bool left = options.own_chirality && (drawn & 1) != 0;
        return static_cast<std::uint8_t>(first | (left ? kLeftHanded : 0));
    };
}

}  // namespace

Cell nearest_cell(const world::Vec3& position) { return world::nearest_cell(position); }

Membership::Membership(const ModuleInfo& module, const world::World& world, const world::Target& target, const comm::Communicator& comm)
    : ensemble(world.cells_and_ports(), target),
      rank_(comm.process()),
      ranks_(comm.processes()),
      // Nodes are sensed where they are.
      senses_positions_(!world.is_graph() && reads_positions(module)) {
    if (module.by_links) ensemble.keep_links(world.apart());
    if (world.is_graph()) {
        ensemble.set_graph();
        nodes.emplace(*world.graph, world.has_moving_nodes());
    }
    if (world.has_amoebots()) ensemble.set_amoebots(compasses(world));
    if (!world.is_free()) return;
    ensemble.set_free(world.target ? [shape = *world.target](const world::Vec3& at) { return shape.contains(at); }
                                   : std::function<bool(const world::Vec3&)>(),
                      world.links ? world::Ensemble::Ports::Any : world::Ensemble::Ports::Twelve);
}

int Membership::owner_of(Catom catom) const {
    MELD_EXPECT(catom < ensemble.index_count() && ensemble.state(catom) != kCatomFree, "catom {}", catom);
    if (ranks_ == 1) return rank_;
    return ensemble.is_free() ? owners_[catom] : halo->owner(ensemble.cell(catom));
}

Catom Membership::add_freely(std::uint64_t id, const world::Vec3& position, CatomState state, int owner) {
    MELD_EXPECT(owner >= 0 && owner < ranks_ && (state == kCatomOwned) == (owner == rank_), "catom @{} of process {}", id, owner);
    const Catom catom = ensemble.add_at(id, position, state);
    const std::size_t count = ensemble.index_count();
    if (senses_positions_) {
        sensed_positions_.resize(count);
        sensed_positions_[catom] = position;
    }
    if (ranks_ > 1) {
        owners_.resize(count);
        owners_[catom] = owner;
    }
    return catom;
}

void Membership::set_owner(Catom catom, int owner) {
    MELD_EXPECT(catom < owners_.size() && owner >= 0 && owner < ranks_, "catom {} of process {}", catom, owner);
    owners_[catom] = owner;
}

void Membership::sense_position(Catom catom, const world::Vec3& position) {
    MELD_EXPECT(senses_positions_ && catom < sensed_positions_.size(), "catom {}", catom);
    sensed_positions_[catom] = position;
}

Cell Membership::start_cell(Catom catom) const {
    MELD_EXPECT(has_start_cell(catom), "catom {}", catom);
    return start_cells_[catom];
}

void Membership::forget_start_cells() { release_memory(start_cells_); }

Cell Membership::cell_in_regions(Catom catom) const {
    if (!ensemble.is_free()) return ensemble.cell(catom);
    return has_start_cell(catom) ? start_cell(catom) : nearest_cell(ensemble.position(catom));
}

void Membership::reserve_freely(std::size_t start, std::size_t room) {
    ensemble.reserve_free(room);
    start_cells_.reserve(start);
    if (senses_positions_) sensed_positions_.reserve(room);
    if (ranks_ > 1) owners_.reserve(room);
}

void Membership::reserve_nodes(std::size_t catoms, std::size_t ports) {
    ensemble.reserve_nodes(catoms, ports);
    if (senses_positions_) sensed_positions_.reserve(catoms);
    if (ranks_ > 1) owners_.reserve(catoms);
}

void Membership::start_freely(std::uint64_t id, Cell cell, const world::Vec3& position) {
    [[maybe_unused]] const Catom catom = add_freely(id, position, kCatomOwned, rank_);
    MELD_ASSERT(catom == start_cells_.size(), "catom {} starts after {}", catom, start_cells_.size());
    start_cells_.push_back(cell);
}

std::size_t Membership::bytes() const {
    return ensemble.bytes() + sensed_positions_.capacity() * sizeof(world::Vec3) + owners_.capacity() * sizeof(owners_[0]) +
           (nodes ? nodes->bytes() : 0);
}

}  // namespace meld::sim
