// Setting up catoms at arbitrary positions from a snapshot: those whose homes are this process's, then ghosts of those that are linked
// with them, and the links.
#include <fmt/format.h>

#include <optional>
#include <unordered_set>

#include "runtime/base/radix_sort.h"
#include "runtime/sim/state/loader.h"
#include "runtime/sim/state/reading.h"

namespace meld::sim {

// Catoms of this process while they are added.
struct Loader::Free {
    struct Seat {
        std::size_t chunk;
        std::uint32_t at;
    };
    // By chunk, of all shares one after the other.
    std::vector<std::vector<tuple::SavedCatom>> here;
    // Those that are to be added, by their numbers, and where each is in the snapshot.
    std::vector<Keyed> order;
    std::vector<Seat> seats;
    // The numbers of ghosts.
    std::unordered_set<std::uint32_t> ghosts;
};

template <class Visit>
Result<void> Loader::each_places(const Visit& visit) {
    std::size_t index = 0;
    return each_chunk([&](std::size_t share, std::size_t chunk) -> Result<void> {
        const std::size_t at = index++;
        if (at < free_places_.size()) return visit(at, free_places_[at]);
        const Result<BlockView> block = shares_.places(share, chunk, room_);
        if (!block) return tl::unexpected<Error>(block.error());
        ByteReader in = reader(*block, "the places of a snapshot");
        Result<FreePlaces> all = FreePlaces::read(in);
        if (!all) return tl::unexpected<Error>(all.error());
        if (auto whole = read_to_its_end(in, "its places"); !whole) return whole;
        return visit(at, subdomain_.alone() ? free_places_.emplace_back(std::move(*all)) : *all);
    });
}

Result<void> Loader::count_homes(CountOf& count_of) {
    return each_places([&](std::size_t, const FreePlaces& all) -> Result<void> {
        for (const FreePlaces::Home& run : all.homes()) count_of[run.home] += run.count;
        return {};
    });
}

Result<void> Loader::add_freely() {
    Free free;
    free.order.reserve(mine_), free.seats.reserve(mine_);
    Result<void> done = each_places([&](std::size_t chunk, const FreePlaces& all) -> Result<void> {
        free.here.emplace_back(all.ids().size());
        std::uint32_t at = 0;
        for (const FreePlaces::Home& run : all.homes()) {
            const bool ours = subdomain_.members_.partition->owner(run.home) == subdomain_.comm.process();
            for (std::uint32_t i = 0; ours && i < run.count; ++i) {
                free.order.push_back({all.ids()[at + i], static_cast<std::uint32_t>(free.seats.size())});
                free.seats.push_back({chunk, at + i});
            }
            at += run.count;
        }
        return {};
    });
    if (done) done = add_own(free);
    if (done && !subdomain_.alone()) done = add_ghosts(free);
    if (done) done = each_places([&](std::size_t chunk, const FreePlaces& all) { return link(all, free.here[chunk]); });
    free_places_ = {};
    if (!done) return done;
    std::size_t index = 0;
    return each_chunk([&](std::size_t share, std::size_t) -> Result<void> {
        PlacedChunk& found = found_[share].emplace_back();
        for (const tuple::SavedCatom& each : free.here[index++]) each.here() ? found.add(each.catom, 1, each.owned) : found.pass(1);
        return {};
    });
}

// By their numbers, as when the run began: so their numbers give their indices.
Result<void> Loader::add_own(Free& free) {
    std::vector<Keyed> spare;
    sort_by_key(free.order, spare);
    for (std::size_t i = 0; i < free.order.size(); ++i) {
        const auto [id, place] = free.order[i];
        if (i > 0 && free.order[i - 1].key == id) return damaged(fmt::format("has catom @{} twice", id));
        const Free::Seat& seat = free.seats[place];
        free.here[seat.chunk][seat.at] = {subdomain_.members_.add_freely(id, {}, kCatomOwned, subdomain_.comm.process()), true};
    }
    return {};
}

Result<void> Loader::add_ghosts(Free& free) {
    const world::Ensemble& ensemble = subdomain_.ensemble;
    const auto beside = [&](std::size_t chunk, const FreePlaces& all) -> Result<void> {
        for (std::size_t i = 0; i < all.ids().size(); ++i)
            for (const FreePlaces::Link& link : all.links(i)) {
                const bool ours = free.here[chunk][i].here(), other_ours = ensemble.find(link.other).has_value();
                if (ours && !other_ours) free.ghosts.insert(link.other);
                if (!ours && other_ours) free.ghosts.insert(all.ids()[i]);
            }
        return {};
    };
    const auto add = [&](std::size_t chunk, const FreePlaces& all) -> Result<void> {
        Membership& m = subdomain_.members_;
        std::size_t i = 0;
        for (const FreePlaces::Home& run : all.homes())
            for (const std::size_t end = i + run.count; i < end; ++i)
                if (!free.here[chunk][i].here() && free.ghosts.erase(all.ids()[i]) > 0)
                    free.here[chunk][i] = {m.add_freely(all.ids()[i], {}, kCatomGhost, m.partition->owner(run.home)), false};
        return {};
    };
    const Result<void> found = each_places(beside);
    return found ? each_places(add) : found;
}

// Ghosts are linked with catoms of this process only.
Result<void> Loader::link(const FreePlaces& all, std::span<const tuple::SavedCatom> here) {
    world::Ensemble& ensemble = subdomain_.members_.ensemble;
    for (std::size_t i = 0; i < here.size(); ++i) {
        if (!here[i].here()) continue;
        const Catom catom = here[i].catom;
        for (const FreePlaces::Link& link : all.links(i)) {
            const std::optional<Catom> other = ensemble.find(link.other);
            if (!other || !(here[i].owned || subdomain_.owned(*other))) continue;
            // Each leads to another catom.
            const std::uint64_t most = ensemble.has_any_ports() ? bodies_ : kMaxPorts;
            const auto port = static_cast<int>(link.port), there = static_cast<int>(link.port_there);
            if (other == catom || link.port >= most || link.port_there >= most || ensemble.linked(catom, port) ||
                ensemble.linked(*other, there))
                return damaged(fmt::format("has a link of catom @{} that cannot be", all.ids()[i]));
            ensemble.link(catom, port, *other, there);
        }
    }
    return {};
}

}  // namespace meld::sim
