// The original design's broadphase, for comparison.
#pragma once

#include <memory>

#include "physics/collision/broadphase.h"

namespace meld::physics {

// The original design: a table of bins for each size of body, filled without locks by exchanging the head of a bin's chain. A body is in
// every bin that its box overlaps, and a vector of n bits for each thread says which partners a body has met already.
std::unique_ptr<Broadphase> make_hash_broadphase();

}  // namespace meld::physics
