#include "runtime/world/ensemble/catom_ids.h"

namespace meld::world {

void CatomIds::add_run(std::uint64_t first_id, std::uint32_t count) {
    if (count_ == 0) first_ = first_id;
    if (implied_ == count_ && first_id == first_ + count_) {
        implied_ += count;
    } else {
        // An eighth more where there is no room, since they are many.
        constexpr std::size_t kShare = 8, kLeast = 64;
        if (stored_.size() + count > stored_.capacity()) stored_.reserve(stored_.size() + count + stored_.size() / kShare + kLeast);
        for (std::uint32_t i = 0; i < count; ++i) stored_.push_back(first_id + i);
    }
    count_ += count;
}

// Rows of the table stay what they are: those of implied ids have none, so after all ids have been stored, the places of the others move.
void CatomIds::replace(std::uint32_t index, std::uint64_t id) {
    if (of(index) == id) return;
    if (index < implied_) {
        std::vector<std::uint64_t> all;
        all.reserve(count_);
        for (std::uint32_t i = 0; i < count_; ++i) all.push_back(of(i));
        const std::uint32_t moved = implied_;
        stored_ = std::move(all);
        implied_ = 0;
        table_.shift(moved);
    }
    stored_[index - implied_] = id;
}

void CatomIds::add_to(Geometry& g) const {
    g.catom_id = stored_.data();
    g.ids_implied = implied_;
    g.first_id = first_;
}

}  // namespace meld::world
