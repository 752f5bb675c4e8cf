// The global ids of the catoms of an ensemble, by index, and back. Catoms are numbered as they are placed, so most ids follow from their
// indices and are not stored: those of all indices up to the first that breaks the row.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

#include "runtime/base/prefetch.h"
#include "runtime/module/abi/geometry_abi.h"
#include "runtime/world/ensemble/brick_table.h"

namespace meld::world {

class CatomIds {
  public:
    std::uint64_t of(std::uint32_t index) const { return index < implied_ ? first_ + index : stored_[index - implied_]; }
    // One more index, and more with consecutive ids.
    void add(std::uint64_t id) { add_run(id, 1); }
    void add_run(std::uint64_t first_id, std::uint32_t count);
    // What replace() will write to is asked for ahead.
    void ask_ahead(std::uint32_t index) const {
        if (index >= implied_) ask_for(&stored_[index - implied_]);
    }
    // The index gets another id.
    void replace(std::uint32_t index, std::uint64_t id);
    void add_to(Geometry& g) const;

    // The index with this id if it follows from the index, whether or not it is in use; otherwise nothing.
    std::optional<std::uint32_t> index_in_order(std::uint64_t id) const {
        // If the id is less than the first, the difference wraps around and is not an index.
        const std::uint64_t index = id - first_;
        if (index >= count_ || of(static_cast<std::uint32_t>(index)) != id) return std::nullopt;
        return static_cast<std::uint32_t>(index);
    }
    bool in_order(std::uint32_t index) const { return of(index) == first_ + index; }

    // ---- the table of those that are not in order, for the others the calls do nothing
    bool table_made() const { return made_; }
    // Calls in_use(index) to know which are to be found.
    template <class InUse>
    void make_table(const InUse& in_use) const {
        table_ = {};
        std::size_t rows = 0;
        const auto needs_row = [&](std::uint32_t index) { return !in_order(index) && in_use(index); };
        for (std::uint32_t index = implied_; index < count_; ++index) rows += needs_row(index) ? 1 : 0;
        table_.reserve(rows, stored_);
        for (std::uint32_t index = implied_; index < count_; ++index)
            if (needs_row(index)) table_.insert(index - implied_, stored_);
        made_ = true;
    }
    void enter(std::uint32_t index) const {
        if (made_ && !in_order(index)) table_.insert(index - implied_, stored_);
    }
    void leave(std::uint32_t index) const {
        if (made_ && !in_order(index)) table_.erase(index - implied_, stored_);
    }
    std::optional<std::uint32_t> find(std::uint64_t id) const {
        const std::uint32_t row = table_.find(id, stored_);
        return row == IdTable::kAbsent ? std::nullopt : std::optional(row + implied_);
    }

    std::size_t bytes() const { return stored_.capacity() * sizeof(stored_[0]) + table_.bytes(); }

  private:
    std::uint64_t first_ = 0;
    std::uint32_t count_ = 0, implied_ = 0;
    std::vector<std::uint64_t> stored_;  // From index implied_ on.
    mutable IdTable table_;              // By place in stored_.
    mutable bool made_ = false;
};

}  // namespace meld::world
