// Set-up of a part: catoms and ghosts from the world, ids along the curve, the program's parameters.
#include <algorithm>
#include <cmath>
#include <set>

#include "runtime/base/bytes.h"
#include "runtime/base/nearest.h"
#include "runtime/sim/core/part_state.h"
#include "runtime/tuple/facts.h"
#include "runtime/tuple/value_text.h"
#include "runtime/world/populate.h"

namespace meld::sim {

namespace {

using Counts = std::vector<std::pair<world::BrickKey, std::uint32_t>>;

// Every part counts its share of the bricks; all learn all counts.
Counts count_together(const world::World& world, const world::Lattice& lattice, comm::Communicator& comm) {
    const Counts mine = world::count_bricks(world, lattice, comm.part(), comm.parts());
    if (comm.parts() == 1) return mine;
    ByteWriter bytes;
    for (const auto& [key, count] : mine) {
        bytes.write(key);
        bytes.write(count);
    }
    Counts all;
    for (const auto& share : comm.allgather_any(bytes.view())) {
        ByteReader in(share, "the counts of bricks");
        while (!in.done()) {
            const auto key = in.read<world::BrickKey>();
            all.emplace_back(key, in.read<std::uint32_t>());
        }
    }
    std::sort(all.begin(), all.end());
    return all;
}

// @arg1 to @arg9, which the command line numbers by itself.
bool is_run_argument(std::string_view name) { return name.size() == 4 && name.starts_with("arg") && name[3] >= '1' && name[3] <= '9'; }

tl::unexpected<Error> missing_argument(const ModuleInfo& module, const ParameterInfo& parameter) {
    const std::string name = parameter.name, type = tuple::type_name({module.types, parameter.deep});
    if (!is_run_argument(name))
        return fail("the program needs a value for the constant " + name + ", of the type " + type, "Give --set " + name + "=VALUE");
    return fail("the program needs its argument @" + name + ", of the type " + type,
                "Give --arg VALUE " + (name == "arg1" ? std::string("once") : name.substr(3) + " times") + ", or --set " + name + "=VALUE");
}

}  // namespace

Cell nearest_cell(const world::Vec3& position) {
    const auto nearest = [](double x) { return static_cast<std::int32_t>(std::clamp(std::round(x), -1e6, 1e6)); };
    return {nearest(position[0]), nearest(position[1]), nearest(position[2])};
}

Result<void> PartState::populate() {
    const Counts counts = count_together(world, lattice, comm);
    partition.emplace(counts, comm.parts());
    // A catom that goes around another looks once around that one.
    const int reach = world.motion.kind == "none" ? 1 : tuple::find_action(module, "moveAround", 2) ? 3 : 2;
    halo.emplace(ensemble, *partition, comm.part(), reach);

    if (world.is_free())
        populate_freely(counts);
    else
        populate_cells(counts);

    columns.resize(ensemble.index_count());
    evaluator.agenda().resize(ensemble.index_count());
    for (Catom c = 0; c < ensemble.index_count(); ++c)
        if (owned(c)) mark(c, kDirtyBirths);
    abi.seed = world.seed;
    abi.max_derivations = world.limits.max_derivations_per_tick;
    abi.max_facts = world.limits.max_facts_per_catom;
    abi.max_list = world.limits.max_list;
    abi.tick_seconds = world.tick_seconds;
    abi.world_catoms = static_cast<i64>(next_id);
    columns.lists().limit(world.limits.max_list);
    refresh();
    if (auto done = set_parameters(); !done) return done;
    return given_facts();
}

void PartState::populate_cells(const Counts& counts) {
    std::vector<std::uint64_t> first_id;
    std::size_t mine = 0, bricks = 0;
    for (const auto& [key, count] : counts) {
        first_id.push_back(next_id);
        next_id += count;
        if (partition->owner(key) == comm.part()) {
            mine += count;
            ++bricks;
        }
    }
    ensemble.reserve(mine + mine / 64, bricks + bricks / 2 + 32);
    std::vector<std::uint32_t> cells;
    const auto place = [&](std::size_t i, CatomState state) {
        const Cell brick = lattice.brick_at(counts[i].first);
        world::cells_of_brick(world, lattice, counts[i].first, cells);
        for (std::size_t n = 0; n < cells.size(); ++n) {
            const Cell cell = lattice.cell_in_brick(brick, cells[n]);
            if (state == kCatomGhost && !halo->subscribes(comm.part(), cell)) continue;
            ensemble.add(first_id[i] + n, cell, state);
        }
    };
    for (std::size_t i = 0; i < counts.size(); ++i)
        if (partition->owner(counts[i].first) == comm.part()) place(i, kCatomOwned);
    if (!alone())
        for (std::size_t i = 0; i < counts.size(); ++i) {
            if (partition->owner(counts[i].first) == comm.part()) continue;
            if (halo->borders(comm.part(), lattice.brick_at(counts[i].first))) place(i, kCatomGhost);
        }
    // Where nobody moves and nothing is aimed at, no catom looks beyond the bricks that are there.
    const bool looks_around = world.motion.kind != "none" || world.target.has_value();
    for (world::Slot slot = 1, end = static_cast<world::Slot>(ensemble.brick_count()); looks_around && slot <= end; ++slot)
        if (partition->owner(lattice.brick_key(ensemble.brick(slot))) == comm.part()) ensemble.surround(slot);
}

// Bodies begin where their cells would be, those that are listed where they are listed, numbered behind the others. Who shall
// own them is for the motion to say; until then the owners of the cells do, and part 0 those that are listed.
void PartState::populate_freely(const Counts& counts) {
    std::vector<std::uint32_t> cells;
    const auto add = [&](std::uint64_t id, Cell cell, const world::Vec3& position) {
        ensemble.add_at(id, position, kCatomOwned);
        start_cells.push_back(cell);
        if (reads_places) sensed_positions.push_back(position);
        if (!alone()) owners.push_back(comm.part());
    };
    std::size_t mine = comm.part() == 0 ? world.placed.size() : 0;
    for (const auto& [key, count] : counts)
        if (partition->owner(key) == comm.part()) mine += count;
    // On several parts there will be ghosts too, and bodies that come and go.
    const std::size_t room = alone() ? mine : mine + mine / 16;
    ensemble.reserve_free(room);
    start_cells.reserve(mine);
    if (reads_places) sensed_positions.reserve(room);
    if (!alone()) owners.reserve(room);
    for (const auto& [key, count] : counts) {
        const std::uint64_t first = next_id;
        next_id += count;
        if (partition->owner(key) != comm.part()) continue;
        world::cells_of_brick(world, lattice, key, cells);
        for (std::size_t n = 0; n < cells.size(); ++n) {
            const Cell cell = lattice.cell_in_brick(lattice.brick_at(key), cells[n]);
            world::Vec3 position = lattice.position(cell);
            for (double& x : position) x *= world.physics.spacing;
            add(first + n, cell, position);
        }
    }
    for (const world::PlacedCatom& placed : world.placed) {
        if (comm.part() == 0) add(next_id, nearest_cell(placed.position), placed.position);
        ++next_id;
    }
}

// A list is not longer than the world allows; told before anything is made of it.
Result<void> PartState::check_length(const std::string& what) {
    const auto [items, text] = columns.lists().too_long(0);
    if (items == 0) return {};
    return fail(what + (text ? " has a string of " : " has a list of ") + std::to_string(items) + (text ? " bytes" : " items") + ", and " +
                    std::to_string(abi.max_list) + " are the most",
                "Raise [limits] max_list in the world if it should", ExitCode::LimitHit);
}

Result<void> PartState::set_parameters() {
    tuple::Arena lists;
    std::set<std::string_view> missing;
    for (u32 i = 0; i < module.parameter_count; ++i)
        if (module.parameters[i].required) missing.insert(module.parameters[i].name);
    std::vector<Value> values;
    for (u32 i = 0; i < module.parameter_count; ++i) values.push_back(module.parameters[i].value);
    for (const auto& [name, text] : world.set) {
        std::vector<std::string_view> known;
        bool found = false;
        for (u32 i = 0; i < module.parameter_count; ++i) {
            if (*module.parameters[i].name == '\0') continue;
            known.emplace_back(module.parameters[i].name);
            if (known.back() != name) continue;
            const Result<Value> value = tuple::parse_value({module.types, module.parameters[i].deep}, text, lists);
            if (!value) return fail("the constant " + name + " cannot be set: " + value.error().problem, value.error().suggestion);
            values[i] = *value;
            missing.erase(known.back());
            found = true;
        }
        if (!found && is_run_argument(name))
            return fail("the program does not read the argument @" + name, "Leave out what it has no use for");
        if (!found) {
            return fail("the program has no constant '" + name + "' to set",
                        known.empty() ? "Declare it in the program: const " + name + " = " + text + "."
                                      : "Constants: " + did_you_mean(name, known));
        }
    }
    for (u32 i = 0; i < module.parameter_count; ++i)
        if (missing.contains(module.parameters[i].name)) return missing_argument(module, module.parameters[i]);
    // Kept, so that facts made of them share them.
    for (u32 i = 0; i < module.parameter_count; ++i) {
        parameters.push_back(columns.lists().keep({module.types, module.parameters[i].deep}, values[i], 0));
        if (auto fits = check_length("the constant " + std::string(module.parameters[i].name)); !fits) return fits;
    }
    abi.parameters = parameters.data();
    return {};
}

}  // namespace meld::sim
