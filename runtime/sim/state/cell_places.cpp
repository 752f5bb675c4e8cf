#include "runtime/sim/state/cell_places.h"

#include <fmt/format.h>

#include "runtime/sim/state/reading.h"
#include "runtime/world/lattice/hilbert.h"

namespace meld::sim {

namespace {

constexpr std::size_t kRun_bytes = 2 * sizeof(std::uint64_t) + sizeof(std::uint32_t);
// Behind the last cell of the curve.
constexpr world::CellKey kEnd = world::CellKey{1} << (3 * world::kHilbertBits + kBrickCellBits);

}  // namespace

void CellPlaces::save(const world::Ensemble& ensemble, std::span<const world::Catom> catoms, ByteWriter& out) {
    std::vector<Run> runs;
    for (const world::Catom catom : catoms) {
        const world::CellKey key = ensemble.key_of(catom);
        const std::uint64_t id = ensemble.id(catom);
        if (Run* last = runs.empty() ? nullptr : &runs.back();
            last != nullptr && key == last->first + last->count && id == last->id + last->count)
            ++last->count;
        else
            runs.push_back({key, id, 1});
    }
    out.reserve(sizeof(std::uint32_t) + runs.size() * kRun_bytes);
    out.write_count(runs.size());
    for (const Run& run : runs) {
        out.write(run.first);
        out.write(run.id);
        out.write(run.count);
    }
}

Result<CellPlaces> CellPlaces::read(ByteReader& in) {
    CellPlaces all;
    all.runs_.resize(in.read_count(kRun_bytes));
    for (Run& run : all.runs_) {
        run.first = in.read<world::CellKey>();
        run.id = in.read<std::uint64_t>();
        run.count = in.read<std::uint32_t>();
        if (run.count == 0 || run.count > kMostCatomsOfAChunk - all.count_ || run.first > kEnd - run.count)
            return damaged(fmt::format("has {} catoms from cell {} of the curve on, after {} others", run.count, run.first, all.count_));
        all.count_ += run.count;
    }
    return all;
}

}  // namespace meld::sim
