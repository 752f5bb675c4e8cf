// A net of springs solved exactly: bodies are eliminated one after the other, always one with the fewest neighbours left, so that rows,
// rings and narrow strips cost no more than their length.
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "physics/statics/spring_net.h"

namespace meld::physics {

class Elimination {
  public:
    // Nothing if more than `most_blocks` blocks would have to be kept, or the net is not held.
    static std::optional<Elimination> of(const SpringNet& net, std::size_t most_blocks);
    // x becomes the displacements under what acts, x.
    void solve(Twists& x) const;
    std::size_t bytes() const;

  private:
    struct Step {
        std::uint32_t body, first;
        Matrix6 inverse;
    };
    std::vector<Step> steps_;
    // Of each step up to that of the next one: the neighbours that were left, and the blocks of its row.
    std::vector<std::uint32_t> neighbours_;
    std::vector<Matrix6> blocks_;
};

}  // namespace meld::physics
