// The links that a graph has so far, where a generator has to ask.
#pragma once

#include <algorithm>
#include <bit>
#include <cstdint>
#include <vector>

#include "runtime/base/hash.h"
#include "runtime/world/graph/graph.h"

namespace meld::graph {

// A table with open addressing, at most half full: 16 to 32 bytes a link.
class LinkSet {
  public:
    explicit LinkSet(std::size_t links) : table_(std::bit_ceil(2 * links + 2), kEmpty) {}
    // Returns whether it was not there. Both directions are the same link.
    bool insert(Node a, Node b) {
        for (std::size_t at = start(key(a, b));; at = next(at)) {
            if (table_[at] == key(a, b)) return false;
            if (table_[at] != kEmpty) continue;
            table_[at] = key(a, b);
            return true;
        }
    }
    bool contains(Node a, Node b) const {
        for (std::size_t at = start(key(a, b)); table_[at] != kEmpty; at = next(at))
            if (table_[at] == key(a, b)) return true;
        return false;
    }
    // Removes a link that is there, and moves up what may have been put behind it.
    void erase(Node a, Node b) {
        std::size_t at = start(key(a, b));
        while (table_[at] != key(a, b)) at = next(at);
        for (std::size_t other = next(at); table_[other] != kEmpty; other = next(other)) {
            const std::size_t home = start(table_[other]);
            if (((other - home) & (table_.size() - 1)) < ((other - at) & (table_.size() - 1))) continue;
            table_[at] = table_[other];
            at = other;
        }
        table_[at] = kEmpty;
    }

  private:
    static constexpr std::uint64_t kEmpty = ~std::uint64_t{0};
    static std::uint64_t key(Node a, Node b) { return std::uint64_t{std::min(a, b)} << 32 | std::max(a, b); }
    std::size_t start(std::uint64_t key) const { return mix64(key) & (table_.size() - 1); }
    std::size_t next(std::size_t at) const { return (at + 1) & (table_.size() - 1); }
    std::vector<std::uint64_t> table_;
};

}  // namespace meld::graph
