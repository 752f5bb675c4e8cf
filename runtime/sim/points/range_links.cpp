#include "runtime/sim/points/range_links.h"

#include <algorithm>
#include <array>
#include <limits>
#include <map>

#include "runtime/base/assert.h"
#include "runtime/base/bytes.h"
#include "runtime/comm/transport/packets.h"
#include "runtime/sim/core/migration.h"

namespace meld::sim {

using graph::Node;
using graph::Point;

namespace {

// Around the catoms of a process; empty if it has none.
struct Bounds {
    Point low, high;
    bool within(const Point& at, double range) const {
        for (std::size_t i = 0; i < 3; ++i)
            if (!(at[i] >= low[i] - range && at[i] <= high[i] + range)) return false;
        return true;
    }
};

Bounds bounds_of(const std::vector<Point>& places) {
    constexpr double kFar = std::numeric_limits<double>::infinity();
    Bounds all{{kFar, kFar, kFar}, {-kFar, -kFar, -kFar}};
    for (const Point& at : places)
        for (std::size_t i = 0; i < 3; ++i) all.low[i] = std::min(all.low[i], at[i]), all.high[i] = std::max(all.high[i], at[i]);
    return all;
}

// No rounding of a box may leave a catom out.
constexpr double kWider = 1.0001;

}  // namespace

std::optional<Node> RangeLinks::Known::find(std::uint64_t id) const {
    const auto at = std::ranges::lower_bound(order, id, {}, &std::pair<std::uint64_t, Node>::first);
    return at == order.end() || at->first != id ? std::nullopt : std::optional<Node>(at->second);
}

void RangeLinks::update(Subdomain& subdomain, const Sees& sees) {
    const Known all = known(subdomain);
    remove_long(subdomain, all, sees);
    std::vector<Missing> wanted = missing(subdomain, all, sees);
    choose_ports(subdomain, wanted);
    connect(subdomain, wanted);
}

RangeLinks::Known RangeLinks::known(Subdomain& subdomain) const {
    Known all;
    const world::Ensemble& ensemble = subdomain.ensemble;
    for (Catom c = 0; c < ensemble.index_count(); ++c) {
        if (!subdomain.owned(c)) continue;
        all.places.push_back(ensemble.position(c));
        all.ids.push_back(ensemble.id(c));
        all.owners.push_back(subdomain.comm.process());
        all.catoms.push_back(c);
    }
    if (!subdomain.alone()) add_others(subdomain, all);
    for (Node node = 0; node < all.ids.size(); ++node) all.order.emplace_back(all.ids[node], node);
    std::ranges::sort(all.order);
    return all;
}

void RangeLinks::add_others(Subdomain& subdomain, Known& all) const {
    ByteWriter mine;
    mine.write(bounds_of(all.places));
    const std::vector<std::byte> boxes = subdomain.comm.allgather(mine.view());
    ByteReader in(boxes, "the boxes of processes");
    std::vector<ByteWriter> out(static_cast<std::size_t>(subdomain.comm.processes()));
    for (int process = 0; process < subdomain.comm.processes(); ++process) {
        const auto box = in.read<Bounds>();
        if (process == subdomain.comm.process()) continue;
        for (std::size_t i = 0; i < all.catoms.size(); ++i)
            if (box.within(all.places[i], range_ * kWider)) {
                out[static_cast<std::size_t>(process)].write(all.ids[i]);
                out[static_cast<std::size_t>(process)].write(all.places[i]);
            }
    }
    for (const comm::Packet& packet : subdomain.comm.exchange(comm::take_packets(out)))
        for (ByteReader theirs(packet.bytes, "catoms near those of another process"); !theirs.done();) {
            all.ids.push_back(theirs.read<std::uint64_t>());
            all.places.push_back(theirs.read<Point>());
            all.owners.push_back(packet.process);
            if (const std::optional<Catom> ghost = subdomain.ensemble.find(all.ids.back())) subdomain.place(*ghost, all.places.back());
        }
}

void RangeLinks::remove_long(Subdomain& subdomain, const Known& all, const Sees& sees) const {
    const world::Ensemble& ensemble = subdomain.ensemble;
    std::vector<std::pair<Catom, Catom>> gone;
    for (std::size_t i = 0; i < all.catoms.size(); ++i)
        ensemble.each_link(all.catoms[i], [&](int, Catom other) {
            // One that no process has sent is out of range.
            const std::optional<Node> there = all.find(ensemble.id(other));
            if (there && graph::square_distance(all.places[i], all.places[*there]) <= range_ * range_ &&
                (!sees || sees(all.ids[i], all.ids[*there])))
                return;
            if (!subdomain.owned(other) || all.catoms[i] < other) gone.emplace_back(all.catoms[i], other);
        });
    for (const auto& [a, b] : gone) subdomain.unlink(a, b);
    for (const auto& [a, b] : gone) {
        if (ensemble.state(b) != kCatomGhost) continue;
        bool linked = false;
        subdomain.each_neighbour(b, [&](Catom) { linked = true; });
        if (!linked) subdomain.remove_freely(b);
    }
}

std::vector<RangeLinks::Missing> RangeLinks::missing(const Subdomain& subdomain, const Known& all, const Sees& sees) const {
    graph::PointGrid grid(range_);
    for (Node node = 0; node < all.places.size(); ++node) grid.add(node, all.places[node]);
    const world::Ensemble& ensemble = subdomain.ensemble;
    std::vector<Missing> wanted;
    std::vector<std::uint64_t> linked;
    for (Node node = 0; node < all.catoms.size(); ++node) {
        linked.clear();
        ensemble.each_link(all.catoms[node], [&](int, Catom other) { linked.push_back(ensemble.id(other)); });
        std::ranges::sort(linked);
        grid.each_within(node, all.places, [&](Node other) {
            if (!std::ranges::binary_search(linked, all.ids[other]) && (!sees || sees(all.ids[node], all.ids[other])))
                wanted.push_back({.here = all.ids[node], .there = all.ids[other], .owner = all.owners[other]});
        });
    }
    std::ranges::sort(wanted, {}, [](const Missing& one) { return std::pair(one.here, one.there); });
    return wanted;
}

void RangeLinks::choose_ports(const Subdomain& subdomain, std::vector<Missing>& missing) {
    const world::Ensemble& ensemble = subdomain.ensemble;
    int port = 0;
    for (std::size_t i = 0; i < missing.size(); ++i) {
        port = i > 0 && missing[i - 1].here == missing[i].here ? port + 1 : 0;
        const Catom catom = *ensemble.find(missing[i].here);
        while (ensemble.linked(catom, port)) ++port;
        missing[i].port = port;
    }
}

void RangeLinks::connect(Subdomain& subdomain, const std::vector<Missing>& missing) {
    const int process = subdomain.comm.process();
    // The ports of ends elsewhere, by both numbers: theirs first.
    std::map<std::pair<std::uint64_t, std::uint64_t>, int> theirs;
    if (!subdomain.alone()) {
        std::vector<ByteWriter> out(static_cast<std::size_t>(subdomain.comm.processes()));
        for (const Missing& one : missing) {
            if (one.owner == process) continue;
            ByteWriter& bytes = out[static_cast<std::size_t>(one.owner)];
            const Catom catom = *subdomain.ensemble.find(one.here);
            bytes.write(one.there);
            bytes.write(one.port);
            bytes.write(subdomain.ensemble.position(catom));
            pack_migrant(subdomain, catom, kCatomGhost).write(bytes);
        }
        for (const comm::Packet& packet : subdomain.comm.exchange(comm::take_packets(out)))
            for (ByteReader in(packet.bytes, "the ends of links that are made"); !in.done();) {
                const auto to = in.read<std::uint64_t>();
                const auto port = in.read<int>();
                const auto position = in.read<world::Vec3>();
                const Migrant who = Migrant::read(in);
                theirs[{who.id, to}] = port;
                if (!subdomain.ensemble.find(who.id)) add_migrant_freely(subdomain, who, position, packet.process);
            }
    }
    for (const Missing& one : missing) {
        const Catom here = *subdomain.ensemble.find(one.here);
        if (one.owner == process) {
            if (one.here > one.there) continue;
            const auto back = std::ranges::lower_bound(missing, std::pair(one.there, one.here), {},
                                                       [](const Missing& each) { return std::pair(each.here, each.there); });
            MELD_CHECK(back != missing.end() && back->here == one.there && back->there == one.here, "a link from @{} to @{} has one end",
                       one.here, one.there);
            subdomain.link(here, one.port, *subdomain.ensemble.find(one.there), back->port);
            continue;
        }
        const auto port = theirs.find({one.there, one.here});
        MELD_CHECK(port != theirs.end(), "@{} is in range of @{} on one process only", one.there, one.here);
        subdomain.link(here, one.port, *subdomain.ensemble.find(one.there), port->second);
    }
}

}  // namespace meld::sim
