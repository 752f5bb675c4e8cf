// Blocks of a divided world that sleep and wake together, as all subdomains say: bodies in them hang together by joints.
#pragma once

#include <cstddef>
#include <cstdint>
#include <unordered_map>
#include <utility>
#include <vector>

namespace meld::physics {

// Blocks are named by their keys. A question about blocks is answered for whole groups: yes if nobody says no of one of them.
class LinkedBlocks {
  public:
    void clear() { place_.clear(), above_.clear(), yes_.clear(); }
    void link(std::uint64_t one, std::uint64_t other) {
        const std::uint32_t a = first(place(one)), b = first(place(other));
        const std::uint8_t both = yes_[a] & yes_[b];
        above_[b] = a;
        yes_[a] = both;
    }
    // The next question, about the same groups.
    void ask() { yes_.assign(yes_.size(), 1); }
    void say_no(std::uint64_t block) { yes_[first(place(block))] = 0; }
    // Of a block that nobody has named: no.
    bool answer(std::uint64_t block) const {
        const auto found = place_.find(block);
        if (found == place_.end()) return false;
        std::uint32_t at = found->second;
        while (above_[at] != at) at = above_[at];
        return yes_[at] != 0;
    }
    std::size_t bytes() const {
        return place_.size() * (sizeof(*place_.begin()) + 2 * sizeof(void*)) + above_.capacity() * sizeof(above_[0]) + yes_.capacity();
    }

  private:
    std::uint32_t place(std::uint64_t block) {
        const auto [at, is_new] = place_.try_emplace(block, static_cast<std::uint32_t>(above_.size()));
        if (is_new) above_.push_back(at->second), yes_.push_back(1);
        return at->second;
    }
    std::uint32_t first(std::uint32_t at) {
        while (above_[at] != at) at = above_[at] = above_[above_[at]];
        return at;
    }

    std::unordered_map<std::uint64_t, std::uint32_t> place_;
    std::vector<std::uint32_t> above_;
    std::vector<std::uint8_t> yes_;
};

}  // namespace meld::physics
