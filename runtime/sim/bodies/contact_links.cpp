// Links are made in two steps, in the same way for any number of processes: each catom promises its lowest free ports to the catoms that it
// has begun to touch, in the order of their numbers; if both have promised one, they are linked.
#include "runtime/sim/bodies/contact_links.h"

#include <algorithm>
#include <iterator>
#include <utility>

#include "runtime/base/assert.h"
#include "runtime/base/bytes.h"
#include "runtime/base/release_memory.h"

namespace meld::sim {

namespace {

// Memory for up to this many pairs is not worth freeing.
constexpr std::size_t kFewPairs = 4096;
static_assert(kMaxPorts <= 16, "promised ports are bits of 16");

// Our catom with this number, if there is one.
std::optional<Catom> ours(const Subdomain& subdomain, physics::BodyId id) {
    const std::optional<Catom> catom = subdomain.ensemble.find(id);
    return catom && subdomain.owned(*catom) ? catom : std::nullopt;
}

}  // namespace

void forget_if_lonely(Subdomain& subdomain, Catom ghost) {
    if (subdomain.owned(ghost)) return;
    bool linked = false;
    subdomain.each_neighbour(ghost, [&](Catom) { linked = true; });
    if (!linked) subdomain.remove_freely(ghost);
}

void ContactLinks::note(Subdomain& subdomain, std::span<const physics::TouchEvent> found, std::span<const physics::TouchEvent> parted,
                        const DividedBodies* divided) {
    std::vector<physics::TouchEvent> shared;
    if (divided != nullptr) {
        shared = share(subdomain, found, *divided);
        for (const physics::TouchEvent& e : parted)
            if (ours(subdomain, e.touch.body) || ours(subdomain, e.touch.other)) shared.push_back(e);
        if (!parted.empty()) std::sort(shared.begin(), shared.end());
        found = shared;
    }
    std::vector<Pair> begun, ended;
    const auto beginnings =
        std::count_if(found.begin(), found.end(), [](const physics::TouchEvent& e) { return e.began && !e.touch.other_is_obstacle; });
    begun.reserve(static_cast<std::size_t>(beginnings));
    for (const physics::TouchEvent& e : found)
        if (!e.touch.other_is_obstacle) (e.began ? begun : ended).push_back({e.touch.body, e.touch.other});
    // Touches that have ended make room for those that have begun.
    end(subdomain, ended);
    begin(std::move(begun));
}

void ContactLinks::connect(Subdomain& subdomain, const DividedBodies* divided) {
    // All processes take part in an exchange, even without data.
    if (waiting_.empty() && divided == nullptr) return;
    make_offers(subdomain);
    if (divided != nullptr) exchange_offers(subdomain, *divided);
    connect_promised(subdomain);
}

// The process that owns a pair's block sees its events; it sends them to the owners of both catoms.
std::vector<physics::TouchEvent> ContactLinks::share(Subdomain& subdomain, std::span<const physics::TouchEvent> events,
                                                     const DividedBodies& divided) const {
    std::vector<physics::TouchEvent> mine;
    std::vector<ByteWriter> out(static_cast<std::size_t>(subdomain.comm.processes()));
    for (const physics::TouchEvent& e : events) {
        if (e.touch.other_is_obstacle) continue;
        const int owners[] = {divided.owner_of(e.touch.body), divided.owner_of(e.touch.other)};
        for (int i = 0; i < (owners[0] == owners[1] ? 1 : 2); ++i) {
            if (owners[i] == subdomain.comm.process()) {
                mine.push_back(e);
                continue;
            }
            ByteWriter& bytes = out[static_cast<std::size_t>(owners[i])];
            bytes.write(e.touch.body);
            bytes.write(physics::BodyId{e.touch.other});
            bytes.write(e.began);
        }
    }
    for (const comm::Packet& packet : exchange_bytes(subdomain, out))
        for (ByteReader in(packet.bytes, "touches that begin and end"); !in.done();) {
            const auto body = in.read<physics::BodyId>(), other = in.read<physics::BodyId>();
            mine.push_back({{body, other, false}, in.read<bool>()});
        }
    std::sort(mine.begin(), mine.end());
    return mine;
}

void ContactLinks::end(Subdomain& subdomain, const std::vector<Pair>& ended) {
    for (const Pair& pair : ended) {
        if (std::binary_search(waiting_.begin(), waiting_.end(), pair)) continue;
        const std::optional<Catom> a = subdomain.ensemble.find(pair.first), b = subdomain.ensemble.find(pair.second);
        MELD_CHECK(a && b, "catoms @{} and @{} part and are not known", pair.first, pair.second);
        subdomain.unlink(*a, *b);
        for (const Catom catom : {*a, *b}) forget_if_lonely(subdomain, catom);
    }
    if (!waiting_.empty()) std::erase_if(waiting_, [&](const Pair& pair) { return std::binary_search(ended.begin(), ended.end(), pair); });
}

void ContactLinks::begin(std::vector<Pair> begun) {
    if (waiting_.empty()) {
        waiting_ = std::move(begun);
        waiting_.erase(std::unique(waiting_.begin(), waiting_.end()), waiting_.end());
        return;
    }
    const auto middle = static_cast<std::ptrdiff_t>(waiting_.size());
    waiting_.insert(waiting_.end(), begun.begin(), begun.end());
    std::inplace_merge(waiting_.begin(), waiting_.begin() + middle, waiting_.end());
    waiting_.erase(std::unique(waiting_.begin(), waiting_.end()), waiting_.end());
}

void ContactLinks::change_hands(const Subdomain& subdomain, const std::vector<Pair>& arrived) {
    std::vector<Pair> sorted = arrived;
    std::sort(sorted.begin(), sorted.end());
    begin(std::move(sorted));
    std::erase_if(waiting_, [&](const Pair& pair) { return !ours(subdomain, pair.first) && !ours(subdomain, pair.second); });
}

void ContactLinks::forget(const std::vector<physics::BodyId>& lost) {
    const auto is_lost = [&](physics::BodyId id) { return std::binary_search(lost.begin(), lost.end(), id); };
    std::erase_if(waiting_, [&](const Pair& pair) { return is_lost(pair.first) || is_lost(pair.second); });
}

int ContactLinks::lowest_free_port(const Subdomain& subdomain, Catom catom) {
    MELD_EXPECT(catom < taken_.size(), "catom {} of {}", catom, taken_.size());
    for (int port = 0; port < kMaxPorts; ++port) {
        if ((taken_[catom] >> port & 1) != 0 || subdomain.ensemble.linked(catom, port)) continue;
        taken_[catom] = static_cast<std::uint16_t>(taken_[catom] | 1u << port);
        return port;
    }
    return -1;
}

void ContactLinks::make_offers(const Subdomain& subdomain) {
    offered_.assign(waiting_.size(), {-1, -1});
    taken_.resize(subdomain.ensemble.index_count());
    const auto offer = [&](std::size_t i, physics::BodyId from, std::size_t end) {
        if (const std::optional<Catom> catom = ours(subdomain, from))
            offered_[i][end] = static_cast<std::int8_t>(lowest_free_port(subdomain, *catom));
    };
    for (std::size_t i = 0; i < waiting_.size(); ++i) {
        offer(i, waiting_[i].first, 0);
        offer(i, waiting_[i].second, 1);
    }
    for (const Pair& pair : waiting_)
        for (const physics::BodyId id : {pair.first, pair.second})
            if (const std::optional<Catom> catom = ours(subdomain, id)) taken_[*catom] = 0;
    MELD_ENSURE(std::all_of(taken_.begin(), taken_.end(), [](std::uint16_t ports) { return ports == 0; }));
}

void ContactLinks::exchange_offers(Subdomain& subdomain, const DividedBodies& divided) {
    offers_.clear();
    std::vector<ByteWriter> out(static_cast<std::size_t>(subdomain.comm.processes()));
    const auto send = [&](physics::BodyId from, physics::BodyId to, int port) {
        const int owner = port < 0 ? subdomain.comm.process() : divided.owner_of(to);
        if (owner == subdomain.comm.process()) return;
        const Catom catom = *subdomain.ensemble.find(from);
        ByteWriter& bytes = out[static_cast<std::size_t>(owner)];
        bytes.write(to);
        bytes.write(port);
        bytes.write(subdomain.ensemble.position(catom));
        pack_migrant(subdomain, catom, kCatomGhost).write(bytes);
    };
    for (std::size_t i = 0; i < waiting_.size(); ++i) {
        send(waiting_[i].first, waiting_[i].second, offered_[i][0]);
        send(waiting_[i].second, waiting_[i].first, offered_[i][1]);
    }
    for (const comm::Packet& packet : exchange_bytes(subdomain, out))
        for (ByteReader in(packet.bytes, "offered ports"); !in.done();) {
            const auto to_us = in.read<physics::BodyId>();
            Offer offer{.port = in.read<int>(), .owner = packet.process, .position = in.read<world::Vec3>(), .who = Migrant::read(in)};
            const auto from = static_cast<physics::BodyId>(offer.who.id);
            offers_[{from, to_us}] = std::move(offer);
        }
}

std::optional<ContactLinks::Side> ContactLinks::side(Subdomain& subdomain, physics::BodyId from, physics::BodyId to, int offered) const {
    if (offered >= 0) return Side{*subdomain.ensemble.find(from), offered};
    const auto received = offers_.find({from, to});
    if (received == offers_.end()) return std::nullopt;
    const Offer& offer = received->second;
    std::optional<Catom> ghost = subdomain.ensemble.find(from);
    if (!ghost) ghost = add_migrant_freely(subdomain, offer.who, offer.position, offer.owner);
    return Side{*ghost, offer.port};
}

void ContactLinks::connect_promised(Subdomain& subdomain) {
    MELD_EXPECT(offered_.size() == waiting_.size() && std::is_sorted(waiting_.begin(), waiting_.end()), "{} pairs", waiting_.size());
    std::size_t kept = 0;
    for (std::size_t i = 0; i < waiting_.size(); ++i) {
        const auto [first, second] = waiting_[i];
        const bool both =
            (offered_[i][0] >= 0 || offers_.contains({first, second})) && (offered_[i][1] >= 0 || offers_.contains({second, first}));
        if (!both) {
            waiting_[kept++] = waiting_[i];
            continue;
        }
        const Side a = *side(subdomain, first, second, offered_[i][0]), b = *side(subdomain, second, first, offered_[i][1]);
        subdomain.link(a.catom, a.port, b.catom, b.port);
    }
    waiting_.resize(kept);
    // After the first step, which has brought all touches at once, their memory is freed.
    if (waiting_.capacity() > std::max(kFewPairs, 4 * kept)) {
        waiting_.shrink_to_fit();
        release_memory(offered_);
    }
}

}  // namespace meld::sim
