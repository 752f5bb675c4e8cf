// The indices beside those of catoms at which columns hold what a catom said, for those who do not read the catom itself.
#pragma once

#include <cstddef>
#include <optional>
#include <vector>

#include "runtime/sim/catoms/fact_store.h"
#include "runtime/sim/catoms/membership.h"

namespace meld::sim {

class MailboxIndices {
  public:
    MailboxIndices(Membership& members, FactStore& facts) : members_(members), facts_(facts) {}

    // One for what this catom says. It holds what it held when it was given back.
    Catom take(Catom catom) {
        Catom index = 0;
        if (spare_.empty()) {
            index = members_.ensemble.add_mailbox(catom);
        } else {
            index = spare_.back();
            spare_.pop_back();
            if (spare_.size() > kAhead) members_.ensemble.ask_ahead_mailbox(spare_[spare_.size() - 1 - kAhead]);
            members_.ensemble.use_mailbox(index, catom);
        }
        // Not one by one: a wave takes thousands in a tick.
        if (index >= facts_.columns.count()) facts_.resize(index + index / 64 + std::size_t{64});
        return index;
    }
    // Nobody reads it any more.
    enum class Leaves { Nothing, WhatItHolds };
    void give_back(Catom index, Leaves leaves = Leaves::Nothing) {
        if (leaves == Leaves::Nothing) facts_.columns.clear(index, 0);
        spare_.push_back(index);
    }
    // One that is taken soon, if there are so many.
    std::optional<Catom> soon() const { return spare_.size() > kAhead ? std::optional(spare_[spare_.size() - 1 - kAhead]) : std::nullopt; }
    std::size_t bytes() const { return spare_.capacity() * sizeof(Catom); }

  private:
    static constexpr std::size_t kAhead = 8;

    Membership& members_;
    FactStore& facts_;
    std::vector<Catom> spare_;
};

}  // namespace meld::sim
