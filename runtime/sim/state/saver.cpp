#include "runtime/sim/state/saver.h"

#include "runtime/base/assert.h"
#include "runtime/base/bytes.h"

namespace meld::sim {

Result<void> Saver::run(std::span<const std::byte> counters, ShareSink& sink) const {
    MELD_EXPECT(!subdomain_.status().half_way(), "a snapshot in the midst of tick {}", subdomain_.tick());
    MELD_EXPECT(subdomain_.facts_.evaluator.requests().empty(), "requests that wait for an evaluation, after tick {}", subdomain_.tick());
    std::vector<Catom> catoms;
    const auto flush = [&]() -> Result<void> {
        if (catoms.empty()) return {};
        const Result<void> done = sink.chunk(chunk(catoms));
        catoms.clear();
        return done;
    };
    for (Catom c = 0; c < subdomain_.ensemble.index_count(); ++c) {
        if (!subdomain_.owned(c)) continue;
        catoms.push_back(c);
        if (catoms.size() < sink.chunk_catoms()) continue;
        if (auto done = flush(); !done) return done;
    }
    if (auto done = flush(); !done) return done;
    return sink.rest(rest(counters));
}

Chunk Saver::chunk(std::span<const Catom> catoms) const {
    const world::Ensemble& ensemble = subdomain_.ensemble;
    ByteWriter places, state;
    places.reserve(sizeof(std::uint32_t) + catoms.size() * (sizeof(std::uint64_t) + sizeof(Cell)));
    places.write_count(catoms.size());
    std::vector<std::uint64_t> ids(catoms.size());
    std::vector<Cell> cells(catoms.size());
    for (std::size_t i = 0; i < catoms.size(); ++i) {
        ids[i] = ensemble.id(catoms[i]);
        cells[i] = ensemble.cell(catoms[i]);
    }
    places.write_bytes(ids.data(), ids.size() * sizeof ids[0]);
    places.write_bytes(cells.data(), cells.size() * sizeof cells[0]);
    subdomain_.facts_.save(catoms, state);
    for (const SimModule* module : modules_) {
        ByteWriter own;
        module->save_catoms(subdomain_, catoms, own);
        state.write_block(own.view());
    }
    return {places.take(), state.take()};
}

Block Saver::rest(std::span<const std::byte> counters) const {
    ByteWriter out;
    out.write(subdomain_.tick());
    out.write(subdomain_.abi_.world_catoms);
    out.write(subdomain_.next_id());
    out.write(subdomain_.totals);
    out.write_block(counters);
    subdomain_.facts_.save_passing([&](u32 catom) { return subdomain_.ensemble.id(catom); }, out);
    codes_.save(out);
    out.write_count(modules_.size());
    for (const SimModule* module : modules_) {
        ByteWriter own;
        module->save_rest(subdomain_, own);
        out.write_block(own.view());
    }
    return out.take();
}

}  // namespace meld::sim
