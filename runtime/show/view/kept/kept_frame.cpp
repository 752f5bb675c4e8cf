#include "runtime/show/view/kept/kept_frame.h"

#include <algorithm>
#include <span>
#include <utility>

#include "runtime/base/bytes.h"
#include "runtime/comm/transport/collective_result.h"
#include "runtime/comm/transport/gather_to_root.h"
#include "runtime/show/picture/palette.h"
#include "runtime/show/render/cells.h"

namespace meld::view {

namespace {

constexpr std::uint32_t kNowhere = 0xffffffff;
// More cells or numbers for a catom than these take more memory than the ensemble: a bit each, and 12 bytes.
constexpr double kCellsToACatom = 256, kFewCells = 1 << 26;
constexpr std::uint64_t kNumbersToACatom = 4, kFewNumbers = 1 << 20;

render::Rgb rgb_of(std::uint32_t c) {
    return {static_cast<std::uint8_t>(c >> 16), static_cast<std::uint8_t>(c >> 8), static_cast<std::uint8_t>(c)};
}

void write(const ShownCatoms& some, ByteWriter& out) {
    out.write_count(some.rows.size());
    for (const ShownCatoms::Row& row : some.rows) out.write(row);
    out.write_count(some.words.size());
    for (const std::string& word : some.words) out.write_string(word);
}

ShownCatoms read_shown(ByteReader& in) {
    ShownCatoms some;
    for (auto left = in.read_count(sizeof(ShownCatoms::Row)); left > 0; --left) some.rows.push_back(in.read<ShownCatoms::Row>());
    for (auto left = in.read_count(sizeof(u32)); left > 0; --left) some.words.push_back(in.read_string());
    return some;
}

}  // namespace

std::unique_ptr<KeptFrame> KeptFrame::make(const sim::Subdomain& subdomain, const record::Drawing& drawing, const picture::Look& look,
                                           std::size_t most) {
    const bool plain = look.links.empty() && look.arrows.empty() && look.labels.empty() && look.callouts.empty() && !look.exposed &&
                       !look.ground && look.size.value_or(1) == 1;
    if (!plain || !drawing.draws_cells_only(subdomain)) return nullptr;
    std::optional<ChangedCatoms> changed = ChangedCatoms::make(subdomain.module, look);
    if (!changed) return nullptr;
    return std::unique_ptr<KeptFrame>(new KeptFrame(look, most, subdomain.world, std::move(*changed)));
}

KeptFrame::KeptFrame(const picture::Look& look, std::size_t most, const world::World& world, ChangedCatoms changed)
    : look_(look),
      most_(most),
      world_(world),
      lattice_(world.lattice),
      changed_(std::move(changed)),
      box_(world.lattice),
      values_(changed_.kind()) {}

Result<KeptFrame::Updated> KeptFrame::update(sim::Subdomain& subdomain, record::Drawing& drawing, sim::Touched& touched) {
    const std::size_t before = catoms_;
    if (!agree(subdomain)) return Updated::TooWide;
    drawing.catch_up(subdomain);
    if (auto done = exchange(subdomain, touched); !done) return tl::unexpected<Error>(done.error());
    if (subdomain.comm.process() != 0) return Updated::Same;
    const bool other_values = std::exchange(other_values_, false);
    bool other = other_values || catoms_ != before;
    const bool moved = std::exchange(moved_, false);
    if (moved) choose();
    if (look_.colour.empty() && (moved || colours_ != drawing.changes())) {
        for (std::size_t i = 0; i < base_.ids.size(); ++i) base_.scene.colours[i] = rgb_of(drawing.colour(base_.ids[i]));
        colours_ = drawing.changes();
        other = true;
    }
    return other || moved ? Updated::Other : Updated::Same;
}

// All processes count cells alike, in a box around their bricks. Returns whether it is not too large.
bool KeptFrame::agree(const sim::Subdomain& subdomain) {
    const world::Ensemble& ensemble = subdomain.ensemble;
    const auto& bits = lattice_.brick_bits();
    const world::Cell last{(1 << bits[0]) - 1, (1 << bits[1]) - 1, (1 << bits[2]) - 1};
    for (; bricks_ < ensemble.brick_count(); ++bricks_) {
        const world::Cell first = lattice_.brick_origin(ensemble.brick(static_cast<world::Slot>(bricks_ + 1)));
        own_.include(box_.bounds_of(first, first + last));
    }
    struct Mine {
        CellBox::Bounds bounds;
        std::uint64_t catoms = 0, next_id = 0;
    };
    const Mine mine{.bounds = own_, .catoms = ensemble.owned_count(), .next_id = subdomain.next_id()};
    const std::vector<std::byte> all = subdomain.comm.allgather(std::as_bytes(std::span(&mine, 1)));
    CellBox::Bounds bounds;
    catoms_ = 0;
    ByteReader in(all, "the bricks of all processes");
    while (!in.done()) {
        const auto one = in.read<Mine>();
        bounds.include(one.bounds);
        catoms_ += one.catoms;
        next_id_ = std::max(next_id_, one.next_id);
    }
    const CellBox before = box_;
    const bool grown = box_.grow(bounds);
    if (box_.size() >= kNowhere || box_.size() > std::max(kCellsToACatom * static_cast<double>(catoms_), kFewCells)) return false;
    if (next_id_ >= kNowhere || next_id_ > kNumbersToACatom * catoms_ + kFewNumbers) return false;
    if (subdomain.comm.process() != 0) return true;
    cells_.resize(std::max<std::size_t>(cells_.size(), next_id_), kNowhere);
    values_.resize(cells_.size());
    if (grown) renumber(before);
    return true;
}

void KeptFrame::renumber(const CellBox& before) {
    occupied_ = render::CellBits(static_cast<std::size_t>(box_.size()), box_.ways(lattice_));
    for (std::uint32_t& cell : cells_) {
        if (cell == kNowhere) continue;
        cell = box_.number(before.cell(cell));
        occupied_.set(cell);
    }
}

Result<void> KeptFrame::exchange(sim::Subdomain& subdomain, sim::Touched& touched) {
    const bool speaks = subdomain.comm.process() == 0;
    // Whoever has come to another process has left its former one first.
    ByteWriter gone;
    for (const std::uint64_t id : changed_.begin(subdomain, touched)) gone.write(id);
    for (const auto& bytes : comm::gather_to_root(subdomain.comm, gone.take()))
        for (ByteReader in(bytes, "catoms that are gone"); !in.done();) hide(in.read<std::uint64_t>());
    ByteWriter shown, hidden;
    const Result<void> looked = changed_.look(
        subdomain, box_, [&](const ShownCatoms& some) { speaks ? show(some) : write(some, shown); },
        [&](std::uint64_t id) { speaks ? hide(id) : hidden.write(id); });
    for (const auto& bytes : comm::gather_to_root(subdomain.comm, hidden.take()))
        for (ByteReader in(bytes, "catoms that are hidden"); !in.done();) hide(in.read<std::uint64_t>());
    for (const auto& bytes : comm::gather_to_root(subdomain.comm, shown.take()))
        for (ByteReader in(bytes, "catoms that are shown"); !in.done();) show(read_shown(in));
    for (const std::uint32_t cell : std::exchange(taken_, {})) occupied_.set(cell);
    return comm::outcome_of_all(subdomain.comm, looked);
}

void KeptFrame::hide(std::uint64_t id) {
    if (cells_[id] == kNowhere) return;
    occupied_.clear(std::exchange(cells_[id], kNowhere));
    --shown_;
    moved_ = true;
    other_values_ = values_.set(id, std::nullopt) || other_values_;
}

void KeptFrame::show(const ShownCatoms& some) {
    const bool words = changed_.kind() == KeptValues::Kind::Holds || changed_.kind() == KeptValues::Kind::Text;
    for (const ShownCatoms::Row& row : some.rows) {
        std::uint32_t& cell = cells_[row.id];
        if (cell != row.cell) {
            if (cell == kNowhere)
                ++shown_;
            else
                occupied_.clear(cell);
            taken_.push_back(cell = row.cell);
            moved_ = true;
        }
        std::optional<std::uint64_t> value;
        if (row.has_value) value = words ? values_.word(some.words[row.value]) : row.value;
        other_values_ = values_.set(row.id, value) || other_values_;
    }
}

std::vector<std::uint32_t> KeptFrame::all_shown() const {
    std::vector<std::uint32_t> ids;
    ids.reserve(shown_);
    for (std::uint32_t id = 0; id < cells_.size(); ++id)
        if (cells_[id] != kNowhere) ids.push_back(id);
    return ids;
}

// Those that can be seen.
std::vector<std::uint32_t> KeptFrame::unhidden() const {
    render::CellBits hidden = occupied_.within();
    for (int layer = 0; layer < layers_seen(look_.form.value_or(picture::form_of(lattice_.kind()))); ++layer) hidden = hidden.within();
    std::vector<std::uint32_t> ids;
    for (std::uint32_t id = 0; id < cells_.size(); ++id)
        if (cells_[id] != kNowhere && !hidden.has(cells_[id])) ids.push_back(id);
    return ids;
}

// Puts catoms into the frame, in the order of their numbers.
void KeptFrame::place(const std::vector<std::uint32_t>& ids) {
    record::Drawn drawn;
    drawn.ids.assign(ids.begin(), ids.end());
    drawn.colours.resize(ids.size());
    drawn.positions.reserve(ids.size());
    for (const std::uint32_t id : ids) drawn.positions.push_back(lattice_.position(box_.cell(cells_[id])));
    base_ = picture::look_at(drawn, world_, 0, look_);
}

void KeptFrame::choose() {
    covers_.clear();
    balls_.reset();
    const bool leaves_out = shown_ > most_ && !lattice_.flat();
    if (leaves_out) {
        const std::vector<std::uint32_t> ids = unhidden();
        place(ids);
        const std::vector<render::Vec>& ways = base_.scene.ways;
        if (render::Cells::fits(base_.scene.places, ways, shown_))
            for (const std::uint32_t id : ids)
                covers_.push_back(cover_of(ways, [&](std::size_t way) { return occupied_.has_next(cells_[id], way); }));
    }
    if (covers_.empty()) place(all_shown());
    if (base_.scene.places.size() > most_) balls_.emplace(base_.scene, covers_, most_);
}

KeptFrame::Seen KeptFrame::seen(std::int64_t tick) {
    Seen out{.frame = base_, .shown = shown_};
    out.frame.tick = tick;
    out.frame.catoms = catoms_;
    picture::Palette palette(look_);
    if (!look_.colour.empty()) {
        for (std::size_t i = 0; i < base_.ids.size(); ++i) values_.put(base_.ids[i], i, out.frame);
        picture::Frame all = values_.witness();
        all.coloured_by = out.frame.coloured_by = changed_.coloured_by();
        all.whole_numbers = out.frame.whole_numbers = changed_.kind() == KeptValues::Kind::Whole;
        palette.include(all);
    }
    out.legend = palette.settle();
    palette.apply(out.frame);
    return out;
}

Thinned KeptFrame::thin(picture::Frame& frame) const {
    Thinned out{.covers = covers_};
    if (!balls_) return out;
    balls_->put(frame);
    out.covers.assign(balls_->covers().begin(), balls_->covers().end());
    out.coarse = balls_->coarse();
    return out;
}

}  // namespace meld::view
