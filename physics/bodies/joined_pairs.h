// Which bodies a joint holds together: they do not collide with each other.
#pragma once

#include <algorithm>
#include <cstddef>
#include <span>
#include <vector>

#include "physics/bodies/types.h"

namespace meld::physics {

class JoinedPairs {
  public:
    bool empty() const { return count_ == 0; }
    std::size_t count() const { return count_; }
    bool has(BodyId one, BodyId other) const { return count_ > 0 && std::ranges::binary_search(of(one), other); }
    // Sorted.
    std::span<const BodyId> of(BodyId body) const {
        return body < of_.size() ? std::span<const BodyId>(of_[body]) : std::span<const BodyId>();
    }

    // The two must not be joined yet.
    void add(BodyId one, BodyId other) {
        of_.resize(std::max<std::size_t>({of_.size(), one + std::size_t{1}, other + std::size_t{1}}));
        insert(one, other), insert(other, one);
        ++count_;
    }
    // The two are joined.
    void remove(BodyId one, BodyId other) {
        std::erase(of_[one], other), std::erase(of_[other], one);
        --count_;
    }
    void remove_all(BodyId body) {
        if (body >= of_.size()) return;
        for (const BodyId other : of_[body]) std::erase(of_[other], body);
        count_ -= of_[body].size();
        of_[body].clear();
    }
    std::size_t bytes() const {
        std::size_t sum = of_.capacity() * sizeof(of_[0]);
        for (const auto& list : of_) sum += list.capacity() * sizeof(BodyId);
        return sum;
    }

  private:
    void insert(BodyId one, BodyId other) { of_[one].insert(std::ranges::lower_bound(of_[one], other), other); }

    std::vector<std::vector<BodyId>> of_;
    std::size_t count_ = 0;
};

}  // namespace meld::physics
