// Facts of routes, from the program's text or the world, that lead to a catom which theirs does not touch. Facts travel between
// catoms that touch, so where nothing moves, nothing would ever be read or sent along them.
#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <utility>

#include "runtime/sim/core/subdomain.h"

namespace meld::sim {

class DeadLinks {
  public:
    explicit DeadLinks(const Subdomain& subdomain) : subdomain_(subdomain) {}

    // Looks at those of the text.
    void look_at_text();
    // Looks at one that the world gives to a catom of this process; `fact` is its number among the facts of the world.
    void look_at_given(std::size_t fact, Catom from, u32 predicate, u64 to);
    // Every process calls it. An error names the first of them all, in the order of text and world.
    Result<void> verdict() const;

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
