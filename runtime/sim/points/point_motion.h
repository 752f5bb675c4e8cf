// Nodes of a graph with [links] range: they move if the world says [motion] kind = "points", and nodes within the range of each other are
// linked. Links of nodes that do not move are those of the graph.
//
// Every process knows the places of all nodes and finds the links of its own. A node stays on its process wherever it goes.
#pragma once

#include <optional>
#include <vector>

#include "runtime/sim/core/extension.h"
#include "runtime/sim/core/subdomain.h"
#include "runtime/sim/points/range_senses.h"
#include "runtime/world/description/point_sight.h"
#include "runtime/world/graph/range.h"

namespace meld::sim {

class PointMotion : public SimModule {
  public:
    explicit PointMotion(const world::World& world) : world_(world), senses_(*world.links) {}
    Result<void> start(Subdomain& subdomain) override;
    // Carries out the actions of the last tick and makes and removes links. Errors: a way that is not finite.
    Result<void> step(Subdomain& subdomain) override;
    Result<void> lose(Subdomain& subdomain, std::span<const Killed> killed) override;
    void struck(Subdomain& subdomain) override;
    void restarted(Subdomain& subdomain, std::span<const std::uint32_t> catoms) override;
    // A snapshot has the places and links of nodes.
    Result<void> saveable() const override { return {}; }
    Result<void> resume(Subdomain& subdomain) override;
    Result<void> resumed(Subdomain& subdomain) override;

  private:
    struct Moved {
        graph::Node node = 0;
        world::Vec3 to = {};
    };
    // The nodes of this process that move, by its actions; then those of all processes.
    Result<std::vector<Moved>> wanted(Subdomain& subdomain) const;
    static Result<std::vector<Moved>> of_all(Subdomain& subdomain, const Result<std::vector<Moved>>& mine);
    void move(Subdomain& subdomain, const std::vector<Moved>& moved);
    // Where nodes must see each other: adds those whose links may have been blocked or freed by one that has moved, came or went.
    void add_disturbed(const Subdomain& subdomain, std::vector<Moved>& moved);
    bool sees(graph::Node one, graph::Node other) const { return !sight_ || sight_->sees(one, other); }
    // Removes links that have become too long or blocked, and makes those of nodes that have come into range.
    void relink(Subdomain& subdomain, const std::vector<Moved>& moved);
    // Where nodes come and go, or move: otherwise the links are those of the graph.
    bool finds_links(const Subdomain& subdomain) const;
    void make_grid(const Subdomain& subdomain);
    void forget_dead(Subdomain& subdomain);
    // Those that rules have made are linked as if they had moved.
    void add_new_nodes(const Subdomain& subdomain, std::vector<Moved>& moved);
    // Ghosts that have lost their last link go in the tick after, when nobody speaks of them any more.
    void drop_lonely(Subdomain& subdomain);

    const world::World& world_;
    RangeSenses senses_;
    // Of all nodes, by their places in `places_`.
    std::optional<graph::PointGrid> grid_;
    std::vector<graph::Point> places_;
    // If nodes must see each other; without those that are gone.
    std::optional<world::PointSight> sight_;
    std::vector<graph::Point> disturbed_;  // In this tick: where something that may be in the way was, or is now.
    std::vector<Catom> lonely_;
    std::uint64_t links_seen_ = 0;  // Links::version() when catoms last sensed their neighbours.
};

}  // namespace meld::sim
