// Broadphases behind one interface, so that they can be compared on the same bodies; comparison/hash_broadphase.h is another.
#pragma once

#include <array>
#include <cstdint>
#include <limits>
#include <memory>
#include <vector>

#include "physics/bodies/bodies.h"
#include "runtime/base/error.h"
#include "runtime/base/exact_sum.h"
#include "runtime/base/process/parallel_for.h"

namespace meld::physics {

class Broadphase {
  public:
    virtual ~Broadphase() = default;
    // The pairs of slots whose surfaces are less than `reach_m` apart, each once, except those of two fixed bodies; `pairs` has a list for
    // each worker. May reorder the bodies.
    virtual Result<void> find(Bodies& bodies, double reach_m, Workers& workers) = 0;

    std::vector<std::vector<BodyPair>> pairs;
};

// The sparse grid of blocks with ordered cells (block_grid.h, pair_search.h).
std::unique_ptr<Broadphase> make_block_broadphase();

// The smallest and largest radius of the bodies that are not removed; 1, 1 if there are none.
struct RadiusRange {
    double min = 1, max = 1;
};
RadiusRange radius_range(const Bodies& bodies);

// The velocities of many bodies, m/s: their mean, relative to which a crowd that moves together is slow, the smallest box that holds them,
// and how many can be fast.
class Velocities {
  public:
    void add(const Vec3& velocity);
    void add(const Velocities& others);
    Vec3 mean() const;
    // No body is faster than this relative to a frame that moves.
    double greatest_beside(const Vec3& frame) const;
    // At most this share of the bodies is faster than `speed_m_s`, which counts some that are less than a third slower.
    double share_above(double speed_m_s) const;

  private:
    static constexpr double kNone = std::numeric_limits<double>::infinity();
    Vec3 least_{kNone, kNone, kNone}, most_{-kNone, -kNone, -kNone};
    // Exact, so the same in any order.
    ExactSum x_, y_, z_;
    std::uint64_t count_ = 0;
    // By the binary exponent of the square of their speed.
    static constexpr int kExponents = 64;
    static int exponent_of(double speed_squared);
    std::array<std::uint64_t, kExponents> of_exponent_{};
};
// Of all finite bodies that are neither removed nor ghosts.
Velocities velocities_of(const Bodies& bodies);

}  // namespace meld::physics
