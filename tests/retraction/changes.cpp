#include "changes.h"

#include <algorithm>

#include "runtime/base/assert.h"
#include "runtime/base/bytes.h"
#include "runtime/comm/packets.h"
#include "runtime/tuple/facts.h"

namespace meld::retraction {

using sim::Catom;
using sim::Subdomain;

Result<void> Changes::step(Subdomain& subdomain) {
    const std::vector<Change>& burst = case_.bursts[burst_];
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
            if (const auto catom = subdomain.ensemble.at(change.cell)) subdomain.remove_catom(*catom);
            return;
        case Change::Kind::Add:
            return add(subdomain, id, change.cell);
        case Change::Kind::Move:
            return move(subdomain, id, change.cell, change.to);
    }
}

void Changes::give_or_take(Subdomain& subdomain, const Given& given, const Change& change) {
    const auto catom = subdomain.ensemble.at(change.cell);
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

void Changes::add(Subdomain& subdomain, std::uint64_t id, Cell cell) {
    const bool ours = subdomain.halo->owner(cell) == subdomain.comm.process();
    const std::vector<int> processes = subdomain.halo->listeners(cell);
    if (!ours && std::find(processes.begin(), processes.end(), subdomain.comm.process()) == processes.end()) return;
    const Catom catom = subdomain.add_catom(id, cell, ours ? kCatomOwned : kCatomGhost);
    if (ours) subdomain.mark(catom, kDirtyBirths);
}

// As LatticeMotion relocates a catom: it keeps its index within a process; between processes all of it is sent to the new owner,
// and to those that only see it what it exports.
void Changes::move(Subdomain& subdomain, std::uint64_t id, Cell from, Cell to) {
    const int me = subdomain.comm.process(), old_owner = subdomain.halo->owner(from), owner = subdomain.halo->owner(to);
    const std::optional<Catom> known = subdomain.ensemble.at(from);
    std::vector<ByteWriter> out(static_cast<std::size_t>(subdomain.comm.processes()));
    if (me == old_owner) {
        for (const int other : subdomain.halo->listeners(to)) {
            if (other == me) continue;
            ByteWriter& bytes = out[static_cast<std::size_t>(other)];
            bytes.write(id);  // Without it, the packet of a catom that exports nothing would be empty and not be sent.
            if (other == owner)
                subdomain.pack_catom(*known, bytes);
            else
                subdomain.pack_exports(*known, bytes);
        }
    }
    ByteWriter exports;
    if (me == old_owner && me != owner) subdomain.pack_exports(*known, exports);
    if (me == old_owner && me == owner) {
        subdomain.move_catom(*known, to);
    } else if (known) {
        subdomain.remove_catom(*known);
    }
    std::vector<comm::Packet> received;
    if (!subdomain.alone()) received = subdomain.comm.exchange(comm::take_packets(out));
    const std::vector<int> processes = subdomain.halo->listeners(to);
    const bool sees = std::find(processes.begin(), processes.end(), me) != processes.end();
    if (me == old_owner && me != owner && sees) {
        const Catom ghost = subdomain.add_catom(id, to, kCatomGhost);
        ByteReader in(exports.view(), "the exports of a catom that has left");
        subdomain.unpack_exports(ghost, in);
    }
    for (const comm::Packet& packet : received) {
        const Catom catom = subdomain.add_catom(id, to, me == owner ? kCatomOwned : kCatomGhost);
        ByteReader in(packet.bytes, "a catom that has moved");
        MELD_CHECK(in.read<std::uint64_t>() == id, "process {} sent another catom than @{}", packet.process, id);
        if (me == owner) {
            subdomain.unpack_catom(catom, in);
            subdomain.mark(catom, kDirtyLinks | kDirtyPlace);
        } else {
            subdomain.unpack_exports(catom, in);
        }
    }
}

}  // namespace meld::retraction
