#include "physics/statics/elimination.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <iterator>
#include <set>
#include <utility>

namespace meld::physics {

namespace {

// The rows of the bodies that are left, as places in a pool of blocks, by neighbour.
class Rows {
  public:
    explicit Rows(const SpringNet& net) : rows_(net.count()) {
        for (std::uint32_t body = 0; body < net.count(); ++body)
            for (std::size_t i = 0; i < net.neighbours(body).size(); ++i) at(body, net.neighbours(body)[i]) = net.blocks(body)[i];
    }
    std::size_t length(std::uint32_t body) const { return rows_[body].size(); }
    std::span<const std::pair<std::uint32_t, std::uint32_t>> row(std::uint32_t body) const { return rows_[body]; }
    const Matrix6& block(std::uint32_t place) const { return pool_[place]; }
    Matrix6& at(std::uint32_t body, std::uint32_t other) {
        auto& row = rows_[body];
        const auto found = std::ranges::lower_bound(row, other, {}, [](const auto& entry) { return entry.first; });
        if (found != row.end() && found->first == other) return pool_[found->second];
        std::uint32_t place = static_cast<std::uint32_t>(pool_.size());
        if (free_.empty())
            pool_.emplace_back();
        else
            place = free_.back(), free_.pop_back();
        pool_[place].setZero();
        row.insert(found, {other, place});
        return pool_[place];
    }
    void drop(std::uint32_t body, std::uint32_t other) {
        auto& row = rows_[body];
        const auto found = std::ranges::lower_bound(row, other, {}, [](const auto& entry) { return entry.first; });
        free_.push_back(found->second);
        row.erase(found);
    }
    void drop_row(std::uint32_t body) {
        for (const auto& [other, place] : rows_[body]) free_.push_back(place);
        rows_[body] = {};
    }

  private:
    std::vector<std::vector<std::pair<std::uint32_t, std::uint32_t>>> rows_;
    std::vector<Matrix6> pool_;
    std::vector<std::uint32_t> free_;
};

// Bodies by the number of neighbours that they have left, in the order in which they are eliminated.
class Queue {
  public:
    void add(std::size_t length, std::uint32_t body) {
        if (length >= of_length_.size()) of_length_.resize(length + 1);
        of_length_[length].insert(body);
        least_ = std::min(least_, length);
        ++count_;
    }
    void take(std::size_t length, std::uint32_t body) { of_length_[length].erase(body), --count_; }
    std::uint32_t next() {
        while (of_length_[least_].empty()) ++least_;
        const std::uint32_t body = *of_length_[least_].begin();
        take(least_, body);
        return body;
    }
    bool empty() const { return count_ == 0; }

  private:
    std::vector<std::set<std::uint32_t>> of_length_;
    std::size_t least_ = 0, count_ = 0;
};

// Whether at most so many blocks are kept: the same elimination, by numbers of neighbours alone.
bool keeps_at_most(const SpringNet& net, std::size_t most_blocks) {
    std::vector<std::vector<std::uint32_t>> rows(net.count());
    Queue left;
    for (std::uint32_t body = 0; body < net.count(); ++body) {
        rows[body].assign(net.neighbours(body).begin(), net.neighbours(body).end());
        left.add(rows[body].size(), body);
    }
    std::size_t kept = 0;
    std::vector<std::uint32_t> joined;
    while (!left.empty()) {
        const std::uint32_t body = left.next();
        const std::vector<std::uint32_t> row = std::move(rows[body]);
        if (kept += row.size(); kept > most_blocks) return false;
        for (const std::uint32_t other : row) {
            left.take(rows[other].size(), other);
            joined.clear();
            std::ranges::set_union(rows[other], row, std::back_inserter(joined));
            std::erase_if(joined, [&](std::uint32_t b) { return b == body || b == other; });
            rows[other] = joined;
            left.add(rows[other].size(), other);
        }
    }
    return true;
}

}  // namespace

std::optional<Elimination> Elimination::of(const SpringNet& net, std::size_t most_blocks) {
    if (!keeps_at_most(net, most_blocks)) return std::nullopt;
    Elimination done;
    Rows rows(net);
    std::vector<Matrix6> diagonal(net.count());
    Queue left;
    for (std::uint32_t body = 0; body < net.count(); ++body) {
        diagonal[body] = net.diagonal(body);
        left.add(rows.length(body), body);
    }
    std::vector<Matrix6> solved;
    while (!left.empty()) {
        const std::uint32_t body = left.next();
        const auto row = rows.row(body);
        const Eigen::LLT<Matrix6> factor(diagonal[body]);
        if (factor.info() != Eigen::Success) return std::nullopt;
        Step& step = done.steps_.emplace_back();
        step.body = body, step.first = static_cast<std::uint32_t>(done.blocks_.size());
        step.inverse = factor.solve(Matrix6::Identity());
        solved.clear();
        for (const auto& [other, place] : row) {
            left.take(rows.length(other), other);
            done.neighbours_.push_back(other);
            done.blocks_.push_back(rows.block(place));
            solved.emplace_back(step.inverse * rows.block(place));
        }
        for (std::size_t i = 0; i < solved.size(); ++i) {
            const std::uint32_t one = done.neighbours_[step.first + i];
            const Matrix6 across = done.blocks_[step.first + i].transpose();
            diagonal[one] -= across * solved[i];
            for (std::size_t k = i + 1; k < solved.size(); ++k) {
                const Matrix6 change = across * solved[k];
                const std::uint32_t other = done.neighbours_[step.first + k];
                rows.at(one, other) -= change;
                rows.at(other, one) -= change.transpose();
            }
        }
        for (std::size_t i = 0; i < solved.size(); ++i) {
            const std::uint32_t other = done.neighbours_[step.first + i];
            rows.drop(other, body);
            left.add(rows.length(other), other);
        }
        rows.drop_row(body);
    }
    return done;
}

void Elimination::solve(Twists& x) const {
    const auto end_of = [&](std::size_t s) { return s + 1 < steps_.size() ? steps_[s + 1].first : neighbours_.size(); };
    for (std::size_t s = 0; s < steps_.size(); ++s) {
        const Vector6 moved = steps_[s].inverse * x[steps_[s].body];
        for (std::size_t i = steps_[s].first; i < end_of(s); ++i) x[neighbours_[i]].noalias() -= blocks_[i].transpose() * moved;
    }
    for (std::size_t s = steps_.size(); s-- > 0;) {
        Vector6 acts = x[steps_[s].body];
        for (std::size_t i = steps_[s].first; i < end_of(s); ++i) acts.noalias() -= blocks_[i] * x[neighbours_[i]];
        x[steps_[s].body].noalias() = steps_[s].inverse * acts;
    }
}

std::size_t Elimination::bytes() const {
    return steps_.capacity() * sizeof(Step) + neighbours_.capacity() * sizeof(std::uint32_t) + blocks_.capacity() * sizeof(Matrix6);
}

}  // namespace meld::physics
