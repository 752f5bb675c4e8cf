#include "runtime/sim/state/saver.h"

#include <algorithm>
#include <utility>

#include "runtime/base/assert.h"
#include "runtime/base/bytes.h"
#include "runtime/base/pulse.h"
#include "runtime/sim/state/free_places.h"

namespace meld::sim {

Result<void> Saver::run(std::span<const std::byte> counters, ShareSink& sink) const {
    MELD_EXPECT(!subdomain_.status().half_way(), "a snapshot in the midst of tick {}", subdomain_.tick());
    MELD_EXPECT(subdomain_.facts_.evaluator.requests().empty(), "requests that wait for an evaluation, after tick {}", subdomain_.tick());
    if (auto done = subdomain_.ensemble.is_free() ? save_homes(sink) : save_cells(sink); !done) return done;
    return sink.rest(rest(counters));
}

Result<void> Saver::save_cells(ShareSink& sink) const {
    std::vector<Catom> catoms;
    const auto flush = [&]() -> Result<void> {
        if (catoms.empty()) return {};
        const Result<void> done = sink.chunk({places(catoms), state(catoms)});
        catoms.clear();
        return done;
    };
    for (Catom c = 0; c < subdomain_.ensemble.index_count(); ++c) {
        if (!subdomain_.owned(c)) continue;
        catoms.push_back(c);
        if (catoms.size() < sink.chunk_catoms()) continue;
        if (auto done = flush(); !done) return done;
    }
    return flush();
}

Result<void> Saver::save_homes(ShareSink& sink) const {
    MELD_EXPECT(subdomain_.home_of_ != nullptr, "catoms at arbitrary positions without homes");
    std::vector<std::pair<world::BrickKey, Catom>> all;
    for (Catom c = 0; c < subdomain_.ensemble.index_count(); ++c)
        if (subdomain_.owned(c)) all.emplace_back(subdomain_.home_of_(c), c);
    std::sort(all.begin(), all.end());
    std::vector<Catom> catoms;
    std::vector<world::BrickKey> homes;
    for (std::size_t i = 0; i < all.size(); ++i) {
        homes.push_back(all[i].first);
        catoms.push_back(all[i].second);
        const bool last = i + 1 == all.size();
        if (!last && (catoms.size() < sink.chunk_catoms() || all[i + 1].first == homes.back())) continue;
        ByteWriter places;
        FreePlaces::save(subdomain_.ensemble, catoms, homes, places);
        if (auto done = sink.chunk({places.take(), state(catoms)}); !done) return done;
        catoms.clear(), homes.clear();
    }
    return {};
}

Block Saver::places(std::span<const Catom> catoms) const {
    const world::Ensemble& ensemble = subdomain_.ensemble;
    ByteWriter places;
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
    return places.take();
}

Block Saver::state(std::span<const Catom> catoms) const {
    pulse::beat();
    ByteWriter state;
    subdomain_.facts_.save(catoms, state);
    for (const SimModule* module : modules_) {
        ByteWriter own;
        module->save_catoms(subdomain_, catoms, own);
        state.write_block(own.view());
    }
    return state.take();
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
