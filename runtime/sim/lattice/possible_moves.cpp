#include "runtime/sim/lattice/possible_moves.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>

#include "runtime/base/assert.h"
#include "runtime/engine/tuple/facts.h"

namespace meld::sim {

namespace {

constexpr const char* kPossible = "possible";
// Catoms that a worker takes at once: whole groups of the agenda.
constexpr Catom kSensedAtOnce = 1024;

// The cells near a site: no farther away than a brick is wide.
class NearSite {
  public:
    NearSite(const Geometry& geometry, u32 site) : g_(geometry), brick_(site >> kBrickCellBits), cell_(site & (kBrickCells - 1)) {}
    bool full(Cell offset) const {
        const i32 offsets[3] = {offset.x, offset.y, offset.z};
        u32 number = 0, brick = 0, across = 1;
        for (i32 axis = 0, shift = 0; axis < 3; shift += g_.cell_bits[axis++], across *= 3) {
            const i32 bits = g_.cell_bits[axis];
            const i32 mask = (1 << bits) - 1, at = (static_cast<i32>(cell_ >> shift) & mask) + offsets[axis];
            brick += static_cast<u32>((at >> bits) + 1) * across;
            number |= static_cast<u32>(at & mask) << shift;
        }
        return g_.cell_catom[g_.brick_neighbours[brick_ * kBrickNeighbours + brick] << kBrickCellBits | number] >= 0;
    }

  private:
    const Geometry& g_;
    u32 brick_, cell_;
};

// The predicate, if the program reads it.
std::optional<u32> stored_possible(const Subdomain& subdomain) {
    const std::optional<u32> p = tuple::find_sensed(subdomain.module, kPossible, 3);
    if (!p || subdomain.module.predicates[*p].base == kNone16) return std::nullopt;
    const u16 base = subdomain.module.predicates[*p].base;
    return subdomain.module.predicates[base].column == kNone16 ? std::nullopt : std::optional<u32>(base);
}

}  // namespace

Result<void> check_nothing_possible(const Subdomain& subdomain) {
    if (!stored_possible(subdomain)) return {};
    const std::string& path = subdomain.world.path;
    return fail(fmt::format("the program reads `{}`, and {} does not say which moves there are", kPossible,
                            path.empty() ? std::string("this world") : path),
                "Write moves = \"sliding\" or another name under [motion] kind = \"lattice\"; docs/moves.md has the names");
}

Result<void> PossibleMoves::start(const Subdomain& subdomain) {
    if (table_ == nullptr) return check_nothing_possible(subdomain);
    predicate_ = stored_possible(subdomain);
    if (predicate_) dirty_ = subdomain.module.columns[subdomain.module.predicates[*predicate_].column].own_dirty;
    return {};
}

void PossibleMoves::sense(Subdomain& subdomain) const {
    if (!predicate_) return;
    subdomain.refresh();
    std::vector<Catom> own;
    for (Catom c = 0; c < subdomain.ensemble.index_count(); ++c)
        if (subdomain.owned(c)) own.push_back(c);
    sense_all(subdomain, own);
}

void PossibleMoves::sense_changes(Subdomain& subdomain) {
    if (changed_.empty()) return;
    subdomain.refresh();
    std::ranges::sort(changed_);
    changed_.erase(std::unique(changed_.begin(), changed_.end()), changed_.end());
    std::vector<Catom> near;
    const auto look_at = [&](Cell cell) {
        const std::optional<Catom> catom = subdomain.ensemble.at(cell);
        if (catom && subdomain.owned(*catom)) near.push_back(*catom);
    };
    for (const Cell cell : changed_) {
        look_at(cell);
        // From even and from odd layers, where these see different cells.
        for (std::int32_t layer = 0; layer < 2; ++layer)
            for (const Cell seen : table_->cells_around({0, 0, layer}))
                if (const Cell from = cell - seen; (from.z & 1) == layer) look_at(from);
    }
    changed_.clear();
    std::ranges::sort(near);
    near.erase(std::unique(near.begin(), near.end()), near.end());
    sense_all(subdomain, near);
}

// Sorted. A worker has those of whole groups of the agenda.
void PossibleMoves::sense_all(Subdomain& subdomain, std::span<const Catom> catoms) const {
    MELD_EXPECT(std::ranges::is_sorted(catoms), "{} catoms out of order", catoms.size());
    std::vector<std::size_t> first;
    for (std::size_t i = 0; i < catoms.size(); ++i)
        if (i == 0 || catoms[i] / kSensedAtOnce != catoms[i - 1] / kSensedAtOnce) first.push_back(i);
    first.push_back(catoms.size());
    subdomain.workers.run(first.size() - 1, [&](int worker, std::size_t job) {
        Scratch scratch;
        for (std::size_t i = first[job]; i < first[job + 1]; ++i)
            if (const u64 news = sense_catom(subdomain, catoms[i], worker, scratch); news != 0) subdomain.mark_shared(catoms[i], news);
    });
}

u64 PossibleMoves::sense_catom(Subdomain& subdomain, Catom catom, int worker, Scratch& scratch) const {
    auto& [known, last, now] = scratch;
    last.clear();
    tuple::each_fact(subdomain.module, subdomain.columns, subdomain.geometry(), *predicate_, catom, [&](const Value* v) {
        const auto at = [&](std::size_t i) { return static_cast<std::int32_t>(v[i].integer); };
        last.push_back({at(0), at(1), at(2)});
    });
    std::ranges::sort(last);
    const NearSite near(subdomain.geometry(), subdomain.geometry().catom_site[catom]);
    const Cell from = subdomain.ensemble.cell(catom);
    table_->possible(from, [&](Cell offset) { return near.full(offset); }, known, now);
    // Where the lattice ends, nobody can go on.
    std::erase_if(now, [&](Cell by) { return !world::Lattice::in_range(from + by); });
    if (last == now) return 0;
    const auto arguments = [](Cell by) {
        std::array<Value, 3> all{};
        all[0].integer = by.x;
        all[1].integer = by.y;
        all[2].integer = by.z;
        return all;
    };
    for (const Cell by : last)
        if (!std::ranges::binary_search(now, by)) subdomain.take_shared(*predicate_, catom, arguments(by).data(), worker);
    for (const Cell by : now)
        if (!std::ranges::binary_search(last, by)) subdomain.give_shared(*predicate_, catom, arguments(by).data(), worker);
    return dirty_;
}

}  // namespace meld::sim
