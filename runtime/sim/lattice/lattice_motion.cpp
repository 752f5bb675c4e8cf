// Lattice motion, second half: sends the changes of granted proposals to every process that knows the cells, and applies them.
#include "runtime/sim/lattice/lattice_motion.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <optional>
#include <set>

#include "runtime/base/assert.h"
#include "runtime/base/bytes.h"
#include "runtime/comm/transport/packets.h"
#include "runtime/engine/tuple/facts.h"
#include "runtime/sim/core/failures/catom_failures.h"

namespace meld::sim {

LatticeMotion::LatticeMotion(const world::World& world)
    : world_(world),
      here_(world.has_amoebots() ? ActionInfo::Performer::Amoebots : ActionInfo::Performer::Lattice),
      activation_(world),
      lattice_(world.lattice),
      possible_(world) {}

Result<void> LatticeMotion::resume(Subdomain& subdomain) {
    // A predicate of the program's own with the same name has another kind or type.
    const auto given = [&](const char* name, PredicateKind kind, ValueType type) -> std::optional<u32> {
        const std::optional<u32> p = tuple::find_predicate(subdomain.module, name, 1);
        if (!p || subdomain.module.predicates[*p].kind != kind || subdomain.module.predicates[*p].fields[0].type != type)
            return std::nullopt;
        if (subdomain.module.predicates[*p].base == kNone16 ||
            subdomain.module.predicates[subdomain.module.predicates[*p].base].column == kNone16)
            return std::nullopt;
        return subdomain.module.predicates[*p].base;
    };
    known_ = {given("holds", PredicateKind::Sensed, ValueType::Int), given("failed", PredicateKind::Linear, ValueType::Int),
              given("created", PredicateKind::Linear, ValueType::Node)};
    packets_.resize(static_cast<std::size_t>(subdomain.comm.processes()));
    partners_elsewhere_.resize(packets_.size());
    activation_.resume(subdomain);
    return possible_.start(subdomain);
}

Result<void> LatticeMotion::start(Subdomain& subdomain) {
    if (auto found = resume(subdomain); !found) return found;
    if (world_.held > world_.motion.capacity)
        return fail(fmt::format("each catom starts with {} units, and the motion's capacity is {}", world_.held, world_.motion.capacity),
                    "Raise [motion] capacity or lower held");
    held_.assign(subdomain.ensemble.index_count(), world_.held);
    for (Catom c = 0; c < subdomain.ensemble.index_count(); ++c) {
        if (!subdomain.owned(c)) continue;
        account(subdomain, c, 1);
        hold(subdomain, c, world_.held);
    }
    packets_.resize(static_cast<std::size_t>(subdomain.comm.processes()));
    possible_.sense(subdomain);
    return {};
}

// A program that has changed, or a world, may sense what the one before did not.
Result<void> LatticeMotion::resumed(Subdomain& subdomain) {
    possible_.sense(subdomain);
    return {};
}

void LatticeMotion::save_catoms(const Subdomain& subdomain, std::span<const Catom> catoms, ByteWriter& out) const {
    if (world_.has_amoebots()) save_tails(subdomain, catoms, out);
    for (const Catom catom : catoms) out.write(held_[catom]);
}

void LatticeMotion::load_catoms(Subdomain& subdomain, std::span<const tuple::SavedCatom> catoms, ByteReader& in) {
    if (world_.has_amoebots()) load_tails(subdomain, catoms, in);
    held_.resize(subdomain.ensemble.index_count());
    for (const tuple::SavedCatom& each : catoms) {
        const auto units = in.read<std::int32_t>();
        if (!each.here()) continue;
        held_[each.catom] = units;
        account(subdomain, each.catom, 1);
        // A program that has changed may sense what the one before did not.
        hold(subdomain, each.catom, units);
    }
}

void LatticeMotion::leave(Subdomain& subdomain, std::span<const Catom> catoms) {
    for (const Catom catom : catoms) account(subdomain, catom, -1);
}

void LatticeMotion::save_rest(const Subdomain&, ByteWriter& out) const {
    out.write(last_change_);
    out.write(moves_);
    activation_.save(out);
}

Result<void> LatticeMotion::load_rest(Subdomain& subdomain, ByteReader& in) {
    last_change_ = std::max(last_change_, in.read<std::int64_t>());
    // What all processes have counted becomes one's.
    const auto moves = in.read<Moves>();
    const bool counts = subdomain.comm.process() == 0;
    if (counts) {
        moves_.expansions += moves.expansions;
        moves_.contractions += moves.contractions;
        moves_.handovers += moves.handovers;
    }
    activation_.load(in, counts);
    return {};
}

void LatticeMotion::account(const Subdomain& subdomain, Catom catom, int sign) {
    MELD_EXPECT(catom < held_.size() && (sign == 1 || sign == -1), "catom {} of {}", catom, held_.size());
    if (!subdomain.owned(catom)) return;
    units_ += sign * held_[catom];
    if (world_.target && !subdomain.ensemble.target(subdomain.ensemble.cell(catom))) outside_ += sign;
}

// Updates the catom's `holds`.
void LatticeMotion::hold(Subdomain& subdomain, Catom catom, std::int32_t units) {
    if (!known_.holds || !subdomain.owned(catom)) return;
    Value value{};
    value.integer = units;
    subdomain.give(*known_.holds, catom, &value);
}

void LatticeMotion::refuse(Subdomain& subdomain, Catom catom, ActionKind kind, Refusal why) {
    subdomain.refuse(kind, why);
    if (!known_.failed) return;
    Value value{};
    value.integer = info(kind).failure;
    subdomain.give(*known_.failed, catom, &value);
}

Result<void> LatticeMotion::step(Subdomain& subdomain) {
    activation_.end(subdomain);
    if (subdomain.totals.actions > 0) act(subdomain);
    activation_.begin(subdomain);
    return {};
}

// Carries out the actions of the last tick.
void LatticeMotion::act(Subdomain& subdomain) {
    subdomain.refresh();
    refuse_those_of_other_worlds(subdomain, here_);
    Proposals mine = collect(subdomain), shared;
    Teleports teleports;
    if (!subdomain.alone()) shared = share(subdomain, mine, teleports);
    const std::vector<bool> wins = decide(subdomain, mine, subdomain.alone() ? mine : shared);
    // Those that are granted move to the front.
    std::size_t granted = 0;
    for (std::size_t i = 0; i < mine.list.size(); ++i) {
        if (wins[i])
            mine.list[granted++] = mine.list[i];
        else
            refuse(subdomain, mine.list[i].mover, mine.list[i].kind, teleports.why_not(mine.list[i]));
    }
    mine.list.resize(granted);
    grant(subdomain, mine.list);
    apply(subdomain, exchange(subdomain));
    if (granted > 0) last_change_ = subdomain.tick();
    subdomain.refresh();
    possible_.sense_changes(subdomain);
}

// Their units go with them.
Result<void> LatticeMotion::lose(Subdomain& subdomain, std::span<const Killed> killed) {
    for (const Killed& each : killed) {
        possible_.note(each.cell);
        if (const std::optional<Catom> catom = subdomain.ensemble.at(each.cell)) account(subdomain, *catom, -1);
    }
    return {};
}

// Units are matter, and stay.
void LatticeMotion::restarted(Subdomain& subdomain, std::span<const Catom> catoms) {
    for (const Catom catom : catoms) {
        hold(subdomain, catom, held_[catom]);
        possible_.note(subdomain.ensemble.cell(catom));
    }
}

void LatticeMotion::struck(Subdomain& subdomain) { possible_.sense_changes(subdomain); }

// New catoms are numbered in the order of their cells, over all processes.
std::vector<CellKey> LatticeMotion::number_creations(Subdomain& subdomain, const std::vector<Proposal>& granted) const {
    std::vector<CellKey> creations;
    for (const Proposal& p : granted)
        if (p.kind == ActionKind::Create) creations.push_back(subdomain.ensemble.key(p.to));
    if (!subdomain.alone() && subdomain.totals.creations_requested > 0) {
        ByteWriter bytes;
        for (const CellKey key : creations) bytes.write(key);
        creations.clear();
        for (const auto& from : subdomain.comm.allgather_any(bytes.view())) {
            ByteReader in(from, "creations");
            while (!in.done()) creations.push_back(in.read<CellKey>());
        }
    }
    std::sort(creations.begin(), creations.end());
    return creations;
}

void LatticeMotion::grant(Subdomain& subdomain, const std::vector<Proposal>& granted) {
    const std::vector<CellKey> creations = number_creations(subdomain, granted);
    for (const Proposal& p : granted) {
        const Catom mover = p.mover;
        switch (p.kind) {
            case ActionKind::Create: {
                const std::uint64_t id =
                    subdomain.next_id() +
                    static_cast<std::uint64_t>(std::lower_bound(creations.begin(), creations.end(), subdomain.ensemble.key(p.to)) -
                                               creations.begin());
                pass_units(subdomain, mover, p.from, -1);
                announce(subdomain, {.kind = Change::Kind::Add, .newborn = true, .cell = p.to, .who = {id, {}}});
                if (known_.created) {
                    Value value{};
                    value.catom = id;
                    subdomain.give(*known_.created, mover, &value);
                }
                break;
            }
            case ActionKind::Destroy:
                if (p.to != p.from) pass_units(subdomain, p.receiver, p.to, 1 + held_[mover]);
                announce(subdomain, {.kind = Change::Kind::Remove, .cell = p.from});
                break;
            case ActionKind::Give:
                pass_units(subdomain, mover, p.from, -1);
                pass_units(subdomain, p.receiver, p.to, 1);
                break;
            case ActionKind::MoveTo:
            case ActionKind::Slide:
            case ActionKind::Turn:
            case ActionKind::MoveAround:
            case ActionKind::Move:
                relocate(subdomain, p);
                break;
            case ActionKind::Expand:
            case ActionKind::Contract:
            case ActionKind::Push:
            case ActionKind::Pull:
                grant_amoebot(subdomain, p);
                break;
            default:
                MELD_CHECK(false, "{} is no motion on a lattice", info(p.kind).word);
        }
    }
    if (world_.has_amoebots()) exchange_partners(subdomain);
    [[maybe_unused]] const std::uint64_t first = subdomain.take_ids(creations.size());
    MELD_ENSURE(std::adjacent_find(creations.begin(), creations.end()) == creations.end(), "two catoms are made in one cell after @{}",
                first);
}

// A catom moves to another cell: its new owner gets all of it, processes that have a ghost of it get its exports, its old process and those
// that had a ghost forget it. Within one process it keeps its index.
void LatticeMotion::relocate(Subdomain& subdomain, const Proposal& p) {
    const int me = subdomain.comm.process(), owner = subdomain.halo->owner(p.to);
    MELD_EXPECT(subdomain.owned(p.mover) && subdomain.halo->owner(p.from) == me, "catom @{} is moved by process {}", p.id, me);
    for (const int other : subdomain.halo->listeners(p.from))
        if (other != me || owner != me) tell(other, me, {.kind = Change::Kind::Remove, .cell = p.from});
    for (const int other : subdomain.halo->listeners(p.to)) {
        if (other == me && owner == me) {
            mine_.push_back({.kind = Change::Kind::Move, .cell = p.from, .to = p.to});
            continue;
        }
        const CatomState there = other == owner ? kCatomOwned : kCatomGhost;
        tell(other, me, {.kind = Change::Kind::Add, .held = held_[p.mover], .cell = p.to, .who = pack_migrant(subdomain, p.mover, there)});
    }
}

// Queues a change for every process that knows its cell.
void LatticeMotion::announce(Subdomain& subdomain, const Change& change) {
    const int me = subdomain.comm.process();
    if (subdomain.alone()) return tell(me, me, change);
    for (const int other : subdomain.halo->listeners(change.cell)) tell(other, me, change);
}

// Who gives or receives units neither moves nor goes in that tick, so it keeps its index.
void LatticeMotion::pass_units(Subdomain& subdomain, Catom catom, Cell cell, std::int32_t units) {
    MELD_EXPECT(subdomain.ensemble.cell(catom) == cell, "catom {} is not in ({}, {}, {})", catom, cell.x, cell.y, cell.z);
    units_passed_.push_back({catom, units});
    if (subdomain.alone()) return;
    const int me = subdomain.comm.process();
    for (const int other : subdomain.halo->listeners(cell))
        if (other != me) tell(other, me, {.kind = Change::Kind::Hold, .held = units, .cell = cell});
}

void LatticeMotion::tell(int process, int me, const Change& change) {
    MELD_EXPECT(process >= 0 && static_cast<std::size_t>(process) < packets_.size(), "process {} of {}", process, packets_.size());
    if (process == me)
        mine_.push_back(change);
    else
        write(packets_[static_cast<std::size_t>(process)], change);
}

void LatticeMotion::write(ByteWriter& out, const Change& change) {
    MELD_EXPECT(change.kind != Change::Kind::Move, "a move within a process is sent to another");
    out.write(change.kind);
    out.write(change.cell);
    if (change.kind == Change::Kind::Remove) return;
    if (change.kind == Change::Kind::Shrink || change.kind == Change::Kind::Grow) {
        out.write(change.to);
        out.write(change.tail);
        return;
    }
    out.write(change.held);
    if (change.kind == Change::Kind::Hold) return;
    out.write(change.newborn);
    out.write(change.tail);
    out.write(change.turn);
    change.who.write(out);
}

LatticeMotion::Change LatticeMotion::read(ByteReader& in) {
    Change change;
    change.kind = in.read<Change::Kind>();
    change.cell = in.read<Cell>();
    if (change.kind == Change::Kind::Remove) return change;
    if (change.kind == Change::Kind::Shrink || change.kind == Change::Kind::Grow) {
        change.to = in.read<Cell>();
        change.tail = in.read<Cell>();
        return change;
    }
    change.held = in.read<std::int32_t>();
    if (change.kind == Change::Kind::Hold) return change;
    MELD_CHECK(change.kind == Change::Kind::Add, "a change of kind {} from another process", static_cast<int>(change.kind));
    change.newborn = in.read<bool>();
    change.tail = in.read<Cell>();
    change.turn = in.read<std::uint8_t>();
    change.who = Migrant::read(in);
    return change;
}

std::vector<LatticeMotion::Change> LatticeMotion::exchange(Subdomain& subdomain) {
    std::vector<Change> changes = std::move(mine_);
    mine_.clear();
    if (subdomain.alone()) return changes;
    for (const comm::Packet& packet : subdomain.comm.exchange(comm::take_packets(packets_)))
        for (ByteReader in(packet.bytes, "granted moves"); !in.done();) changes.push_back(read(in));
    return changes;
}

void LatticeMotion::apply(Subdomain& subdomain, std::vector<Change> changes) {
    struct Turn {
        Change::Kind kind;
        Cell cell;
        std::uint32_t number;
    };
    std::vector<Turn> order;
    order.reserve(changes.size());
    for (const Change& c : changes) order.push_back({c.kind, c.cell, static_cast<std::uint32_t>(order.size())});
    std::ranges::sort(order, {}, [](const Turn& t) { return std::tuple(t.kind, t.cell, t.number); });
    for (const Turn& turn : order) {
        const Change& c = changes[turn.number];
        if (c.kind != Change::Kind::Hold) possible_.note(c.cell);
        if (c.kind == Change::Kind::Move) possible_.note(c.to);
        if (c.kind == Change::Kind::Add) {
            apply_add(subdomain, c);
            continue;
        }
        const Cell cell = c.cell;
        const std::optional<Catom> catom = c.catom ? c.catom : subdomain.ensemble.at(cell);
        MELD_CHECK(catom.has_value(), "a change for ({}, {}, {}), where no catom is known", cell.x, cell.y, cell.z);
        if (c.kind == Change::Kind::Hold) {
            units_passed_.push_back({*catom, c.held});
            continue;
        }
        account(subdomain, *catom, -1);
        if (c.kind == Change::Kind::Remove) {
            subdomain.remove_catom(*catom);
            continue;
        }
        if (c.kind == Change::Kind::Move)
            subdomain.move_catom(*catom, c.to);
        else
            subdomain.reshape_catom(*catom, c.to, c.tail);
        account(subdomain, *catom, 1);
    }
    apply_units(subdomain);
}

// A catom that receives as many units as it gives away has not changed.
void LatticeMotion::apply_units(Subdomain& subdomain) {
    units_due_.resize(subdomain.ensemble.index_count());
    for (const auto& [catom, units] : units_passed_) units_due_[catom] += units;
    for (const auto& [catom, units] : units_passed_) {
        const std::int32_t due = std::exchange(units_due_[catom], 0);
        if (due == 0) continue;
        held_[catom] += due;
        subdomain.touch(catom);
        MELD_ASSERT(held_[catom] >= 0 && held_[catom] <= world_.motion.capacity, "a catom holds {} units", held_[catom]);
        hold(subdomain, catom, held_[catom]);
        if (subdomain.owned(catom)) units_ += due;
    }
    units_passed_.clear();
}

void LatticeMotion::apply_add(Subdomain& subdomain, const Change& c) {
    MELD_EXPECT(c.held >= 0 && c.held <= world_.motion.capacity, "catom @{} holds {} units", c.who.id, c.held);
    const Catom catom = c.newborn ? add_newborn(subdomain, c.who.id, c.cell) : add_migrant(subdomain, c.who, c.cell);
    held_.resize(subdomain.ensemble.index_count());
    held_[catom] = c.held;
    account(subdomain, catom, 1);
    if (c.newborn) hold(subdomain, catom, 0);
    if (!world_.has_amoebots()) return;
    if (c.tail != c.cell) subdomain.reshape_catom(catom, c.cell, c.tail);
    activation_.set_turn(subdomain, catom, c.turn);
}

// The cells of the target in the bricks where own catoms stand and in those around them, by brick.
std::map<world::BrickKey, std::uint32_t> LatticeMotion::target_nearby(const Subdomain& subdomain) const {
    const world::Ensemble& ensemble = subdomain.ensemble;
    std::map<world::BrickKey, std::uint32_t> cells;
    std::set<world::BrickKey> seen;
    std::optional<Cell> last;  // Mostly the next catom stands in the same brick.
    for (Catom c = 0; c < ensemble.index_count(); ++c) {
        if (!subdomain.owned(c)) continue;
        const Cell centre = subdomain.lattice.brick_of(ensemble.cell(c));
        if (last == centre) continue;
        last = centre;
        if (!seen.insert(subdomain.lattice.brick_key(centre)).second) continue;
        for (std::uint32_t n = 0; n < kBrickNeighbours; ++n) {
            const Cell brick = centre + world::Lattice::brick_offset(n);
            if (!subdomain.lattice.brick_in_range(brick)) continue;
            const auto [at, added] = cells.try_emplace(subdomain.lattice.brick_key(brick));
            for (std::uint32_t cell = 0; added && cell < kBrickCells; ++cell)
                at->second += ensemble.target(subdomain.lattice.cell_in_brick(brick, cell));
        }
    }
    return cells;
}

void LatticeMotion::finish(Subdomain& subdomain) {
    ByteWriter mine;
    mine.write(std::array{static_cast<std::int64_t>(subdomain.ensemble.owned_count()), outside_, units_, last_change_});
    mine.write(std::exchange(moves_, {}));
    activation_.write_counts(mine);
    if (world_.target)
        for (const auto& [brick, cells] : target_nearby(subdomain)) {
            mine.write(brick);
            mine.write(cells);
        }
    std::int64_t catoms = 0, target = 0;
    std::map<world::BrickKey, std::uint32_t> nearby;
    for (const auto& theirs : subdomain.comm.allgather_any(mine.view())) {
        ByteReader in(theirs, "counts of the target");
        const auto counts = in.read<std::array<std::int64_t, 4>>();
        catoms += counts[0];
        all_outside_ += counts[1];
        all_units_ += counts[2];
        last_change_ = std::max(last_change_, counts[3]);
        const auto moves = in.read<Moves>();
        moves_.expansions += moves.expansions;
        moves_.contractions += moves.contractions;
        moves_.handovers += moves.handovers;
        activation_.add_counts(in);
        while (!in.done()) {
            const auto brick = in.read<world::BrickKey>();
            nearby[brick] = in.read<std::uint32_t>();
        }
    }
    for (const auto& [brick, cells] : nearby) target += cells;
    // Who stands in the target stands in one of these bricks.
    all_missing_ = world_.target ? target - (catoms - all_outside_) : 0;
}

std::string LatticeMotion::status() const {
    return world_.target ? fmt::format("{} outside the target, {} units held", outside_, units_) : "";
}

std::string LatticeMotion::outcome() const {
    if (world_.has_amoebots()) return outcome_of_amoebots();
    if (!world_.target) return "";
    if (all_outside_ == 0 && all_units_ == 0 && all_missing_ == 0) return fmt::format("target reached in {} ticks", last_change_);
    return fmt::format("target not reached: {} catoms outside it, {} units still held, {} of its cells near the ensemble empty",
                       all_outside_, all_units_, all_missing_);
}

}  // namespace meld::sim
