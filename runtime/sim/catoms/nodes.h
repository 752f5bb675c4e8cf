// The nodes of a graph world: those of its graph, and after them those that rules have made since. All processes know all of them, also
// those that are gone.
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
    explicit Nodes(const graph::Graph& graph) : graph_(graph) {}

    std::uint64_t count() const { return graph_.nodes() + made_.size(); }
    std::uint64_t id(Node node) const { return is_made(node) ? made(node).id : graph_.id(node); }
    std::optional<Node> find(std::uint64_t id) const;
    const graph::Point& place(Node node) const { return is_made(node) ? made(node).place : graph_.places[node]; }
    // By the graph of the world; ascending.
    std::span<const Node> neighbours(Node node) const { return is_made(node) ? std::span<const Node>() : graph_.neighbours(node); }

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
    std::vector<Made> made_;                            // Ascending.
    std::unordered_map<Node, std::uint32_t> children_;  // By maker.
};

}  // namespace meld::sim
