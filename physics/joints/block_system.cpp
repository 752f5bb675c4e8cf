#include "physics/joints/block_system.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <set>

#include "runtime/base/assert.h"

namespace meld::physics {

namespace {

// The order of elimination, and for each place the places of those that it is coupled with then, which come later; sorted.
struct Elimination {
    std::vector<std::uint32_t> place_of;
    std::vector<std::vector<std::uint32_t>> later;
    bool fits = true;
};

Elimination eliminate(std::size_t count, std::span<const BlockSystem::Pair> pairs, std::size_t most) {
    std::vector<std::set<std::uint32_t>> left(count);
    for (const auto& [one, other] : pairs) left[one].insert(other), left[other].insert(one);
    std::set<std::pair<std::size_t, std::uint32_t>> queue;
    for (std::uint32_t i = 0; i < count; ++i) queue.emplace(left[i].size(), i);
    Elimination done{std::vector<std::uint32_t>(count), std::vector<std::vector<std::uint32_t>>(count)};
    std::size_t products = 0;
    for (std::uint32_t place = 0; place < count; ++place) {
        const std::uint32_t next = queue.begin()->second;
        queue.erase(queue.begin());
        done.place_of[next] = place;
        const std::set<std::uint32_t> around = std::move(left[next]);
        if (products += around.size() * (around.size() + 1) / 2; products > most) {
            done.fits = false;
            return done;
        }
        done.later[place].assign(around.begin(), around.end());
        for (const std::uint32_t one : around) {
            queue.erase({left[one].size(), one});
            left[one].erase(next);
            for (const std::uint32_t other : around)
                if (other != one) left[one].insert(other);
            queue.emplace(left[one].size(), one);
        }
    }
    for (auto& list : done.later) {
        for (std::uint32_t& index : list) index = done.place_of[index];
        std::ranges::sort(list);
    }
    return done;
}

}  // namespace

bool BlockSystem::lay_out(std::size_t count, std::span<const Pair> pairs, std::size_t most) {
    Elimination order = eliminate(count, pairs, most);
    if (!order.fits) return false;
    place_of_ = std::move(order.place_of);
    first_entry_.assign(1, 0), first_update_.assign(1, 0);
    entries_.clear(), updates_.clear(), of_pair_.clear();
    for (std::uint32_t column = 0; column < count; ++column) {
        for (const std::uint32_t row : order.later[column]) entries_.push_back({row, column});
        first_entry_.push_back(static_cast<std::uint32_t>(entries_.size()));
    }
    const auto entry = [&](std::uint32_t row, std::uint32_t column) {
        const auto& list = order.later[column];
        const auto found = std::ranges::lower_bound(list, row);
        MELD_EXPECT(found != list.end() && *found == row, "block {}, {}", row, column);
        return first_entry_[column] + static_cast<std::uint32_t>(found - list.begin());
    };
    for (std::uint32_t column = 0; column < count; ++column) {
        const std::uint32_t first = first_entry_[column], end = first_entry_[column + 1];
        for (std::uint32_t one = first; one < end; ++one)
            for (std::uint32_t other = first; other <= one; ++other) {
                const std::uint32_t row = entries_[one].row, to = entries_[other].row;
                updates_.push_back({row == to ? kDiagonal | row : entry(row, to), one, other});
            }
        first_update_.push_back(static_cast<std::uint32_t>(updates_.size()));
    }
    for (const auto& [one, other] : pairs) {
        const std::uint32_t row = place_of_[one], column = place_of_[other];
        of_pair_.emplace_back(row > column ? entry(row, column) : entry(column, row), row < column);
    }
    diagonal_.resize(count), sorted_.resize(count);
    below_.resize(entries_.size()), undivided_.resize(entries_.size());
    return true;
}

void BlockSystem::set(std::span<const JointBlock> diagonal, std::span<const JointBlock> of_pairs) {
    MELD_EXPECT(diagonal.size() == diagonal_.size() && of_pairs.size() == of_pair_.size(), "{} and {} blocks", diagonal.size(),
                of_pairs.size());
    for (std::size_t i = 0; i < diagonal.size(); ++i) diagonal_[place_of_[i]] = diagonal[i];
    for (JointBlock& block : below_) block.setZero();
    for (std::size_t p = 0; p < of_pairs.size(); ++p) {
        const auto [at, transposed] = of_pair_[p];
        if (transposed)
            below_[at] = of_pairs[p].transpose();
        else
            below_[at] = of_pairs[p];
    }
}

// The diagonal holds its inverses afterwards.
void BlockSystem::factor() {
    for (std::uint32_t column = 0; column < diagonal_.size(); ++column) {
        diagonal_[column] = JointBlock(diagonal_[column].llt().solve(JointBlock::Identity()));
        for (std::uint32_t e = first_entry_[column]; e < first_entry_[column + 1]; ++e) {
            undivided_[e] = below_[e];
            below_[e].noalias() = undivided_[e] * diagonal_[column];
        }
        for (std::uint32_t u = first_update_[column]; u < first_update_[column + 1]; ++u) {
            const Update& update = updates_[u];
            const bool on_diagonal = (update.target & kDiagonal) != 0;
            JointBlock& target = on_diagonal ? diagonal_[update.target & ~kDiagonal] : below_[update.target];
            target.noalias() -= below_[update.one] * undivided_[update.other].transpose();
        }
    }
}

void BlockSystem::solve(std::span<JointVector> x) {
    MELD_EXPECT(x.size() == diagonal_.size(), "{} of {} blocks", x.size(), diagonal_.size());
    for (std::size_t i = 0; i < x.size(); ++i) sorted_[place_of_[i]] = x[i];
    for (std::uint32_t column = 0; column < diagonal_.size(); ++column)
        for (std::uint32_t e = first_entry_[column]; e < first_entry_[column + 1]; ++e)
            sorted_[entries_[e].row].noalias() -= below_[e] * sorted_[column];
    for (std::size_t column = diagonal_.size(); column-- > 0;) {
        sorted_[column] = JointVector(diagonal_[column] * sorted_[column]);
        for (std::uint32_t e = first_entry_[column]; e < first_entry_[column + 1]; ++e)
            sorted_[column].noalias() -= below_[e].transpose() * sorted_[entries_[e].row];
    }
    for (std::size_t i = 0; i < x.size(); ++i) x[i] = sorted_[place_of_[i]];
}

std::size_t BlockSystem::bytes() const {
    return (diagonal_.capacity() + below_.capacity() + undivided_.capacity()) * sizeof(JointBlock) +
           sorted_.capacity() * sizeof(JointVector) + entries_.capacity() * sizeof(Entry) + updates_.capacity() * sizeof(Update) +
           of_pair_.capacity() * sizeof(of_pair_[0]) +
           (place_of_.capacity() + first_entry_.capacity() + first_update_.capacity()) * sizeof(std::uint32_t);
}

}  // namespace meld::physics
