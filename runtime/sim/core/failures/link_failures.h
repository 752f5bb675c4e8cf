// Links that go and come back, by events of the world and by chance. Both ends sense it in the same tick.
//
// A link that was cut is missing in the table of links although its catoms touch, or the graph has it; nothing else is kept of it. So a
// catom that moves has links with all that it then touches.
#pragma once

#include <cstdint>
#include <functional>
#include <span>
#include <utility>
#include <vector>

#include "runtime/sim/core/subdomain.h"

namespace meld::sim {

class LinkFailures {
  public:
    explicit LinkFailures(Subdomain& subdomain) : subdomain_(subdomain) {}

    // What this tick's events and faults do. Every process calls it. Cost: nothing in a tick without; otherwise a look at each link, and in
    // a graph on several processes two exchanges for links that are made.
    void strike();

    // An end of a link, as regions see it.
    struct End {
        std::uint64_t id = 0;
        Cell cell = {};
        world::Vec3 position = {};
    };
    End end_of(Catom catom) const;
    End end_of_node(graph::Node node) const;
    // Whether a link is meant; the ends may be in any order.
    using Which = std::function<bool(const End&, const End&)>;
    void cut(const Which& which);
    // These links, by one of their ends.
    void cut(std::span<const std::pair<Catom, world::Port>> links);
    // Makes links that are missing. Every process calls it.
    void heal(const Which& which);
    // Makes links of nodes. Every process calls it.
    void join(const std::vector<std::pair<std::uint64_t, std::uint64_t>>& pairs);

  private:
    using Pair = std::pair<std::uint64_t, std::uint64_t>;
    void heal_cells(const Which& which);
    std::vector<Pair> missing_in_graph(const Which& which) const;
    // Nodes: `wanted` are links by their ends, the one of this process first; one that both ends want is made.
    void connect(std::vector<Pair> wanted);
    void note(Catom a, Catom b, std::uint64_t& count);
    Subdomain& subdomain_;
};

}  // namespace meld::sim
