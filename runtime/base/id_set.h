// A set of ids of one table, as bits: for the few that a rule has, one word and no memory of its own.
#pragma once

#include <algorithm>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <initializer_list>
#include <iterator>
#include <vector>

#include "runtime/base/ids.h"

namespace meld {

// Takes memory in proportion to the greatest id in it. Ids that are not valid are in no set.
template <class Tag>
class IdSet {
  public:
    using value_type = Id<Tag>;

    IdSet() = default;
    IdSet(std::initializer_list<Id<Tag>> ids) { insert(ids.begin(), ids.end()); }
    template <class Iterator>
    IdSet(Iterator from, Iterator to) {
        insert(from, to);
    }

    bool contains(Id<Tag> id) const {
        return id.index() < kBits ? (first_ & bit(id)) != 0 : word(id) < rest_.size() && (rest_[word(id)] & bit(id)) != 0;
    }
    // Whether it is new there.
    bool insert(Id<Tag> id) {
        if (!id.valid()) return false;
        if (id.index() >= kBits && word(id) >= rest_.size()) rest_.resize(word(id) + 1);
        std::uint64_t& in = id.index() < kBits ? first_ : rest_[word(id)];
        const bool is_new = (in & bit(id)) == 0;
        in |= bit(id);
        return is_new;
    }
    template <class Iterator>
    void insert(Iterator from, Iterator to) {
        for (; from != to; ++from) insert(*from);
    }
    void insert(std::initializer_list<Id<Tag>> ids) { insert(ids.begin(), ids.end()); }
    void clear() { *this = {}; }
    void erase(Id<Tag> id) {
        if (!contains(id)) return;
        (id.index() < kBits ? first_ : rest_[word(id)]) &= ~bit(id);
    }
    bool empty() const {
        return first_ == 0 && std::ranges::all_of(rest_, [](std::uint64_t bits) { return bits == 0; });
    }
    std::size_t size() const {
        std::size_t sum = static_cast<std::size_t>(std::popcount(first_));
        for (const std::uint64_t bits : rest_) sum += static_cast<std::size_t>(std::popcount(bits));
        return sum;
    }

    // In the order of ids. Nothing may be put in or taken out meanwhile.
    class Iterator {
      public:
        using iterator_category = std::forward_iterator_tag;
        using value_type = Id<Tag>;
        using difference_type = std::ptrdiff_t;
        using pointer = const value_type*;
        using reference = value_type;

        Iterator() = default;
        Iterator(const IdSet& set, std::size_t at) : set_(&set), at_(at), left_(at < set.words() ? set.bits(at) : 0) { find(); }
        Id<Tag> operator*() const { return Id<Tag>(kBits * at_ + static_cast<std::size_t>(std::countr_zero(left_))); }
        Iterator& operator++() {
            left_ &= left_ - 1;
            find();
            return *this;
        }
        Iterator operator++(int) {
            Iterator before = *this;
            ++*this;
            return before;
        }
        bool operator==(const Iterator& other) const { return at_ == other.at_ && left_ == other.left_; }

      private:
        void find() {
            while (left_ == 0 && at_ < set_->words()) left_ = ++at_ < set_->words() ? set_->bits(at_) : 0;
        }

        const IdSet* set_ = nullptr;
        std::size_t at_ = 0;
        // Those of this word that come now and later.
        std::uint64_t left_ = 0;
    };
    Iterator begin() const { return {*this, 0}; }
    Iterator end() const { return {*this, words()}; }

  private:
    static constexpr std::size_t kBits = 64;
    static std::uint64_t bit(Id<Tag> id) { return std::uint64_t{1} << id.index() % kBits; }
    static std::size_t word(Id<Tag> id) { return id.index() / kBits - 1; }
    std::size_t words() const { return 1 + rest_.size(); }
    std::uint64_t bits(std::size_t at) const { return at == 0 ? first_ : rest_[at - 1]; }

    std::uint64_t first_ = 0;
    std::vector<std::uint64_t> rest_;
};

}  // namespace meld
