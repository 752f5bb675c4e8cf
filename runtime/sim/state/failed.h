// What a snapshot says of catoms and links that fail: which catoms hang, which of them are dying, which links are missing although their
// catoms touch or the graph has them, and which links of nodes the graph does not have;
// and which nodes rules have made.
#pragma once

#include <cstdint>
#include <utility>
#include <vector>

#include "runtime/base/bytes.h"
#include "runtime/sim/core/setup/graph_setup.h"
#include "runtime/sim/core/subdomain.h"

namespace meld::sim {

class Failed {
  public:
    // Of this process: a link is the end's with the lower number. Cost: a look at each link, where links are listed.
    static void save(const Subdomain& subdomain, ByteWriter& out);
    // Adds what another share says. Errors: it cannot be.
    Result<void> read(const world::World& world, ByteReader& in);

    const std::vector<JoinedNodes>& joined() const { return joined_; }
    struct Made {
        std::uint64_t id = 0;
        graph::Node maker = 0;
    };
    // As Nodes::add() takes them.
    const std::vector<Made>& made() const { return made_; }
    // Once all shares have been read and all nodes are known. Errors: a link cannot be.
    Result<void> check_joined(const Nodes& nodes) const;
    // The same of the places of nodes that move, which they get. Errors: there are too few.
    Result<void> place(Nodes& nodes) const;
    // Takes the missing links out, once all catoms are there.
    void cut(world::Ensemble& ensemble) const;
    // By their numbers.
    const std::vector<std::uint64_t>& hung() const { return hung_; }
    // In the order of Status::dying.
    const std::vector<Dying>& dying() const { return dying_; }

  private:
    std::vector<std::uint64_t> hung_;
    std::vector<Dying> dying_;
    std::vector<std::pair<std::uint64_t, std::uint64_t>> missing_;
    std::vector<JoinedNodes> joined_;
    std::vector<Made> made_;
    std::vector<graph::Point> places_;  // Of all nodes, if they move.
};

}  // namespace meld::sim
