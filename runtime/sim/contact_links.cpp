// Links come about in two steps, alike for any number of parts: each catom promises its lowest free ports to those that it has
// come to touch, in the order of their numbers; where both have promised one, they are linked.
#include "runtime/sim/contact_links.h"

#include <algorithm>

#include "runtime/base/assert.h"
#include "runtime/sim/bytes.h"

namespace meld::sim {

namespace {

bool is_ours(const PartState& part, std::uint64_t id) {
    const std::optional<Catom> catom = part.ensemble.find(id);
    return catom && part.owned(*catom);
}

}  // namespace

void forget_if_lonely(PartState& part, Catom ghost) {
    if (part.owned(ghost)) return;
    for (int port = 0; port < kMaxPorts; ++port)
        if (part.ensemble.linked(ghost, port)) return;
    part.remove_freely(ghost);
}

void ContactLinks::update(PartState& part, std::span<const physics::TouchEvent> found, const DividedBodies* divided) {
    std::vector<physics::TouchEvent> events(found.begin(), found.end());
    std::erase_if(events, [](const physics::TouchEvent& e) { return e.touch.other_is_obstacle; });
    if (divided != nullptr) events = share(part, events, *divided);
    // What has ended makes room for what has begun.
    for (const physics::TouchEvent& e : events)
        if (!e.began) end(part, {e.touch.body, e.touch.other});
    for (const physics::TouchEvent& e : events)
        if (e.began) waiting.insert({e.touch.body, e.touch.other});
    offers_.clear();
    taken_.clear();
    for (const Pair& pair : waiting) {
        offer(part, pair.first, pair.second);
        offer(part, pair.second, pair.first);
    }
    if (divided != nullptr) exchange_offers(part, *divided);
    connect(part);
}

// The part that owns a pair's block has seen what befell it; the owners of both catoms are told.
std::vector<physics::TouchEvent> ContactLinks::share(PartState& part, std::span<const physics::TouchEvent> events, const DividedBodies& divided) const {
    std::vector<physics::TouchEvent> ours;
    std::vector<std::vector<std::byte>> out(static_cast<std::size_t>(part.comm.parts()));
    for (const physics::TouchEvent& e : events) {
        const int owners[] = {divided.owner_of(e.touch.body), divided.owner_of(e.touch.other)};
        for (int i = 0; i < (owners[0] == owners[1] ? 1 : 2); ++i) {
            if (owners[i] == part.comm.part()) {
                ours.push_back(e);
                continue;
            }
            std::vector<std::byte>& bytes = out[static_cast<std::size_t>(owners[i])];
            put(bytes, e.touch.body);
            put(bytes, e.touch.other);
            put(bytes, e.began);
        }
    }
    for (const comm::Packet& packet : exchange_bytes(part, out))
        for (const std::byte* at = packet.bytes.data(); at != packet.bytes.data() + packet.bytes.size();) {
            physics::TouchEvent e{};
            e.touch.body = take_value<physics::BodyId>(at);
            e.touch.other = take_value<std::uint32_t>(at);
            e.began = take_value<bool>(at);
            ours.push_back(e);
        }
    std::sort(ours.begin(), ours.end());
    return ours;
}

void ContactLinks::end(PartState& part, Pair ids) {
    if (waiting.erase(ids) > 0) return;
    const std::optional<Catom> a = part.ensemble.find(ids.first), b = part.ensemble.find(ids.second);
    const std::optional<int> port = a && b ? part.ensemble.port_towards(*a, *b) : std::nullopt;
    MELD_CHECK(port.has_value(), "catoms {} and {} part and were never linked", ids.first, ids.second);
    part.ensemble.unlink(*a, *port);
    for (const Catom catom : {*a, *b}) {
        part.mark(catom, kDirtyLinks);
        forget_if_lonely(part, catom);
    }
}

void ContactLinks::offer(PartState& part, std::uint64_t from, std::uint64_t to) {
    if (!is_ours(part, from)) return;
    const Catom catom = *part.ensemble.find(from);
    std::uint32_t& taken = taken_[from];
    for (int port = 0; port < kMaxPorts; ++port) {
        if ((taken >> port & 1) != 0 || part.ensemble.linked(catom, port)) continue;
        taken |= std::uint32_t{1} << port;
        offers_[{from, to}] = {.port = port, .owner = part.comm.part()};
        return;
    }
}

void ContactLinks::exchange_offers(PartState& part, const DividedBodies& divided) {
    std::vector<std::vector<std::byte>> out(static_cast<std::size_t>(part.comm.parts()));
    for (const auto& [ids, offer] : offers_) {
        const int to = divided.owner_of(static_cast<physics::BodyId>(ids.second));
        if (to == part.comm.part()) continue;
        const Catom catom = *part.ensemble.find(ids.first);
        std::vector<std::byte>& bytes = out[static_cast<std::size_t>(to)];
        put(bytes, ids.first);
        put(bytes, ids.second);
        put(bytes, offer.port);
        put(bytes, part.ensemble.position(catom));
        std::vector<std::byte> exports;
        part.columns.pack(catom, tuple::Columns::Which::Exported, exports);
        put(bytes, static_cast<std::uint32_t>(exports.size()));
        bytes.insert(bytes.end(), exports.begin(), exports.end());
    }
    for (const comm::Packet& packet : exchange_bytes(part, out))
        for (const std::byte* at = packet.bytes.data(); at != packet.bytes.data() + packet.bytes.size();) {
            const auto from = take_value<std::uint64_t>(at), to_us = take_value<std::uint64_t>(at);
            Offer& offer = offers_[{from, to_us}];
            offer.port = take_value<int>(at);
            offer.owner = packet.part;
            offer.position = take_value<world::Vec3>(at);
            const auto size = take_value<std::uint32_t>(at);
            offer.exports.assign(at, at + size);
            at += size;
        }
}

Catom ContactLinks::known(PartState& part, std::uint64_t id, const Offer& offer) const {
    if (const std::optional<Catom> catom = part.ensemble.find(id)) return *catom;
    const Catom ghost = part.add_freely(id, offer.position, kCatomGhost, offer.owner);
    part.columns.unpack(ghost, tuple::Columns::Which::Exported, offer.exports.data(), 0);
    return ghost;
}

void ContactLinks::connect(PartState& part) {
    for (auto it = waiting.begin(); it != waiting.end();) {
        const auto first = offers_.find(*it), second = offers_.find({it->second, it->first});
        if (first == offers_.end() || second == offers_.end()) {
            ++it;
            continue;
        }
        const Catom a = known(part, it->first, first->second), b = known(part, it->second, second->second);
        part.ensemble.link(a, first->second.port, b, second->second.port);
        for (const Catom catom : {a, b}) part.mark(catom, kDirtyLinks);
        it = waiting.erase(it);
    }
}

}  // namespace meld::sim
