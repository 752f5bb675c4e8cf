// The block engine in a snapshot: block by block, each with its bodies in their slots, whether it rests, and the batches of its contacts.
// What decides when the next list is made is saved too, so lists are made in the same steps as without the snapshot.
#include <algorithm>
#include <ranges>

#include "physics/solver/block_engine.h"
#include "physics/solver/saved_bodies.h"
#include "runtime/base/assert.h"
#include "runtime/base/release_memory.h"

namespace meld::physics {

namespace {

struct SavedBlock {
    float speed_squared, drift_squared, first_speed_squared, second_speed_squared;
    std::uint16_t still_ticks, decide_at;
    std::uint8_t stays, asleep, has, zero;
};
constexpr std::uint8_t kHasCages = 1, kHasShapes = 2, kHasPaths = 4;

struct SavedCages {
    std::uint64_t since_tick;
    std::int32_t watch_ticks, confirmed;
};

// Equal on all subdomains, except the three flags.
struct SavedEngine {
    double cell_m, smallest_radius_m, skin_m, margin_m, farthest_path_m, dt_s, substep_s;
    Vec3 frame_m_s;
    std::int32_t levels;
    std::uint8_t rebuild, fresh, forget, has_composites, has_loads, has_joints, zero[6];
};

}  // namespace

// Before the first step, the block in which the body will be.
Home BlockEngine::home(std::uint32_t slot) const {
    if (last_dt_s_ == 0) return pack(block_of(world_.bodies.place[slot], next_shape().block_m()));
    const std::uint32_t block = grid_.block_with(slot);
    MELD_CHECK(block != kNoBlock, "body {} was added after the last step, and cannot be saved before the next one",
               world_.bodies.properties[slot].id);
    return grid_.blocks()[block].key;
}

std::vector<std::uint32_t> BlockEngine::slots_of(Home home, std::span<const std::uint32_t> known) const {
    if (last_dt_s_ == 0) return {known.begin(), known.end()};
    const std::uint32_t block = grid_.find(home);
    MELD_EXPECT(block != kNoBlock, "block {}", home);
    std::vector<std::uint32_t> slots(grid_.blocks()[block].count);
    for (std::uint32_t i = 0; i < slots.size(); ++i) slots[i] = grid_.blocks()[block].first + i;
    return slots;
}

void BlockEngine::save_home(Home home, ByteWriter& bodies, ByteWriter& contacts) const {
    if (last_dt_s_ == 0) return;
    const std::uint32_t block = grid_.find(home);
    MELD_EXPECT(block < states_.size() && states_[block].owned, "block {}", home);
    const BlockState& s = states_[block];
    const auto cages = cages_.find(block);
    const bool caged = cages != cages_.end(), has_shapes = !shape_contacts_.lanes(block).empty();
    const std::span<const Path> paths = paths_of(block);
    const int has = (caged ? kHasCages : 0) | (has_shapes ? kHasShapes : 0) | (paths.empty() ? 0 : kHasPaths);
    bodies.write(SavedBlock{s.speed_squared, s.drift_squared, s.first_speed_squared, s.second_speed_squared, s.still_ticks, s.decide_at,
                            s.stays, s.asleep, static_cast<std::uint8_t>(has), 0});
    if (!paths.empty()) {
        bodies.write_count(paths.size());
        for (const Path& path : paths) bodies.write(Path{path.slot - grid_.blocks()[block].first, path.length_m});
    }
    if (caged) {
        bodies.write(SavedCages{cages->second.since_tick, cages->second.watch_ticks, cages->second.confirmed});
        bodies.write_count(cages->second.rattlers.size());
        for (Rattler rattler : cages->second.rattlers) {
            rattler.slot -= grid_.blocks()[block].first;
            bodies.write(rattler);
        }
    }
    if (has_shapes) {
        ByteWriter of_shapes;
        shape_contacts_.save(grid_, world_.bodies, block, of_shapes);
        contacts.write_block(of_shapes.view());
    }
    contacts_.save(grid_, world_.bodies, block, contacts);
}

Result<void> BlockEngine::load_home(Home home, std::uint32_t first, Holds holds, ByteReader& bodies, ByteReader& contacts) {
    const auto count = static_cast<std::uint32_t>(world_.bodies.count()) - first;
    if (last_dt_s_ == 0) return {};
    LoadedBlock& block = loading_.blocks.emplace_back(LoadedBlock{.key = home, .first = first, .count = count});
    const auto s = bodies.read<SavedBlock>();
    BlockState& state = block.state;
    state.speed_squared = s.speed_squared, state.drift_squared = s.drift_squared;
    state.first_speed_squared = s.first_speed_squared, state.second_speed_squared = s.second_speed_squared;
    state.still_ticks = s.still_ticks, state.decide_at = s.decide_at;
    state.stays = s.stays != 0, state.asleep = state.rests = s.asleep != 0;
    state.owned = holds == Holds::Own;
    if ((s.has & kHasPaths) != 0) {
        block.paths.resize(bodies.read_count(sizeof(Path)));
        for (Path& path : block.paths)
            if (path = bodies.read<Path>(); path.slot >= count) return damaged_snapshot("knows the way of a body that is not there");
    }
    if ((s.has & kHasCages) != 0) {
        const auto saved = bodies.read<SavedCages>();
        // Clang 19 takes a class within a class for one that cannot be made without arguments until the outer one ends.
        Cages& cages = *(block.cages = Cages{});
        cages.since_tick = saved.since_tick, cages.watch_ticks = saved.watch_ticks, cages.confirmed = saved.confirmed;
        cages.rattlers.resize(bodies.read_count(sizeof(Rattler)));
        for (Rattler& rattler : cages.rattlers)
            if (rattler = bodies.read<Rattler>(); rattler.slot >= count) return damaged_snapshot("watches a body that is not there");
    }
    if ((s.has & kHasShapes) != 0 && holds == Holds::Own) block.shape_contacts = contacts.read_block();
    block.contacts = contacts.read_bytes(contacts.left());
    return {};
}

void BlockEngine::save_rest(ByteWriter& out) const {
    out.write(SavedEngine{grid_.shape().cell_m,
                          smallest_radius_m_,
                          skin_m_,
                          margin_m_,
                          farthest_path_m_,
                          last_dt_s_,
                          last_substep_s_,
                          frame_m_s_,
                          grid_.shape().levels,
                          rebuild_,
                          fresh_,
                          forget_,
                          !world_.composites.empty(),
                          world_.loads.wanted(),
                          !world_.joints.empty(),
                          {}});
    // Where obstacles are follows from the time.
    if (world_.obstacles.any_moves()) out.write(list_tick_);
    // All know all connections; what a body has is saved by its owner.
    const auto is_ours = [&](BodyId body) {
        return !divided() || (world_.bodies.has(body) && (world_.bodies.properties[world_.bodies.slot(body)].flags & kGhost) == 0);
    };
    if (!world_.composites.empty()) world_.composites.write(out, is_ours);
    if (world_.loads.wanted()) world_.loads.write(out, divided(), is_ours);
    // Of those that several subdomains have, the one with the lowest body saves them.
    if (world_.joints.empty()) return;
    std::vector<bool> ours(world_.joints.all().size(), !divided());
    if (divided())
        for (const auto& [lowest, joints] : world_.joints.groups(world_.movers()))
            for (const std::uint32_t joint : joints)
                ours[joint] = (world_.bodies.properties[world_.bodies.slot(lowest)].flags & kGhost) == 0;
    world_.joints.write(out, ours);
}

void BlockEngine::load_rest(ByteReader& in) {
    const auto saved = in.read<SavedEngine>();
    const bool first = last_dt_s_ == 0;
    loading_.shape = {saved.cell_m, saved.levels};
    smallest_radius_m_ = saved.smallest_radius_m, skin_m_ = saved.skin_m, margin_m_ = saved.margin_m;
    farthest_path_m_ = saved.farthest_path_m, frame_m_s_ = saved.frame_m_s;
    last_dt_s_ = saved.dt_s, last_substep_s_ = saved.substep_s;
    rebuild_ = saved.rebuild != 0 || (!first && rebuild_);
    fresh_ = saved.fresh != 0 && (first || fresh_);
    forget_ = saved.forget != 0 || (!first && forget_);
    if (world_.obstacles.any_moves()) list_tick_ = in.read<std::uint64_t>();
    composites_fine_ = (saved.has_composites == 0 || world_.composites.read(in)) && composites_fine_;
    if (saved.has_loads != 0) world_.loads.read(in);
    joints_fine_ = (saved.has_joints == 0 || world_.joints.read(in)) && joints_fine_;
}

Result<void> BlockEngine::loaded(Workers& workers) {
    Bodies& bodies = world_.bodies;
    const auto composites_loaded = [&] { return composites_fine_ && world_.composites.loaded(bodies, divided()); };
    if (!joints_fine_ || !world_.joints.fits(bodies)) return damaged_snapshot("has invalid joints");
    // A subdomain has done so for its joints.
    for (const Joint& joint : world_.joints.all())
        if (!divided()) world_.composites.joined().add(joint.first, joint.second);
    if (last_dt_s_ == 0) return composites_loaded() ? Result<void>() : damaged_snapshot("has invalid connections");
    std::sort(loading_.blocks.begin(), loading_.blocks.end(),
              [](const LoadedBlock& one, const LoadedBlock& other) { return one.key < other.key; });
    std::vector<std::pair<std::uint64_t, std::uint32_t>> blocks;
    std::vector<std::uint32_t> order;
    order.reserve(bodies.count());
    for (const LoadedBlock& block : loading_.blocks) {
        if (!blocks.empty() && blocks.back().first == block.key) return damaged_snapshot("has a block twice");
        blocks.emplace_back(block.key, block.count);
        for (std::uint32_t i = 0; i < block.count; ++i) order.push_back(block.first + i);
    }
    // Homes mostly come in order, so that nothing moves.
    if (order.size() != bodies.count() ||
        !std::ranges::equal(order, std::views::iota(std::uint32_t{0}, static_cast<std::uint32_t>(order.size()))))
        bodies.permute(order, workers, blocks.size());
    grid_.restore(loading_.shape, blocks, workers);
    Contacts::add_motionless(bodies, world_.obstacles, blocks.size());
    if (!composites_loaded()) return damaged_snapshot("has invalid connections");
    if (auto settled = world_.joints.settle(world_.movers()); !settled) return settled;
    states_.clear(), cages_.clear(), paths_.clear();
    std::vector<std::span<const std::byte>> contacts, shape_contacts;
    for (LoadedBlock& block : loading_.blocks) {
        const auto index = static_cast<std::uint32_t>(states_.size());
        const std::uint32_t first = grid_.blocks()[index].first;
        const BlockState& state = states_.emplace_back(block.state);
        for (std::uint32_t slot = first; state.asleep && slot < first + block.count; ++slot)
            bodies.velocity[slot].inverse_mass = bodies.velocity[slot].inverse_surface_mass = 0;
        if (block.cages) {
            for (Rattler& rattler : block.cages->rattlers) rattler.slot += first;
            cages_.emplace(index, std::move(*block.cages));
        }
        for (const Path& path : block.paths) paths_.push_back({first + path.slot, path.length_m});
        contacts.push_back(block.contacts);
        shape_contacts.push_back(block.shape_contacts);
    }
    release_memory(loading_.blocks);
    if (auto done = contacts_.load({grid_, bodies, world_.obstacles, world_.materials, {.apart_m = list_reach_m()}, 0, &world_.composites},
                                   contacts, workers);
        !done)
        return done;
    if (!world_.shapes.empty()) {
        shape_contacts_.turn_all(shape_setup(), workers);
        if (!shape_contacts_.load(shape_setup(), shape_contacts)) return damaged_snapshot("has invalid contacts");
    }
    restore_list_of_obstacles();
    lay_out_obstacle_lanes();
    rows_.lay_out(contacts_, shape_contacts_, grid_.blocks().size(), bodies, world_.composites, workers);
    turning_.forget();
    link_blocks();
    list_blocks();
    return {};
}

}  // namespace meld::physics
