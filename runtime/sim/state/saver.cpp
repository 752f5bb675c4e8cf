#include "runtime/sim/state/saver.h"

#include <algorithm>
#include <numeric>
#include <utility>

#include "runtime/base/assert.h"
#include "runtime/base/bytes.h"
#include "runtime/base/process/liveness.h"
#include "runtime/engine/tuple/schema.h"
#include "runtime/sim/state/cell_places.h"
#include "runtime/sim/state/failed.h"
#include "runtime/sim/state/free_places.h"

namespace meld::sim {

namespace {

bool touches_what_it_keeps(const SimModule& module) {
    const auto* const says = dynamic_cast<const SaysWhatChanges*>(&module);
    return says != nullptr && says->touches_what_it_keeps();
}

}  // namespace

Result<void> Saver::run(std::span<const std::byte> counters, ShareSink& sink) const {
    MELD_EXPECT(!subdomain_.status().half_way(), "a snapshot in the midst of tick {}", subdomain_.tick());
    MELD_EXPECT(subdomain_.facts_.evaluator.requests().empty(), "requests that wait for an evaluation, after tick {}", subdomain_.tick());
    if (auto done = subdomain_.ensemble.is_free() ? save_homes(sink) : save_cells(sink); !done) return done;
    ByteWriter end;
    rest(counters, end);
    return sink.rest(end.view());
}

Result<void> Saver::save_cells(ShareSink& sink) const {
    const std::size_t most = sink.chunk_catoms(), count = subdomain_.ensemble.index_count();
    const bool by_changes = changed_ != nullptr && most == changed_->catoms();
    const bool silent = by_changes && std::ranges::any_of(modules_, [](const NamedModule& m) { return !touches_what_it_keeps(*m.module); });
    std::vector<Catom> catoms;
    ByteWriter places, held;
    for (std::size_t chunk = 0; chunk * most < count; ++chunk) {
        if (by_changes) {
            bool changed = changed_->changed(chunk);
            if (silent) {
                list(chunk * most, most, catoms);
                const bool kept = any_kept_silently(catoms);
                if (kept) changed_->changes_by_itself(chunk);
                changed = changed || kept;
            }
            if (!changed && sink.take_as_before(chunk)) continue;
        }
        list(chunk * most, most, catoms);
        if (catoms.empty()) continue;
        places.clear(), held.clear();
        CellPlaces::save(subdomain_.ensemble, catoms, places);
        state(catoms, held);
        if (auto done = sink.chunk({places.view(), held.view(), chunk}); !done) return done;
    }
    return {};
}

void Saver::list(std::size_t first, std::size_t count, std::vector<Catom>& catoms) const {
    const auto end = static_cast<Catom>(std::min<std::size_t>(first + count, subdomain_.ensemble.index_count()));
    catoms.clear();
    // Mostly all are this process's. To count them is a few instructions for many of them.
    std::size_t mine = 0;
    for (auto c = static_cast<Catom>(first); c < end; ++c) mine += subdomain_.ensemble.state(c) == kCatomOwned ? 1 : 0;
    if (mine == end - first) {
        catoms.resize(mine);
        std::iota(catoms.begin(), catoms.end(), static_cast<Catom>(first));
        return;
    }
    for (auto c = static_cast<Catom>(first); c < end; ++c)
        if (subdomain_.owned(c)) catoms.push_back(c);
}

bool Saver::any_kept_silently(std::span<const Catom> catoms) const {
    ByteWriter kept;
    for (const NamedModule& each : modules_)
        if (!touches_what_it_keeps(*each.module) && !catoms.empty()) each.module->save_catoms(subdomain_, catoms, kept);
    return !kept.empty();
}

Result<void> Saver::save_homes(ShareSink& sink) const {
    // Which process owns a node follows from the graph, so nodes have no homes: they are saved in the order of their numbers.
    const bool graph = subdomain_.ensemble.is_graph();
    MELD_EXPECT(graph || subdomain_.home_of_ != nullptr, "catoms at arbitrary positions without homes");
    std::vector<std::pair<world::BrickKey, Catom>> all;
    for (Catom c = 0; c < subdomain_.ensemble.index_count(); ++c)
        if (subdomain_.owned(c))
            all.emplace_back(graph ? *subdomain_.nodes().find(subdomain_.ensemble.id(c)) / kBrickCells : subdomain_.home_of_(c), c);
    std::sort(all.begin(), all.end());
    std::vector<Catom> catoms;
    std::vector<world::BrickKey> homes;
    // A body has ten times the bytes of a catom on a lattice, and a block should fit into the cache and into memory that is used again.
    const std::size_t most = std::min<std::size_t>(sink.chunk_catoms(), kMostBodiesOfAChunk);
    ByteWriter places, held;
    for (std::size_t i = 0; i < all.size(); ++i) {
        homes.push_back(all[i].first);
        catoms.push_back(all[i].second);
        const bool last = i + 1 == all.size();
        if (!last && (catoms.size() < most || all[i + 1].first == homes.back())) continue;
        places.clear(), held.clear();
        FreePlaces::save(subdomain_.ensemble, subdomain_.members_.nodes, catoms, homes, places);
        state(catoms, held);
        if (auto done = sink.chunk({places.view(), held.view()}); !done) return done;
        catoms.clear(), homes.clear();
    }
    return {};
}

void Saver::state(std::span<const Catom> catoms, ByteWriter& out) const {
    liveness::beat();
    subdomain_.facts_.save(catoms, out);
    for (const NamedModule& each : modules_) {
        const std::size_t begun = out.begin_block();
        each.module->save_catoms(subdomain_, catoms, out);
        out.end_block(begun);
    }
}

void Saver::rest(std::span<const std::byte> counters, ByteWriter& out) const {
    // By which a later program reads the facts of this one.
    const std::size_t schema = out.begin_block();
    tuple::Schema::save(subdomain_.module, out);
    out.end_block(schema);
    out.write_count(modules_.size());
    for (const NamedModule& each : modules_) out.write_string(each.name);
    const std::size_t failed = out.begin_block();
    Failed::save(subdomain_, out);
    out.end_block(failed);
    out.write(subdomain_.tick());
    out.write(subdomain_.abi_.world_catoms);
    out.write(subdomain_.abi_.first_unborn);
    out.write(subdomain_.next_id());
    out.write(subdomain_.totals);
    out.write_block(counters);
    subdomain_.facts_.save_passing([&](u32 catom) { return subdomain_.ensemble.id(catom); }, out);
    const std::size_t network = out.begin_block();
    if (subdomain_.network_) subdomain_.network_->save(subdomain_.tick(), out);
    out.end_block(network);
    const std::size_t turns = out.begin_block();
    if (subdomain_.turns_) subdomain_.turns_->save(out);
    out.end_block(turns);
    codes_.save(out);
    for (const NamedModule& each : modules_) {
        const std::size_t begun = out.begin_block();
        each.module->save_rest(subdomain_, out);
        out.end_block(begun);
    }
}

}  // namespace meld::sim
