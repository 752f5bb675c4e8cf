// Broadphases behind one interface, so that they can be compared on the same bodies: ours and the seed design's.
#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include "physics/bodies.h"
#include "runtime/base/error.h"
#include "runtime/base/parallel_for.h"

namespace meld::physics {

class Broadphase {
  public:
    virtual ~Broadphase() = default;
    // The pairs of slots whose surfaces are less than `reach_m` apart, each once, except those of two fixed bodies; in `pairs`,
    // a list for each worker. May bring the bodies into another order.
    virtual Result<void> find(Bodies& bodies, double reach_m, Workers& workers) = 0;

    std::vector<std::vector<BodyPair>> pairs;
};

// The sparse grid of blocks with ordered cells (block_grid.h, pair_search.h).
std::unique_ptr<Broadphase> make_block_broadphase();

// The seed design: a table of bins for each size of body, filled without locks by
// exchanging the head of a bin's chain; a body is in every bin its box overlaps, and a vector of n bits for each thread says
// which partners a body has already met.
std::unique_ptr<Broadphase> make_hash_broadphase();

// The least and largest radius of the bodies that are not removed; 1, 1 if there are none.
struct RadiusRange {
    double least = 1, largest = 1;
};
RadiusRange radius_range(const Bodies& bodies);

}  // namespace meld::physics
