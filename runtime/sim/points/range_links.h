// Links between catoms within a range of each other, which migrate between processes: bodies. Each process finds those of its own catoms.
#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <utility>
#include <vector>

#include "runtime/sim/core/subdomain.h"
#include "runtime/world/graph/range.h"

namespace meld::sim {

class RangeLinks {
  public:
    explicit RangeLinks(double range) : range_(range) {}
    // Whether two catoms see each other, by their numbers: the same for both ends on all processes. Empty: all do.
    using Sees = std::function<bool(std::uint64_t, std::uint64_t)>;
    // When catoms are where they are in this tick, on every process: removes links that are longer than the range, or between catoms that
    // do not see each other, and makes those that are missing. A catom of another process that comes into the range of one of ours becomes
    // a ghost here; ghosts get their positions. New links take the lowest free ports, in the order of the neighbours' numbers. Cost: a look
    // at all pairs in range; other processes are sent the catoms within the range of the box around theirs.
    void update(Subdomain& subdomain, const Sees& sees = {});

  private:
    // Of our catoms, then of those of other processes near ours.
    struct Known {
        std::vector<graph::Point> places;
        std::vector<std::uint64_t> ids;
        std::vector<std::int32_t> owners;
        std::vector<Catom> catoms;  // Of ours.
        std::optional<graph::Node> find(std::uint64_t id) const;
        // By number.
        std::vector<std::pair<std::uint64_t, graph::Node>> order;
    };
    // A link that is to be made, as the end that is ours sees it.
    struct Missing {
        std::uint64_t here = 0, there = 0;
        std::int32_t owner = 0;  // Of the other end.
        int port = -1;
    };
    Known known(Subdomain& subdomain) const;
    void add_others(Subdomain& subdomain, Known& all) const;
    void remove_long(Subdomain& subdomain, const Known& all, const Sees& sees) const;
    std::vector<Missing> missing(const Subdomain& subdomain, const Known& all, const Sees& sees) const;
    static void choose_ports(const Subdomain& subdomain, std::vector<Missing>& missing);
    static void connect(Subdomain& subdomain, const std::vector<Missing>& missing);

    double range_;
};

}  // namespace meld::sim
