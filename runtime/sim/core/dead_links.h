// Facts of routes that lead to a catom which theirs does not touch. Facts travel between catoms that touch, so where nothing moves,
// nothing would ever be read or sent along them. Those of the program's text and of the world are an error at the start; those
// that rules have derived are a warning at the end.
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

    // Checks the facts of the text.
    void look_at_text();
    // Checks a fact that the world gives to a catom of this process; `fact` is its number among the facts of the world.
    void look_at_given(std::size_t fact, Catom from, u32 predicate, u64 to);
    // Every process calls it. An error names the first of them all, in the order of text and world.
    Result<void> verdict() const;
    // Looks at all facts of routes as they are now. Cost: a visit of each.
    void look_at_all();
    // Every process calls it. Says which is the first of them all, and how many there are; empty: none is.
    std::string warning() const;

  private:
    using Order = std::pair<u64, u64>;
    bool dead(Catom from, u64 to) const;
    void found(Order order, Catom from, u64 to, u32 predicate, const std::string& place);

    struct First {
        Order order;
        std::string text;
    };
    // The first of all processes and the number of them all, or nothing.
    struct All {
        std::string first;
        u64 count;
    };
    std::optional<All> of_all_processes() const;

    const Subdomain& subdomain_;
    std::optional<First> first_;
    u64 count_ = 0;
};

}  // namespace meld::sim
