// Steps of a run of one process: from its arrays into those of the step, one after the other. All catoms packed into bytes would take more
// time and memory than their columns.
#include <algorithm>
#include <cstring>
#include <iterator>
#include <tuple>
#include <utility>

#include "runtime/base/process/liveness.h"
#include "runtime/module/abi/geometry_abi.h"
#include "runtime/results/record/drawing.h"
#include "runtime/results/record/recorder.h"

namespace meld::record {

namespace {

// Where catoms are, without a call for the cell of each.
class Places {
  public:
    explicit Places(const sim::Subdomain& subdomain) : subdomain_(subdomain), geometry_(subdomain.geometry()) {}
    RecordedPosition of(sim::Catom catom) const {
        if (subdomain_.ensemble.is_free()) return narrow(subdomain_.ensemble.position(catom));
        const u32 site = geometry_.catom_site[catom];
        const auto at = [&](i32 axis) { return cell_coordinate(geometry_, site, axis); };
        return narrow(subdomain_.lattice.position({at(0), at(1), at(2)}));
    }

  private:
    const sim::Subdomain& subdomain_;
    const Geometry& geometry_;
};

}  // namespace

// Numbers are used once: if there are as many catoms as in the last step, and those that may have come were in it, nobody has gone either.
bool Recorder::own_are_as_before(const sim::Subdomain& subdomain) const {
    if (subdomain.ensemble.owned_count() != step_.ids.size()) return false;
    return std::ranges::all_of(changed_, [&](sim::Catom c) {
        return c >= subdomain.ensemble.index_count() || !subdomain.owned(c) || has_row(subdomain.ensemble.id(c));
    });
}

void Recorder::read_own_appearance(sim::Subdomain& subdomain) {
    ByteWriter packed;
    pack_appearance(subdomain, packed);
    ByteReader appearance(packed.view(), "what is drawn in a step of a recording");
    read_appearance(appearance);
}

// All of them, in the order of their ids, which have few gaps in most runs.
void Recorder::take_own(const sim::Subdomain& subdomain) {
    constexpr sim::Catom kNone = ~sim::Catom{0};
    changed_.clear();
    u64 last = 0;
    bool sorted = true;
    for (sim::Catom c = 0; c < subdomain.ensemble.index_count(); ++c) {
        if (!subdomain.owned(c)) continue;
        const u64 id = subdomain.ensemble.id(c);
        sorted = sorted && id >= last;
        last = std::max(last, id);
        changed_.push_back(c);
    }
    if (sorted) return;
    if (last >= 2 * changed_.size()) {
        std::ranges::sort(changed_, {}, [&](sim::Catom c) { return subdomain.ensemble.id(c); });
        return;
    }
    std::vector<sim::Catom> at(last + 1, kNone);
    for (const sim::Catom c : changed_) at[subdomain.ensemble.id(c)] = c;
    changed_.clear();
    std::ranges::copy_if(at, std::back_inserter(changed_), [](sim::Catom c) { return c != kNone; });
}

void Recorder::read_own_rows(sim::Subdomain& subdomain) {
    take_own(subdomain);
    const std::span<const sim::Catom> catoms = changed_;
    begin_rows(catoms.size());
    read_own_appearance(subdomain);
    const Places places(subdomain);
    for (const sim::Catom c : catoms) {
        liveness::beat();
        step_.ids.push_back(subdomain.ensemble.id(c));
        step_.positions.push_back(places.of(c));
    }
    liveness::beat();
    if (load_)
        for (const sim::Catom c : catoms) load_->add(subdomain.ensemble.id(c), LoadMap::here(subdomain, c));
    if (has_tails_)
        for (const sim::Catom c : catoms) step_.tails.push_back(tail_position(subdomain, c));
    if (has_diameters_)
        for (const sim::Catom c : catoms) step_.diameters.push_back(subdomain.diameter(c));
    if (has_turns_)
        for (const sim::Catom c : catoms) add_rounded(subdomain.rounded(c));
    step_.colours.resize(3 * catoms.size());
    for (std::size_t i = 0; i < catoms.size(); ++i) {
        const std::uint32_t colour = appearance_.colour(step_.ids[i]);
        for (std::size_t k = 0; k < 3; ++k) step_.colours[3 * i + k] = static_cast<std::uint8_t>(colour >> (16 - 8 * k));
    }
    if (appearance_.labels())
        for (const u64 id : step_.ids) step_.labels.push_back(appearance_.label(id));
    for (RecordedPredicate& r : recorded_) {
        liveness::beat();
        r.read(subdomain, catoms);
    }
}

// Of the same catoms as the last step, those that may have changed.
RowsOfCatoms Recorder::changed_rows(const sim::Subdomain& subdomain) {
    std::erase_if(changed_, [&](sim::Catom c) { return c >= subdomain.ensemble.index_count() || !subdomain.owned(c); });
    changed_rows_.clear();
    changed_rows_.reserve(changed_.size());
    for (const sim::Catom c : changed_) changed_rows_.push_back(static_cast<u32>(row_with(subdomain.ensemble.id(c))));
    if (std::ranges::is_sorted(changed_rows_)) return {changed_rows_, changed_};
    std::vector<std::pair<u32, sim::Catom>> rows;
    rows.reserve(changed_.size());
    for (std::size_t i = 0; i < changed_.size(); ++i) rows.emplace_back(changed_rows_[i], changed_[i]);
    std::ranges::sort(rows);
    for (std::size_t i = 0; i < rows.size(); ++i) std::tie(changed_rows_[i], changed_[i]) = rows[i];
    return {changed_rows_, changed_};
}

void Recorder::update_own_rows(sim::Subdomain& subdomain) {
    begin_update();
    read_own_appearance(subdomain);
    const RowsOfCatoms rows = changed_rows(subdomain);
    const Places places(subdomain);
    rows.each([&](u32 row, sim::Catom c) { replace(step_.positions, row, places.of(c), step_.moved); });
    liveness::beat();
    if (has_tails_) rows.each([&](u32 row, sim::Catom c) { replace(step_.tails, row, tail_position(subdomain, c), step_.changed_tails); });
    if (has_diameters_)
        rows.each([&](u32 row, sim::Catom c) { replace(step_.diameters, row, subdomain.diameter(c), step_.changed_diameters); });
    if (has_turns_) rows.each([&](u32 row, sim::Catom c) { replace_rounded(row, subdomain.rounded(c)); });
    for (RecordedPredicate& r : recorded_) {
        liveness::beat();
        r.update(subdomain, rows);
    }
    end_update();
}

}  // namespace meld::record
