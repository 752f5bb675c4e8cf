#include "runtime/sim/core/migration.h"

#include "runtime/base/assert.h"
#include "runtime/sim/core/programs.h"

namespace meld::sim {

namespace {

CatomState state_here(const Subdomain& subdomain, int owner) { return owner == subdomain.comm.process() ? kCatomOwned : kCatomGhost; }

void unpack(Subdomain& subdomain, const Migrant& migrant, Catom catom) {
    ByteReader in(migrant.facts, "a catom from another process");
    subdomain.unpack_catom(catom, in);
    MELD_CHECK(in.done(), "catom @{} comes with {} bytes too many", migrant.id, in.left());
}

}  // namespace

void Migrant::write(ByteWriter& out) const {
    out.write(id);
    out.write_block(facts);
}

Migrant Migrant::read(ByteReader& in) {
    Migrant migrant{.id = in.read<std::uint64_t>()};
    const auto block = in.read_block();
    migrant.facts.assign(block.begin(), block.end());
    return migrant;
}

Migrant pack_migrant(const Subdomain& subdomain, Catom catom, CatomState there) {
    ByteWriter facts;
    subdomain.pack_catom(catom, there, facts);
    return {subdomain.ensemble.id(catom), facts.take()};
}

Catom add_migrant(Subdomain& subdomain, const Migrant& migrant, Cell cell) {
    const CatomState state = state_here(subdomain, subdomain.halo->owner(cell));
    const Catom catom = subdomain.add_catom(migrant.id, cell, state);
    unpack(subdomain, migrant, catom);
    if (state == kCatomOwned) subdomain.mark(catom, kDirtyLinks | kDirtyPlace);
    return catom;
}

Catom add_migrant_freely(Subdomain& subdomain, const Migrant& migrant, const world::Vec3& position, int owner) {
    const Catom catom = subdomain.add_freely(migrant.id, position, state_here(subdomain, owner), owner);
    unpack(subdomain, migrant, catom);
    return catom;
}

Catom add_newborn(Subdomain& subdomain, std::uint64_t id, Cell cell) {
    const CatomState state = state_here(subdomain, subdomain.halo->owner(cell));
    const Catom catom = subdomain.add_catom(id, cell, state);
    if (state != kCatomOwned) return catom;
    Programs(subdomain).begin(catom);
    subdomain.mark(catom, kDirtyBirths);
    return catom;
}

}  // namespace meld::sim
