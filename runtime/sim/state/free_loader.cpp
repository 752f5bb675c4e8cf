// Setting up catoms at arbitrary positions from a snapshot: those whose homes are this process's, then ghosts of those that are linked
// with them, and the links.
#include <algorithm>
#include <optional>

#include "runtime/sim/state/loader.h"
#include "runtime/sim/state/reading.h"

namespace meld::sim {

Result<FreePlaces> Loader::free_places(std::size_t share, std::size_t chunk) const {
    const Result<Block> block = shares_.places(share, chunk);
    if (!block) return tl::unexpected<Error>(block.error());
    ByteReader in = reader(*block, "the places of a snapshot");
    FreePlaces all = FreePlaces::read(in);
    if (auto whole = read_to_its_end(in, "its places"); !whole) return tl::unexpected<Error>(whole.error());
    return all;
}

Result<void> Loader::count_homes(CountOf& count_of) const {
    return each_chunk([&](std::size_t share, std::size_t chunk) -> Result<void> {
        const Result<FreePlaces> all = free_places(share, chunk);
        if (!all) return tl::unexpected<Error>(all.error());
        for (const world::BrickKey home : all->homes()) ++count_of[home];
        return {};
    });
}

Result<void> Loader::add_freely() {
    // The numbers that are linked with catoms of this process.
    std::unordered_set<std::uint64_t> beside;
    const Result<void> added = each_chunk([&](std::size_t share, std::size_t chunk) -> Result<void> {
        const Result<FreePlaces> all = free_places(share, chunk);
        if (!all) return tl::unexpected<Error>(all.error());
        return add_own(*all, found_[share].emplace_back(all->ids().size()), beside);
    });
    if (!added || subdomain_.alone()) return added;
    return each_chunk([&](std::size_t share, std::size_t chunk) -> Result<void> {
        const Result<FreePlaces> all = free_places(share, chunk);
        if (!all) return tl::unexpected<Error>(all.error());
        Found& found = found_[share][chunk];
        if (auto done = add_ghosts(*all, found, beside); !done) return done;
        if (std::none_of(found.begin(), found.end(), [](const tuple::SavedCatom& each) { return each.here(); })) found.clear();
        return {};
    });
}

Result<void> Loader::add_own(const FreePlaces& all, Found& found, std::unordered_set<std::uint64_t>& beside) {
    Membership& m = subdomain_.members_;
    const int rank = subdomain_.comm.process();
    for (std::size_t i = 0; i < found.size(); ++i) {
        if (m.partition->owner(all.homes()[i]) != rank) continue;
        if (m.ensemble.find(all.ids()[i])) return damaged(fmt::format("has catom @{} twice", all.ids()[i]));
        found[i] = {m.add_freely(all.ids()[i], {}, kCatomOwned, rank), true};
        if (auto linked = link(found[i].catom, all.links(i)); !linked) return linked;
        if (subdomain_.alone()) continue;
        for (const FreePlaces::Link& link : all.links(i)) beside.insert(link.other);
    }
    return {};
}

Result<void> Loader::add_ghosts(const FreePlaces& all, Found& found, const std::unordered_set<std::uint64_t>& beside) {
    Membership& m = subdomain_.members_;
    for (std::size_t i = 0; i < found.size(); ++i) {
        if (found[i].here() || !beside.contains(all.ids()[i])) continue;
        found[i] = {m.add_freely(all.ids()[i], {}, kCatomGhost, m.partition->owner(all.homes()[i])), false};
        if (auto linked = link(found[i].catom, all.links(i)); !linked) return linked;
    }
    return {};
}

// With those that are here already; the others will do it when they come. Ghosts are linked with catoms of this process only.
Result<void> Loader::link(Catom catom, std::span<const FreePlaces::Link> links) {
    world::Ensemble& ensemble = subdomain_.members_.ensemble;
    for (const FreePlaces::Link& link : links) {
        const std::optional<Catom> other = ensemble.find(link.other);
        if (!other || !(subdomain_.owned(catom) || subdomain_.owned(*other))) continue;
        if (other == catom || link.port >= kMaxPorts || link.port_there >= kMaxPorts || ensemble.linked(catom, link.port) ||
            ensemble.linked(*other, link.port_there))
            return damaged(fmt::format("has a link of catom @{} that cannot be", ensemble.id(catom)));
        ensemble.link(catom, link.port, *other, link.port_there);
    }
    return {};
}

}  // namespace meld::sim
