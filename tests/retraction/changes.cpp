#include "changes.h"

#include <algorithm>

#include "runtime/base/assert.h"
#include "runtime/base/bytes.h"
#include "runtime/comm/packets.h"
#include "runtime/tuple/facts.h"

namespace meld::retraction {

using sim::Catom;
using sim::Subdomain;

Result<void> Changes::step(Subdomain& part) {
    const std::vector<Change>& burst = case_.bursts[burst_];
    for (; next_ < burst.size() && start_ + burst[next_].tick < part.tick(); ++next_) {
        const Change& change = burst[next_];
        const std::uint64_t id = change.kind == Change::Kind::Add   ? mirror_.next_id
                                 : mirror_.at.contains(change.cell) ? mirror_.at.at(change.cell)
                                                                    : 0;
        if (mirror_.apply(change) && &change != lost_) apply(part, change, id);
    }
    part.refresh();
    return {};
}

void Changes::apply(Subdomain& part, const Change& change, std::uint64_t id) {
    switch (change.kind) {
        case Change::Kind::Give:
        case Change::Kind::Take:
            return give_or_take(part, mirror_.given[change.given], change);
        case Change::Kind::Remove:
            if (const auto catom = part.ensemble.at(change.cell)) part.remove_catom(*catom);
            return;
        case Change::Kind::Add:
            return add(part, id, change.cell);
        case Change::Kind::Move:
            return move(part, id, change.cell, change.to);
    }
}

void Changes::give_or_take(Subdomain& part, const Given& given, const Change& change) {
    const auto catom = part.ensemble.at(change.cell);
    if (!catom || !part.owned(*catom)) return;
    const auto predicate = tuple::find_predicate(part.module, given.predicate, change.arguments.size());
    MELD_CHECK(predicate && part.module.predicates[*predicate].base != kNone16, "{} cannot be given", given.predicate);
    std::vector<Value> values(change.arguments.size());
    const FieldInfo* fields = part.module.predicates[*predicate].fields;
    for (std::size_t i = 0; i < values.size(); ++i) {
        if (fields[i].type == ValueType::Float)
            values[i].real = quarters(change.arguments[i]);
        else
            values[i].integer = change.arguments[i];
    }
    const u32 base = part.module.predicates[*predicate].base;
    if (change.kind == Change::Kind::Give)
        part.give(base, *catom, values.data());
    else
        part.take(base, *catom, values.data());
}

void Changes::add(Subdomain& part, std::uint64_t id, Cell cell) {
    const bool ours = part.halo->owner(cell) == part.comm.part();
    const std::vector<int> parts = part.halo->listeners(cell);
    if (!ours && std::find(parts.begin(), parts.end(), part.comm.part()) == parts.end()) return;
    const Catom catom = part.add_catom(id, cell, ours ? kCatomOwned : kCatomGhost);
    if (ours) part.mark(catom, kDirtyBirths);
}

// As LatticeMotion relocates a catom: it keeps its index within a part; between parts all of it is sent to the new owner,
// and to those that only see it what it exports.
void Changes::move(Subdomain& part, std::uint64_t id, Cell from, Cell to) {
    const int me = part.comm.part(), old_owner = part.halo->owner(from), owner = part.halo->owner(to);
    const std::optional<Catom> known = part.ensemble.at(from);
    std::vector<ByteWriter> out(static_cast<std::size_t>(part.comm.parts()));
    if (me == old_owner) {
        for (const int other : part.halo->listeners(to)) {
            if (other == me) continue;
            ByteWriter& bytes = out[static_cast<std::size_t>(other)];
            bytes.write(id);  // Without it, the packet of a catom that exports nothing would be empty and not be sent.
            if (other == owner)
                part.pack_catom(*known, bytes);
            else
                part.pack_exports(*known, bytes);
        }
    }
    ByteWriter exports;
    if (me == old_owner && me != owner) part.pack_exports(*known, exports);
    if (me == old_owner && me == owner) {
        part.move_catom(*known, to);
    } else if (known) {
        part.remove_catom(*known);
    }
    std::vector<comm::Packet> received;
    if (!part.alone()) received = part.comm.exchange(comm::take_packets(out));
    const std::vector<int> parts = part.halo->listeners(to);
    const bool sees = std::find(parts.begin(), parts.end(), me) != parts.end();
    if (me == old_owner && me != owner && sees) {
        const Catom ghost = part.add_catom(id, to, kCatomGhost);
        ByteReader in(exports.view(), "the exports of a catom that has left");
        part.unpack_exports(ghost, in);
    }
    for (const comm::Packet& packet : received) {
        const Catom catom = part.add_catom(id, to, me == owner ? kCatomOwned : kCatomGhost);
        ByteReader in(packet.bytes, "a catom that has moved");
        MELD_CHECK(in.read<std::uint64_t>() == id, "process {} sent another catom than @{}", packet.part, id);
        if (me == owner) {
            part.unpack_catom(catom, in);
            part.mark(catom, kDirtyLinks | kDirtyPlace);
        } else {
            part.unpack_exports(catom, in);
        }
    }
}

}  // namespace meld::retraction
