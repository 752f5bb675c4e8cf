#include "runtime/sim/state/loader.h"

#include <fmt/format.h>

#include <algorithm>
#include <optional>

#include "runtime/base/assert.h"
#include "runtime/comm/outcome.h"
#include "runtime/sim/core/setup.h"
#include "runtime/sim/state/reading.h"

namespace meld::sim {

namespace {

constexpr const char* kOfModule = "what a module keeps for catoms";

}  // namespace

Result<Block> Loader::run(const Modules& modules, CodeModules& codes) {
    MELD_EXPECT(!subdomain_.members_.partition && subdomain_.tick() == 0, "a subdomain is set up once");
    // Modules may exchange while they are resumed, so all processes come that far or none does; and so at the end.
    Result<void> placed = divide();
    if (placed) placed = add_catoms();
    if (auto all = comm::outcome_of_all(subdomain_.comm, placed); !all) return tl::unexpected<Error>(all.error());
    subdomain_.facts_.resize(subdomain_.ensemble.index_count());
    if (auto done = Setup(subdomain_).set_constants(); !done) return tl::unexpected<Error>(done.error());
    for (SimModule* module : modules)
        if (auto done = module->resume(subdomain_); !done) return tl::unexpected<Error>(done.error());
    Block counters;
    Result<void> loaded = load_catoms([&](std::span<const tuple::SavedCatom> found, ByteReader& in) -> Result<void> {
        for (SimModule* module : modules) {
            ByteReader own(in.read_block(), kOfModule, ByteReader::Origin::Outside);
            module->load_catoms(subdomain_, found, own);
            if (auto whole = read_to_its_end(own, kOfModule); !whole) return whole;
        }
        return read_to_its_end(in, "its facts");
    });
    if (loaded) loaded = load_rest(modules, codes, counters);
    if (auto all = comm::outcome_of_all(subdomain_.comm, loaded); !all) return tl::unexpected<Error>(all.error());
    for (SimModule* module : modules)
        if (auto done = module->resumed(subdomain_); !done) return tl::unexpected<Error>(done.error());
    subdomain_.refresh();
    return counters;
}

Result<void> Loader::facts(const Place& place) {
    Result<void> done = divide();
    if (done) done = add_catoms();
    if (!done) return done;
    subdomain_.facts_.resize(subdomain_.ensemble.index_count());
    done = load_catoms([&](std::span<const tuple::SavedCatom> found, ByteReader& in) -> Result<void> {
        if (!subdomain_.ensemble.is_free()) return in.outcome();
        ByteReader own(in.read_block(), kOfModule, ByteReader::Origin::Outside);
        if (auto placed = place(subdomain_, found, own); !placed) return placed;
        return in.failed() ? in.outcome() : own.outcome();
    });
    subdomain_.refresh();
    return done;
}

Result<Loader::Places> Loader::places(std::size_t share, std::size_t chunk) const {
    const Result<Block> block = shares_.places(share, chunk);
    if (!block) return tl::unexpected<Error>(block.error());
    ByteReader in = reader(*block, "the places of a snapshot");
    const std::uint32_t count = in.read_count(sizeof(std::uint64_t) + sizeof(Cell));
    Places out{std::vector<std::uint64_t>(count), std::vector<Cell>(count)};
    for (std::uint64_t& id : out.ids) id = in.read<std::uint64_t>();
    for (Cell& cell : out.cells) cell = in.read<Cell>();
    if (auto whole = read_to_its_end(in, "its places"); !whole) return tl::unexpected<Error>(whole.error());
    return out;
}

// Most catoms stand in the brick of the one before.
Result<void> Loader::count_bricks(CountOf& count_of) const {
    const world::Lattice& lattice = subdomain_.lattice;
    return each_chunk([&](std::size_t share, std::size_t chunk) -> Result<void> {
        const Result<Places> all = places(share, chunk);
        if (!all) return tl::unexpected<Error>(all.error());
        std::optional<Cell> last;
        std::uint32_t* count = nullptr;
        for (const Cell cell : all->cells) {
            const Cell brick = lattice.brick_of(cell);
            if (last != brick) count = &count_of[lattice.brick_key(brick)];
            last = brick;
            ++*count;
        }
        return {};
    });
}

Result<void> Loader::divide() {
    const bool free = subdomain_.ensemble.is_free();
    CountOf count_of;
    const Result<void> counted = free ? count_homes(count_of) : count_bricks(count_of);
    if (!counted) return counted;
    Setup::Counts counts(count_of.begin(), count_of.end());
    std::sort(counts.begin(), counts.end());
    Setup(subdomain_).divide(counts);
    std::size_t mine = 0, bricks = 0;
    for (const auto& [key, count] : counts) {
        if (subdomain_.members_.partition->owner(key) != subdomain_.comm.process()) continue;
        mine += count;
        ++bricks;
    }
    if (free)
        subdomain_.members_.reserve_freely(0, subdomain_.alone() ? mine : mine + mine / 16);
    else
        subdomain_.members_.ensemble.reserve(mine + mine / 64, bricks + bricks / 2 + 32);
    return {};
}

Result<void> Loader::add_catoms() {
    found_.resize(shares_.count());
    if (subdomain_.ensemble.is_free()) return add_freely();
    const Result<void> added = each_chunk([&](std::size_t share, std::size_t chunk) -> Result<void> {
        const Result<Places> all = places(share, chunk);
        if (!all) return tl::unexpected<Error>(all.error());
        Result<Found> here = add(*all);
        if (!here) return tl::unexpected<Error>(here.error());
        found_[share].push_back(std::move(*here));
        return {};
    });
    if (added) Setup(subdomain_).surround();
    return added;
}

Result<Loader::Found> Loader::add(const Places& all) {
    Membership& m = subdomain_.members_;
    const int rank = subdomain_.comm.process();
    Found found(all.ids.size());
    bool any = false;
    std::optional<Cell> last;
    bool ours = false, beside = false;
    for (std::size_t i = 0; i < all.ids.size(); ++i) {
        const Cell cell = all.cells[i];
        if (const Cell brick = subdomain_.lattice.brick_of(cell); last != brick) {
            last = brick;
            ours = m.partition->owner(subdomain_.lattice.brick_key(brick)) == rank;
            beside = !ours && !subdomain_.alone() && m.halo->borders(rank, brick);
        }
        if (!ours && !(beside && m.halo->subscribes(rank, cell))) continue;
        if (m.ensemble.at(cell)) return damaged(fmt::format("has two catoms in cell ({}, {}, {})", cell.x, cell.y, cell.z));
        found[i] = {m.ensemble.add(all.ids[i], cell, ours ? kCatomOwned : kCatomGhost), ours};
        any = true;
    }
    if (!any) found.clear();
    return found;
}

Result<void> Loader::load_catoms(const Rest& rest) {
    return each_chunk([&](std::size_t share, std::size_t chunk) -> Result<void> {
        const Found& found = found_[share][chunk];
        if (found.empty()) return {};
        const Result<Block> block = shares_.state(share, chunk);
        if (!block) return tl::unexpected<Error>(block.error());
        ByteReader in = reader(*block, "the facts of a snapshot");
        subdomain_.facts_.load(found, in);
        return rest(found, in);
    });
}

Result<void> Loader::load_rest(const Modules& modules, CodeModules& codes, Block& counters) {
    for (std::size_t share = 0; share < shares_.count(); ++share) {
        const Result<Block> block = shares_.rest(share);
        if (!block) return tl::unexpected<Error>(block.error());
        ByteReader in = reader(*block, "the end of a snapshot");
        const auto tick = in.read<std::int64_t>();
        subdomain_.abi_.now = tick;
        subdomain_.abi_.world_catoms = in.read<std::int64_t>();
        subdomain_.members_.next_id = in.read<std::uint64_t>();
        // Whoever stopped it there now wants it to go on.
        auto totals = in.read<Totals>();
        totals.stop = totals.save = false;
        subdomain_.status_.resume(tick, totals);
        subdomain_.facts_.evaluator.restore_greatest_rank(subdomain_.totals.greatest_rank);
        const auto counted = in.read_block();
        counters.assign(counted.begin(), counted.end());
        const auto owned = [&](u64 id) -> std::optional<u32> {
            const std::optional<Catom> catom = subdomain_.ensemble.find(id);
            return catom && subdomain_.owned(*catom) ? catom : std::nullopt;
        };
        subdomain_.facts_.load_passing(tick, owned, in);
        codes.load(subdomain_, share == 0, in);
        const std::uint32_t count = in.read_count(sizeof(std::uint32_t));
        if (count != modules.size()) return damaged(fmt::format("is of a run with {} modules, and this one has {}", count, modules.size()));
        for (SimModule* module : modules) {
            ByteReader own(in.read_block(), "what a module keeps", ByteReader::Origin::Outside);
            if (auto done = module->load_rest(subdomain_, own); !done) return done;
            if (auto whole = read_to_its_end(own, "what a module keeps"); !whole) return whole;
        }
        if (auto whole = read_to_its_end(in, "its end"); !whole) return whole;
    }
    subdomain_.facts_.evaluator.order_actions(subdomain_.ensemble.geometry().catom_id);
    return {};
}

}  // namespace meld::sim
