// Nodes of a graph that rules make with `exists`.
//
// A rule needs the number of its node at once, when no catom knows what others make. So each has numbers of its own in each tick: with n
// nodes so far and the next number b, node i (in the order of numbers) takes b + i, b + n + i, b + 2n + i, ... At the end of the tick all
// processes learn which of these are nodes now, and who has made them. Numbers do not repeat, follow from the program alone, and grow by no
// more than n times the most that one node makes in a tick.
#pragma once

#include <optional>
#include <vector>

#include "runtime/base/bytes.h"
#include "runtime/sim/core/subdomain.h"

namespace meld::sim {

class Births {
  public:
    explicit Births(Subdomain& subdomain) : subdomain_(subdomain) {}

    // The number of a catom's node number `number` of this tick. From several threads at once.
    static u64 number(const Membership& members, Catom maker, u32 number);

    // A fact for a node that lives on this process from the next tick on. Those for one node come in the order in which they were made.
    struct Fact {
        u64 to;
        u64 from;  // Its maker.
        u16 predicate;
        const Value* arguments;
        std::optional<Catom> catom = {};  // Once it is there.
    };
    void take(const Fact& fact) { facts_.push_back(fact); }
    // When all facts have come: makes their nodes, and returns the facts in the order of nodes. Collective. Arrays may move.
    const std::vector<Fact>& run();
    // When the facts have been delivered.
    void clear() { facts_.clear(); }

  private:
    struct Newborn {
        u64 id, maker;
    };
    std::vector<Newborn> all();
    void place(u64 id);

    Subdomain& subdomain_;
    std::vector<Fact> facts_;
};

}  // namespace meld::sim
