// The forces of magnets, plates and latches on the bodies of a world, for all engines.
#pragma once

#include <vector>

#include "physics/broadphase.h"
#include "physics/engine.h"

namespace meld::physics {

// A step, in this order. At its beginning: no body is pulled, and what is on draws its power.
void begin_pulls(World& world, std::vector<Push>& pulls, double dt_s, Workers& workers);
// Then for each pair whose surfaces are nearer than the world's range, `normal` from a to b: adds what their features do to each
// other. Returns the force of the latches that hold, N, which is not among it.
double pull_pair(World& world, std::vector<Push>& pulls, std::uint32_t a, std::uint32_t b, Vec3 normal, double gap_m);
// At its end: what charged plates have taken.
void settle_charges(World& world, Workers& workers);

// The same for engines without a list of candidates and without latches in their contact rows. There a latch is a force that
// presses the two together: a contact with the impulse lambda under a force F holds what lambda - F >= -F pulls apart, and
// friction sees lambda, which is what a latch is.
class FlatPulls {
  public:
    // At the beginning of a step. Cost: a search for pairs within the range of features.
    Result<void> find(World& world, double dt_s, Workers& workers);
    // By slot; empty in a world without features.
    const std::vector<Push>& pulls() const { return pulls_; }
    // Takes the forces of latches out of the normal forces that contacts report; of several contacts of a pair, the first.
    void discount(std::vector<ContactReport>& reports) const;

  private:
    struct Held {
        Touch touch;
        double force_n;
    };
    std::unique_ptr<Broadphase> broadphase_ = make_hash_broadphase();
    std::vector<Push> pulls_;
    std::vector<Held> held_;
};

}  // namespace meld::physics
