#include "runtime/engine/tuple/row_pool.h"

#include "runtime/base/assert.h"

namespace meld::tuple {

std::uint8_t* RowPool::take(std::size_t bytes) {
    MELD_EXPECT(bytes > 0);
    const std::size_t cls = size_class(bytes), size = std::size_t{1} << cls;
    if (!free_[cls].empty()) {
        std::uint8_t* block = free_[cls].back();
        free_[cls].pop_back();
        return block;
    }
    if (size > kSlab / 4) {
        slabs_.push_back(std::make_unique_for_overwrite<std::uint8_t[]>(size));
        reserved_ += size;
        return slabs_.back().get();
    }
    if (left_ < size) {
        slabs_.push_back(std::make_unique_for_overwrite<std::uint8_t[]>(kSlab));
        reserved_ += kSlab;
        next_ = slabs_.back().get();
        left_ = kSlab;
    }
    std::uint8_t* block = next_;
    next_ += size;
    left_ -= size;
    return block;
}

void RowPool::give(std::uint8_t* block, std::size_t bytes) {
    MELD_EXPECT(block != nullptr && bytes > 0);
    free_[size_class(bytes)].push_back(block);
}

}  // namespace meld::tuple
