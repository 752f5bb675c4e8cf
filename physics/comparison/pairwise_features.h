// Magnets, plates and latches for engines that keep no list of candidate pairs.
#pragma once

#include <memory>
#include <vector>

#include "physics/collision/broadphase.h"
#include "physics/comparison/hash_broadphase.h"
#include "physics/solver/engine.h"

namespace meld::physics {

// The feature wrenches for engines without a list of candidates and without latches in their contact rows. There a latch is a force that
// presses the two bodies together: a contact with the impulse lambda under a force F holds up to lambda - F >= -F in tension, and friction
// sees lambda. That is what a latch does.
class PairwiseFeatures {
  public:
    // At the start of a step. Cost: a search for pairs within the range of features.
    Result<void> find(World& world, double dt_s, Workers& workers);
    // By slot; empty in a world without features.
    const std::vector<Wrench>& wrenches() const { return wrenches_; }
    // Subtracts the forces of latches from the normal forces that contacts report; if a pair has several contacts, from the first.
    void discount(std::vector<ContactReport>& reports) const;

  private:
    struct Held {
        Touch touch;
        double force_n;
    };
    std::unique_ptr<Broadphase> broadphase_ = make_hash_broadphase();
    std::vector<Wrench> wrenches_;
    std::vector<Held> held_;
};

}  // namespace meld::physics
