#include "runtime/record/facts_file.h"

#include <algorithm>
#include <bit>
#include <cstring>
#include <queue>

#include "runtime/base/assert.h"
#include "runtime/base/bytes.h"
#include "runtime/comm/outcome.h"
#include "runtime/tuple/facts.h"

namespace meld::record {

namespace {

bool shown(const PredicateInfo& p) { return !p.auxiliary && p.column != kNone16 && p.kind != PredicateKind::Action; }

// One catom's facts of a predicate as text, to be merged by id.
struct Lines {
    u64 id;
    std::string text;
};

// The facts of one predicate on this process, by id and then by arguments, as packed bytes: id, length, text.
std::vector<std::byte> facts_of(sim::Subdomain& part, u32 predicate) {
    const PredicateInfo& p = part.module.predicates[predicate];
    std::vector<std::pair<u64, sim::Catom>> order;
    for (sim::Catom c = 0; c < part.ensemble.index_count(); ++c)
        if (part.owned(c)) order.emplace_back(part.ensemble.id(c), c);
    std::sort(order.begin(), order.end());
    ByteWriter out;
    std::string text;
    std::vector<std::vector<Value>> facts;
    for (const auto& [id, catom] : order) {
        facts.clear();
        tuple::each_fact(part.module, part.columns, part.geometry(), predicate, catom,
                         [&](const Value* v) { facts.emplace_back(v, v + p.arity); });
        if (facts.empty()) continue;
        std::sort(facts.begin(), facts.end(),
                  [&](const auto& a, const auto& b) { return tuple::compare_arguments(part.module, p, a.data(), b.data()) < 0; });
        text.clear();
        for (const auto& fact : facts) text += tuple::print_fact(part.module, p, id, fact.data()) + ".\n";
        out.write(id);
        out.write_string(text);
    }
    return out.take();
}

// Reads packed lines one after another.
bool read_lines(ByteReader& in, Lines& out) {
    if (in.done()) return false;
    out.id = in.read<u64>();
    out.text = in.read_string();
    return true;
}

void merge(const std::vector<std::vector<std::byte>>& parts, OutputFile& file) {
    std::vector<ByteReader> readers;
    std::vector<Lines> heads(parts.size());
    std::priority_queue<std::pair<u64, std::size_t>, std::vector<std::pair<u64, std::size_t>>, std::greater<>> next;
    for (std::size_t i = 0; i < parts.size(); ++i) {
        readers.emplace_back(parts[i], "facts of a process");
        if (read_lines(readers[i], heads[i])) next.emplace(heads[i].id, i);
    }
    while (!next.empty()) {
        const std::size_t i = next.top().second;
        next.pop();
        file.write(heads[i].text);
        if (read_lines(readers[i], heads[i])) next.emplace(heads[i].id, i);
    }
}

}  // namespace

Result<void> write_facts(sim::Subdomain& part, OutputFile* file) {
    part.refresh();
    std::vector<u32> order;
    for (u32 i = 0; i < part.module.predicate_count; ++i)
        if (shown(part.module.predicates[i])) order.push_back(i);
    std::sort(order.begin(), order.end(), [&](u32 a, u32 b) {
        const PredicateInfo &x = part.module.predicates[a], &y = part.module.predicates[b];
        const int names = std::strcmp(x.name, y.name);
        return names != 0 ? names < 0 : x.arity < y.arity;
    });
    const bool writer = part.comm.process() == 0;
    MELD_CHECK(writer == (file != nullptr), "process 0 alone has the file of facts");
    for (const u32 predicate : order) {
        std::vector<std::byte> mine = facts_of(part, predicate);
        std::vector<std::vector<std::byte>> all(1);
        if (writer) all[0] = std::move(mine);
        std::vector<comm::Packet> packets;
        if (!writer && !mine.empty()) packets.push_back({0, std::move(mine)});
        if (!part.alone())
            for (comm::Packet& p : part.comm.exchange(std::move(packets))) all.push_back(std::move(p.bytes));
        if (writer) merge(all, *file);
    }
    Result<void> written;
    if (writer) written = file->commit();
    return comm::outcome_of_first(part.comm, written);
}

namespace {

// Of a cell its key, of a place anywhere all its bits.
u64 place_of(const sim::Subdomain& part, sim::Catom catom) {
    if (!part.ensemble.is_free()) return part.lattice.key(part.ensemble.cell(catom));
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
