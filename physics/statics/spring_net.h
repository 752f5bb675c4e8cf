// Rigid bodies held to each other, and to a ground that does not move, by springs that resist all six ways of moving: one block of six rows
// and columns for each body and each pair that a spring joins. The matrix is symmetric, and positive definite if every part is held.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "physics/statics/twist.h"

namespace meld::physics {

inline constexpr std::uint32_t kGround = 0xffffffff;

// Between two bodies, or a body and the ground, which is then the other. `stiffness` answers a displacement about `at`.
struct Spring {
    std::uint32_t one = 0, other = kGround;
    Vec3 at = {};
    Matrix6 stiffness = Matrix6::Zero();
};

class SpringNet {
  public:
    // At most one spring joins two bodies. A displacement of a body is about its place.
    SpringNet(std::vector<Vec3> places, std::vector<Spring> springs);

    std::size_t count() const { return places_.size(); }
    const Matrix6& diagonal(std::size_t body) const { return diagonal_[body]; }
    // The neighbours of a body, and the blocks of its row.
    std::span<const std::uint32_t> neighbours(std::size_t body) const { return range(neighbours_, body); }
    std::span<const Matrix6> blocks(std::size_t body) const { return range(blocks_, body); }

    void multiply(const Twists& x, Twists& product) const;
    // A sweep of Gauss and Seidel towards A x = b, in the order of the bodies or against it.
    enum class Order { Forward, Backward };
    void sweep(const Twists& b, Twists& x, Order order) const;

    // Groups of neighbours that move as one body, and the springs between them: all rigid motions of the groups, exactly.
    // `group_of`: for each body.
    SpringNet coarser(std::vector<std::uint32_t>& group_of) const;
    // What acts on bodies, added up for their groups; and displacements of the groups, added to those of their bodies.
    void gather(std::span<const std::uint32_t> group_of, const SpringNet& groups, const Twists& on_bodies, Twists& on_groups) const;
    void spread(std::span<const std::uint32_t> group_of, const SpringNet& groups, const Twists& of_groups, Twists& of_bodies) const;
    std::size_t bytes() const;

  private:
    template <class T>
    std::span<const T> range(const std::vector<T>& all, std::size_t body) const {
        return std::span(all).subspan(first_[body], first_[body + 1] - first_[body]);
    }
    std::vector<std::uint32_t> group() const;

    std::vector<Vec3> places_;
    std::vector<Spring> springs_;
    std::vector<Matrix6> diagonal_, inverse_diagonal_;
    // By body, and one more.
    std::vector<std::uint32_t> first_;
    std::vector<std::uint32_t> neighbours_;
    std::vector<Matrix6> blocks_;
};

}  // namespace meld::physics
