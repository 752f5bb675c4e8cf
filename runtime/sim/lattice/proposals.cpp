// Lattice motion, first half: from actions to proposals, and which of them are granted.
#include <algorithm>
#include <bit>

#include "runtime/base/assert.h"
#include "runtime/base/bytes.h"
#include "runtime/base/hash.h"
#include "runtime/comm/transport/packets.h"
#include "runtime/module/abi/actions.h"
#include "runtime/sim/lattice/around.h"
#include "runtime/sim/lattice/lattice_motion.h"
#include "runtime/sim/lattice/ties.h"

namespace meld::sim {

namespace {

using Proposal = LatticeMotion::Proposal;
using Proposals = LatticeMotion::Proposals;

constexpr CellKey kBody = LatticeMotion::kBody;

// Whether a cell of the catom is empty afterwards.
bool leaves(const Proposal& p) {
    switch (p.kind) {
        case ActionKind::Destroy:
        case ActionKind::MoveTo:
        case ActionKind::Slide:
        case ActionKind::Turn:
        case ActionKind::MoveAround:
        case ActionKind::Move:
        case ActionKind::Contract:
            return true;
        default:
            return false;
    }
}

// Whether it leads to a cell nearby, which where there is a table of moves must be one of these.
bool goes_a_way(ActionKind kind) { return kind == ActionKind::Slide || kind == ActionKind::Turn || kind == ActionKind::MoveAround; }

// The best proposal by claim: open addressing in one array, because there are several lookups per mover and tick.
class Claims {
  public:
    explicit Claims(std::size_t claims) { slots_.resize(std::bit_ceil((claims + 16) * 2)); }
    const Proposal*& at(CellKey key) {
        // That cell is never in the highest brick.
        MELD_EXPECT(key != kEmpty, "a claim on the cell that stands for none");
        for (std::size_t i = mix64(key) & (slots_.size() - 1);; i = (i + 1) & (slots_.size() - 1)) {
            if (slots_[i].key == kEmpty) slots_[i].key = key;
            if (slots_[i].key == key) return slots_[i].best;
        }
    }

  private:
    static constexpr CellKey kEmpty = ~CellKey{0};
    struct Slot {
        CellKey key = kEmpty;
        const Proposal* best = nullptr;
    };
    std::vector<Slot> slots_;
};

// With keep_connected, moves rest on catoms, and others ask to leave their cells. Moves may share what they rest on, so these are not
// claims.
class Ties {
  public:
    Ties(const Subdomain& subdomain, const Proposals& all)
        : subdomain_(subdomain), none_(all.rests.empty()), first_(none_ ? 0 : 2 * (all.rests.size() + all.list.size())) {
        if (none_) return;
        for (const Proposal& p : all.list) {
            for (const CellKey cell : all.rests_of(p)) improve(first_.at(cell), p);
            if (leaves(p)) improve(first_.at(kBody | key(p)), p);
        }
    }
    // Whether nobody with priority leaves what the proposal rests on, or rests on the catom that it moves.
    bool hold(const Proposals& mine, const Proposal& p) {
        if (none_) return true;
        const auto yields = [&](const Proposal* other) { return other != nullptr && other->order() < p.order(); };
        for (const CellKey cell : mine.rests_of(p))
            if (yields(first_.at(kBody | cell))) return false;
        return !leaves(p) || !yields(first_.at(key(p)));
    }

  private:
    static void improve(const Proposal*& first, const Proposal& p) {
        if (first == nullptr || p.order() < first->order()) first = &p;
    }
    CellKey key(const Proposal& p) const { return subdomain_.ensemble.key(p.left); }

