// Lattice motion, second half: what granted proposals change is sent to every process that knows the cells, and applied.
#include "runtime/sim/lattice/lattice_motion.h"

#include <fmt/format.h>

#include <algorithm>

#include "runtime/base/assert.h"
#include "runtime/base/bytes.h"
#include "runtime/comm/packets.h"
#include "runtime/tuple/facts.h"

namespace meld::sim {

LatticeMotion::LatticeMotion(const world::World& world) : world_(world) {}

Result<void> LatticeMotion::start(Subdomain& part) {
    // One of the same name that is the program's own is of another kind or type.
    const auto given = [&](const char* name, PredicateKind kind, ValueType type) -> std::optional<u32> {
        const std::optional<u32> p = tuple::find_predicate(part.module, name, 1);
        if (!p || part.module.predicates[*p].kind != kind || part.module.predicates[*p].fields[0].type != type) return std::nullopt;
        if (part.module.predicates[*p].base == kNone16 || part.module.predicates[part.module.predicates[*p].base].column == kNone16)
            return std::nullopt;
        return part.module.predicates[*p].base;
    };
    known_ = {given("holds", PredicateKind::Sensed, ValueType::Int), given("failed", PredicateKind::Linear, ValueType::Int),
              given("created", PredicateKind::Linear, ValueType::Node)};
    if (world_.held > world_.motion.capacity)
        return fail(fmt::format("each catom starts with {} units, and the motion's capacity is {}", world_.held, world_.motion.capacity),
                    "Raise [motion] capacity or lower held");
    held_.assign(part.ensemble.index_count(), world_.held);
    for (Catom c = 0; c < part.ensemble.index_count(); ++c) {
        if (!part.owned(c)) continue;
        account(part, c, 1);
        hold(part, c, world_.held);
    }
    packets_.resize(static_cast<std::size_t>(part.comm.parts()));
    return {};
}

void LatticeMotion::account(const Subdomain& part, Catom catom, int sign) {
    if (!part.owned(catom)) return;
    units_ += sign * held_[catom];
    if (world_.target && !part.ensemble.target(part.ensemble.cell(catom))) outside_ += sign;
}

// Tells the catom what it holds.
void LatticeMotion::hold(Subdomain& part, Catom catom, std::int32_t units) {
    if (!known_.holds || !part.owned(catom)) return;
    Value value{};
    value.integer = units;
    part.give(*known_.holds, catom, &value);
}

void LatticeMotion::refuse(Subdomain& part, Catom catom, ActionKind kind) {
    if (!known_.failed) return;
    Value value{};
    value.integer = info(kind).failure;
    part.give(*known_.failed, catom, &value);
}

Result<void> LatticeMotion::step(Subdomain& part) {
    if (part.totals.actions == 0) return {};
    part.refresh();
    const Proposals mine = collect(part);
    const std::vector<bool> wins = decide(mine, share(part, mine));
    std::vector<Proposal> granted;
    for (std::size_t i = 0; i < mine.list.size(); ++i) {
        if (wins[i])
            granted.push_back(mine.list[i]);
        else
            refuse(part, mine.list[i].mover, mine.list[i].kind);
    }
    grant(part, granted);
    apply(part, exchange(part));
    if (!granted.empty()) last_change_ = part.tick();
    part.refresh();
    return {};
}

// New catoms are numbered in the order of their cells, over all parts.
std::vector<CellKey> LatticeMotion::number_creations(Subdomain& part, const std::vector<Proposal>& granted) const {
    std::vector<CellKey> creations;
    for (const Proposal& p : granted)
        if (p.kind == ActionKind::Create) creations.push_back(part.ensemble.key(p.to));
    if (!part.alone() && part.totals.creations_requested > 0) {
        ByteWriter bytes;
        for (const CellKey key : creations) bytes.write(key);
        creations.clear();
        for (const auto& from : part.comm.allgather_any(bytes.view())) {
            ByteReader in(from, "creations");
            while (!in.done()) creations.push_back(in.read<CellKey>());
        }
    }
    std::sort(creations.begin(), creations.end());
    return creations;
}

void LatticeMotion::grant(Subdomain& part, const std::vector<Proposal>& granted) {
    const std::vector<CellKey> creations = number_creations(part, granted);
    for (const Proposal& p : granted) {
        const Catom mover = p.mover;
        switch (p.kind) {
            case ActionKind::Create: {
                const std::uint64_t id =
                    part.next_id() + static_cast<std::uint64_t>(
                                         std::lower_bound(creations.begin(), creations.end(), part.ensemble.key(p.to)) - creations.begin());
                announce(part, {.kind = Change::Kind::Hold, .held = -1, .cell = p.from});
                announce(part, {.kind = Change::Kind::Add, .newborn = true, .cell = p.to, .id = id});
                if (known_.created) {
                    Value value{};
                    value.catom = id;
                    part.give(*known_.created, mover, &value);
                }
                break;
            }
            case ActionKind::Destroy:
                announce(part, {.kind = Change::Kind::Hold, .held = 1 + held_[mover], .cell = p.to});
                announce(part, {.kind = Change::Kind::Remove, .cell = p.from});
                break;
            case ActionKind::Give:
                announce(part, {.kind = Change::Kind::Hold, .held = -1, .cell = p.from});
                announce(part, {.kind = Change::Kind::Hold, .held = 1, .cell = p.to});
                break;
            case ActionKind::MoveTo:
            case ActionKind::Slide:
            case ActionKind::Turn:
            case ActionKind::MoveAround:
                relocate(part, p);
                break;
            default:
                MELD_CHECK(false, "{} is no motion on a lattice", info(p.kind).word);
        }
    }
    part.take_ids(creations.size());
}

// A catom goes to another cell: its new owner gets all of it, parts that see it get what it exports, its old part and
// those that saw it forget it. Within one part it keeps its index.
void LatticeMotion::relocate(Subdomain& part, const Proposal& p) {
    const Cell from = p.from, to = p.to;
    const Catom mover = p.mover;
    const int me = part.comm.part(), owner = part.halo->owner(to);
    const std::vector<int> old_parts = part.halo->listeners(from);
    for (const int other : old_parts) {
        if (other == me && owner == me) continue;
        const Change change{.kind = Change::Kind::Remove, .cell = p.from};
        if (other == me)
            mine_.push_back(change);
        else {
            packets_[static_cast<std::size_t>(other)].write(change.kind);
            packets_[static_cast<std::size_t>(other)].write(change.cell);
        }
    }
    for (const int other : part.halo->listeners(to)) {
        if (other == me && owner == me) {
            mine_.push_back({.kind = Change::Kind::Move, .cell = p.from, .to = p.to});
            continue;
        }
        Change change{.kind = Change::Kind::Add, .held = held_[mover], .cell = p.to, .id = p.id};
        ByteWriter state;
        if (other == owner)
            part.pack_catom(mover, state);
        else
            part.pack_exports(mover, state);
        change.state = state.take();
        if (other == me) {
            mine_.push_back(std::move(change));
            continue;
        }
        ByteWriter& out = packets_[static_cast<std::size_t>(other)];
        out.write(change.kind);
        out.write(change.cell);
        out.write(change.newborn);
        out.write(change.held);
        out.write(change.id);
        out.write_block(change.state);
    }
}

// Queues a change without state for every part that knows its cell.
void LatticeMotion::announce(Subdomain& part, const Change& change) {
    const auto send = [&](int other) {
        if (other == part.comm.part()) {
            mine_.push_back(change);
            return;
        }
        ByteWriter& out = packets_[static_cast<std::size_t>(other)];
        out.write(change.kind);
        out.write(change.cell);
        if (change.kind == Change::Kind::Add) {
            out.write(change.newborn);
            out.write(change.held);
            out.write(change.id);
            out.write_block({});
        } else if (change.kind == Change::Kind::Hold) {
            out.write(change.held);
        }
    };
    if (part.alone()) return send(0);
    for (const int other : part.halo->listeners(change.cell)) send(other);
}

std::vector<LatticeMotion::Change> LatticeMotion::exchange(Subdomain& part) {
    std::vector<Change> changes = std::move(mine_);
    mine_.clear();
    if (part.alone()) return changes;
    for (const comm::Packet& packet : part.comm.exchange(comm::take_packets(packets_))) {
        ByteReader in(packet.bytes, "granted moves");
        while (!in.done()) {
            Change c;
            c.kind = in.read<Change::Kind>();
            c.cell = in.read<Cell>();
            if (c.kind == Change::Kind::Add) {
                c.newborn = in.read<bool>();
                c.held = in.read<std::int32_t>();
                c.id = in.read<std::uint64_t>();
                const auto state = in.read_block();
                c.state.assign(state.begin(), state.end());
            } else if (c.kind == Change::Kind::Hold) {
                c.held = in.read<std::int32_t>();
            }
            changes.push_back(std::move(c));
        }
    }
    return changes;
}

void LatticeMotion::apply(Subdomain& part, std::vector<Change> changes) {
    std::stable_sort(changes.begin(), changes.end(),
                     [](const Change& a, const Change& b) { return std::tuple(a.kind, a.cell) < std::tuple(b.kind, b.cell); });
    for (const Change& c : changes) {
        if (c.kind == Change::Kind::Add) {
            apply_add(part, c);
            continue;
        }
        const Cell cell = c.cell;
        const std::optional<Catom> catom = part.ensemble.at(cell);
        MELD_CHECK(catom.has_value(), "a change for ({}, {}, {}), where no catom is known", cell.x, cell.y, cell.z);
        account(part, *catom, -1);
        if (c.kind == Change::Kind::Remove) {
            part.remove_catom(*catom);
            continue;
        }
        if (c.kind == Change::Kind::Move) {
            part.move_catom(*catom, c.to);
        } else {
            held_[*catom] += c.held;
            MELD_ASSERT(held_[*catom] >= 0 && held_[*catom] <= world_.motion.capacity, "a catom holds {} units", held_[*catom]);
            hold(part, *catom, held_[*catom]);
        }
        account(part, *catom, 1);
    }
}

void LatticeMotion::apply_add(Subdomain& part, const Change& c) {
    const Cell cell = c.cell;
    const bool ours = part.halo->owner(cell) == part.comm.part();
    const Catom catom = part.add_catom(c.id, cell, ours ? kCatomOwned : kCatomGhost);
    held_.resize(part.ensemble.index_count());
    held_[catom] = c.held;
    MELD_ASSERT(c.held >= 0, "catom @{} holds {} units", c.id, c.held);
    account(part, catom, 1);
    if (c.newborn) {
        if (!ours) return;
        part.mark(catom, kDirtyBirths);
        hold(part, catom, 0);
        return;
    }
    ByteReader in(c.state, "a catom that has moved");
    if (ours) {
        part.unpack_catom(catom, in);
        part.mark(catom, kDirtyLinks | kDirtyPlace);
    } else {
        part.unpack_exports(catom, in);
    }
}

void LatticeMotion::finish(Subdomain& part) {
    std::int64_t counts[4] = {outside_, units_, 0, last_change_};
    for (world::Slot slot = 1; slot <= part.ensemble.brick_count(); ++slot) {
        const Cell brick = part.ensemble.brick(slot);
        if (!world_.target || part.halo->owner(part.lattice.brick_origin(brick)) != part.comm.part()) continue;
        for (std::uint32_t n = 0; n < kBrickCells; ++n) {
            const Cell cell = part.lattice.cell_in_brick(brick, n);
            counts[2] += part.ensemble.target(cell) && !full(part, cell);
        }
    }
    ByteWriter bytes;
    bytes.write(counts);
    const std::vector<std::byte> all = part.comm.allgather(bytes.view());
    ByteReader in(all, "counts of the target");
    last_change_ = 0;
    for (int p = 0; p < part.comm.parts(); ++p) {
        all_outside_ += in.read<std::int64_t>();
        all_units_ += in.read<std::int64_t>();
        all_missing_ += in.read<std::int64_t>();
        last_change_ = std::max(last_change_, in.read<std::int64_t>());
    }
}

std::string LatticeMotion::status() const {
    return world_.target ? fmt::format("{} outside the target, {} units held", outside_, units_) : "";
}

std::string LatticeMotion::outcome() const {
    if (!world_.target) return "";
    if (all_outside_ == 0 && all_units_ == 0 && all_missing_ == 0) return fmt::format("target reached in {} ticks", last_change_);
    return fmt::format("target not reached: {} catoms outside it, {} units still held, {} of its cells near the ensemble empty",
                       all_outside_, all_units_, all_missing_);
}

}  // namespace meld::sim
