// What the connections between rigid bodies carry: each is a short round bar, equally stiff in all connections but for its radius, and the
// bodies are held by the ground or, if nothing holds them, are in balance.
//
// What hangs on one connection only is added up from its end: there the result follows from statics alone, whatever the stiffness. What is
// left has loops. It is eliminated directly if that takes little memory, and otherwise solved by conjugate gradients: the preconditioner
// lets groups of neighbours move as rigid bodies, groups of groups too, and solves the coarsest directly (aggregation multigrid with a
// K-cycle; Notay and Vassilevski: "Recursive Krylov-based multigrid cycles", 2008). All sums have a fixed order.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "physics/statics/elimination.h"
#include "physics/statics/spring_net.h"
#include "physics/statics/twist.h"

namespace meld::physics {

// From one body to another, or to the ground. `at` is where it gives way, `along` a unit vector from one to the other.
struct Beam {
    std::uint32_t one = 0, other = kGround;
    Vec3 at, along;
    double radius_m = 0.5;
    bool operator==(const Beam&) const = default;
};

class StiffLattice {
  public:
    // All bodies hang together, perhaps through the ground, and at most one beam joins two of them.
    StiffLattice(std::vector<Vec3> places, std::vector<Beam> beams);

    // What each beam does to its one body, about the point where it gives way, if this acts on the bodies, about their places. Without a
    // beam to the ground, all that acts must be in balance. False if it was not found: by conjugate gradients to a part in ten million,
    // directly to one in ten thousand.
    bool solve(std::span<const Pull> on_bodies, std::span<Pull> by_beams) const;

    const std::vector<Vec3>& places() const { return places_; }
    const std::vector<Beam>& beams() const { return beams_; }
    std::size_t bytes() const;

  private:
    // A body with one beam left, which carries all that acts on it.
    struct Peeled {
        std::uint32_t body, beam;
    };
    struct Level {
        SpringNet net;
        std::vector<std::uint32_t> group_of;  // In the next one.
    };
    std::vector<std::uint8_t> peel();
    void lay_out(std::vector<Vec3> places, std::vector<Spring> springs);
    // Flexible conjugate gradients from zero, in at most so many steps; whether what is left is below this share of what acts.
    bool iterate(std::size_t level, const Twists& acts, Twists& x, int most_steps, double share) const;
    void precondition(std::size_t level, const Twists& acts, Twists& x) const;

    std::vector<Vec3> places_;
    std::vector<Beam> beams_;
    // Lengths are counted in it, so that forces and torques have sizes to compare.
    double unit_m_ = 1;
    std::vector<Peeled> peeled_;
    // What is left: its bodies' numbers there; and its beams with their springs.
    std::vector<std::uint32_t> left_;
    std::vector<std::uint32_t> left_beams_;
    std::vector<Level> levels_;
    std::optional<Elimination> direct_;
};

}  // namespace meld::physics
