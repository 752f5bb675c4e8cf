#include "runtime/sim/core/setup/setup.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstring>
#include <set>
#include <span>
#include <utility>

#include "runtime/base/assert.h"
#include "runtime/base/did_you_mean.h"
#include "runtime/base/process/available_memory.h"
#include "runtime/engine/tuple/facts.h"
#include "runtime/engine/tuple/value_text.h"
#include "runtime/sim/core/programs.h"
#include "runtime/sim/core/setup/graph_setup.h"
#include "runtime/sim/core/setup/world_facts.h"
#include "runtime/world/description/limits.h"
#include "runtime/world/description/populate.h"
#include "runtime/world/lattice/move_table.h"

namespace meld::sim {

namespace {

// Workers mark catoms of different blocks of the agenda.
constexpr std::size_t kMarkedAtOnce = 4 * eval::Agenda::kBlock;

// What every process may take, of those of the run: all have the same limits.
std::uint64_t least_memory(comm::Communicator& comm, const world::Limits& limits) {
    const std::uint64_t mine = memory_limit(limits.memory_bytes).bytes;
    std::uint64_t least = mine;
    const std::vector<std::byte> all = comm.allgather(std::as_bytes(std::span(&mine, 1)));
    for (std::size_t at = 0; at + sizeof mine <= all.size(); at += sizeof mine) {
        std::uint64_t theirs = 0;
        std::memcpy(&theirs, all.data() + at, sizeof theirs);
        least = std::min(least, theirs);
    }
    return least;
}

// @arg1 to @arg9, which the command line numbers itself.
bool is_run_argument(std::string_view name) { return name.size() == 4 && name.starts_with("arg") && name[3] >= '1' && name[3] <= '9'; }

tl::unexpected<Error> missing_argument(const ModuleInfo& module, const ParameterInfo& parameter) {
    const std::string name = parameter.name, type = tuple::type_name({module.types, parameter.deep});
    if (!is_run_argument(name))
        return fail("the program needs a value for the constant " + name + ", of the type " + type, "Give --set " + name + "=VALUE");
    return fail("the program needs its argument @" + name + ", of the type " + type,
                "Give --arg VALUE " + (name == "arg1" ? std::string("once") : name.substr(3) + " times") + ", or --set " + name + "=VALUE");
}

}  // namespace

Result<void> Setup::run(std::optional<BrickCounts> counted) {
    Subdomain& s = subdomain_;
    MELD_EXPECT(!s.members_.partition && s.tick() == 0, "a subdomain is set up once, before its first tick");
    const BrickCounts counts = counted              ? std::move(*counted)
                               : s.world.is_graph() ? BrickCounts()
                                                    : count_together(s.world, s.lattice, s.comm, s.workers);
    divide(counts);

    if (s.world.is_graph())
        populate_graph(s.members_, *s.world.graph, s.comm, nullptr,
                       s.world.has_moving_nodes() ? first_links(*s.world.graph) : std::vector<JoinedNodes>());
    else if (s.world.is_free())
        populate_freely(counts);
    else
        populate_cells(counts);

    MELD_ENSURE(s.ensemble.owned_count() + s.ensemble.ghost_count() == s.ensemble.index_count() && s.ensemble.owned_count() <= s.next_id(),
                "{} catoms and {} ghosts", s.ensemble.owned_count(), s.ensemble.ghost_count());
    if (auto named = check_single_links(); !named) return named;
    s.facts_.resize(s.ensemble.index_count());
    if (auto done = set_constants(); !done) return done;
    Programs(s).start();
    if (auto done = GivenFacts(s).start(); !done) return done;
    mark_births();
    return {};
}

// Nothing can be read at neighbours yet: what they export is derived from given facts.
void Setup::mark_births() {
    Subdomain& s = subdomain_;
    if (s.module.idle_births) {
        s.agenda().each([&](u32 catom, u64) { s.mark(catom, kDirtyBirths); });
        return;
    }
    const std::size_t count = s.ensemble.index_count();
    s.workers.run((count + kMarkedAtOnce - 1) / kMarkedAtOnce, [&](int, std::size_t part) {
        for (std::size_t c = part * kMarkedAtOnce; c < std::min(count, (part + 1) * kMarkedAtOnce); ++c)
            if (s.owned(static_cast<Catom>(c))) s.mark(static_cast<Catom>(c), kDirtyBirths);
    });
}

// New catoms may have any number.
Result<void> Setup::check_single_links() const {
    const world::World& world = subdomain_.world;
    if (!world.is_graph() && (world.motion.kind != "none" || !world.components.empty())) return {};
    const auto known = [&](std::uint64_t id) { return world.is_graph() ? world.graph->find(id).has_value() : id < subdomain_.next_id(); };
    for (const world::NetworkOptions::Single& one : world.network.singles)
        for (const std::uint64_t end : {one.from, one.to})
            if (!known(end))
                return fail(fmt::format("{}:{}: there is no catom @{}", world.network.singles_path, one.line, end),
                            "Take the line out, or correct the number");
    return {};
}

void Setup::divide(const BrickCounts& counts) {
    Subdomain& s = subdomain_;
    s.members_.partition.emplace(counts, s.comm.processes());
    s.members_.halo.emplace(s.ensemble, *s.members_.partition, s.comm.process(), reach(s.world, s.program_actions));
}

int Setup::reach(const world::World& world, const tuple::ProgramActions& actions) {
    // The head of an amoebot that touches the tail of another is three cells from its head.
    if (world.has_amoebots()) return 3;
    // A catom that goes around another looks once around that one.
    const int around = world.motion.kind == "none" ? 1 : actions.uses(ActionKind::MoveAround) ? 3 : 2;
    return world.motion.moves != nullptr ? std::max(around, static_cast<int>(world.motion.moves->reach())) : around;
}

// Where nobody moves and nothing is aimed at, no catom looks beyond the bricks that are there.
bool Setup::looks_around(const world::World& world) { return world.motion.kind != "none" || world.target.has_value(); }

// Not around empty bricks, or each division of a running ensemble would add a layer.
void Setup::surround() {
    Membership& m = subdomain_.members_;
    const bool around = looks_around(subdomain_.world);
    for (world::Slot slot = 1, end = static_cast<world::Slot>(m.ensemble.brick_count()); around && slot <= end; ++slot)
        if (!m.ensemble.empty(slot, 0, kBrickCells) &&
            m.partition->owner(subdomain_.lattice.brick_key(m.ensemble.brick(slot))) == subdomain_.comm.process())
            m.ensemble.surround(slot);
}

Result<void> Setup::set_constants() {
    set_limits();
    subdomain_.refresh();
    return set_parameters();
}

void Setup::set_limits() {
    const world::World& world = subdomain_.world;
    SubdomainView& abi = subdomain_.abi_;
    abi.seed = world.seed;
    const world::DerivationLimits derivations = world::derivation_limits(world.limits);
    abi.max_derivations = derivations.firings;
    abi.max_finite_derivations = derivations.finite;
    abi.max_growing_derivations = derivations.growing;
    const world::FactLimits facts = world::fact_limits(world.limits, least_memory(subdomain_.comm, world.limits));
    abi.max_facts = facts.bounded;
    abi.max_growing_facts = facts.growing;
    abi.max_list = world.limits.max_list;
    abi.tick_seconds = world.tick_seconds;
    abi.latency = world.clock.gives_turns() ? Turns::kUntilRest : world.latency();
    abi.world_catoms = static_cast<i64>(world.is_graph() ? world.graph->nodes() : subdomain_.next_id());
    subdomain_.facts_.columns.lists().limit(world.limits.max_list);
}

void Setup::populate_cells(const BrickCounts& counts) {
    Membership& m = subdomain_.members_;
    const world::World& world = subdomain_.world;
    const world::Lattice& lattice = subdomain_.lattice;
    const int rank = subdomain_.comm.process();
    // A process owns a range of the curve, so its bricks are neighbours in the list.
    std::vector<std::uint64_t> first_id;
    first_id.reserve(counts.size());
    std::size_t mine = 0, begin = counts.size(), end = 0;
    for (std::size_t i = 0; i < counts.size(); ++i) {
        first_id.push_back(m.next_id);
        m.next_id += counts[i].second;
        if (m.partition->owner(counts[i].first) != rank) continue;
        mine += counts[i].second;
        begin = std::min(begin, i);
        end = i + 1;
    }
    const std::span<const std::pair<world::BrickKey, std::uint32_t>> ours(counts.data() + std::min(begin, end), end - std::min(begin, end));
    // Found first, so that there is room for them: arrays that grow leave as much memory behind again.
    std::vector<std::pair<std::uint64_t, Cell>> ghosts;
    std::vector<std::uint32_t> cells;
    partition::each_border_brick(*m.partition, lattice, counts, rank, [&](std::size_t i) {
        if (m.partition->owner(counts[i].first) == rank) return;
        const Cell brick = lattice.brick_at(counts[i].first);
        std::vector<partition::Halo::Side> sides = m.halo->sides(brick);
        std::erase_if(sides, [&](const auto& side) { return side.process != rank; });
        world::cells_of_brick(world, lattice, counts[i].first, cells);
        for (std::size_t n = 0; n < cells.size(); ++n)
            if (std::ranges::any_of(sides, [&](const auto& side) { return m.halo->near(side, cells[n]); }))
                ghosts.emplace_back(first_id[i] + n, lattice.cell_in_brick(brick, cells[n]));
    });
    m.ensemble.reserve(mine + mine / 64 + ghosts.size(), room_for_bricks(ours.size()));
    const auto fill = [&](Cell brick, std::span<std::uint64_t, 8> bits) {
        std::ranges::copy(world::cells_of_body(world, lattice, brick), bits.begin());
    };
    if (!ours.empty()) m.ensemble.add_bricks(ours, first_id[begin], fill, kCatomOwned, subdomain_.workers);
    for (const auto& [id, cell] : ghosts) m.ensemble.add(id, cell, kCatomGhost);
    surround();
}

// Bodies begin where their cells would be; listed bodies begin at their positions and are numbered after the others. The motion decides who
// owns them; until then they belong to the owners of the cells, and listed bodies to process 0.
void Setup::populate_freely(const BrickCounts& counts) {
    Membership& m = subdomain_.members_;
    const world::World& world = subdomain_.world;
    const world::Lattice& lattice = subdomain_.lattice;
    const int rank = subdomain_.comm.process();
    std::size_t mine = rank == 0 ? world.placed.size() : 0;
    for (const auto& [key, count] : counts)
        if (m.partition->owner(key) == rank) mine += count;
    // On several processes there will be ghosts too, and bodies that migrate.
    m.reserve_freely(mine, subdomain_.alone() ? mine : mine + mine / 16);
    std::vector<std::uint32_t> cells;
    for (const auto& [key, count] : counts) {
        const std::uint64_t first = m.next_id;
        m.next_id += count;
        if (m.partition->owner(key) != rank) continue;
        world::cells_of_brick(world, lattice, key, cells);
        for (std::size_t n = 0; n < cells.size(); ++n) {
            const Cell cell = lattice.cell_in_brick(lattice.brick_at(key), cells[n]);
            world::Vec3 position = lattice.position(cell);
            for (double& x : position) x *= world.physics.spacing;
            m.start_freely(first + n, cell, position);
        }
    }
    for (const world::PlacedCatom& placed : world.placed) {
        if (rank == 0) m.start_freely(m.next_id, nearest_cell(placed.position), placed.position);
        ++m.next_id;
    }
}

Result<void> check_length(tuple::ListStore& lists, const SubdomainView& limits, const std::string& what) {
    const auto [items, text] = lists.too_long(0);
    if (items == 0) return {};
    return fail(what + (text ? " has a string of " : " has a list of ") + std::to_string(items) + (text ? " bytes" : " items") +
                    ", and the maximum is " + std::to_string(limits.max_list),
                "Raise [limits] max_list in the world if it should", ExitCode::LimitHit);
}

Result<void> Setup::set_parameters() {
    const ModuleInfo& module = subdomain_.module;
    FactStore& facts = subdomain_.facts_;
    tuple::Arena lists;
    std::set<std::string_view> missing;
    for (u32 i = 0; i < module.parameter_count; ++i)
        if (module.parameters[i].required) missing.insert(module.parameters[i].name);
    std::vector<Value> values;
    for (u32 i = 0; i < module.parameter_count; ++i) values.push_back(module.parameters[i].value);
    for (const auto& [name, text] : subdomain_.world.set) {
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
        if (!found && is_run_argument(name)) return fail("the program does not read the argument @" + name, "Leave it out");
        if (!found) {
            return fail("the program has no constant '" + name + "' to set",
                        known.empty() ? "Declare it in the program: const " + name + " = " + text + "."
                                      : "Constants: " + did_you_mean(name, known));
        }
    }
    for (u32 i = 0; i < module.parameter_count; ++i)
        if (missing.contains(module.parameters[i].name)) return missing_argument(module, module.parameters[i]);
    // Stored, so that facts made of them share them.
    for (u32 i = 0; i < module.parameter_count; ++i) {
        facts.add_parameter({module.types, module.parameters[i].deep}, values[i]);
        if (auto fits = check_length(facts.columns.lists(), subdomain_.abi_, "the constant " + std::string(module.parameters[i].name));
            !fits)
            return fits;
    }
    subdomain_.abi_.parameters = facts.parameters().data();
    return {};
}

}  // namespace meld::sim
