// Branches of a run in a session: each is what was done by hand, and the tick where it was left. To switch to one makes its run again from
// where the two part, so a branch keeps no state of catoms.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "runtime/ask/debug/answer.h"
#include "runtime/ask/debug/by_hand.h"
#include "runtime/base/error.h"
#include "runtime/results/timeline/timeline.h"

namespace meld::debug {

// Every process has one and calls all of this at the same time.
class Branches {
  public:
    // From here on the session is in a new branch; the one that it was in stays as it is. Errors: there is one of this name.
    Result<Answer> fork(timeline::Timeline& timeline, const ByHand& by_hand, const std::string& name);
    // Goes to where a branch was left. Errors: there is none of this name; those of Timeline::to(), and then the session is still in the
    // branch that it was in, perhaps at an earlier tick. Cost: a way back to where the branches part, and from there the run.
    Result<Answer> go_to(timeline::Timeline& timeline, ByHand& by_hand, const std::string& name);
    BranchesFound all(timeline::Timeline& timeline, const ByHand& by_hand) const;
    // The present branch begins anew with another program. Returns the others, which are gone.
    std::vector<std::string> keep_the_present();

  private:
    struct Branch {
        std::string name;
        std::int64_t tick = 0;    // Where it was left,
        ByHand::State done = {};  // and what was done by hand.
    };
    std::vector<Branch> branches_ = {{.name = "main"}};
    std::size_t present_ = 0;
};

}  // namespace meld::debug
