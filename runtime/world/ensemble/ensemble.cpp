// Bricks are slots that are never removed; catoms are indices that are freed and reused, lowest first.
#include "runtime/world/ensemble/ensemble.h"

#include <algorithm>
#include <bit>
#include <numeric>
#include <utility>

#include "runtime/base/assert.h"
#include "runtime/world/ensemble/target.h"

namespace meld::world {
namespace {

// Bricks that a worker fills at once: some ten microseconds, and neighbours in memory.
constexpr std::size_t kBricksAtOnce = 32;

}  // namespace

Ensemble::Ensemble(const Lattice& lattice, std::function<bool(Cell)> in_target)
    : Ensemble(lattice,
               in_target ? FillTarget([lattice, in_target](Cell brick, std::span<std::uint64_t, 8> bits) {
                   for (std::uint32_t number = 0; number < kBrickCells; ++number) {
                       if (in_target(lattice.cell_in_brick(brick, number))) bits[number / 64] |= std::uint64_t{1} << number % 64;
                   }
               })
                         : FillTarget(),
               1) {}

Ensemble::Ensemble(const Lattice& lattice, const Target& target)
    : Ensemble(lattice, [&target](Cell brick, std::span<std::uint64_t, 8> bits) { target.fill(brick, bits); }, 1) {}

Ensemble::Ensemble(const Lattice& lattice, FillTarget fill_target, std::size_t sentinels)
    : lattice_(lattice),
      fill_target_(std::move(fill_target)),
      neighbours_(sentinels * kBrickNeighbours, 0),
      cell_catom_(sentinels * kBrickCells, kNobody),
      target_(sentinels * kBrickCells / 64, 0),
      origin_(sentinels * 3, 0),
      key_(sentinels, 0) {}

void Ensemble::keep_links(bool apart) {
    MELD_EXPECT(index_count() == 0, "{} catoms", index_count());
    links_.emplace(apart);
}

void Ensemble::link_around(Catom catom, Catom placed_until) {
    if (!links_) return;
    if (has_amoebots()) return link_amoebot(catom, placed_until);
    links_->room(catom, static_cast<Port>(lattice_.ports()));
    for (int port = 0; port < lattice_.ports(); ++port) {
        const std::int32_t there = cell_catom_[site_towards(site_[catom], port)];
        const auto other = static_cast<Catom>(there);
        if (there == kNobody || (other > catom && other < placed_until)) continue;
        links_->connect(catom, static_cast<Port>(port), other, static_cast<Port>(lattice_.opposite(port)));
    }
}

void Ensemble::unlink_around(Catom catom) {
    if (links_) links_->clear(catom);
}

Geometry Ensemble::geometry() const {
    Geometry g;
    g.ports = lattice_.ports();
    for (int port = 0; port < g.ports; ++port) g.opposite[port] = lattice_.opposite(port);
    g.step = lattice_.step_table().data();
    g.cell_catom = cell_catom_.data();
    g.brick_neighbours = neighbours_.data();
    g.brick_target = target_.data();
    g.brick_origin = origin_.data();
    std::copy(lattice_.brick_bits().begin(), lattice_.brick_bits().end(), g.cell_bits);
    g.catom_site = site_.data();
    ids_.add_to(g);
    g.catom_state = state_.data();
    g.catoms = static_cast<u32>(index_count());
    if (free_links_) add_free(g);
    if (has_amoebots()) g.catom_tail = tail_.data(), g.catom_compass = compass_.data();
    if (links_) links_->add_to(g);
    return g;
}

Slot Ensemble::slot(Cell brick) {
    const std::uint64_t key = packed(brick);
    if (last_slot_ != 0 && key == last_key_) return last_slot_;
    const Slot known = slots_.find(key);
    last_slot_ = known != 0 ? known : make_slot(brick);
    last_key_ = key;
    return last_slot_;
}

std::optional<Slot> Ensemble::find_slot(Cell brick) const {
    if (!lattice_.brick_in_range(brick)) return std::nullopt;
    const Slot known = slots_.find(packed(brick));
    return known != 0 ? std::optional<Slot>(known) : std::nullopt;
}

Cell Ensemble::brick(Slot slot) const {
    MELD_EXPECT(slot > 0 && slot <= brick_count(), "slot {}", slot);
    const std::size_t at = std::size_t{slot} * 3;
    return lattice_.brick_of({origin_[at], origin_[at + 1], origin_[at + 2]});
}

std::size_t Ensemble::brick_count() const { return origin_.size() / 3 - 1; }

void Ensemble::surround(Slot slot) {
    const Cell centre = brick(slot);
    // A flat world has one layer of bricks, the middle one of three.
    constexpr u32 kLayer = kBrickNeighbours / 3;
    const u32 first = lattice_.flat() ? kLayer : 0, end = lattice_.flat() ? 2 * kLayer : kBrickNeighbours;
    for (u32 n = first; n < end; ++n) {
        if (neighbours_[std::size_t{slot} * kBrickNeighbours + n] != 0) continue;
        const Cell there = centre + Lattice::brick_offset(n);
        if (lattice_.brick_in_range(there)) make_slot(there);
    }
}

Slot Ensemble::make_slot(Cell brick) {
    MELD_CHECK(lattice_.brick_in_range(brick), "brick {} {} {}", brick.x, brick.y, brick.z);
    const std::size_t made = brick_count() + 1;
    // A site has 32 bits, 9 of them for the cell.
    MELD_CHECK(made < std::size_t{1} << (32 - kBrickCellBits), "{} bricks", made);
    const Slot slot = static_cast<Slot>(made);
    neighbours_.resize((made + 1) * kBrickNeighbours, 0);
    cell_catom_.resize((made + 1) * kBrickCells, kNobody);
    target_.resize((made + 1) * kBrickCells / 64, 0);
    const Cell origin = lattice_.brick_origin(brick);
    origin_.insert(origin_.end(), {origin.x, origin.y, origin.z});
    key_.push_back(lattice_.brick_key(brick));
    slots_.insert(packed(brick), slot);
    for (u32 n = 0; n < kBrickNeighbours; ++n) {
        const std::optional<Slot> other = find_slot(brick + Lattice::brick_offset(n));
        if (!other) continue;
        neighbours_[made * kBrickNeighbours + n] = *other;
        neighbours_[std::size_t{*other} * kBrickNeighbours + (kBrickNeighbours - 1 - n)] = slot;
    }
    if (fill_target_) fill_target_(brick, std::span<std::uint64_t, 8>(target_.data() + made * 8, 8));
    return slot;
}

void Ensemble::add_slots(std::span<const std::pair<BrickKey, std::uint32_t>> bricks, Workers& workers) {
    MELD_EXPECT(brick_count() == 0, "{} bricks", brick_count());
    const std::size_t slots = bricks.size() + 1;
    MELD_CHECK(slots <= std::size_t{1} << (32 - kBrickCellBits), "{} bricks", bricks.size());
    neighbours_.resize(slots * kBrickNeighbours);
    cell_catom_.resize(slots * kBrickCells);
    target_.resize(slots * kBrickCells / 64);
    origin_.resize(slots * 3);
    key_.resize(slots);
    workers.run((bricks.size() + kBricksAtOnce - 1) / kBricksAtOnce, [&](int, std::size_t part) {
        for (std::size_t i = part * kBricksAtOnce; i < std::min(bricks.size(), (part + 1) * kBricksAtOnce); ++i) {
            const Cell origin = lattice_.brick_origin(lattice_.brick_at(bricks[i].first));
            key_[i + 1] = bricks[i].first;
            std::copy_n(std::array{origin.x, origin.y, origin.z}.begin(), 3, &origin_[(i + 1) * 3]);
        }
    });
    for (Slot slot = 1; slot < slots; ++slot) slots_.insert(packed(brick(slot)), slot);
}

void Ensemble::fill_brick(Slot slot, Catom first, std::uint32_t count, const FillCells& fill, CatomState state) {
    const Cell here = brick(slot);
    for (u32 n = 0; n < kBrickNeighbours; ++n)
        neighbours_[std::size_t{slot} * kBrickNeighbours + n] = find_slot(here + Lattice::brick_offset(n)).value_or(0);
    const std::span<std::uint64_t, 8> target(&target_[std::size_t{slot} * 8], 8);
    std::ranges::fill(target, 0);
    if (fill_target_) fill_target_(here, target);
    std::array<std::uint64_t, 8> cells{};
    fill(here, cells);
    u32 filled = 0;
    for (const std::uint64_t word : cells) filled += static_cast<u32>(std::popcount(word));
    MELD_CHECK(filled == count, "a brick of {} catoms, and {} were counted", filled, count);
    std::fill_n(&state_[first], count, static_cast<std::uint8_t>(state));
    const std::uint32_t site = slot << kBrickCellBits;
    for (std::uint32_t word = 0; word < cells.size(); ++word) {
        std::int32_t* const at = &cell_catom_[site + word * 64];
        // Most bricks are full.
        if (cells[word] == ~std::uint64_t{0}) {
            std::iota(at, at + 64, static_cast<std::int32_t>(first));
            std::iota(&site_[first], &site_[first] + 64, site + word * 64);
            first += 64;
            continue;
        }
        std::fill_n(at, 64, kNobody);
        for (std::uint64_t left = cells[word]; left != 0; left &= left - 1) {
            const auto number = static_cast<std::uint32_t>(std::countr_zero(left));
            at[number] = static_cast<std::int32_t>(first);
            site_[first++] = site + word * 64 + number;
        }
    }
}

void Ensemble::add_bricks(std::span<const std::pair<BrickKey, std::uint32_t>> bricks, std::uint64_t first_id, const FillCells& fill,
                          CatomState state, Workers& workers) {
    MELD_EXPECT(index_count() == 0 && state != kCatomFree, "{} catoms", index_count());
    if (bricks.empty()) return;
    std::vector<Catom> firsts;
    firsts.reserve(bricks.size());
    std::size_t all = 0;
    for (const auto& [key, catoms] : bricks) {
        firsts.push_back(static_cast<Catom>(all));
        all += catoms;
    }
    // An index is positive in the map of cells.
    MELD_CHECK(all < std::size_t{1} << 31, "{} catoms", all);
    const auto total = static_cast<std::uint32_t>(all);
    add_slots(bricks, workers);
    site_.resize(total);
    state_.resize(total);
    ids_.add_run(first_id, total);
    workers.run((bricks.size() + kBricksAtOnce - 1) / kBricksAtOnce, [&](int, std::size_t part) {
        for (std::size_t i = part * kBricksAtOnce; i < std::min(bricks.size(), (part + 1) * kBricksAtOnce); ++i)
            fill_brick(static_cast<Slot>(i + 1), firsts[i], bricks[i].second, fill, state);
    });
    if (has_amoebots()) add_tails(total);
    // Where links take time, some more indices come soon.
    if (links_) links_->reserve(total + total / 8, std::size_t{total} * static_cast<std::size_t>(lattice_.ports()));
    for (Catom catom = 0; links_ && catom < total; ++catom) link_around(catom, total);
    count(state, total);
}

std::uint32_t Ensemble::site(Cell cell) { return slot(lattice_.brick_of(cell)) << kBrickCellBits | lattice_.number_in_brick(cell); }

Catom Ensemble::add(std::uint64_t id, Cell cell, CatomState state) {
    MELD_EXPECT(state != kCatomFree);
    MELD_EXPECT(Lattice::in_range(cell), "cell {} {} {}", cell.x, cell.y, cell.z);
    const std::uint32_t here = site(cell);
    MELD_EXPECT(cell_catom_[here] == kNobody, "catom {} stands on {} {} {}", cell_catom_[here], cell.x, cell.y, cell.z);
    const Catom catom = take_index(id, here, state);
    cell_catom_[here] = static_cast<std::int32_t>(catom);
    link_around(catom);
    return catom;
}

bool Ensemble::empty(Slot slot, std::uint32_t first_number, std::uint32_t count) const {
    MELD_EXPECT(slot <= brick_count() && first_number + count <= kBrickCells, "{} cells from {} on", count, first_number);
    const auto first = cell_catom_.begin() + static_cast<std::ptrdiff_t>(std::size_t{slot} << kBrickCellBits | first_number);
    return std::all_of(first, first + count, [](std::int32_t catom) { return catom == kNobody; });
}

Catom Ensemble::add_run(std::uint64_t first_id, Slot slot, std::uint32_t first_number, std::uint32_t count, CatomState state) {
    MELD_EXPECT(free_.empty() && !free_links_ && empty(slot, first_number, count), "slot {}", slot);
    const auto first = static_cast<Catom>(index_count());
    const std::uint32_t site = slot << kBrickCellBits | first_number;
    ids_.add_run(first_id, count);
    site_.resize(first + count);
    state_.resize(first + count, static_cast<std::uint8_t>(state));
    for (std::uint32_t i = 0; i < count; ++i) {
        site_[first + i] = site + i;
        cell_catom_[site + i] = static_cast<std::int32_t>(first + i);
    }
    if (has_amoebots()) add_tails(first + count);
    for (Catom catom = first; links_ && catom < first + count; ++catom) link_around(catom, first + count);
    this->count(state, count);
    for (Catom catom = first; ids_.table_made() && catom < first + count; ++catom) ids_.enter(catom);
    return first;
}

// For one more, without doubling what is large: after the set-up, only some catoms and mailboxes come.
template <class Array>
static void make_room(Array& all) {
    constexpr std::size_t kLeast = 64, kShare = 8;
    if (all.size() == all.capacity()) all.reserve(all.size() + all.size() / kShare + kLeast);
}

Catom Ensemble::take_index(std::uint64_t id, std::uint32_t site, CatomState state) {
    Catom catom = static_cast<Catom>(index_count());
    if (free_.empty()) {
        ids_.add(id);
        make_room(site_), make_room(state_);
        site_.push_back(site);
        state_.push_back(state);
    } else {
        std::pop_heap(free_.begin(), free_.end(), std::greater<>());
        catom = free_.back();
        free_.pop_back();
        ids_.replace(catom, id);
        site_[catom] = site;
        state_[catom] = state;
    }
    count(state, 1);
    if (has_amoebots()) add_tails(catom + 1), set_amoebot(catom);
    if (links_) links_->room(catom, 0);
    if (state != kCatomMailbox) ids_.enter(catom);
    return catom;
}

void Ensemble::remove(Catom catom) {
    MELD_EXPECT(catom < index_count() && state_[catom] != kCatomFree, "catom {}", catom);
    ids_.leave(catom);
    count(state_[catom], static_cast<std::size_t>(-1));
    if (free_links_)
        cut(catom);
    else
        unlink_around(catom), cell_catom_[site_[catom]] = kNobody;
    if (has_amoebots()) {
        cell_catom_[tail_[catom]] = kNobody;
        tail_[catom] = 0;
        compass_[catom] &= static_cast<std::uint8_t>(~kTwoCells);
        class_[catom] = kNoClass;
    }
    site_[catom] = 0;
    free_index(catom);
}

void Ensemble::move(Catom catom, Cell to) {
    MELD_EXPECT(catom < index_count() && state_[catom] != kCatomFree, "catom {}", catom);
    MELD_EXPECT(Lattice::in_range(to), "cell {} {} {}", to.x, to.y, to.z);
    if (has_amoebots()) return reshape(catom, to, to);
    const std::uint32_t there = site(to);
    MELD_EXPECT(cell_catom_[there] == kNobody, "catom {} stands on {} {} {}", cell_catom_[there], to.x, to.y, to.z);
    unlink_around(catom);
    cell_catom_[site_[catom]] = kNobody;
    cell_catom_[there] = static_cast<std::int32_t>(catom);
    site_[catom] = there;
    link_around(catom);
}

void Ensemble::set_state(Catom catom, CatomState state) {
    MELD_EXPECT(catom < index_count() && state_[catom] != kCatomFree && state != kCatomFree, "catom {}", catom);
    count(state_[catom], static_cast<std::size_t>(-1));
    count(state, 1);
    state_[catom] = state;
}

Catom Ensemble::add_mailbox(Catom of) { return take_index(id(of), of, kCatomMailbox); }

void Ensemble::use_mailbox(Catom mailbox, Catom of) {
    MELD_EXPECT(state_[mailbox] == kCatomMailbox, "index {}", mailbox);
    site_[mailbox] = of;
    ids_.replace(mailbox, id(of));
}

void Ensemble::free_index(Catom index) {
    state_[index] = kCatomFree;
    free_.push_back(index);
    std::push_heap(free_.begin(), free_.end(), std::greater<>());
}

// `by` is 1 or, wrapped around, -1.
void Ensemble::count(std::uint8_t state, std::size_t by) {
    if (state != kCatomMailbox) (state == kCatomOwned ? owned_count_ : ghost_count_) += by;
}

CellKey Ensemble::key(Cell cell) const {
    const std::optional<Slot> slot = find_slot(lattice_.brick_of(cell));
    return slot ? key_[*slot] << kBrickCellBits | lattice_.number_in_brick(cell) : lattice_.key(cell);
}

std::optional<Catom> Ensemble::at(Cell cell) const {
    const std::optional<Slot> slot = find_slot(lattice_.brick_of(cell));
    if (!slot) return std::nullopt;
    const std::int32_t catom = cell_catom_[std::size_t{*slot} << kBrickCellBits | lattice_.number_in_brick(cell)];
    return catom == kNobody ? std::nullopt : std::optional<Catom>(static_cast<Catom>(catom));
}

Cell Ensemble::cell(Catom catom) const {
    MELD_EXPECT(catom < index_count() && state_[catom] != kCatomFree, "catom {}", catom);
    return cell_at_site(site_[catom]);
}

Cell Ensemble::cell_at_site(std::uint32_t site) const {
    const std::size_t at = std::size_t{site >> kBrickCellBits} * 3;
    return Cell{origin_[at], origin_[at + 1], origin_[at + 2]} + lattice_.cell_in_brick({}, site & (kBrickCells - 1));
}

bool Ensemble::target(Cell cell) const {
    const std::optional<Slot> slot = find_slot(lattice_.brick_of(cell));
    if (!slot) return false;
    const std::uint32_t number = lattice_.number_in_brick(cell);
    return target_[std::size_t{*slot} * 8 + number / 64] >> number % 64 & 1;
}

std::optional<Catom> Ensemble::find(std::uint64_t id) const {
    if (const std::optional<Catom> catom = ids_.index_in_order(id); catom && is_catom(*catom)) return catom;
    if (!ids_.table_made()) ids_.make_table([&](Catom catom) { return is_catom(catom); });
    return ids_.find(id);
}

void Ensemble::reserve(std::size_t catoms, std::size_t bricks) {
    site_.reserve(catoms);
    state_.reserve(catoms);
    neighbours_.reserve((bricks + 1) * kBrickNeighbours);
    cell_catom_.reserve((bricks + 1) * kBrickCells);
    target_.reserve((bricks + 1) * kBrickCells / 64);
    origin_.reserve((bricks + 1) * 3);
    key_.reserve(bricks + 1);
    slots_.reserve(bricks);
}

std::size_t Ensemble::bytes() const {
    const auto size = [](const auto& column) { return column.capacity() * sizeof(column[0]); };
    return ids_.bytes() + size(site_) + size(state_) + size(free_) + size(neighbours_) + size(cell_catom_) + size(target_) + size(origin_) +
           size(key_) + slots_.bytes() + size(positions_) + size(link_back_) + size(tail_) + size(compass_) + size(class_) +
           (links_ ? links_->bytes() : 0);
}

std::size_t Ensemble::bytes_for(std::size_t catoms, std::size_t bricks, std::size_t room) {
    constexpr std::size_t kCatom = sizeof(site_[0]) + sizeof(state_[0]);
    constexpr std::size_t kBrick = kBrickNeighbours * sizeof(neighbours_[0]) + kBrickCells * sizeof(cell_catom_[0]) +
                                   kBrickCells / 64 * sizeof(target_[0]) + 3 * sizeof(origin_[0]) + sizeof(key_[0]);
    // Arrays of bricks double; while they do, the old ones are there too.
    std::size_t copied = 0;
    for (std::size_t most = room + 1; most < bricks + 1; most *= 2) copied = most;
    return catoms * kCatom + std::max(bricks + 1, 2 * copied) * kBrick + BrickTable::bytes_for(std::max(room, bricks));
}

}  // namespace meld::world
