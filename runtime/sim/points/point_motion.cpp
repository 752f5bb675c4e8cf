#include "runtime/sim/points/point_motion.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "runtime/base/assert.h"
#include "runtime/base/bytes.h"
#include "runtime/comm/transport/collective_result.h"
#include "runtime/engine/tuple/values.h"
#include "runtime/sim/core/failures/catom_failures.h"
#include "runtime/sim/core/failures/link_failures.h"

namespace meld::sim {

using graph::Node;
using world::Port;

namespace {

// No rounding may leave a node out.
constexpr double kSomeMore = 1.0001;

world::Vec3 vector_of(const Subdomain& subdomain, const eval::Action& action) {
    const Value* v = action.arguments;
    if (subdomain.module.predicates[action.predicate].arity == 3) return {v[0].real, v[1].real, v[2].real};
    const List* list = v[0].list;
    return {tuple::item(list, 0).real, tuple::item(list, 1).real, tuple::item(list, 2).real};
}

// Not longer than a node may go in a tick.
world::Vec3 shortened(const world::Vec3& way, double most) {
    const double square = graph::square_distance({}, way);
    if (!(square > most * most)) return way;
    const double share = most / std::sqrt(square);
    return {way[0] * share, way[1] * share, way[2] * share};
}

bool is_lonely(const Subdomain& subdomain, Catom catom) {
    bool linked = false;
    subdomain.each_neighbour(catom, [&](Catom) { linked = true; });
    return !linked && subdomain.ensemble.state(catom) == kCatomGhost;
}

}  // namespace

bool PointMotion::finds_links(const Subdomain& subdomain) const { return world_.has_moving_nodes() || subdomain.module.makes_nodes; }

void PointMotion::make_grid(const Subdomain& subdomain) {
    if (!finds_links(subdomain)) return;
    const Nodes& nodes = subdomain.nodes();
    grid_.emplace(world_.links->range);
    places_.clear();
    for (Node node = 0; node < nodes.count(); ++node) {
        places_.push_back(nodes.place(node));
        grid_->add(node, places_.back());
    }
    if (!world_.links->sight) return;
    sight_.emplace(*world_.links);
    for (Node node = 0; node < nodes.count(); ++node) sight_->set(node, places_[node]);
}

// Those that were killed before: no process has them.
void PointMotion::forget_dead(Subdomain& subdomain) {
    if (!sight_) return;
    ByteWriter mine;
    for (Catom c = 0; c < subdomain.ensemble.index_count(); ++c)
        if (subdomain.owned(c)) mine.write(*subdomain.nodes().find(subdomain.ensemble.id(c)));
    std::vector<bool> alive(places_.size());
    const auto note = [&](std::span<const std::byte> nodes) {
        for (ByteReader in(nodes, "nodes that there are"); !in.done();) alive[in.read<Node>()] = true;
    };
    if (subdomain.alone())
        note(mine.view());
    else
        for (const auto& theirs : subdomain.comm.allgather_any(mine.view())) note(theirs);
    for (Node node = 0; node < places_.size(); ++node)
        if (!alive[node]) sight_->remove(node);
}

Result<void> PointMotion::start(Subdomain& subdomain) {
    make_grid(subdomain);
    senses_.start(subdomain);
    subdomain.refresh();
    senses_.sense(subdomain);
    links_seen_ = subdomain.ensemble.links().version();
    return {};
}

Result<void> PointMotion::resume(Subdomain& subdomain) {
    senses_.start(subdomain);
    return {};
}

Result<void> PointMotion::resumed(Subdomain& subdomain) {
    make_grid(subdomain);
    forget_dead(subdomain);
    links_seen_ = subdomain.ensemble.links().version();
    return {};
}

Result<void> PointMotion::step(Subdomain& subdomain) {
    using Performer = ActionInfo::Performer;
    refuse_those_of_other_worlds(subdomain, world_.has_moving_nodes() ? Performer::Points : Performer::None);
    if (!grid_) return {};
    drop_lonely(subdomain);
    std::vector<Moved> moved;
    if (world_.has_moving_nodes() && subdomain.totals.actions > 0) {
        Result<std::vector<Moved>> all = of_all(subdomain, wanted(subdomain));
        if (!all) return tl::unexpected<Error>(all.error());
        moved = std::move(*all);
        move(subdomain, moved);
    }
    add_new_nodes(subdomain, moved);
    if (moved.empty()) return {};
    add_disturbed(subdomain, moved);
    relink(subdomain, moved);
    senses_.sense(subdomain);
    links_seen_ = subdomain.ensemble.links().version();
    return {};
}

Result<std::vector<PointMotion::Moved>> PointMotion::wanted(Subdomain& subdomain) const {
    std::vector<Moved> moved;
    std::vector<std::pair<Catom, world::Vec3>> ways;
    // They come in the order of the catoms' numbers, and of one catom in that of their arguments.
    for (const eval::Action& action : subdomain.actions()) {
        if (info(subdomain.kind_of(action)).performer != ActionInfo::Performer::Points) continue;
        if (ways.empty() || ways.back().first != action.catom) ways.emplace_back(action.catom, world::Vec3{});
        const world::Vec3 way = vector_of(subdomain, action);
        for (std::size_t i = 0; i < 3; ++i) ways.back().second[i] += way[i];
    }
    for (const auto& [catom, sum] : ways) {
        const world::Vec3 way = shortened(sum, world_.motion.speed), from = subdomain.ensemble.position(catom);
        const world::Vec3 to = {from[0] + way[0], from[1] + way[1], from[2] + way[2]};
        if (!std::ranges::all_of(to, [](double x) { return std::isfinite(x); }))
            return fail(fmt::format("in tick {}, @{} is to move by ({:.6g}, {:.6g}, {:.6g}), which leads nowhere", subdomain.tick(),
                                    subdomain.ensemble.id(catom), sum[0], sum[1], sum[2]),
                        "Let the program compute a finite way", ExitCode::ProgramWrong);
        if (to != from) moved.push_back({*subdomain.nodes().find(subdomain.ensemble.id(catom)), to});
    }
    return moved;
}

Result<std::vector<PointMotion::Moved>> PointMotion::of_all(Subdomain& subdomain, const Result<std::vector<Moved>>& mine) {
    if (subdomain.alone()) return mine;
    const Result<void> fine = mine ? Result<void>{} : tl::unexpected<Error>(mine.error());
    if (auto all = comm::outcome_of_all(subdomain.comm, fine); !all) return tl::unexpected<Error>(all.error());
    ByteWriter bytes;
    for (const Moved& one : *mine) bytes.write(one);
    std::vector<Moved> moved;
    for (const auto& theirs : subdomain.comm.allgather_any(bytes.view()))
        for (ByteReader in(theirs, "nodes that move"); !in.done();) moved.push_back(in.read<Moved>());
    std::ranges::sort(moved, {}, &Moved::node);
    return moved;
}

void PointMotion::move(Subdomain& subdomain, const std::vector<Moved>& moved) {
    for (const Moved& one : moved) {
        grid_->move(one.node, places_[one.node], one.to);
        if (sight_) {
            disturbed_.insert(disturbed_.end(), {places_[one.node], one.to});
            sight_->set(one.node, one.to);
        }
        places_[one.node] = one.to;
        subdomain.move_node(one.node, one.to);
        const std::optional<Catom> catom = subdomain.ensemble.find(subdomain.nodes().id(one.node));
        if (catom && subdomain.owned(*catom)) subdomain.mark(*catom, kDirtyPlace);
    }
    if (!moved.empty()) subdomain.note_change();
}

void PointMotion::add_new_nodes(const Subdomain& subdomain, std::vector<Moved>& moved) {
    for (auto node = static_cast<Node>(places_.size()); node < subdomain.nodes().count(); ++node) {
        places_.push_back(subdomain.nodes().place(node));
        grid_->add(node, places_.back());
        if (sight_) {
            disturbed_.push_back(places_.back());
            sight_->set(node, places_.back());
        }
        moved.push_back({node, places_.back()});
    }
}

// What is on the line between two nodes is not farther from the nearer one than half the range.
void PointMotion::add_disturbed(const Subdomain& subdomain, std::vector<Moved>& moved) {
    if (!sight_) return;
    const double reach = (world_.links->range + world_.links->thickness) / 2 * kSomeMore;
    std::vector<bool> known(subdomain.nodes().count());
    for (const Moved& one : moved) known[one.node] = true;
    const auto add = [&](Node node) {
        if (known[node]) return;
        known[node] = true;
        moved.push_back({node, places_[node]});
    };
    if (reach > world_.links->range) {
        // Thick nodes with a short range: the grid finds only what is in range.
        for (Node node = 0; !disturbed_.empty() && node < places_.size(); ++node) add(node);
    } else {
        for (const graph::Point& at : disturbed_)
            grid_->each_near(at, places_, [&](Node node) {
                if (graph::square_distance(at, places_[node]) <= reach * reach) add(node);
            });
    }
    disturbed_.clear();
    std::ranges::sort(moved, {}, &Moved::node);
}

void PointMotion::relink(Subdomain& subdomain, const std::vector<Moved>& moved) {
    const Nodes& nodes = subdomain.nodes();
    const world::Ensemble& ensemble = subdomain.ensemble;
    const double range = world_.links->range;
    std::vector<std::pair<Catom, Port>> too_long;
    std::vector<std::pair<std::uint64_t, std::uint64_t>> near;
    // Each link once, also if both ends have moved.
    std::vector<bool> has_moved(nodes.count());
    for (const Moved& one : moved) has_moved[one.node] = true;
    for (const Moved& one : moved) {
        const std::optional<Catom> here = ensemble.find(nodes.id(one.node));
        const auto each_once = [&](Node other) { return !has_moved[other] || one.node < other; };
        if (here)
            ensemble.links().each(*here, [&](Port port, Catom other) {
                const Node there = *nodes.find(ensemble.id(other));
                if (!each_once(there)) return;
                if (graph::square_distance(one.to, places_[there]) > range * range || !sees(one.node, there))
                    too_long.emplace_back(*here, port);
            });
        const bool ours = here && subdomain.owned(*here);
        grid_->each_within(one.node, places_, [&](Node other) {
            if (!each_once(other)) return;
            if (sight_ && here && ensemble.find(nodes.id(other)) && ensemble.links().towards(*here, *ensemble.find(nodes.id(other))))
                return;
            const std::optional<Catom> there = ours ? std::nullopt : ensemble.find(nodes.id(other));
            if ((ours || (there && subdomain.owned(*there))) && sees(one.node, other))
                near.emplace_back(nodes.id(one.node), nodes.id(other));
        });
    }
    for (const auto& [catom, port] : too_long) lonely_.insert(lonely_.end(), {catom, *ensemble.links().at(catom, port)});
    LinkFailures links(subdomain);
    if (!too_long.empty()) links.cut(too_long);
    links.join(near);
}

void PointMotion::drop_lonely(Subdomain& subdomain) {
    if (lonely_.empty()) return;
    std::ranges::sort(lonely_);
    const auto [end, last] = std::ranges::unique(lonely_);
    lonely_.erase(end, last);
    std::erase_if(lonely_, [&](Catom catom) { return !is_lonely(subdomain, catom); });
    for (const Catom catom : lonely_) subdomain.remove_freely(catom);
    if (!lonely_.empty()) subdomain.refresh();
    lonely_.clear();
}

// What was behind them can be seen now; the links of others are made in struck(), when they are gone.
Result<void> PointMotion::lose(Subdomain& subdomain, std::span<const Killed> killed) {
    if (!sight_) return {};
    for (const Killed& one : killed)
        if (const std::optional<Node> node = subdomain.nodes().find(one.id)) {
            sight_->remove(*node);
            disturbed_.push_back(places_[*node]);
        }
    return {};
}

// Links that events have cut, joined or taken with their catoms.
void PointMotion::struck(Subdomain& subdomain) {
    if (!disturbed_.empty()) {
        std::vector<Moved> freed;
        add_disturbed(subdomain, freed);
        relink(subdomain, freed);
    }
    const std::uint64_t now = subdomain.ensemble.links().version();
    if (std::exchange(links_seen_, now) != now) senses_.sense(subdomain);
}

void PointMotion::restarted(Subdomain& subdomain, std::span<const std::uint32_t> catoms) { senses_.sense(subdomain, catoms); }

}  // namespace meld::sim
