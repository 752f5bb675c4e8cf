// Lattice motion of amoebots: expansions, contractions and handovers (docs/amoebots.md; Daymude, Richa, Scheideler, "The canonical amoebot
// model", 2023).
#include <fmt/format.h>

#include <algorithm>
#include <string_view>

#include "runtime/base/assert.h"
#include "runtime/base/bytes.h"
#include "runtime/base/units.h"
#include "runtime/comm/transport/packets.h"
#include "runtime/engine/tuple/values.h"
#include "runtime/sim/lattice/lattice_motion.h"

namespace meld::sim {

LatticeMotion::Objection LatticeMotion::propose_amoebot(const Subdomain& subdomain, const eval::Action& action, Proposal& p,
                                                        std::vector<CellKey>& claims) const {
    const world::Ensemble& ensemble = subdomain.ensemble;
    const bool expanded = ensemble.expanded(action.catom), needs_two = p.kind == ActionKind::Contract || p.kind == ActionKind::Pull;
    if (needs_two != expanded) return expanded ? Refusal::IsExpanded : Refusal::IsContracted;
    // It claims itself, as all do whose actions are collected.
    const Cell tail = ensemble.tail(action.catom);
    if (p.kind == ActionKind::Contract) {
        const std::string_view end = tuple::bytes_of(action.arguments[0].list);
        if (end != "head" && end != "tail") return Refusal::NoSuchEnd;
        p.to = p.tail = end == "head" ? p.from : tail;
        p.left = end == "head" ? tail : p.from;
        p.direction = end == "head" ? 0 : 1;
        return std::nullopt;
    }
    const Geometry& g = subdomain.geometry();
    const std::int64_t port = action.arguments[0].integer;
    if (port < 0 || port >= places_of(g, action.catom)) return Refusal::NoSuchPort;
    p.direction = static_cast<std::int32_t>(port);
    const bool head = port < kDirections;
    const Cell here = head ? p.from : tail;
    const i32 direction = lattice_direction(g.catom_compass[action.catom], p.direction % kDirections);
    const Cell cell = lattice_.neighbour(here, direction);
    if (!world::Lattice::in_range(cell)) return Refusal::Outside;
    if (p.kind == ActionKind::Pull) {
        p.to = p.tail = head ? tail : p.from;
        p.left = here;
        return propose_handover(subdomain, cell, here, p, claims);
    }
    p.to = cell;
    p.tail = p.from;
    if (p.kind == ActionKind::Push) return propose_handover(subdomain, cell, cell, p, claims);
    const std::uint32_t site = ensemble.site_beside(action.catom, world::Ensemble::End::Head, direction);
    if (ensemble.full_at(site)) return Refusal::Occupied;
    claims.push_back(ensemble.key_at(site));
    return std::nullopt;
}

// With the amoebot in a cell, which is expanded if it is pushed and contracted if it is pulled.
LatticeMotion::Objection LatticeMotion::propose_handover(const Subdomain& subdomain, Cell cell, Cell given, Proposal& p,
                                                         std::vector<CellKey>& claims) const {
    MELD_EXPECT(world::Lattice::in_range(given), "cell {} {}", given.x, given.y);
    const std::optional<Catom> other = subdomain.ensemble.at(cell);
    if (!other || *other == p.mover) return Refusal::NotANeighbour;
    const bool expanded = subdomain.ensemble.expanded(*other);
    if (expanded != (p.kind == ActionKind::Push)) return expanded ? Refusal::OtherExpanded : Refusal::OtherContracted;
    p.partner = subdomain.ensemble.cell(*other);
    claims.push_back(kBody | subdomain.ensemble.key(p.partner));
    return std::nullopt;
}

void LatticeMotion::grant_amoebot(Subdomain& subdomain, const Proposal& p) {
    reshape(subdomain, p.mover, p.to, p.tail);
    if (p.kind == ActionKind::Expand) ++moves_.expansions;
    if (p.kind == ActionKind::Contract) ++moves_.contractions;
    if (p.kind != ActionKind::Push && p.kind != ActionKind::Pull) return;
    ++moves_.handovers;
    const std::optional<Catom> other = subdomain.ensemble.at(p.partner);
    MELD_CHECK(other.has_value(), "nobody is in ({}, {})", p.partner.x, p.partner.y);
    Partner partner{p.partner, p.left, p.partner};
    if (p.kind == ActionKind::Push) {
        const Cell tail = subdomain.ensemble.tail(*other);
        partner.head = partner.tail = p.to == p.partner ? tail : p.partner;
    }
    const int owner = subdomain.alone() ? 0 : subdomain.halo->owner(p.partner);
    if (owner == subdomain.comm.process())
        reshape(subdomain, *other, partner.head, partner.tail);
    else
        partners_elsewhere_[static_cast<std::size_t>(owner)].write(partner);
}

void LatticeMotion::exchange_partners(Subdomain& subdomain) {
    if (subdomain.alone()) return;
    for (const comm::Packet& packet : subdomain.comm.exchange(comm::take_packets(partners_elsewhere_)))
        for (ByteReader in(packet.bytes, "amoebots that are pushed or pulled"); !in.done();) {
            const auto partner = in.read<Partner>();
            const std::optional<Catom> catom = subdomain.ensemble.at(partner.at);
            MELD_CHECK(catom && subdomain.owned(*catom), "nobody of this process is in ({}, {})", partner.at.x, partner.at.y);
            reshape(subdomain, *catom, partner.head, partner.tail);
        }
}

// An amoebot of this process goes to these cells. Who knows it before and afterwards changes it in place, except where it gets another
// owner.
void LatticeMotion::reshape(Subdomain& subdomain, Catom catom, Cell head, Cell tail) {
    const Cell from = subdomain.ensemble.cell(catom);
    const Change change{.kind = head == tail ? Change::Kind::Shrink : Change::Kind::Grow, .cell = from, .to = head, .tail = tail};
    if (subdomain.alone()) {
        mine_.push_back(change);
        mine_.back().catom = catom;
        return;
    }
    const int me = subdomain.comm.process(), owner = subdomain.halo->owner(head);
    const std::vector<int> before = subdomain.halo->listeners(from), after = head == from ? before : subdomain.halo->listeners(head);
    const auto stays = [&](int other) {
        return std::ranges::binary_search(before, other) && std::ranges::binary_search(after, other) && (other == me) == (other == owner);
    };
    for (const int other : before)
        if (!stays(other)) tell(other, me, {.kind = Change::Kind::Remove, .cell = from});
    for (const int other : after) {
        if (stays(other)) {
            tell(other, me, change);
            continue;
        }
        const CatomState there = other == owner ? kCatomOwned : kCatomGhost;
        tell(other, me,
             {.kind = Change::Kind::Add,
              .held = held_[catom],
              .cell = head,
              .tail = tail,
              .turn = activation_.turn(catom),
              .who = pack_migrant(subdomain, catom, there)});
    }
}

// Of each its turn, and where its tail is: the lattice's direction from its head, or that there is none.
void LatticeMotion::save_tails(const Subdomain& subdomain, std::span<const Catom> catoms, ByteWriter& out) const {
    for (const Catom catom : catoms) {
        std::uint8_t direction = 0;
        const Cell head = subdomain.ensemble.cell(catom), tail = subdomain.ensemble.tail(catom);
        while (direction < kDirections && lattice_.neighbour(head, direction) != tail) ++direction;
        out.write(direction);
        out.write(activation_.turn(catom));
    }
}

void LatticeMotion::load_tails(Subdomain& subdomain, std::span<const tuple::SavedCatom> catoms, ByteReader& in) {
    for (const tuple::SavedCatom& each : catoms) {
        const auto direction = in.read<std::uint8_t>();
        const auto turn = in.read<std::uint8_t>();
        if (!each.here()) continue;
        if (direction < kDirections) subdomain.restore_tail(each.catom, lattice_.neighbour(subdomain.ensemble.cell(each.catom), direction));
        activation_.set_turn(subdomain, each.catom, turn);
    }
}

std::string LatticeMotion::outcome_of_amoebots() const {
    std::string text = fmt::format("amoebots: {} expansions, {} contractions, {} handovers", grouped(moves_.expansions),
                                   grouped(moves_.contractions), grouped(moves_.handovers));
    if (activation_.activations() > 0) text += fmt::format("; {} activations", grouped(activation_.activations()));
    if (const auto rounds = activation_.rounds()) text += fmt::format(" in {} rounds", grouped(static_cast<std::uint64_t>(*rounds)));
    return text;
}

}  // namespace meld::sim
