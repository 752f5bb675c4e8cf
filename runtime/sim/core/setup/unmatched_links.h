// Which of the links that a world speaks of are there: events that cut, heal, jam or join them, faults, regions of the network and single
// links.
#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "runtime/sim/core/failures/link_failures.h"
#include "runtime/sim/core/subdomain.h"

namespace meld::sim {

class UnmatchedLinks {
  public:
    explicit UnmatchedLinks(Subdomain& subdomain);
    // Warns of events that are still to come and concern no link, where that is known beforehand. A link counts if the graph has it or its
    // catoms touch, also if it is cut at the moment, or if an event joins it; only heal knows nothing of those. Every process calls it.
    // Cost: a look at each catom for every region that matches nothing.
    void look_at_events();
    // The same of the network and of faults, at the start of a run.
    void look_at_start();

  private:
    using Pair = std::pair<std::uint64_t, std::uint64_t>;
    struct Claim {
        std::optional<Pair> pair = {};  // Otherwise the links of catoms in a region, or between two.
        const world::Region* where = nullptr;
        const world::Region* other = nullptr;
        std::int64_t until = 0;  // What events join up to this tick is there too.
        bool graph_only = false;
        std::function<std::string()> warning = {};
        bool matched = false;
    };
    // Nobody moves, and no catoms are made.
    bool known() const;
    Claim claim(const world::LinkChoice& choice, std::int64_t until) const;
    void add_events();
    void add_joins();
    void report();
    bool matches_pair(const Claim& claim) const;
    bool matches_at(const Claim& claim, Catom catom) const;
    // Whether test(End) holds for the other end of a link of the catom.
    template <class Test>
    bool any_link(const Claim& claim, Catom catom, const Test& test) const;
    bool joined(const Pair& pair, std::int64_t until) const;

    Subdomain& subdomain_;
    const LinkFailures ends_;
    std::multimap<std::uint64_t, std::pair<std::uint64_t, std::int64_t>> joins_;  // By both ends, with the tick.
    std::vector<Claim> claims_;
};

}  // namespace meld::sim
