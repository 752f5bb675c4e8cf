// Facts of routes that lead to a catom which theirs does not touch. Facts travel between catoms that touch, so where nothing moves,
// nothing would ever be read or sent along them: there, those of the program's text and of the world are an error at the start, and those
// that rules have derived are a warning at the end. Where catoms move, the summary counts those that there are at the end.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <utility>

#include "runtime/sim/core/subdomain.h"

namespace meld::sim {

struct DeadRoutes {
    std::uint64_t count = 0;
    std::string first;  // "edge(@0, @3) is a route that leads nowhere, since ..."
};
// The first, and how many more there are.
std::string describe(const DeadRoutes& routes);

class DeadLinks {
  public:
    explicit DeadLinks(const Subdomain& subdomain) : subdomain_(subdomain) {}

    // Checks the facts of the text.
    void look_at_text();
    // Checks a fact that the world gives to a catom of this process; `fact` is its number among the facts of the world.
    void look_at_given(std::size_t fact, Catom from, u32 predicate, u64 to);
    // Every process calls it. An error names the first of them all, in the order of text and world.
    Result<void> verdict() const;
    // Looks at all facts of routes as they are now. Cost: a visit of each.
    void look_at_all();
    // Those that were found. Every process calls it.
    DeadRoutes of_all_processes() const;

  private:
    using Order = std::pair<u64, u64>;
    bool dead(Catom from, u64 to) const;
    void found(Order order, Catom from, u64 to, u32 predicate, const std::string& place);

    struct First {
        Order order;
        std::string text;
    };

    const Subdomain& subdomain_;
    std::optional<First> first_;
    u64 count_ = 0;
};

}  // namespace meld::sim
