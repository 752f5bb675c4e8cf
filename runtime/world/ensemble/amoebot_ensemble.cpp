// Catoms of one or two cells, whose ports follow compasses of their own (docs/amoebots.md).
//
// The map of cells names an amoebot at both of its cells, so whoever looks at a cell finds it as any other catom. Its place in the order of
// catoms, its owner and its ghosts follow from its head. Neighbours are listed in the table of links: they follow from two cells, and from
// compasses. Two amoebots touch at up to three pairs of ports, and have one link all the same: a link is what facts go over, and a fact
// that is sent to a neighbour arrives once.
#include <array>
#include <utility>

#include "runtime/base/assert.h"
#include "runtime/world/ensemble/ensemble.h"

namespace meld::world {

void Ensemble::set_amoebots(std::function<std::uint8_t(std::uint64_t id)> compass_of) {
    MELD_EXPECT(index_count() == 0 && links_ && lattice_.kind() == LatticeKind::Hex && compass_of, "{} catoms", index_count());
    compass_of_ = std::move(compass_of);
}

void Ensemble::add_tails(Catom end) {
    const std::size_t first = tail_.size();
    if (first >= end) return;
    tail_.resize(end);
    compass_.resize(end);
    class_.resize(end);
    for (std::size_t catom = first; catom < end; ++catom) set_amoebot(static_cast<Catom>(catom));
}

void Ensemble::set_amoebot(Catom catom) {
    tail_[catom] = site_[catom];
    compass_[catom] = compass_of_(ids_.of(catom));
    set_form(catom);
}

void Ensemble::set_form(Catom catom) {
    const Cell head = cell_at_site(site_[catom]);
    const auto rest = [](std::int32_t coordinate) {
        const std::int32_t left = coordinate % kApart;
        return left < 0 ? left + kApart : left;
    };
    class_[catom] = static_cast<std::uint8_t>(rest(head.y) * kApart + rest(head.x));
    const bool two = tail_[catom] != site_[catom];
    compass_[catom] = static_cast<std::uint8_t>(two ? compass_[catom] | kTwoCells : compass_[catom] & ~kTwoCells);
}

std::uint32_t Ensemble::site_near(Cell cell, std::uint32_t near) {
    const std::uint32_t slot = near >> kBrickCellBits;
    const std::int32_t* const origin = &origin_[std::size_t{slot} * 3];
    const auto bits = lattice_.brick_bits();
    const bool same = (cell.x - origin[0]) >> bits[0] == 0 && (cell.y - origin[1]) >> bits[1] == 0 && (cell.z - origin[2]) >> bits[2] == 0;
    return slot != 0 && same ? slot << kBrickCellBits | lattice_.number_in_brick(cell) : site(cell);
}

void Ensemble::surround_amoebot(Catom catom) {
    const Slot head = site_[catom] >> kBrickCellBits, tail = tail_[catom] >> kBrickCellBits;
    surround(head);
    if (tail != head) surround(tail);
}

void Ensemble::reshape(Catom catom, Cell head, Cell tail) {
    MELD_EXPECT(has_amoebots() && catom < index_count() && state_[catom] != kCatomFree, "catom {}", catom);
    MELD_EXPECT(Lattice::in_range(head) && Lattice::in_range(tail), "cell {} {}", head.x, head.y);
    unlink_around(catom);
    cell_catom_[site_[catom]] = cell_catom_[tail_[catom]] = kNobody;
    site_[catom] = site_near(head, site_[catom]);
    tail_[catom] = site_near(tail, site_[catom]);
    set_form(catom);
    for (const std::uint32_t each : {site_[catom], tail_[catom]}) {
        MELD_EXPECT(cell_catom_[each] == kNobody || cell_catom_[each] == static_cast<std::int32_t>(catom), "catom {} is there",
                    cell_catom_[each]);
        cell_catom_[each] = static_cast<std::int32_t>(catom);
    }
    link_amoebot(catom, 0);
}

void Ensemble::link_amoebot(Catom catom, Catom placed_until) {
    // Where it touches another one.
    struct Touch {
        Catom other;
        std::int32_t here, there;
    };
    std::array<Touch, 2 * kDirections> touches;
    std::size_t count = 0;
    links_->room(catom, 2 * kDirections);
    const bool two = expanded(catom);
    for (std::int32_t port = 0; port < (two ? 2 : 1) * kDirections; ++port) {
        const std::int32_t direction = lattice_direction(compass_[catom], port % kDirections);
        const std::uint32_t there = site_towards(port < kDirections ? site_[catom] : tail_[catom], direction);
        if (cell_catom_[there] == kNobody) continue;
        const auto other = static_cast<Catom>(cell_catom_[there]);
        if (other == catom || (other > catom && other < placed_until)) continue;
        const std::int32_t back = own_direction(compass_[other], lattice_.opposite(direction));
        const Touch touch{other, port, there == site_[other] ? back : kDirections + back};
        // The lowest port of the one with the smaller id decides; ports come ascending here.
        std::size_t same = 0;
        while (same < count && touches[same].other != other) ++same;
        if (same == count)
            touches[count++] = touch;
        else if (ids_.of(other) < ids_.of(catom) && touch.there < touches[same].there)
            touches[same] = touch;
    }
    for (std::size_t i = 0; i < count; ++i) {
        links_->room(touches[i].other, 2 * kDirections);
        links_->connect(catom, static_cast<Port>(touches[i].here), touches[i].other, static_cast<Port>(touches[i].there));
    }
}

}  // namespace meld::world
