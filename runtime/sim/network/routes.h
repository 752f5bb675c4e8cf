// Ways through a graph, for linear facts to nodes that are known only by their numbers.
//
// Every process knows which nodes there are, who owns them, and the links between them, as of the end of the last tick: the graph of the
// world, and the neighbours of those nodes that have others now. What has changed is part of what processes say to each other at the end of
// a tick. A way is found hop by hop: from a node to that of its present neighbours that was nearest to the target then. So it is a shortest
// one as long as links stay, and whatever the number of processes, all of them find the same.
#pragma once

#include <cstdint>
#include <mutex>
#include <optional>
#include <span>
#include <unordered_map>
#include <vector>

#include "runtime/base/bytes.h"
#include "runtime/comm/transport/communicator.h"
#include "runtime/sim/catoms/membership.h"

namespace meld::sim {

class Routes {
  public:
    // `anywhere`: every node is one hop away.
    Routes(bool anywhere, const Membership& members, const comm::Communicator& comm);

    // What has changed at the nodes of this process since all have last taken it; at first everything. Cost: nothing if no link and no node
    // has come or gone; otherwise a look at each link.
    void report(ByteWriter& out) const;
    // What a process has reported; once for each, in their order, this one included.
    void take(int process, ByteReader& in);
    // After all have been taken.
    void settle();

    // Where a fact for the target goes next from a catom of this process: to itself, to a neighbour, or nowhere, which is the catom's own
    // number. From several threads at once. Cost: a search of the whole graph for each target whose distances are not known.
    u64 next_hop(Catom from, u64 target) const;
    // The process that owns a node; none if there is no such node, or not any more.
    std::optional<int> owner(u64 id) const;

    std::size_t bytes() const;
    // What a process takes for so many nodes: always, and beside that for distances at most.
    static double bytes_for(double nodes) { return static_cast<double>(sizeof(std::int32_t)) * nodes; }
    static double most_distances_bytes(double nodes);

  private:
    using Node = Nodes::Node;
    std::span<const Node> neighbours(Node node) const;
    std::vector<Node> neighbours_now(Catom catom) const;
    // By node; kFar where no way leads.
    const std::vector<std::uint32_t>& distances_from(Node target) const;
    // What report() looks at, in short.
    struct Seen {
        std::uint64_t links = 0, catoms = 0;
        bool operator==(const Seen&) const = default;
    };
    Seen now() const { return {members_.ensemble.links().version(), members_.ensemble.owned_count()}; }

    // The one that is known for a node; kGone also for one that has just been made.
    std::int32_t known_owner(Node node) const;

    const bool anywhere_;
    const Membership& members_;
    const int process_;
    std::vector<std::int32_t> owner_;  // By node.
    // Where they are not those of the graph, ascending.
    std::unordered_map<Node, std::vector<Node>> neighbours_;
    std::optional<Seen> seen_;
    bool changed_ = false;                                                    // Something that was taken.
    mutable std::mutex mutex_;                                                // Of what follows.
    mutable std::unordered_map<Node, std::vector<std::uint32_t>> distances_;  // By target.
};

}  // namespace meld::sim
