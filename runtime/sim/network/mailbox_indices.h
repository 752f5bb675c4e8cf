// The indices beside those of catoms at which columns hold what a catom said, for those who do not read the catom itself.
#pragma once

#include <cstddef>
#include <vector>

#include "runtime/sim/catoms/fact_store.h"
#include "runtime/sim/catoms/membership.h"

namespace meld::sim {

class MailboxIndices {
  public:
    MailboxIndices(Membership& members, FactStore& facts) : members_(members), facts_(facts) {}

    // One for what this catom says, empty.
    Catom take(Catom catom) {
        Catom index = 0;
        if (spare_.empty()) {
            index = members_.ensemble.add_mailbox(catom);
        } else {
            index = spare_.back();
            spare_.pop_back();
            members_.ensemble.use_mailbox(index, catom);
        }
        // Not one by one: a wave takes thousands in a tick.
        if (index >= facts_.columns.count()) facts_.resize(index + index / 64 + std::size_t{64});
        return index;
    }
    // Nobody reads it any more.
    void give_back(Catom index) {
        facts_.columns.clear(index, 0);
        spare_.push_back(index);
    }
    std::size_t bytes() const { return spare_.capacity() * sizeof(Catom); }

  private:
    Membership& members_;
    FactStore& facts_;
    std::vector<Catom> spare_;
};

}  // namespace meld::sim
