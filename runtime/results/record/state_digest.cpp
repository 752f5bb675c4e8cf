#include "runtime/results/record/state_digest.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <bit>
#include <span>
#include <vector>

#include "runtime/base/assert.h"
#include "runtime/base/bytes.h"
#include "runtime/engine/tuple/facts.h"
#include "runtime/engine/tuple/field.h"
#include "runtime/engine/tuple/single_facts.h"
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

// Of some catoms of this process, and all that they hold: the digest of each.
class Parts {
  public:
    void add(const sim::Subdomain& subdomain, sim::Catom catom) {
        catoms_[count_] = catom;
        parts_[count_] = {};
        parts_[count_++].add(hash_combine(subdomain.ensemble.id(catom), place_of(subdomain, catom)));
    }
    bool full() const { return count_ == kCatomsAtOnce; }
    void clear() { count_ = 0; }
    std::span<const sim::Catom> catoms() const { return std::span(catoms_).first(count_); }
    std::span<const Digest> of(const sim::Subdomain& subdomain) {
        for (u32 i = 0; i < subdomain.module.predicate_count; ++i) {
            const PredicateInfo& p = subdomain.module.predicates[i];
            if (!shown(p)) continue;
            const u64 name = hash_combine(hash_text(p.name), p.arity);
            if (tuple::SingleFacts::fits(p)) {
                const tuple::SingleFacts facts(subdomain.module, subdomain.columns, i);
                for (std::size_t k = 0; k < count_; ++k)
                    if (const u8* const record = facts.find(catoms_[k]))
                        parts_[k].add(facts.hash(hash_combine(name, subdomain.ensemble.id(catoms_[k])), record));
                continue;
            }
            if (p.storage == Storage::Rows) {
                of_rows(subdomain, p, name);
                continue;
            }
            std::size_t at = 0;
            tuple::each_fact_of(subdomain.module, subdomain.columns, subdomain.geometry(), i, catoms(), [&](sim::Catom c, const Value* v) {
                while (catoms_[at] != c) ++at;
                parts_[at].add(tuple::hash_arguments(subdomain.module, p, hash_combine(name, subdomain.ensemble.id(c)), v));
            });
        }
        return std::span(parts_).first(count_);
    }

  private:
    // Most catoms have none of most predicates.
    void of_rows(const sim::Subdomain& subdomain, const PredicateInfo& p, u64 name) {
        const std::size_t row_bytes = subdomain.module.columns[p.column].row_bytes;
        for (std::size_t k = 0; k < count_; ++k) {
            const RowsHead& head = subdomain.columns.rows(p.column, catoms_[k]);
            for (u32 r = 0; r < head.count; ++r) {
                tuple::read_row(p, head.data + r * row_bytes, values_);
                parts_[k].add(
                    tuple::hash_arguments(subdomain.module, p, hash_combine(name, subdomain.ensemble.id(catoms_[k])), values_.data()));
            }
        }
    }

    std::vector<Value> values_;
    std::array<sim::Catom, kCatomsAtOnce> catoms_;
    std::array<Digest, kCatomsAtOnce> parts_;
    std::size_t count_ = 0;
};

Digest difference(const Digest& a, const Digest& b) { return {a.low() - b.low(), a.high() - b.high()}; }

// Calls visit(worker, catoms, parts) for the catoms of this process among so many, some at a time, from all workers at once. `catom(i)` is
// the i-th; visit_other(catom) is called for those that are not of this process.
template <class Catom, class Visit, class Other>
void each_part(sim::Subdomain& subdomain, std::size_t count, const Catom& catom, const Visit& visit, const Other& visit_other) {
    subdomain.workers.run((count + kCatomsAtOnce - 1) / kCatomsAtOnce, [&](int worker, std::size_t block) {
        Parts parts;
        for (std::size_t i = block * kCatomsAtOnce; i < std::min(count, (block + 1) * kCatomsAtOnce); ++i) {
            const sim::Catom c = catom(i);
            if (c < subdomain.ensemble.index_count() && subdomain.owned(c))
                parts.add(subdomain, c);
            else
                visit_other(worker, c);
        }
        visit(worker, parts.catoms(), parts.of(subdomain));
    });
}

// The same of the catoms that have been touched, without a list of them, by one worker.
template <class Visit, class Other>
void take_parts(sim::Subdomain& subdomain, sim::Touched& touched, const Visit& visit, const Other& visit_other) {
    Parts parts;
    const auto end = [&] {
        visit(0, parts.catoms(), parts.of(subdomain));
        parts.clear();
    };
    touched.take([&](sim::Catom c) {
        if (c < subdomain.ensemble.index_count() && subdomain.owned(c))
            parts.add(subdomain, c);
        else
            visit_other(0, c);
        if (parts.full()) end();
    });
    end();
}

Digest of_all(sim::Subdomain& subdomain, std::span<const Digest> by_worker) {
    ByteWriter bytes;
    Digest digest;
    for (const Digest& each : by_worker) digest.combine(each);
    if (subdomain.alone()) return digest;
    bytes.write(digest);
    Digest sum;
    const std::vector<std::byte> all = subdomain.comm.allgather(bytes.view());
    ByteReader in(all, "digests of all processes");
    for (int p = 0; p < subdomain.comm.processes(); ++p) sum.combine(in.read<Digest>());
    return sum;
}

}  // namespace

