#include "runtime/sim/state/loader.h"

#include <fmt/format.h>

#include <algorithm>
#include <optional>
#include <utility>

#include "runtime/base/assert.h"
#include "runtime/comm/transport/collective_result.h"
#include "runtime/sim/core/programs.h"
#include "runtime/sim/core/setup/setup.h"
#include "runtime/sim/core/setup/world_facts.h"
#include "runtime/sim/state/reading.h"

namespace meld::sim {

namespace {

constexpr const char* kOfModule = "what a module keeps for catoms";

}  // namespace

Result<Block> Loader::run(const Modules& modules, CodeModules& codes) {
    MELD_EXPECT(!subdomain_.members_.partition && subdomain_.tick() == 0, "a subdomain is set up once");
    // Modules may exchange while they are resumed, so all processes come that far or none does; and so at the end.
    Result<void> placed = prepare(modules);
    if (placed) placed = divide();
    if (placed) placed = add_catoms();
    if (auto all = comm::outcome_of_all(subdomain_.comm, placed); !all) return tl::unexpected<Error>(all.error());
    subdomain_.facts_.resize(subdomain_.ensemble.index_count());
    if (auto done = Setup(subdomain_).set_constants(); !done) return tl::unexpected<Error>(done.error());
    for (const NamedModule& each : modules)
        if (auto done = each.module->resume(subdomain_); !done) return tl::unexpected<Error>(done.error());
    Block counters;
    Result<void> loaded = load_catoms([&](std::span<const tuple::SavedCatom> found, ByteReader& in) -> Result<void> {
        for (SimModule* module : kept_by_) {
            ByteReader own(in.read_block(), kOfModule, ByteReader::Origin::Outside);
            if (module == nullptr) continue;
            module->load_catoms(subdomain_, found, own);
            if (auto whole = read_to_its_end(own, kOfModule); !whole) return whole;
        }
        return read_to_its_end(in, "its facts");
    });
    if (loaded) loaded = load_rest(codes, counters);
    if (loaded) loaded = check_length(subdomain_.facts_.columns.lists(), subdomain_.abi_, "a fact of the snapshot");
    if (auto all = comm::outcome_of_all(subdomain_.comm, loaded); !all) return tl::unexpected<Error>(all.error());
    if (take_over_) {
        Result<TakenOver> outcome = take_over_->outcome(subdomain_.comm);
        if (!outcome) return tl::unexpected<Error>(outcome.error());
        taken_over_ = std::move(*outcome);
    }
    if (how_ == Loads::Anew || how_ == Loads::LooksAgain)
        for (Catom c = 0; c < subdomain_.ensemble.index_count(); ++c)
            if (subdomain_.owned(c)) subdomain_.mark(c, how_ == Loads::Anew ? kDirtyBirths : kDirtyPlace);
    if (how_ == Loads::Anew) Programs(subdomain_).complete();
    // What happens later may be new.
    if (how_ != Loads::GoesOn)
        if (auto checked = GivenFacts(subdomain_).check_events(); !checked) return tl::unexpected<Error>(checked.error());
    for (const NamedModule& each : modules)
        if (auto done = each.module->resumed(subdomain_); !done) return tl::unexpected<Error>(done.error());
    subdomain_.refresh();
    return counters;
}

Loader::Head Loader::read_head(ByteReader& in) {
    Head head;
    const auto schema = in.read_block();
    head.schema.assign(schema.begin(), schema.end());
    for (auto left = in.read_count(sizeof(std::uint32_t)); left > 0; --left) head.modules.push_back(in.read_string());
    const auto failed = in.read_block();
    head.failed.assign(failed.begin(), failed.end());
    return head;
}

// Finds out who reads what was kept, and how facts were stored.
Result<void> Loader::prepare(const Modules& modules) {
    if (shares_.count() == 0) return damaged("has no share");
    const Result<BlockView> block = shares_.rest(0, room_);
    if (!block) return tl::unexpected<Error>(block.error());
    ByteReader in = reader(*block, "the end of a snapshot");
    const Head head = read_head(in);
    if (in.failed()) return in.outcome();
    const auto same = [](const NamedModule& here, const std::string& name) { return here.name == name; };
    if (how_ == Loads::GoesOn && !std::equal(modules.begin(), modules.end(), head.modules.begin(), head.modules.end(), same))
        return damaged(fmt::format("is of a run with the modules {}", fmt::join(head.modules, ", ")));
    for (std::size_t i = 0; i < head.modules.size(); ++i) {
        const auto found = std::find_if(modules.begin(), modules.end(), [&](const NamedModule& m) { return same(m, head.modules[i]); });
        kept_by_.push_back(how_ == Loads::GoesOn ? modules[i].module : found == modules.end() ? nullptr : found->module);
    }
    if (how_ != Loads::Anew) return {};
    ByteReader stored(head.schema, "how a snapshot stores facts", ByteReader::Origin::Outside);
    Result<tuple::Schema> schema = tuple::Schema::read(stored);
    if (!schema) return tl::unexpected<Error>(schema.error());
    take_over_.emplace(std::move(*schema), subdomain_.module, subdomain_.facts_);
    return {};
}

Result<void> Loader::facts(const Place& place) {
    Result<void> done = divide();
    if (done) done = add_catoms();
    if (!done) return done;
    subdomain_.facts_.resize(subdomain_.ensemble.index_count());
    done = load_catoms([&](std::span<const tuple::SavedCatom> found, ByteReader& in) -> Result<void> {
        if (!subdomain_.ensemble.is_free() || subdomain_.ensemble.is_graph()) return in.outcome();
        ByteReader own(in.read_block(), kOfModule, ByteReader::Origin::Outside);
        if (auto placed = place(subdomain_, found, own); !placed) return placed;
        return in.failed() ? in.outcome() : own.outcome();
    });
    subdomain_.refresh();
    return done;
}

Result<CellPlaces> Loader::places(std::size_t share, std::size_t chunk) {
    const Result<BlockView> block = shares_.places(share, chunk, room_);
    if (!block) return tl::unexpected<Error>(block.error());
    ByteReader in = reader(*block, "the places of a snapshot");
    Result<CellPlaces> all = CellPlaces::read(in);
    if (auto whole = read_to_its_end(in, "its places"); !whole) return tl::unexpected<Error>(whole.error());
    return all;
}

Result<void> Loader::count_bricks(CountOf& count_of) {
    return each_chunk([&](std::size_t share, std::size_t chunk) -> Result<void> {
        const Result<CellPlaces> all = places(share, chunk);
        if (!all) return tl::unexpected<Error>(all.error());
        return all->each_in_brick([&](const CellPlaces::Run& run) -> Result<void> {
            count_of[run.first >> kBrickCellBits] += run.count;
            return {};
        });
    });
}

Result<void> Loader::divide() {
    const bool free = subdomain_.ensemble.is_free();
    if (subdomain_.ensemble.is_graph()) return Setup(subdomain_).divide({}), Result<void>();
    CountOf count_of;
    const Result<void> counted = free ? count_homes(count_of) : count_bricks(count_of);
    if (!counted) return counted;
    BrickCounts counts(count_of.begin(), count_of.end());
    std::sort(counts.begin(), counts.end());
    Setup(subdomain_).divide(counts);
    std::size_t bricks = 0;
    for (const auto& [key, count] : counts) {
        bodies_ += free ? count : 0;
        if (subdomain_.members_.partition->owner(key) != subdomain_.comm.process()) continue;
        mine_ += count;
        ++bricks;
    }
    if (free)
        subdomain_.members_.reserve_freely(0, subdomain_.alone() ? mine_ : mine_ + mine_ / 16);
    else
        subdomain_.members_.ensemble.reserve(mine_ + mine_ / 64, bricks + bricks / 2 + 32);
    return {};
}

Result<void> Loader::read_failed() {
    for (std::size_t share = 0; share < shares_.count(); ++share) {
        const Result<BlockView> block = shares_.rest(share, room_);
        if (!block) return tl::unexpected<Error>(block.error());
        ByteReader in = reader(*block, "the end of a snapshot");
        const Head head = read_head(in);
        if (in.failed()) return in.outcome();
        ByteReader failed = reader(head.failed, "what has failed in a snapshot");
        if (auto done = failed_.read(subdomain_.world, failed); !done) return done;
        if (auto whole = read_to_its_end(failed, "what has failed"); !whole) return whole;
    }
    return {};
}

Result<void> Loader::add_catoms() {
    found_.resize(shares_.count());
    Result<void> added = read_failed();
    if (subdomain_.ensemble.is_graph()) {
        // Nodes are placed by all processes together.
        if (auto all = comm::outcome_of_all(subdomain_.comm, added); !all) return all;
        added = add_nodes();
    } else if (added) {
        added = subdomain_.ensemble.is_free() ? add_freely() : add_cells();
    }
    if (added) failed_.cut(subdomain_.members_.ensemble);
    return added;
}

Result<void> Loader::add_cells() {
    const Result<void> added = each_chunk([&](std::size_t share, std::size_t chunk) -> Result<void> {
        const Result<CellPlaces> all = places(share, chunk);
        if (!all) return tl::unexpected<Error>(all.error());
        return place_on_cells(subdomain_.members_, *all, subdomain_.comm.process(), found_[share].emplace_back());
    });
    if (added) Setup(subdomain_).surround();
    return added;
}

Result<void> Loader::load_catoms(const Rest& rest) {
    std::vector<tuple::SavedCatom> found;
    return each_chunk([&](std::size_t share, std::size_t chunk) -> Result<void> {
        if (!found_[share][chunk].any()) return {};
        found_[share][chunk].list(found);
        const Result<BlockView> block = shares_.state(share, chunk, room_);
        if (!block) return tl::unexpected<Error>(block.error());
        ByteReader in = reader(*block, "the facts of a snapshot");
        if (take_over_)
            take_over_->load(found, in);
        else
            subdomain_.facts_.load(found, in);
        return rest(found, in);
    });
}

// Whoever stopped it there now wants it to go on.
void Loader::load_totals(const Totals& saved) {
    Totals totals = saved;
    totals.stop = totals.save = false;
    // The world may have got other events since.
    totals.waiting = totals.timers || subdomain_.world.expects_after(subdomain_.tick()) || !failed_.dying().empty();
    totals.awake = totals.awake || how_ == Loads::LooksAgain || how_ == Loads::Anew;
    if (how_ == Loads::Anew) {
        totals.waiting = totals.timers = totals.undefined = totals.finished = false;
        totals.greatest_rank = 0;
        totals.failure = {};
        subdomain_.abi_.first_unborn = subdomain_.next_id();
    }
    subdomain_.status_.resume(subdomain_.tick(), totals);
    subdomain_.facts_.evaluator.restore_greatest_rank(totals.greatest_rank);
}

Result<void> Loader::load_rest(CodeModules& codes, Block& counters) {
    if (subdomain_.network_) subdomain_.network_->read_in_place();
    for (std::size_t share = 0; share < shares_.count(); ++share) {
        const Result<BlockView> block = shares_.rest(share, room_);
        if (!block) return tl::unexpected<Error>(block.error());
        ByteReader in = reader(*block, "the end of a snapshot");
        read_head(in);
        subdomain_.abi_.now = in.read<std::int64_t>();
        // Once: each share says what is under way to some of the links.
        if (share == 0 && subdomain_.network_) subdomain_.members_.ensemble.links().begin_arrivals(subdomain_.tick());
        subdomain_.abi_.world_catoms = in.read<std::int64_t>();
        subdomain_.abi_.first_unborn = in.read<std::uint64_t>();
        subdomain_.members_.next_id = in.read<std::uint64_t>();
        load_totals(in.read<Totals>());
        for (const std::uint64_t id : failed_.hung()) subdomain_.fall_silent(id);
        subdomain_.status_.dying = failed_.dying();
        const auto counted = in.read_block();
        counters.assign(counted.begin(), counted.end());
        const auto owned = [&](u64 id) -> std::optional<u32> {
            const std::optional<Catom> catom = subdomain_.ensemble.find(id);
            return catom && subdomain_.owned(*catom) ? catom : std::nullopt;
        };
        if (take_over_)
            take_over_->load_passing(owned, in);
        else
            subdomain_.facts_.load_passing(subdomain_.tick(), owned, in);
        ByteReader under_way(in.read_block(), "what is under way in a snapshot", ByteReader::Origin::Outside);
        // What another program has told is derived anew.
        if (subdomain_.network_ && !take_over_)
            subdomain_.network_->load(subdomain_.tick(), owned, subdomain_.comm.process() == 0, under_way);
        ByteReader turns(in.read_block(), "the turns of a snapshot", ByteReader::Origin::Outside);
        if (subdomain_.turns_ && !turns.done()) subdomain_.turns_->load(owned, turns);
        codes.load(subdomain_, share == 0, in);
        for (SimModule* module : kept_by_) {
            ByteReader own(in.read_block(), "what a module keeps", ByteReader::Origin::Outside);
            if (module == nullptr) continue;
            if (auto done = module->load_rest(subdomain_, own); !done) return done;
            if (auto whole = read_to_its_end(own, "what a module keeps"); !whole) return whole;
        }
        if (auto whole = read_to_its_end(in, "its end"); !whole) return whole;
    }
    subdomain_.facts_.evaluator.order_actions(subdomain_.ensemble.geometry());
    return {};
}

}  // namespace meld::sim
