// The nodes of a graph world: those of its graph, and after them those that rules have made since. All processes know all of them, also
// those that are gone, and where they are.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <unordered_map>
#include <vector>

#include "runtime/world/graph/graph.h"

namespace meld::sim {

class Nodes {
  public:
    using Node = graph::Node;
    // moving: nodes have places of their own, and links only as these give them.
    explicit Nodes(const graph::Graph& graph, bool moving = false) : graph_(graph), moving_(moving) {
        if (moving) places_ = graph.places;
    }

    std::uint64_t count() const { return graph_.nodes() + made_.size(); }
    std::uint64_t id(Node node) const { return is_made(node) ? made(node).id : graph_.id(node); }
    std::optional<Node> find(std::uint64_t id) const;
    const graph::Point& place(Node node) const { return is_made(node) ? made(node).place : moving_ ? places_[node] : graph_.places[node]; }
    // By the graph of the world; ascending. None, where they move.
    std::span<const Node> neighbours(Node node) const {
        return is_made(node) || moving_ ? std::span<const Node>() : graph_.neighbours(node);
    }
    // Only where they move; on all processes.
    void move(Node node, const graph::Point& to) { (is_made(node) ? made_[node - graph_.nodes()].place : places_[node]) = to; }

    struct Made {
        std::uint64_t id = 0;
        Node maker = 0;
        graph::Point place = {};
    };
    const std::vector<Made>& made() const { return made_; }
    // One with this number, which is above those of all others. It is placed near its maker: the k-th one on a spiral around it.
    void add(std::uint64_t id, Node maker);
    // The process on which it lives.
    static int owner(std::uint64_t id, int processes) { return static_cast<int>(id % static_cast<std::uint64_t>(processes)); }

    std::size_t bytes() const;

  private:
    bool is_made(Node node) const { return node >= graph_.nodes(); }
    const Made& made(Node node) const { return made_[node - graph_.nodes()]; }

    const graph::Graph& graph_;
    const bool moving_;
    std::vector<graph::Point> places_;                  // By node of the graph, if they move.
    std::vector<Made> made_;                            // Ascending.
    std::unordered_map<Node, std::uint32_t> children_;  // By maker.
};

}  // namespace meld::sim
