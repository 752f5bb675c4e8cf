// Catoms at arbitrary positions, linked with those they touch.
//
// A module finds the neighbour over a port by a table of steps within bricks. Here a brick holds no cells but the links of 42 catoms, 12
// ports each: a catom's site is where its links begin, and the step over a port leads that many entries further.
#include <algorithm>

#include "runtime/base/assert.h"
#include "runtime/world/ensemble/ensemble.h"

namespace meld::world {
namespace {

constexpr std::uint32_t kPorts = kMaxPorts;
constexpr std::uint32_t kCatomsOfBrick = kBrickCells / kPorts;

// Brick 0 stays empty.
std::uint32_t site_of(Catom catom) { return (1 + catom / kCatomsOfBrick) * kBrickCells + catom % kCatomsOfBrick * kPorts; }

const std::vector<u16>& link_steps() {
    static const std::vector<u16> steps = [] {
        std::vector<u16> made(kPorts * kBrickCells);
        for (std::uint32_t port = 0; port < kPorts; ++port)
            for (std::uint32_t cell = 0; cell < kBrickCells; ++cell)
                made[port * kBrickCells + cell] = static_cast<u16>(kBrickCentre << kBrickCellBits | std::min(cell + port, kBrickCells - 1));
        return made;
    }();
    return steps;
}

}  // namespace

void Ensemble::set_free(std::function<bool(const Vec3&)> in_target, Ports ports) {
    MELD_EXPECT(index_count() == 0 && (ports == Ports::Twelve || links_), "{} catoms", index_count());
    free_links_ = true, any_ports_ = ports == Ports::Any;
    in_target_ = std::move(in_target);
    link_back_.assign(kBrickCells, 0);
}

void Ensemble::reserve_free(std::size_t catoms) {
    const std::size_t bricks = 1 + (catoms + kCatomsOfBrick - 1) / kCatomsOfBrick;
    site_.reserve(catoms), state_.reserve(catoms), positions_.reserve(catoms);
    link_back_.reserve(bricks * kBrickCells);
    cell_catom_.reserve(bricks * kBrickCells);
    target_.reserve(bricks * kBrickCells / 64);
    neighbours_.reserve(bricks * kBrickNeighbours);
}

void Ensemble::set_graph() {
    MELD_EXPECT(index_count() == 0 && links_, "{} catoms", index_count());
    free_links_ = graph_ = any_ports_ = true;
}

void Ensemble::reserve_nodes(std::size_t catoms, std::size_t ports) {
    site_.reserve(catoms), state_.reserve(catoms), positions_.reserve(catoms);
    links_->reserve(catoms, ports);
}

void Ensemble::add_free(Geometry& g) const {
    if (any_ports_) {
        g.ports = 0;
        return;
    }

    g.ports = kMaxPorts;
    g.step = link_steps().data();
    g.link_back = link_back_.data();
}

Catom Ensemble::add_at(std::uint64_t id, const Vec3& position, CatomState state) {
    MELD_EXPECT(state != kCatomFree);
    const Catom catom = take_index(id, 0, state);
    // A node has the first site of the empty brick, which is in no target.
    site_[catom] = graph_ ? 0 : site_of(catom);
    if (positions_.size() <= catom) positions_.resize(catom + std::size_t{1});
    positions_[catom] = position;
    if (graph_) return catom;
    const std::size_t bricks = (site_[catom] >> kBrickCellBits) + std::size_t{1};
    if (link_back_.size() < bricks * kBrickCells) {
        cell_catom_.resize(bricks * kBrickCells, kNobody);
        link_back_.resize(bricks * kBrickCells, 0);
        target_.resize(bricks * kBrickCells / 64, 0);
        neighbours_.resize(bricks * kBrickNeighbours, 0);
        neighbours_[(bricks - 1) * kBrickNeighbours + kBrickCentre] = static_cast<std::uint32_t>(bricks - 1);
    }
    place(catom, position);
    if (links_ && !any_ports_) links_->room(catom, kPorts);
    return catom;
}

bool Ensemble::place(Catom catom, const Vec3& position) {
    positions_[catom] = position;
    if (!in_target_) return false;
    const std::uint32_t site = site_[catom];
    const std::uint64_t bit = std::uint64_t{1} << (site & 63), before = target_[site >> 6];
    target_[site >> 6] = in_target_(position) ? before | bit : before & ~bit;
    return target_[site >> 6] != before;
}

void Ensemble::link(Catom a, int port_of_a, Catom b, int port_of_b) {
    if (any_ports_) {
        links_->room(a, static_cast<Port>(port_of_a) + 1), links_->room(b, static_cast<Port>(port_of_b) + 1);
        return links_->connect(a, static_cast<Port>(port_of_a), b, static_cast<Port>(port_of_b));
    }
    const std::uint32_t at_a = site_[a] + static_cast<std::uint32_t>(port_of_a), at_b = site_[b] + static_cast<std::uint32_t>(port_of_b);
    MELD_EXPECT(cell_catom_[at_a] == kNobody && cell_catom_[at_b] == kNobody, "link {} {}", a, b);
    cell_catom_[at_a] = static_cast<std::int32_t>(b);
    cell_catom_[at_b] = static_cast<std::int32_t>(a);
    link_back_[at_a] = static_cast<std::uint8_t>(port_of_b);
    link_back_[at_b] = static_cast<std::uint8_t>(port_of_a);
    if (links_) links_->connect(a, static_cast<Port>(port_of_a), b, static_cast<Port>(port_of_b));
}

void Ensemble::unlink(Catom catom, int port) {
    if (any_ports_) return links_->disconnect(catom, static_cast<Port>(port));
    const std::uint32_t here = site_[catom] + static_cast<std::uint32_t>(port);
    MELD_EXPECT(cell_catom_[here] != kNobody, "catom {} port {}", catom, port);
    cell_catom_[site_[static_cast<Catom>(cell_catom_[here])] + link_back_[here]] = kNobody;
    cell_catom_[here] = kNobody;
    if (links_) links_->disconnect(catom, static_cast<Port>(port));
}

std::optional<Catom> Ensemble::linked(Catom catom, int port) const {
    if (any_ports_) return static_cast<Port>(port) < links_->ports(catom) ? links_->at(catom, static_cast<Port>(port)) : std::nullopt;
    const std::int32_t other = cell_catom_[site_[catom] + static_cast<std::uint32_t>(port)];
    return other == kNobody ? std::nullopt : std::optional<Catom>(static_cast<Catom>(other));
}

std::optional<int> Ensemble::vacant_port(Catom catom) const {
    if (any_ports_) return links_->vacant(catom);
    for (int port = 0; port < kMaxPorts; ++port)
        if (!linked(catom, port)) return port;
    return std::nullopt;
}

std::optional<int> Ensemble::port_towards(Catom catom, Catom other) const {
    if (any_ports_) return links_->towards(catom, other);
    for (int port = 0; port < kMaxPorts; ++port)
        if (linked(catom, port) == other) return port;
    return std::nullopt;
}

void Ensemble::cut(Catom catom) {
    if (any_ports_) links_->clear(catom);
    if (graph_) return;
    for (int port = 0; port < kMaxPorts && !any_ports_; ++port)
        if (linked(catom, port)) unlink(catom, port);
    target_[site_[catom] >> 6] &= ~(std::uint64_t{1} << (site_[catom] & 63));
}

}  // namespace meld::world
