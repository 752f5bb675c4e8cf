// Typed indices into tables: an Id<Rule> is never mistaken for an Id<Predicate> or a count.
#pragma once

#include <compare>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <vector>

#include "runtime/base/assert.h"

namespace meld {

template <class Tag>
class Id {
  public:
    constexpr Id() = default;
    constexpr explicit Id(std::size_t index) : index_(static_cast<std::uint32_t>(index)) {}
    constexpr std::size_t index() const { return index_; }
    constexpr bool valid() const { return index_ != kNone; }
    constexpr auto operator<=>(const Id&) const = default;

  private:
    static constexpr std::uint32_t kNone = 0xffffffff;
    std::uint32_t index_ = kNone;
};

// A vector that is indexed only by Id<Tag>.
template <class Tag, class T = Tag>
class Table {
  public:
    Id<Tag> add(T value) {
        rows_.push_back(std::move(value));
        return Id<Tag>(rows_.size() - 1);
    }
    T& operator[](Id<Tag> id) {
        MELD_EXPECT(id.index() < rows_.size());
        return rows_[id.index()];
    }
    const T& operator[](Id<Tag> id) const {
        MELD_EXPECT(id.index() < rows_.size());
        return rows_[id.index()];
    }
    std::size_t count() const { return rows_.size(); }
    bool empty() const { return rows_.empty(); }
    auto begin() { return rows_.begin(); }
    auto end() { return rows_.end(); }
    auto begin() const { return rows_.begin(); }
    auto end() const { return rows_.end(); }

    // All ids in order, for loops that need the id and the row.
    std::vector<Id<Tag>> ids() const {
        std::vector<Id<Tag>> result;
        for (std::size_t i = 0; i < rows_.size(); ++i) result.push_back(Id<Tag>(i));
        return result;
    }

  private:
    std::vector<T> rows_;
};

}  // namespace meld

template <class Tag>
struct std::hash<meld::Id<Tag>> {
    std::size_t operator()(meld::Id<Tag> id) const noexcept { return id.index(); }
};
