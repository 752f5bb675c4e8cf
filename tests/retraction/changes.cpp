#include "changes.h"

#include <algorithm>

#include "runtime/base/assert.h"
#include "runtime/base/bytes.h"
#include "runtime/comm/transport/packets.h"
#include "runtime/engine/tuple/facts.h"
#include "runtime/sim/core/failures/catom_failures.h"
#include "runtime/sim/core/failures/link_failures.h"
#include "runtime/sim/core/migration.h"

namespace meld::retraction {

using sim::Catom;
using sim::Subdomain;

Result<void> Changes::step(Subdomain& subdomain) {
    const std::vector<Change>& burst = case_.bursts[burst_];
    for (const std::uint64_t id : mirror_.wake(subdomain.tick())) restart(subdomain, id);
    for (; next_ < burst.size() && start_ + burst[next_].tick < subdomain.tick(); ++next_) {
        const Change& change = burst[next_];
        const std::uint64_t id = change.kind == Change::Kind::Add   ? mirror_.next_id
                                 : mirror_.at.contains(change.cell) ? mirror_.at.at(change.cell)
                                                                    : 0;
        if (mirror_.apply(change) && &change != lost_) apply(subdomain, change, id);
    }
    subdomain.refresh();
    return {};
}

void Changes::apply(Subdomain& subdomain, const Change& change, std::uint64_t id) {
    switch (change.kind) {
        case Change::Kind::Give:
        case Change::Kind::Take:
            return give_or_take(subdomain, mirror_.given[change.given], change);
        case Change::Kind::Remove:
            if (case_.graph) return sim::CatomFailures(subdomain).take_out(std::vector{sim::Killed{id, {}}});
            if (const auto catom = subdomain.ensemble.at(change.cell)) subdomain.remove_catom(*catom);
            return;
        case Change::Kind::Add:
            return add(subdomain, id, change.cell);
        case Change::Kind::Move:
            return move(subdomain, id, change.cell, change.to);
        case Change::Kind::Cut:
        case Change::Kind::Heal:
        case Change::Kind::Join:
            return change_link(subdomain, change);
        case Change::Kind::Hang:
            mirror_.hang(id, subdomain.tick() + change.arguments.at(0));
            return sim::CatomFailures(subdomain).hang(std::vector{sim::Killed{id, change.cell}});
        case Change::Kind::Restart:
            return restart(subdomain, id);
    }
}

std::optional<Catom> Changes::find(const Subdomain& subdomain, Cell cell) const {
    return case_.graph ? subdomain.ensemble.find(static_cast<std::uint64_t>(cell.x)) : subdomain.ensemble.at(cell);
}

void Changes::change_link(Subdomain& subdomain, const Change& change) const {
    using End = sim::LinkFailures::End;
    const auto is = [&](const End& end, Cell cell) { return case_.graph ? node(end.id) == cell : end.cell == cell; };
    const sim::LinkFailures::Which which = [&](const End& a, const End& b) {
        return (is(a, change.cell) && is(b, change.to)) || (is(a, change.to) && is(b, change.cell));
    };
    sim::LinkFailures links(subdomain);
    if (change.kind == Change::Kind::Cut)
        links.cut(which);
    else if (change.kind == Change::Kind::Heal)
        links.heal(which);
    else
        links.join({{static_cast<std::uint64_t>(change.cell.x), static_cast<std::uint64_t>(change.to.x)}});
}

void Changes::restart(Subdomain& subdomain, std::uint64_t id) const {
    for (const auto& [cell, there] : mirror_.at)
        if (there == id) static_cast<void>(sim::CatomFailures(subdomain).restart(std::vector{sim::Killed{id, cell}}));
}

void Changes::give_or_take(Subdomain& subdomain, const Given& given, const Change& change) const {
    const auto catom = find(subdomain, change.cell);
    if (!catom || !subdomain.owned(*catom)) return;
    const auto predicate = tuple::find_predicate(subdomain.module, given.predicate, change.arguments.size());
    MELD_CHECK(predicate && subdomain.module.predicates[*predicate].base != kNone16, "{} cannot be given", given.predicate);
    std::vector<Value> values(change.arguments.size());
    const FieldInfo* fields = subdomain.module.predicates[*predicate].fields;
    for (std::size_t i = 0; i < values.size(); ++i) {
        if (fields[i].type == ValueType::Float)
            values[i].real = quarters(change.arguments[i]);
        else
            values[i].integer = change.arguments[i];
    }
    const u32 base = subdomain.module.predicates[*predicate].base;
    if (change.kind == Change::Kind::Give)
        subdomain.give(base, *catom, values.data());
    else
        subdomain.take(base, *catom, values.data());
}

bool Changes::sees(const Subdomain& subdomain, Cell cell) {
    const std::vector<int> processes = subdomain.halo->listeners(cell);
    return std::find(processes.begin(), processes.end(), subdomain.comm.process()) != processes.end();
}

void Changes::add(Subdomain& subdomain, std::uint64_t id, Cell cell) {
    if (sees(subdomain, cell)) add_newborn(subdomain, id, cell);
}

// As LatticeMotion relocates a catom: it keeps its index within a process; between processes all of it is sent to the new owner,
// and to those that only see it what it exports.
void Changes::move(Subdomain& subdomain, std::uint64_t id, Cell from, Cell to) {
    const int me = subdomain.comm.process(), old_owner = subdomain.halo->owner(from), owner = subdomain.halo->owner(to);
    const std::optional<Catom> known = subdomain.ensemble.at(from);
    std::vector<ByteWriter> out(static_cast<std::size_t>(subdomain.comm.processes()));
    std::optional<sim::Migrant> ghost;
    if (me == old_owner) {
        for (const int other : subdomain.halo->listeners(to))
            if (other != me)
                pack_migrant(subdomain, *known, other == owner ? kCatomOwned : kCatomGhost).write(out[static_cast<std::size_t>(other)]);
        if (me != owner && sees(subdomain, to)) ghost = pack_migrant(subdomain, *known, kCatomGhost);
    }
    if (me == old_owner && me == owner)
        subdomain.move_catom(*known, to);
    else if (known)
        subdomain.remove_catom(*known);
    if (ghost) add_migrant(subdomain, *ghost, to);
    if (subdomain.alone()) return;
    for (const comm::Packet& packet : subdomain.comm.exchange(comm::take_packets(out))) {
        ByteReader in(packet.bytes, "a catom that has moved");
        const sim::Migrant who = sim::Migrant::read(in);
        MELD_CHECK(who.id == id, "process {} sent catom @{} instead of @{}", packet.process, who.id, id);
        add_migrant(subdomain, who, to);
    }
}

}  // namespace meld::retraction
