#include "runtime/results/record/state_digest.h"

#include <algorithm>
#include <bit>
#include <span>
#include <vector>

#include "runtime/base/bytes.h"
#include "runtime/engine/tuple/facts.h"
#include "runtime/results/facts/fact_tables.h"

namespace meld::record {

namespace {

// A worker takes so many catoms at a time: enough to ask for the facts of each predicate in turn, and few enough to stay in the cache.
constexpr std::size_t kCatomsAtOnce = 2048;

// Of a cell its key, of a place anywhere all its bits.
u64 place_of(const sim::Subdomain& subdomain, sim::Catom catom) {
    if (!subdomain.ensemble.is_free()) return subdomain.ensemble.key_of(catom);
    u64 hash = 0;
    for (const double x : subdomain.ensemble.position(catom)) hash = hash_combine(hash, std::bit_cast<u64>(x + 0.0));
    return hash;
}

// Of some catoms, and all that they hold.
Digest digest_of(const sim::Subdomain& subdomain, std::span<const sim::Catom> catoms) {
    Digest digest;
    for (const sim::Catom c : catoms) digest.add(hash_combine(subdomain.ensemble.id(c), place_of(subdomain, c)));
    for (u32 i = 0; i < subdomain.module.predicate_count; ++i) {
        const PredicateInfo& p = subdomain.module.predicates[i];
        if (!shown(p)) continue;
        const u64 name = hash_combine(hash_text(p.name), p.arity);
        tuple::each_fact_of(subdomain.module, subdomain.columns, subdomain.geometry(), i, catoms, [&](sim::Catom c, const Value* v) {
            digest.add(tuple::hash_arguments(subdomain.module, p, hash_combine(name, subdomain.ensemble.id(c)), v));
        });
    }
    return digest;
}

}  // namespace

Digest state_digest(sim::Subdomain& subdomain) {
    subdomain.refresh();
    const std::size_t count = subdomain.ensemble.index_count();
    std::vector<Digest> by_worker(static_cast<std::size_t>(subdomain.workers.threads()));
    subdomain.workers.run((count + kCatomsAtOnce - 1) / kCatomsAtOnce, [&](int worker, std::size_t part) {
        std::vector<sim::Catom> catoms;
        catoms.reserve(kCatomsAtOnce);
        for (std::size_t c = part * kCatomsAtOnce; c < std::min(count, (part + 1) * kCatomsAtOnce); ++c)
            if (subdomain.owned(static_cast<sim::Catom>(c))) catoms.push_back(static_cast<sim::Catom>(c));
        by_worker[static_cast<std::size_t>(worker)].combine(digest_of(subdomain, catoms));
    });
    Digest digest;
    for (const Digest& each : by_worker) digest.combine(each);
    ByteWriter bytes;
    bytes.write(digest);
    Digest sum;
    const std::vector<std::byte> all = subdomain.comm.allgather(bytes.view());
    ByteReader in(all, "digests of all processes");
    for (int p = 0; p < subdomain.comm.processes(); ++p) sum.combine(in.read<Digest>());
    return sum;
}

}  // namespace meld::record
