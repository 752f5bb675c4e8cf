#include "runtime/record/state_digest.h"

#include <bit>

#include "runtime/base/bytes.h"
#include "runtime/record/fact_tables.h"
#include "runtime/tuple/facts.h"

namespace meld::record {

namespace {

// Of a cell its key, of a place anywhere all its bits.
u64 place_of(const sim::Subdomain& part, sim::Catom catom) {
    if (!part.ensemble.is_free()) return part.ensemble.key(part.ensemble.cell(catom));
    u64 hash = 0;
    for (const double x : part.ensemble.position(catom)) hash = hash_combine(hash, std::bit_cast<u64>(x + 0.0));
    return hash;
}

}  // namespace

Digest state_digest(sim::Subdomain& part) {
    part.refresh();
    Digest digest;
    for (sim::Catom c = 0; c < part.ensemble.index_count(); ++c)
        if (part.owned(c)) digest.add(hash_combine(part.ensemble.id(c), place_of(part, c)));
    for (u32 i = 0; i < part.module.predicate_count; ++i) {
        const PredicateInfo& p = part.module.predicates[i];
        if (!shown(p)) continue;
        const u64 name = hash_combine(hash_text(p.name), p.arity);
        for (sim::Catom c = 0; c < part.ensemble.index_count(); ++c) {
            if (!part.owned(c)) continue;
            const u64 start = hash_combine(name, part.ensemble.id(c));
            tuple::each_fact(part.module, part.columns, part.geometry(), i, c,
                             [&](const Value* v) { digest.add(tuple::hash_arguments(part.module, p, start, v)); });
        }
    }
    ByteWriter bytes;
    bytes.write(digest);
    Digest sum;
    const std::vector<std::byte> all = part.comm.allgather(bytes.view());
    ByteReader in(all, "digests of all processes");
    for (int p = 0; p < part.comm.processes(); ++p) sum.combine(in.read<Digest>());
    return sum;
}

}  // namespace meld::record
