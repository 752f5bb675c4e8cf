#include "runtime/record/state_digest.h"

#include <bit>

#include "runtime/base/bytes.h"
#include "runtime/base/pulse.h"
#include "runtime/record/fact_tables.h"
#include "runtime/tuple/facts.h"

namespace meld::record {

namespace {

// Of a cell its key, of a place anywhere all its bits.
u64 place_of(const sim::Subdomain& subdomain, sim::Catom catom) {
    if (!subdomain.ensemble.is_free()) return subdomain.ensemble.key(subdomain.ensemble.cell(catom));
    u64 hash = 0;
    for (const double x : subdomain.ensemble.position(catom)) hash = hash_combine(hash, std::bit_cast<u64>(x + 0.0));
    return hash;
}

}  // namespace

Digest state_digest(sim::Subdomain& subdomain) {
    subdomain.refresh();
    Digest digest;
    for (sim::Catom c = 0; c < subdomain.ensemble.index_count(); ++c)
        if (subdomain.owned(c)) digest.add(hash_combine(subdomain.ensemble.id(c), place_of(subdomain, c)));
    for (u32 i = 0; i < subdomain.module.predicate_count; ++i) {
        const PredicateInfo& p = subdomain.module.predicates[i];
        if (!shown(p)) continue;
        const u64 name = hash_combine(hash_text(p.name), p.arity);
        for (sim::Catom c = 0; c < subdomain.ensemble.index_count(); ++c) {
            pulse::beat();
            if (!subdomain.owned(c)) continue;
            const u64 start = hash_combine(name, subdomain.ensemble.id(c));
            tuple::each_fact(subdomain.module, subdomain.columns, subdomain.geometry(), i, c,
                             [&](const Value* v) { digest.add(tuple::hash_arguments(subdomain.module, p, start, v)); });
        }
    }
    ByteWriter bytes;
    bytes.write(digest);
    Digest sum;
    const std::vector<std::byte> all = subdomain.comm.allgather(bytes.view());
    ByteReader in(all, "digests of all processes");
    for (int p = 0; p < subdomain.comm.processes(); ++p) sum.combine(in.read<Digest>());
    return sum;
}

}  // namespace meld::record