Digest state_digest(sim::Subdomain& subdomain) {
    subdomain.refresh();
    std::vector<Digest> by_worker(static_cast<std::size_t>(subdomain.workers.threads()));
    each_part(
        subdomain, subdomain.ensemble.index_count(), [](std::size_t i) { return static_cast<sim::Catom>(i); },
        [&](int worker, std::span<const sim::Catom>, std::span<const Digest> parts) {
            for (const Digest& part : parts) by_worker[static_cast<std::size_t>(worker)].combine(part);
        },
        [](int, sim::Catom) {});
    return of_all(subdomain, by_worker);
}

Digest ChunkDigest::of(sim::Subdomain& subdomain, const sim::ChangedChunks& chunks) {
    const std::size_t catoms = chunks.catoms();
    MELD_EXPECT(catoms <= kCatomsAtOnce, "{} catoms a chunk", catoms);
    subdomain.refresh();
    const std::vector<std::size_t> changed = chunks.all_changed();
    if (!changed.empty()) parts_.resize(std::max(parts_.size(), changed.back() + 1));
    std::vector<Digest> by_worker(static_cast<std::size_t>(subdomain.workers.threads()));
    subdomain.workers.run(changed.size(), [&](int worker, std::size_t at) {
        Parts parts;
        const std::size_t first = changed[at] * catoms;
        const std::size_t end = std::min(first + catoms, subdomain.ensemble.index_count());
        for (std::size_t c = first; c < end; ++c)
            if (subdomain.owned(static_cast<sim::Catom>(c))) parts.add(subdomain, static_cast<sim::Catom>(c));
        Digest sum;
        for (const Digest& part : parts.of(subdomain)) sum.combine(part);
        by_worker[static_cast<std::size_t>(worker)].combine(difference(sum, parts_[changed[at]]));
        parts_[changed[at]] = sum;
    });
    for (const Digest& change : by_worker) sum_.combine(change);
    return of_all(subdomain, {&sum_, 1});
}

Digest RunningDigest::of(sim::Subdomain& subdomain) {
    subdomain.refresh();
    if (touched_ == nullptr) touched_ = &subdomain.follow();
    parts_.resize(std::max(parts_.size(), subdomain.ensemble.index_count()));
    std::vector<Digest> by_worker(static_cast<std::size_t>(subdomain.workers.threads()));
    const auto put = [&](int worker, sim::Catom c, const Digest& part) {
        by_worker[static_cast<std::size_t>(worker)].combine(difference(part, parts_[c]));
        parts_[c] = part;
    };
    const auto put_all = [&](int worker, std::span<const sim::Catom> catoms, std::span<const Digest> parts) {
        for (std::size_t i = 0; i < catoms.size(); ++i) put(worker, catoms[i], parts[i]);
    };
    const auto put_none = [&](int worker, sim::Catom c) {
        if (c < parts_.size()) put(worker, c, {});
    };
    if (by_worker.size() == 1) {
        take_parts(subdomain, *touched_, put_all, put_none);
    } else {
        catoms_.clear();
        touched_->take([&](sim::Catom c) { catoms_.push_back(c); });
        each_part(subdomain, catoms_.size(), [&](std::size_t i) { return catoms_[i]; }, put_all, put_none);
    }
    for (const Digest& change : by_worker) sum_.combine(change);
    return of_all(subdomain, {&sum_, 1});
}

Result<void> RunningDigest::check(sim::Subdomain& subdomain) const {
    subdomain.refresh();
    constexpr u64 kNone = ~u64{0};
    struct Found {
        u64 least = kNone;
        bool same = true;
        Digest sum;
    };
    std::vector<Found> by_worker(static_cast<std::size_t>(subdomain.workers.threads()));
    each_part(
        subdomain, subdomain.ensemble.index_count(), [](std::size_t i) { return static_cast<sim::Catom>(i); },
        [&](int worker, std::span<const sim::Catom> catoms, std::span<const Digest> parts) {
            Found& found = by_worker[static_cast<std::size_t>(worker)];
            for (std::size_t i = 0; i < catoms.size(); ++i) {
                found.sum.combine(parts[i]);
                if (catoms[i] < parts_.size() && parts_[catoms[i]] == parts[i]) continue;
                found.least = std::min(found.least, subdomain.ensemble.id(catoms[i]));
            }
        },
        [](int, sim::Catom) {});
    Found mine;
    for (const Found& found : by_worker) mine.least = std::min(mine.least, found.least), mine.sum.combine(found.sum);
    mine.same = mine.sum == sum_;
    ByteWriter bytes;
    bytes.write(mine);
    const std::vector<std::byte> all = subdomain.comm.allgather(bytes.view());
    ByteReader in(all, "checked digests of all processes");
    Found sum;
    for (int p = 0; p < subdomain.comm.processes(); ++p) {
        const auto found = in.read<Found>();
        sum.least = std::min(sum.least, found.least);
        sum.same = sum.same && found.same;
    }
    if (sum.same && sum.least == kNone) return {};
    // Only a catom that has left without a word is missed by none that there are.
    const std::string first = sum.least == kNone ? "catoms that are no more" : fmt::format("first at catom @{}", sum.least);
    return fail(fmt::format("the digest of tick {} by changes is not that of the whole state: it differs {}{}", subdomain.tick(),
                            sum.least == kNone ? "by " : "", first),
                "Please report this with the program and the world", ExitCode::OurBug);
}

}  // namespace meld::record
