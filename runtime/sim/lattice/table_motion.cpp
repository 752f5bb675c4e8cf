// Lattice motion by a table of moves (docs/moves.md): the action `move`, and what other actions may do where the world has a table.
#include "runtime/base/assert.h"
#include "runtime/sim/lattice/lattice_motion.h"
#include "runtime/world/lattice/move_table.h"

namespace meld::sim {

LatticeMotion::Objection LatticeMotion::propose_by_table(const Subdomain& subdomain, const eval::Action& action, Proposal& p,
                                                         std::vector<CellKey>& claims) const {
    if (world_.motion.moves == nullptr) return Refusal::NoMoves;
    Cell by;
    std::int32_t* const axes[] = {&by.x, &by.y, &by.z};
    for (std::size_t i = 0; i < 3; ++i) {
        const std::int64_t way = action.arguments[i].integer;
        if (way < -world::MoveTable::kMaxBy || way > world::MoveTable::kMaxBy) return Refusal::NotAllowed;
        *axes[i] = static_cast<std::int32_t>(way);
    }
    p.to = p.from + by;
    if (!world::Lattice::in_range(p.to)) return Refusal::Outside;
    return claim_by_table(subdomain, p, claims);
}

// The first move that leads from the mover's cell to the new one and fits; it claims what it depends on.
LatticeMotion::Objection LatticeMotion::claim_by_table(const Subdomain& subdomain, Proposal& p, std::vector<CellKey>& claims) const {
    const auto is_full = [&](Cell offset) { return full(subdomain, p.from + offset); };
    const std::optional<std::size_t> found = world_.motion.moves->find(p.from, p.to - p.from, is_full);
    if (!found) return Refusal::NotAllowed;
    if (p.kind == ActionKind::Move) p.direction = static_cast<std::int32_t>(*found);
    const world::Move& move = world_.motion.moves->from(p.from)[*found];
    const auto key = [&](Cell offset) { return subdomain.ensemble.key(p.from + offset); };
    for (const Cell cell : move.full) claims.push_back(kBody | key(cell));
    for (const Cell cell : move.empty) claims.push_back(key(cell));
    for (const auto& [one, other] : move.one_empty) claims.push_back(key(is_full(one) ? other : one));
    return std::nullopt;
}

}  // namespace meld::sim
