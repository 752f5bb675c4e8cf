// Sparse symmetric systems of blocks of six rows, solved directly: block L D L^T. Of the rows that are left, the one with the fewest
// neighbours is eliminated next, which for joints that form a tree leaves no block to fill in, and few for loops.
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <cstdint>
#include <span>
#include <utility>
#include <vector>

namespace meld::physics {

using JointBlock = Eigen::Matrix<double, 6, 6>;
using JointVector = Eigen::Matrix<double, 6, 1>;

class BlockSystem {
  public:
    using Pair = std::pair<std::uint32_t, std::uint32_t>;
    // The blocks that are not zero beside the diagonal, each pair once. False: elimination would need more than `most` products of blocks.
    bool lay_out(std::size_t count, std::span<const Pair> pairs, std::size_t most);

    // Sets all blocks: those of the diagonal, and of each pair as given the block in the row of its first and the column of its second.
    void set(std::span<const JointBlock> diagonal, std::span<const JointBlock> of_pairs);
    void factor();
    // x: the right side, then the solution.
    void solve(std::span<JointVector> x);
    std::size_t bytes() const;

  private:
    // A block below the diagonal.
    struct Entry {
        std::uint32_t row, column;
    };
    // Block `target` loses the product of `one` and the transpose of `other`, which is not yet divided by the diagonal.
    struct Update {
        std::uint32_t target, one, other;
    };
    static constexpr std::uint32_t kDiagonal = 0x80000000u;

    std::vector<std::uint32_t> place_of_;
    std::vector<JointBlock> diagonal_, below_, undivided_;
    // By place in the order of elimination, and one more: its blocks below the diagonal, and what they change.
    std::vector<std::uint32_t> first_entry_, first_update_;
    std::vector<Entry> entries_;
    std::vector<Update> updates_;
    // Of each pair as given: its block, and whether it is stored transposed.
    std::vector<std::pair<std::uint32_t, bool>> of_pair_;
    std::vector<JointVector> sorted_;
};

}  // namespace meld::physics