    const Subdomain& subdomain_;
    bool none_;
    Claims first_;  // By cell, who rests on its catom; by kBody | cell, who leaves it.
};

void write_proposal(ByteWriter& out, const Proposals& from, const Proposal& p) {
    out.write(p);
    for (std::uint32_t i = 0; i < p.claim_count; ++i) out.write(from.claims[p.first_claim + i]);
    for (const CellKey cell : from.rests_of(p)) out.write(cell);
}

void read_proposal(ByteReader& in, Proposals& to) {
    Proposal p = in.read<Proposal>();
    MELD_CHECK(std::uint64_t{p.claim_count} + p.rest_count <= in.left() / sizeof(CellKey),
               "a proposal of catom @{} with {} claims and {} rests in {} bytes", p.id, p.claim_count, p.rest_count, in.left());
    p.first_claim = static_cast<std::uint32_t>(to.claims.size());
    for (std::uint32_t i = 0; i < p.claim_count; ++i) to.claims.push_back(in.read<CellKey>());
    p.first_rest = static_cast<std::uint32_t>(to.rests.size());
    for (std::uint32_t i = 0; i < p.rest_count; ++i) to.rests.push_back(in.read<CellKey>());
    to.list.push_back(p);
}

}  // namespace

// The actions of this process's catoms as proposals; those whose conditions do not hold are refused at once.
Proposals LatticeMotion::collect(Subdomain& subdomain) {
    Proposals out;
    const bool by_table = world_.motion.moves != nullptr;
    for (const eval::Action& action : subdomain.actions()) {
        Proposal p;
        const ActionKind kind = subdomain.kind_of(action);
        if (info(kind).performer != here_) continue;
        MELD_EXPECT(subdomain.owned(action.catom) && action.arguments != nullptr, "{} of catom {}", info(kind).word, action.catom);
        p.kind = kind;
        p.id = subdomain.ensemble.id(action.catom);
        p.mover = action.catom;
        p.from = p.left = subdomain.ensemble.cell(action.catom);
        p.first_claim = static_cast<std::uint32_t>(out.claims.size());
        p.first_rest = static_cast<std::uint32_t>(out.rests.size());
        Objection objection = kind == ActionKind::Slide || kind == ActionKind::Turn ? propose_move(subdomain, action, p, out.claims)
                              : kind == ActionKind::MoveAround                      ? propose_around(subdomain, action, p, out.claims)
                              : here_ == ActionInfo::Performer::Amoebots            ? propose_amoebot(subdomain, action, p, out.claims)
                              : kind == ActionKind::Move                            ? propose_by_table(subdomain, action, p, out.claims)
                                                                                    : propose(subdomain, action, p, out.claims);
        if (by_table && !objection && goes_a_way(kind)) objection = claim_by_table(subdomain, p, out.claims);
        if (!objection) objection = may_leave(subdomain, p, out.rests);
        if (objection) {
            // Most of the catoms that wait for room end here, in every tick.
            out.claims.resize(p.first_claim);
            refuse(subdomain, action.catom, kind, *objection);
            continue;
        }
        // The same request twice is granted once: a catom's requests are adjacent. Only the owner of a far cell knows whether it is empty,
        // so on several processes each moveTo of a catom is proposed, and the first that is not vetoed is kept.
        bool again = false;
        for (auto other = out.list.rbegin(); other != out.list.rend() && other->id == p.id; ++other) {
            if (kind == ActionKind::MoveTo && other->kind == kind && !subdomain.alone())
                p.direction = std::max(p.direction, other->direction + 1);
            else
                again = again || other->order() == p.order();
        }
        if (again) {
            out.claims.resize(p.first_claim);
            out.rests.resize(p.first_rest);
            refuse(subdomain, action.catom, kind, Refusal::Repeated);
            continue;
        }
        out.claims.push_back(kBody | subdomain.ensemble.key_of(action.catom));
        p.claim_count = static_cast<std::uint32_t>(out.claims.size()) - p.first_claim;
        out.list.push_back(p);
    }
    MELD_ENSURE(std::ranges::is_sorted(out.list, {}, &Proposal::id), "the requests of a catom do not stand together");
    return out;
}

LatticeMotion::Objection LatticeMotion::propose(Subdomain& subdomain, const eval::Action& action, Proposal& p,
                                                std::vector<CellKey>& claims) const {
    if (p.kind == ActionKind::Create) {
        const std::int64_t port = action.arguments[0].integer;
        if (port < 0 || port >= subdomain.lattice.ports()) return Refusal::NoSuchPort;
        if (held_[action.catom] < 1) return Refusal::NoUnit;
        const Cell to = subdomain.lattice.neighbour(p.from, static_cast<int>(port));
        if (full(subdomain, to)) return Refusal::Occupied;
        p.direction = subdomain.lattice.own_number(static_cast<int>(port));
        p.to = to;
        claims.push_back(subdomain.ensemble.key(to));
        return std::nullopt;
    }
    if (p.kind == ActionKind::MoveTo) {
        Cell to;
        std::int32_t* axes[] = {&to.x, &to.y, &to.z};
        for (std::size_t i = 0; i < 3; ++i) {
            const std::int64_t at = action.arguments[i].integer;
            if (at < -world::kCellLimit || at >= world::kCellLimit) return Refusal::Outside;
            *axes[i] = static_cast<std::int32_t>(at);
        }
        if (subdomain.lattice.flat() && to.z != 0) return Refusal::Outside;
        if (full(subdomain, to)) return Refusal::Occupied;
        p.to = to;
        claims.push_back(kBody | subdomain.ensemble.key(p.from));
        claims.push_back(subdomain.ensemble.key(to));
        return std::nullopt;
    }
    return propose_give(subdomain, action, p, claims);
}

// give and destroy name a neighbour by its id.
LatticeMotion::Objection LatticeMotion::propose_give(const Subdomain& subdomain, const eval::Action& action, Proposal& p,
                                                     std::vector<CellKey>& claims) const {
    const std::int32_t units = held_[action.catom];
    const std::int32_t amount = p.kind == ActionKind::Give ? 1 : 1 + units;
    if (p.kind == ActionKind::Give && units < 1) return Refusal::NoUnit;
    if (p.kind == ActionKind::Destroy && action.arguments[0].catom == p.id) {
        // It ends alone: nobody receives anything.
        if (units > 0) return Refusal::HoldsUnits;
        p.to = p.from;
        claims.push_back(kBody | subdomain.ensemble.key_of(action.catom));
        return std::nullopt;
    }
    const Geometry& geometry = subdomain.geometry();
    for (int port = 0; port < subdomain.lattice.ports(); ++port) {
        const std::int32_t beside = catom_towards(geometry, geometry.catom_site[action.catom], port);
        if (beside < 0) continue;
        const auto other = static_cast<Catom>(beside);
        if (subdomain.ensemble.id(other) != action.arguments[0].catom) continue;
        if (held_[other] + amount > world_.motion.capacity) return Refusal::NoRoom;
        p.direction = subdomain.lattice.own_number(port);
        p.receiver = other;
        p.to = subdomain.ensemble.cell(other);
        if (p.kind == ActionKind::Destroy) claims.push_back(kBody | subdomain.ensemble.key_of(action.catom));
        claims.push_back(kBody | subdomain.ensemble.key_of(other));
        return std::nullopt;
    }
    return Refusal::NotANeighbour;
}

// The sliding cube: along a face of its pivots, or around an edge of one.
LatticeMotion::Objection LatticeMotion::propose_move(Subdomain& subdomain, const eval::Action& action, Proposal& p,
                                                     std::vector<CellKey>& claims) const {
    const world::LatticeKind lattice = subdomain.lattice.kind();
    if (lattice != world::LatticeKind::Cubic && lattice != world::LatticeKind::Square) return Refusal::NotOnThisLattice;
    const std::int64_t pivot = action.arguments[0].integer, towards = action.arguments[1].integer;
    const int ports = subdomain.lattice.ports();
    if (pivot < 0 || pivot >= ports || towards < 0 || towards >= ports) return Refusal::NoSuchPort;
    if (pivot == towards || subdomain.lattice.opposite(static_cast<int>(pivot)) == towards) return Refusal::NotAtRightAngles;
    const Cell here = subdomain.ensemble.cell(action.catom);
    const Cell P = subdomain.lattice.neighbour(here, static_cast<int>(pivot)) - here;
    const Cell D = subdomain.lattice.neighbour(here, static_cast<int>(towards)) - here;
    p.direction = subdomain.lattice.own_number(static_cast<int>(pivot)) * ports + subdomain.lattice.own_number(static_cast<int>(towards));
    const auto key = [&](Cell offset) { return subdomain.ensemble.key(here + offset); };
    if (!full(subdomain, here + P)) return Refusal::NoSupport;
    claims.push_back(kBody | key({}));
    claims.push_back(kBody | key(P));
    Cell to;
    if (p.kind == ActionKind::Slide) {
        to = here + D;
        if (!full(subdomain, here + P + D)) return Refusal::NoSupport;
        if (full(subdomain, to)) return Refusal::Occupied;
        claims.push_back(kBody | key(P + D));
        claims.push_back(key(D));
    } else {
        to = here + P + D;
        const Cell zero{};
        for (const Cell empty : {P + D, D, D + D, P + D + D, zero - P, D - P}) {
            if (full(subdomain, here + empty)) return Refusal::Occupied;
            claims.push_back(key(empty));
        }
    }
    p.to = to;
    return std::nullopt;
}

// Around one neighbour to a cell beside another catom.
LatticeMotion::Objection LatticeMotion::propose_around(Subdomain& subdomain, const eval::Action& action, Proposal& p,
                                                       std::vector<CellKey>& claims) const {
    const std::uint64_t around = action.arguments[0].catom, beside = action.arguments[1].catom;
    const std::optional<Catom> last = subdomain.ensemble.find(beside);
    for (int port = 0; port < subdomain.lattice.ports(); ++port) {
        const std::optional<Catom> pivot = subdomain.ensemble.at(subdomain.lattice.neighbour(p.from, port));
        if (!pivot || subdomain.ensemble.id(*pivot) != around) continue;
        // A catom that is far away is not known here, and there is no path to it either.
        if (around == beside || beside == p.id || !last) return Refusal::NoPath;
        const auto way = way_around(
            lattice_, [&](Cell c) { return full(subdomain, c); }, p.from, subdomain.lattice.own_number(port),
            subdomain.ensemble.cell(*last));
        if (!way) return Refusal::NoPath;
        p.to = way->to;
        p.direction = way->direction;
        for (const Cell cell : way->bodies) claims.push_back(kBody | subdomain.ensemble.key(cell));
        for (const Cell cell : way->empty) claims.push_back(subdomain.ensemble.key(cell));
        return std::nullopt;
    }
    return Refusal::NotANeighbour;
}

// A slide, a turn, a moveAround or a move rests on the catoms that keep the ensemble together without the mover.
LatticeMotion::Objection LatticeMotion::may_leave(const Subdomain& subdomain, Proposal& p, std::vector<CellKey>& rests) const {
    if (!world_.motion.keep_connected) return std::nullopt;
    if (!goes_a_way(p.kind) && p.kind != ActionKind::Move && p.kind != ActionKind::Contract) return std::nullopt;
    const auto cells = ties(subdomain.lattice, [&](Cell c) { return full(subdomain, c); }, p.left, p.to);
    if (!cells) return Refusal::Disconnects;
    for (const Cell cell : *cells) rests.push_back(subdomain.ensemble.key(cell));
    p.rest_count = static_cast<std::uint32_t>(cells->size());
    return std::nullopt;
}

// Afterwards every proposal that may compete with one of ours is known here: competitors are within eight cells of our mover, so in its
// brick or a neighbouring one. If any catom teleports, all processes get all proposals.
Proposals LatticeMotion::share(Subdomain& subdomain, const Proposals& mine, Teleports& teleports) const {
    MELD_EXPECT(!subdomain.alone(), "{} proposals are shared by one process", mine.list.size());
    Proposals all;
    if (subdomain.totals.teleports > 0) {
        ByteWriter bytes;
        for (const Proposal& p : mine.list) write_proposal(bytes, mine, p);
        for (const auto& from : subdomain.comm.allgather_any(bytes.view())) {
            ByteReader in(from, "proposals");
            while (!in.done()) read_proposal(in, all);
        }
        teleports = veto_teleports(subdomain, all.list);
        return all;
    }
    std::vector<ByteWriter> out(static_cast<std::size_t>(subdomain.comm.processes()));
    for (const Proposal& p : mine.list)
        for (const int other : subdomain.halo->around(p.from)) write_proposal(out[static_cast<std::size_t>(other)], mine, p);
    all = mine;
    for (const comm::Packet& packet : subdomain.comm.exchange(comm::take_packets(out))) {
        ByteReader in(packet.bytes, "proposals");
        while (!in.done()) read_proposal(in, all);
    }
    return all;
}

// Only the owner of a far cell knows whether it is empty. Of each catom the first moveTo to an empty cell is kept, as on a single process.
LatticeMotion::Teleports LatticeMotion::veto_teleports(Subdomain& subdomain, std::vector<Proposal>& all) const {
    ByteWriter mine;
    for (const Proposal& p : all)
        if (p.kind == ActionKind::MoveTo && subdomain.halo->owner(p.to) == subdomain.comm.process() && full(subdomain, p.to)) {
            mine.write(p.id);
            mine.write(p.direction);
        }
    Teleports teleports;
    auto& [vetoed, kept] = teleports;
    for (const auto& from : subdomain.comm.allgather_any(mine.view()))
        for (ByteReader in(from, "vetoed moves"); !in.done();) {
            const auto id = in.read<std::uint64_t>();
            vetoed.emplace(id, in.read<std::int32_t>());
        }
    for (const Proposal& p : all) {
        if (p.kind != ActionKind::MoveTo || vetoed.contains({p.id, p.direction})) continue;
        const auto [first, added] = kept.emplace(p.id, p.direction);
        if (!added) first->second = std::min(first->second, p.direction);
    }
    std::erase_if(all, [&](const Proposal& p) {
        const auto first = teleports.kept.find(p.id);
        return p.kind == ActionKind::MoveTo && (first == teleports.kept.end() || first->second != p.direction);
    });
    return teleports;
}

// The same as on a single process, where collect() finds the cell full, or an earlier moveTo.
Refusal LatticeMotion::Teleports::why_not(const Proposal& p) const {
    if (p.kind != ActionKind::MoveTo) return Refusal::Conflict;
    if (vetoed.contains({p.id, p.direction})) return Refusal::Occupied;
    const auto first = kept.find(p.id);
    return first != kept.end() && first->second != p.direction ? Refusal::Repeated : Refusal::Conflict;
}

// A proposal is granted if it is the smallest on each of its claims, and its ties hold.
std::vector<bool> LatticeMotion::decide(const Subdomain& subdomain, const Proposals& mine, const Proposals& all) {
    Claims best(all.claims.size());
    for (const Proposal& p : all.list) {
        MELD_EXPECT(p.claim_count > 0 && p.first_claim + p.claim_count <= all.claims.size(), "catom @{} claims {} of {}", p.id,
                    p.first_claim, all.claims.size());
        for (std::uint32_t i = 0; i < p.claim_count; ++i) {
            const Proposal*& first = best.at(all.claims[p.first_claim + i]);
            if (first == nullptr || p.order() < first->order()) first = &p;
        }
    }
    Ties together(subdomain, all);
    std::vector<bool> granted;
    for (const Proposal& p : mine.list) {
        bool wins = true;
        for (std::uint32_t i = 0; i < p.claim_count && wins; ++i) {
            // A vetoed teleport is not the best on any claim.
            const Proposal* first = best.at(mine.claims[p.first_claim + i]);
            wins = first != nullptr && first->order() == p.order();
        }
        wins = wins && together.hold(mine, p);
        granted.push_back(wins);
    }
    MELD_ENSURE(granted.size() == mine.list.size(), "{} of {} requests are decided", granted.size(), mine.list.size());
    return granted;
}

}  // namespace meld::sim
